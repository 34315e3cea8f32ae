"""Runs the passes of a config, each with its hooks, under the contract of ``engine.contract``."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from time import perf_counter
from typing import Any

import pluggy

from urdf2mbs import hookspecs
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config
from urdf2mbs.config.paths import expand
from urdf2mbs.conversion import Conversion, File
from urdf2mbs.disk.files import is_file
from urdf2mbs.engine.contract import PassCheck, check_protected, protected_state, record_change
from urdf2mbs.engine.failures import locating_option, naming_pass, naming_plugin
from urdf2mbs.engine.levels import apply_levels, raise_errors
from urdf2mbs.engine.order import ConfiguredPass, check_order, list_method, resolve
from urdf2mbs.engine.plugins import Plugins, load_plugins
from urdf2mbs.engine.settings import check_output, make_settings
from urdf2mbs.hookspecs import GROUP, Pass
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, nearest
from urdf2mbs.proof.verdict import NOT_CHECKED
from urdf2mbs.urdf.changes import encode
from urdf2mbs.urdf.reader import is_name

#: Ends an .mbs file that nobody compared with its URDF.
_UNPROVEN = f"<!-- {NOT_CHECKED}: the pass 'check' was not in the pipeline -->\n".encode()


class Pipeline:
    """The passes of one config, in an order that has been checked.

    Args:
        config: The config.
        lines: The line of each value of the config.
        installed_plugins: Whether the plugins of other installed packages take part.
        fresh: Whether to start over, and forget what people changed in the .mbs.

    Raises:
        ConfigError: The config is wrong; with all its faults in the order of their lines.
    """

    passes: list[ConfiguredPass]
    plugins: Plugins

    def __init__(
        self, config: Config, lines: Lines, *, installed_plugins: bool = True, fresh: bool = False
    ) -> None:
        if config.sweep is not None:
            lines.check()
            message = "this config is a sweep, which makes many robots"
            hint = "'urdf2mbs run' makes them; 'explain' shows the first"
            raise lines.error("sweep-many", message, ("sweep",), hint)
        self._config = config
        self._lines = lines
        self._files = self._list_files()
        if len(self._files) == len(config.plugins):  # otherwise passes would be missing, too
            self._resolve(installed_plugins)
        hook = None
        if is_name(config.source):
            lines.check()  # before a robot is downloaded
            hook = self.plugins.hook
        with lines.gather(), ExitStack() as stack:
            if hook is not None:
                locating = "hook 'urdf2mbs_locate' of plugin '{}'"
                stack.enter_context(naming_plugin(self.plugins, locating.format))
            self.settings = make_settings(config, lines, hook, fresh=fresh)
        lines.check()
        self._hooks: list[Any] = [self.plugins.hook]
        """The hooks of the plugins, and of each observer."""
        self._check_order()

    def _list_files(self) -> list[Path]:
        """Return the plugin files of the config; those that do not exist become faults."""
        files: list[Path] = []
        for index, name in enumerate(self._config.plugins):
            key = ("plugins", index)
            with self._lines.gather():
                path = self._lines.folder / expand(name, self._lines, key)
                if not is_file(path):
                    message = f"plugin file '{path}' does not exist"
                    raise self._lines.error("plugin-missing", message, key)
                files.append(path)
        return files

    def _resolve(self, installed: bool) -> None:
        """Load the plugins and choose the passes; what is wrong becomes faults of the lines."""
        lines = self._lines
        with lines.gather():
            self.plugins = load_plugins(self._files, installed=installed)
            for fault in lines.faults:
                for name in self.plugins.passes:
                    if fault.message == f"unknown key '{name}'":
                        fault.hint = f"did you mean 'passes: {{{name}: {{}}}}'?"
            self._check_levels()
            count = len(lines.faults)
            self.passes = resolve(self._config, lines, self.plugins)
            for fault in lines.faults[count:]:
                # what is missing may be in a plugin that was left out
                broken = map(str, self.plugins.broken)
                fault.hint = "\n  ".join([fault.hint or "", *broken]).lstrip() or None

    def _check_levels(self) -> None:
        """Record a fault for each code that nobody has, or whose level is fixed."""
        levels = self._config.diagnostics
        if not levels:
            return
        codes = self.plugins.codes
        adjustable = {code for code, text in codes.items() if not text.startswith("error:")}
        for code in [code for code in levels if code not in adjustable]:
            message = f"there is no '{code}' among the codes whose level can be changed"
            hint = nearest(code, adjustable) or "docs/diagnostics.md lists them"
            if code not in codes:
                hint += self._explain_declaration(code)
            fault = self._lines.error("unknown-code", message, ("diagnostics", code), hint)
            self._lines.faults.append(fault)

    def _explain_declaration(self, code: str) -> str:
        """Return where plugins would declare a code, as more lines of a hint."""
        entries = [entry for entries in self.plugins.passes.values() for entry in entries]
        files = {entry.plugin: entry.source for entry in entries if not entry.is_ours}
        return "".join(
            f"\n  if it is a code of plugin '{plugin}': add \"{code}\" to what its hook "
            f"'urdf2mbs_codes' returns, in {file}"
            for plugin, file in files.items()
        )

    def _check_order(self) -> None:
        """Check an order that is not that of the method, and the place of the output."""
        method = list_method(self.plugins)
        names = [step.name for step in self.passes]
        if names != [name for name in method if name in names] or self._config.without:
            check_order(self.passes, method, self._lines)
        # a pass that may have no work is not imported for this
        certain = [step for step in self.passes if step.given or step.entry.is_core]
        if any("mbs-file" in step.kind.writes for step in certain):
            check_output(self.settings, self._lines)

    def watch(self, observer: object) -> None:
        """Call an object's own hooks, too, around every pass."""
        manager = pluggy.PluginManager(GROUP)
        manager.add_hookspecs(hookspecs)
        manager.register(observer)
        self._hooks.append(manager.hook)

    def run(self, *, stop_after: str | None = None, before: Conversion | None = None) -> Conversion:
        """Run the passes; nothing is written to disk.

        Messages get the user's levels here, and only here: after each pass, and with the error
        that ends a run.  An error that does not stop a pass is raised at the end, together with
        all such errors.

        Args:
            stop_after: The last pass that runs; None: all run.
            before: A conversion of the same robot, whose source is not read again.

        Raises:
            ConversionError: A pass failed, or a message has the level of an error.
        """
        names = [step.name for step in self.passes]
        if stop_after is not None and stop_after not in names:
            message = f"there is no pass '{stop_after}' in this pipeline to stop after"
            hint = nearest(stop_after, names) or f"there are: {', '.join(names)}"
            raise ConfigError("unknown-pass", message, hint=hint)
        conversion = Conversion(self.settings, hook=self.plugins.hook, progress=self._show_progress)
        if before is not None:
            conversion.input = before.input
        conversion.diagnostics += self.plugins.broken
        self._warn_of_idle_plugins(conversion)
        try:
            self._run_passes(conversion, stop_after)
        except ConversionError as error:
            diagnostics = [*conversion.diagnostics, *error.earlier]
            error.earlier = apply_levels(diagnostics, self._config, self.plugins)
            raise
        raise_errors(conversion.diagnostics)
        _mark_unproven(conversion)
        return conversion

    def _warn_of_idle_plugins(self, conversion: Conversion) -> None:
        """Warn of the files of the config that bring only passes, none of which is used."""
        used = {step.entry.plugin for step in self.passes}
        for plugin in [file.stem for file in self._files if file.stem not in used]:
            unused = self.plugins.list_only_passes(plugin)
            if unused:
                conversion.warn(
                    "plugin-idle",
                    f"plugin '{plugin}' does nothing: none of its passes is in the pipeline "
                    f"({', '.join(unused)})",
                    hint=f"put one in, by 'pipeline', 'before' or 'after: {{PASS: {unused[0]}}}'",
                )

    def _run_passes(self, conversion: Conversion, stop_after: str | None) -> None:
        ran: list[ConfiguredPass] = []
        for step in self.passes:
            if self._has_work(step, conversion, ran):
                self._call_hook("urdf2mbs_before_pass", step.pass_, conversion)
                start = perf_counter()
                self._run_pass(step, conversion, ran)
                seconds = perf_counter() - start
                ran.append(step)
                conversion.diagnostics = apply_levels(
                    conversion.diagnostics, self._config, self.plugins
                )
                self._call_hook("urdf2mbs_after_pass", step.pass_, conversion, seconds=seconds)
            if step.name == stop_after:
                break

    def _has_work(
        self, step: ConfiguredPass, conversion: Conversion, ran: Sequence[ConfiguredPass]
    ) -> bool:
        """Return whether a pass has work; the pass is imported then."""
        with naming_pass(step.entry, conversion, [earlier.entry for earlier in ran]):
            return step.entry.work(conversion, step.given) and step.pass_ is not None

    def _run_pass(
        self, step: ConfiguredPass, conversion: Conversion, ran: Sequence[ConfiguredPass]
    ) -> None:
        """Run a pass, and check what it has changed.

        Args:
            step: The pass, with its options.
            conversion: What the pass changes.
            ran: The passes that ran before it.

        Raises:
            ConversionError: The pass failed, or broke the contract.
        """
        check = PassCheck(step, conversion, ran)
        with naming_pass(step.entry, conversion, [earlier.entry for earlier in ran]):
            with locating_option(step.name, self._config, self._lines), ExitStack() as stack:
                if step.entry.is_ours:  # it may call the hooks of plugins
                    called = f"plugin '{{}}', called by pass '{step.name}',"
                    stack.enter_context(naming_plugin(self.plugins, called.format, conversion))
                step.pass_.run(conversion)
            check.finish()
        check.check_sections()

    def _call_hook(self, hook: str, pass_: Pass, conversion: Conversion, **timing: float) -> None:
        """Call a hook around a pass, of all plugins and observers.

        Raises:
            ConversionError: A plugin's hook failed, or changed what is for reading.
        """
        listeners = [hooks for hooks in self._hooks if getattr(hooks, hook).get_hookimpls()]
        if not listeners:
            return
        when = "before" if "before" in hook else "after"
        users = self.plugins.find_hook_users(hook)
        robot = encode(conversion.robot) if users else None
        protected = protected_state(conversion) if users else ""
        failed = f"hook '{hook}' of plugin '{{}}', called {when} pass '{pass_.name}',"
        with naming_plugin(self.plugins, failed.format, conversion):
            for hooks in listeners:
                getattr(hooks, hook)(pass_=pass_, conversion=conversion, **timing)
        if robot is not None:
            code, plugin = f"the hook {when} '{pass_.name}'", "' or '".join(users)
            check_protected(conversion, protected, f"{code} of plugin '{plugin}'", "")
            record_change(conversion, robot, code, plugin, declared=False)

    def _show_progress(self, text: str) -> None:
        """Tell plugins and observers what a pass is doing."""
        for hooks in self._hooks:
            hooks.urdf2mbs_progress(text=text)


def _mark_unproven(conversion: Conversion) -> None:
    """Add to an .mbs that was not compared a comment that says so."""
    output = conversion.settings.output
    data = conversion.files.get(output)
    if conversion.checked.proof is None and data is not None and output.suffix == ".mbs":
        # after the root element: not every reader accepts a comment before it
        marked = data.removesuffix(_UNPROVEN) + _UNPROVEN
        conversion.files[output] = File(marked, replaces=getattr(data, "replaces", None))
