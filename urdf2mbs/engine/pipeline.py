"""Resolves a config's passes, checks what each needs against what is given, and runs them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

from urdf2mbs.config.model import Config, Lines, expand
from urdf2mbs.conversion import Conversion, File
from urdf2mbs.disk.files import is_file
from urdf2mbs.engine.faults import (
    called_plugin_failed,
    check_left,
    check_protected,
    hook_failed,
    pass_failed,
    protected_state,
)
from urdf2mbs.engine.levels import judge, weigh
from urdf2mbs.engine.options import locate_option
from urdf2mbs.engine.order import check_order, find_stale
from urdf2mbs.engine.plugins import hooks_of, plugins_of
from urdf2mbs.engine.registered import Registered
from urdf2mbs.engine.resolve import Configured, resolve
from urdf2mbs.engine.sections import IMPLIED, compare, take_snapshot
from urdf2mbs.engine.settings import check_output, settings_of
from urdf2mbs.engine.tracebacks import FAILURES, in_words, line_in
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, nearest
from urdf2mbs.proof.verdict import NOT_CHECKED
from urdf2mbs.urdf.changes import RobotChange, encode, find_changes
from urdf2mbs.urdf.reader import is_name

#: Ends an .mbs file that nobody compared with its URDF.
_UNPROVEN = f"<!-- {NOT_CHECKED}: the pass 'check' was not in the pipeline -->\n".encode()


class Pipeline:
    """The passes of one config, in an order that has been checked."""

    def __init__(
        self, config: Config, lines: Lines, *, installed_plugins: bool = True, fresh: bool = False
    ) -> None:
        if config.sweep is not None:
            lines.check()
            raise lines.error(
                "sweep-many", "this config is a sweep, which makes many robots", ("sweep",),
                "'urdf2mbs run' makes them; 'explain' shows the first",
            )  # fmt: skip
        self._lines = lines
        self._files = []
        for index, file in enumerate(config.plugins):
            with lines.gather():
                path = lines.folder / expand(file, lines, ("plugins", index))
                if not is_file(path):
                    raise lines.error(
                        "plugin-missing", f"plugin file '{path}' does not exist", ("plugins", index)
                    )
                self._files.append(path)
        if len(self._files) == len(config.plugins):  # else passes would be missing, too
            self._resolve(config, lines, installed_plugins)
        hook = None
        if is_name(config.source):
            lines.check()  # before a robot is fetched
            hook = self.plugins.hook
        with lines.gather(), self._naming_plugin():
            self.settings = settings_of(config, lines, hook, fresh=fresh)
        lines.check()
        self._hooks: list[Any] = [self.plugins.hook]
        """The hooks of the plugins and of the observers."""
        method = self.plugins.method
        names = [configured.name for configured in self.passes]
        if names != [name for name in method if name in names] or config.without:
            passes = [configured.registered.kind for configured in self.passes]
            check_order(passes, method, lines, [configured.at for configured in self.passes])
        certain = [each.registered for each in self.passes if each.given or each.registered.is_core]
        if any("mbs-file" in registered.kind.writes for registered in certain):
            check_output(self.settings, lines)

    def _resolve(self, config: Config, lines: Lines, installed: bool) -> None:
        """Load the plugins and choose the passes; what is wrong becomes faults of the lines."""
        with lines.gather():
            self.plugins = plugins_of(self._files, installed=installed)
            for fault in lines.faults:
                for name in self.plugins.passes:
                    if fault.message == f"unknown key '{name}'":
                        fault.hint = f"did you mean 'passes: {{{name}: {{}}}}'?"
            self._check_levels(config, lines)
            known = len(lines.faults)
            self.passes = resolve(config, lines, self.plugins)
            for fault in lines.faults[known:]:
                # what is missing may be in a plugin that was left out
                broken = map(str, self.plugins.broken)
                fault.hint = "\n  ".join([fault.hint or "", *broken]).lstrip() or None

    @contextmanager
    def _naming_plugin(self) -> Iterator[None]:
        """Raise an exception of a plugin that says where a robot is as a ConfigError."""
        try:
            yield
        except ConversionError:
            raise
        except FAILURES as error:
            plugin = self.plugins.blame(error.__traceback__)
            if plugin is None:
                raise
            name, file = plugin
            message = f"hook 'urdf2mbs_locate' of plugin '{name}' failed: {in_words(error)}"
            line = line_in(Path(file), error)
            raise ConfigError("plugin-failed", message, file=file, line=line) from error

    def watch(self, observer: object) -> None:
        """Let an object's own hooks be called too, around every pass."""
        self._hooks.append(hooks_of(observer))

    def run(self, *, stop_after: str | None = None, before: Conversion | None = None) -> Conversion:
        """Run the passes; raises ConversionError. Nothing is written to disk.

        ``before``: a conversion of the same robot, whose source is not read again.

        Messages get the user's levels here, and only here: after each pass, and with the error
        that ends a run.  An error that does not stop a pass is raised at the end, together with
        all such errors.
        """
        names = [configured.name for configured in self.passes]
        if stop_after is not None and stop_after not in names:
            raise ConfigError(
                "unknown-pass", f"there is no pass '{stop_after}' in this pipeline to stop after",
                hint=nearest(stop_after, names) or f"there are: {', '.join(names)}",
            )  # fmt: skip
        settings = self.settings
        conversion = Conversion(settings, pipeline=self)
        if before is not None:
            conversion.input = before.input
        conversion.diagnostics += self.plugins.broken
        for plugin, brought in self._idle():
            conversion.warn(
                "plugin-idle",
                f"plugin '{plugin}' does nothing: none of its passes is in the pipeline "
                f"({', '.join(brought)})",
                hint=f"put one in, by 'pipeline', 'before' or 'after: {{PASS: {brought[0]}}}'",
            )
        try:
            self._run(conversion, stop_after)
        except ConversionError as error:
            found = [*conversion.diagnostics, *error.earlier]
            error.earlier = weigh(found, settings.config, self.plugins)
            raise
        judge(conversion.diagnostics)
        output = settings.output
        data = conversion.files.get(output)
        if conversion.checked.proof is None and data is not None and output.suffix == ".mbs":
            # behind the root: what stands before it is no place for a comment in every reader
            said = data.removesuffix(_UNPROVEN) + _UNPROVEN
            conversion.files[output] = File(said, replaces=getattr(data, "replaces", None))
        return conversion

    def progress(self, text: str) -> None:
        """Tell those who watch what a pass is at."""
        for hooks in self._hooks:
            hooks.urdf2mbs_progress(text=text)

    def _run(self, conversion: Conversion, stop_after: str | None) -> None:
        ran, config = list[Registered](), self.settings.config
        for configured in self.passes:
            if self._has_work(configured, conversion, ran):
                pass_ = configured.pass_
                self._call("urdf2mbs_before_pass", conversion, pass_=pass_)
                start = perf_counter()
                self._run_pass(configured, conversion, ran)
                seconds = perf_counter() - start
                ran.append(configured.registered)
                conversion.diagnostics = weigh(conversion.diagnostics, config, self.plugins)
                self._call("urdf2mbs_after_pass", conversion, pass_=pass_, seconds=seconds)
            if configured.name == stop_after:
                break

    def _has_work(
        self, configured: Configured, conversion: Conversion, ran: list[Registered]
    ) -> bool:
        """True if a pass has work; the pass is imported then."""
        try:
            found = configured.registered
            return found.has_work(conversion, configured.given) and configured.pass_ is not None
        except ConversionError:
            raise
        except FAILURES as error:
            raise self._failed(configured.registered, conversion, error, ran) from error

    def _failed(
        self,
        registered: Registered,
        conversion: Conversion,
        error: BaseException,
        ran: list[Registered],
    ) -> ConversionError:
        """Return the error for an exception of a pass, or of a plugin that the pass has called."""
        plugin = self.plugins.blame(error.__traceback__) if registered.is_ours else None
        if plugin is None:
            return pass_failed(registered, conversion, error, ran)
        return called_plugin_failed(*plugin, registered.name, conversion, error)

    def _run_pass(
        self, configured: Configured, conversion: Conversion, ran: list[Registered]
    ) -> None:
        """Run a pass, and check what a plugin's pass leaves.

        Args:
            configured: The pass, with its options.
            conversion: What the pass changes.
            ran: The passes that ran before it.

        Raises:
            ConversionError: The pass failed, or broke the contract of ``engine.order``.
        """
        registered, pass_ = configured.registered, configured.pass_
        plugin = registered.plugin
        strange = not registered.is_ours
        known = bool(conversion.robot.links)
        robot = encode(conversion.robot) if known and _may_change(configured) else None
        ours = protected_state(conversion) if strange else ""
        # Our own passes keep the contract among themselves, as the tests show.
        is_checked = strange or not all(earlier.is_ours for earlier in ran)
        before = take_snapshot(conversion) if is_checked else None
        try:
            pass_.run(conversion)
            if strange:
                check_protected(conversion, ours, f"pass '{pass_.name}'", plugin, registered.file)
                check_left(registered, conversion, known)
            if robot is not None:
                _note_change(conversion, robot, pass_.name, plugin, "robot" in pass_.writes)
        except ConfigError as error:
            locate_option(error, registered.name, self.settings.config, self._lines)
            raise
        except ConversionError:
            raise
        except FAILURES as error:
            raise self._failed(registered, conversion, error, ran) from error
        if before is not None:
            self._check_change(registered, conversion, before, ran)

    def _check_change(
        self,
        registered: Registered,
        conversion: Conversion,
        before: dict[str, Counter[bytes]],
        ran: Sequence[Registered],
    ) -> None:
        """Check what a pass changed of the sections, by the contract of ``engine.order``."""
        change = compare(before, take_snapshot(conversion))
        readers = ran if not registered.is_ours else [one for one in ran if not one.is_ours]
        stale = find_stale(registered.kind, change.altered, [reader.kind for reader in readers])
        if stale:
            message, hint = stale
            strangers = [one for one in (registered, *readers) if not one.is_ours]
            message += f" (plugin '{strangers[0].plugin}')"
            hint += ": a pass of that place uses the change"
            raise ConversionError("stale", message, file=strangers[0].file, hint=hint)
        writes = registered.kind.writes
        declared = {*writes, *(IMPLIED[name] for name in writes if name in IMPLIED)}
        undeclared = [name for name in change.changed if name not in declared]
        if undeclared and not registered.is_ours:
            conversion.warn(
                "undeclared",
                f"pass '{registered.name}' of plugin '{registered.plugin}' changes the "
                f"{' and the '.join(undeclared)}, and does not declare it",
                hint=f"add to its 'writes': {', '.join(map(repr, undeclared))}",
            )

    def _check_levels(self, config: Config, lines: Lines) -> None:
        """Note each code that neither urdf2mbs nor a plugin has, or whose level is fixed."""
        if not config.diagnostics:
            return
        codes = self.plugins.codes.items()
        known = {code for code, meaning in codes if not meaning.startswith("error:")}
        for code in [code for code in config.diagnostics if code not in known]:
            message = f"there is no '{code}' among the codes whose level can be changed"
            hint = nearest(code, known) or "docs/diagnostics.md lists them"
            if code not in self.plugins.codes:
                hint += self._explain_declaration(code)
            lines.faults.append(lines.error("unknown-code", message, ("diagnostics", code), hint))

    def _explain_declaration(self, code: str) -> str:
        """Return where plugins would declare a code, as more lines of a hint."""
        passes = [registered for offered in self.plugins.passes.values() for registered in offered]
        files = {each.plugin: each.file for each in passes if not each.is_ours}
        return "".join(
            f"\n  if it is a code of plugin '{plugin}': add \"{code}\" to what its hook "
            f"'urdf2mbs_codes' returns, in {file}"
            for plugin, file in files.items()
        )

    def _idle(self) -> list[tuple[str, list[str]]]:
        """The files of the config that bring nothing but passes, none of which is used."""
        used = {configured.registered.plugin for configured in self.passes}
        idle = [file.stem for file in self._files if file.stem not in used]
        brought = [(plugin, self.plugins.only_passes(plugin)) for plugin in idle]
        return [(plugin, passes) for plugin, passes in brought if passes]

    def _call(self, hook: str, conversion: Conversion, **more: Any) -> None:
        """Call a hook of all plugins, and of those who watch; ``more`` it is called with, too."""
        listeners = [hooks for hooks in self._hooks if getattr(hooks, hook).get_hookimpls()]
        if not listeners:
            return
        pass_: Pass | None = more.get("pass_")
        if pass_ is not None:
            more["conversion"] = conversion
        name = pass_.name if pass_ is not None else ""
        strangers = self.plugins.with_hook(hook) if pass_ is not None else []
        before = encode(conversion.robot) if strangers else None
        ours = protected_state(conversion) if strangers else ""
        try:
            for hooks in listeners:
                getattr(hooks, hook)(**more)
            if before is not None:
                who = f"the hook {'before' if 'before' in hook else 'after'} '{name}'"
                names = "' or '".join(strangers)
                check_protected(conversion, ours, who, names, "")
                _note_change(conversion, before, who, names, declared=False)
        except ConversionError:
            raise
        except FAILURES as error:
            plugin = self.plugins.blame(error.__traceback__)
            if plugin is None:
                raise
            raise hook_failed(hook, *plugin, name, conversion, error) from error


def _may_change(configured: Configured) -> bool:
    """True if a pass may change the robot that the URDF states.

    A plugin's pass may.  A built-in pass changes the robot only if its options say so;
    insert-base only puts a base under the robot.
    """
    found = configured.registered
    return not found.is_ours or ("robot" in found.kind.writes and configured.pass_ != found.kind())


def _note_change(
    conversion: Conversion, before: bytes, by: str, plugin: str, declared: bool
) -> None:
    """Keep what has changed of the robot since a snapshot; the base is no part of the URDF."""
    robot, inserted = conversion.robot, conversion.base.inserted
    base = {inserted, robot.joints[inserted].parent} if inserted in robot.joints else set()
    try:
        after = encode(robot)
    except (TypeError, ValueError) as error:
        raise ConversionError(
            "plugin-robot-broken",
            f"{by} (plugin '{plugin}') leaves in robot '{robot.name}' what no URDF can hold: "
            f"{error}",
        ) from error
    changes = [
        change
        for change in find_changes(before, after)
        if not (change.kind in ("link-added", "joint-added") and change.name in base)
    ]
    if changes:
        conversion.checked.changed.append(RobotChange(by, plugin, declared, changes))
