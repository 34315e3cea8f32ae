"""Resolves a config's passes, checks what each needs against what is given, and runs them."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from time import perf_counter
from typing import Any

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.files import is_file
from urdf2mbs.disk.seal import seal, unsealed
from urdf2mbs.engine.config import Config, Lines
from urdf2mbs.engine.faults import check_left, check_ours, hook_failed, ours_alone, pass_failed
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.engine.order import check_order, check_stale
from urdf2mbs.engine.plugins import FAILURES, GROUP, Registered, hooks_of, plugins_of
from urdf2mbs.engine.resolve import Configured, resolve
from urdf2mbs.engine.sections import changed, look
from urdf2mbs.engine.settings import check_output, settings_of, spelled
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, nearest
from urdf2mbs.messages.levels import judge, weigh
from urdf2mbs.proof.verdict import NOT_CHECKED
from urdf2mbs.urdf.changes import RobotChange, between, snapshot

#: The hooks around every pass.
_AROUND = ("urdf2mbs_before_pass", "urdf2mbs_after_pass")


#: Ends an .mbs file that nobody compared with its URDF.
_UNPROVEN = f"<!-- {NOT_CHECKED}: the pass 'check' was not in the pipeline -->\n".encode()


class Pipeline:
    """The passes of one config, in an order that has been checked."""

    def __init__(self, config: Config, lines: Lines, *, installed_plugins: bool = True) -> None:
        folder = lines.folder
        if config.sweep is not None:
            raise lines.error(
                "sweep-many", "this config is a sweep, which makes many robots", ("sweep",),
                "'urdf2mbs run' makes them; 'explain' shows the first",
            )  # fmt: skip
        self.settings = settings_of(config, lines, folder)
        files = [
            folder / spelled(file, lines, ("plugins", n)) for n, file in enumerate(config.plugins)
        ]
        for index, file in enumerate(files):
            if not is_file(file):
                raise lines.error(
                    "plugin-missing", f"plugin file '{file}' does not exist", ("plugins", index)
                )
        self._files = files
        self.plugins = plugins_of(files, installed=installed_plugins)
        self._hooks: list[Any] = [self.plugins.hook]
        """Of the plugins, and of those who watch."""
        self.passes = self._resolved(config, lines)
        self._check_levels(config, lines)
        passes = [configured.registered.kind for configured in self.passes]
        method = [
            name for name, offered in self.plugins.passes.items() if offered[0].plugin == GROUP
        ]
        named = [(kind.name, kind) for kind in passes]
        check_order(named, method, lines, [one.at for one in self.passes])
        check_output(self.settings, passes, lines)

    def _resolved(self, config: Config, lines: Lines) -> list[Configured]:
        try:
            return resolve(config, lines, self.plugins)
        except ConfigError as error:
            # what is missing may be in a plugin that was left out
            error.hint = "\n  ".join([error.hint or "", *map(str, self.plugins.broken)]).lstrip()
            raise

    def watch(self, observer: object) -> None:
        """Let an object's own hooks be called too, around every pass."""
        self._hooks.append(hooks_of(observer))

    def run(self, *, stop_after: str | None = None) -> Conversion:
        """Run the passes; raises ConversionError. Nothing is written to disk.

        What is said gets the user's levels here, and only here: after each pass, and with the
        error that ends a run.  An error of which something can be made is raised at the end, so
        that all are told at once.
        """
        names = [configured.pass_.name for configured in self.passes]
        if stop_after is not None and stop_after not in names:
            raise ConfigError(
                "unknown-pass", f"there is no pass '{stop_after}' in this pipeline to stop after",
                hint=nearest(stop_after, names) or f"there are: {', '.join(names)}",
            )  # fmt: skip
        conversion = Conversion(self.settings)
        conversion.progress = self._progress
        conversion.diagnostics += self.plugins.broken
        for plugin, brought in self._idle():
            conversion.warn(
                "plugin-idle",
                f"plugin '{plugin}' does nothing: none of its passes is in the pipeline "
                f"({', '.join(brought)})",
                hint=f"put one in, such as 'after: {{{self._place(brought[0])}: {brought[0]}}}'",
            )
        config = self.settings.config
        try:
            with seldom_collected():
                self._call("urdf2mbs_before_run", conversion, settings=self.settings)
                self._run(conversion, stop_after)
        except ConversionError as error:
            error.said = weigh([*conversion.diagnostics, *error.said], config)
            raise
        judge(conversion.diagnostics)
        output = self.settings.output
        data = conversion.files.get(output)
        if conversion.proof is None and data is not None and output.suffix == ".mbs":
            # behind the root: what stands before it is no place for a comment in every reader
            conversion.files[output] = seal(output, unsealed(data) + _UNPROVEN)
        return conversion

    def _progress(self, text: str) -> None:
        for hooks in self._hooks:
            hooks.urdf2mbs_progress(text=text)

    def _run(self, conversion: Conversion, stop_after: str | None) -> None:
        watched = len(self._hooks) > 1 or any(map(self.plugins.hooked, _AROUND))
        ran: list[Registered] = []
        for configured in self.passes:
            found = configured.registered
            pass_ = configured.pass_
            if watched:
                self._call("urdf2mbs_before_pass", conversion, pass_=pass_)
            known = bool(conversion.robot.links)
            before = snapshot(conversion.robot) if known and _may_change(configured) else None
            ours = ours_alone(conversion) if found.plugin != GROUP else ""
            sections = look(conversion) if found.plugin != GROUP else None
            start = perf_counter()
            try:
                pass_.run(conversion)
                seconds = perf_counter() - start
                if found.plugin != GROUP:
                    who = f"pass '{pass_.name}'"
                    check_ours(conversion, ours, who, found.plugin, found.file)
                    check_left(found, conversion, known)
                if before is not None:
                    declared = "robot" in pass_.writes
                    _note_change(conversion, before, pass_.name, found.plugin, declared)
            except ConversionError:
                raise
            except FAILURES as error:
                raise pass_failed(found, conversion, error, ran) from error
            if sections is not None:
                seen = changed(sections, look(conversion))
                others = [(other.kind.name, other.kind) for other in ran]
                check_stale(type(pass_), seen, others, partial(_stale, found))
            ran.append(found)
            conversion.diagnostics = weigh(conversion.diagnostics, self.settings.config)
            if watched:
                self._call("urdf2mbs_after_pass", conversion, pass_=pass_, seconds=seconds)
            if pass_.name == stop_after:
                break

    def _check_levels(self, config: Config, lines: Lines) -> None:
        """A code is one whose level can be changed, or may be a plugin's."""
        if not config.diagnostics or any(name != GROUP for name in self.plugins.names()):
            return
        from urdf2mbs.messages.catalogue import DEFAULTS

        for code in config.diagnostics:
            if code not in DEFAULTS:
                raise lines.error(
                    "unknown-code",
                    f"there is no '{code}' among the codes whose level can be changed",
                    ("diagnostics", code),
                    nearest(code, DEFAULTS) or "docs/diagnostics.md lists them",
                )

    def _idle(self) -> list[tuple[str, list[str]]]:
        """The config's plugins that bring nothing but passes, of which none is used."""
        used = {configured.registered.plugin for configured in self.passes}
        return [
            (file.stem, self.plugins.only_passes(file.stem))
            for file in self._files
            if file.stem not in used and self.plugins.only_passes(file.stem)
        ]

    def _place(self, name: str) -> str:
        """After which pass of the pipeline all that a pass needs is given."""
        passes = [configured.pass_ for configured in self.passes]
        first = {
            section: place
            for place, pass_ in reversed(list(enumerate(passes)))
            for section in pass_.writes
        }
        reads = self.plugins.passes[name][0].kind.reads
        return passes[max((first.get(section, 0) for section in reads), default=0)].name

    def _call(self, hook: str, conversion: Conversion, **more: Any) -> None:
        """Call a hook of all plugins, and of those who watch; ``more`` it is called with, too."""
        pass_: Pass | None = more.get("pass_")
        if pass_ is not None:
            more["conversion"] = conversion
        name = pass_.name if pass_ is not None else ""
        strangers = self.plugins.hooked(hook) if pass_ is not None else []
        before = snapshot(conversion.robot) if strangers else None
        ours = ours_alone(conversion) if strangers else ""
        try:
            for hooks in self._hooks:
                getattr(hooks, hook)(**more)
            if before is not None:
                who = f"the hook {'before' if 'before' in hook else 'after'} '{name}'"
                names = "' or '".join(strangers)
                check_ours(conversion, ours, who, names, "")
                _note_change(conversion, before, who, names, declared=False)
        except ConversionError:
            raise
        except FAILURES as error:
            plugin = self.plugins.blame(error.__traceback__)
            if plugin is None:
                raise
            raise hook_failed(hook, *plugin, name, conversion, error) from error


def _stale(found: Registered, message: str, hint: str) -> ConversionError:
    return ConversionError(
        "stale", f"{message} (plugin '{found.plugin}')", file=found.file,
        hint=f"{hint}: a pass of that place uses the change",
    )  # fmt: skip


@contextmanager
def seldom_collected() -> Iterator[None]:
    """The collector seldom looks for cycles: a robot has hardly any.  A quarter of the time."""
    before = gc.get_threshold()
    gc.set_threshold(500_000, 20, 100)
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _may_change(configured: Configured) -> bool:
    """Whether a pass may change the robot that the URDF states: any of a plugin, and of ours
    those that do when they are told to (insert-base only puts a base under it)."""
    found = configured.registered
    return found.plugin != GROUP or (
        "robot" in found.kind.writes and configured.pass_ != found.kind()
    )


def _note_change(
    conversion: Conversion, before: bytes, by: str, plugin: str, declared: bool
) -> None:
    """Keep what has changed of the robot since a snapshot; the base is no part of the URDF."""
    robot, inserted = conversion.robot, conversion.inserted
    base = {inserted, robot.joints[inserted].parent} if inserted in robot.joints else set()
    try:
        after = snapshot(robot)
    except (TypeError, ValueError) as error:
        raise ConversionError(
            "plugin-robot-broken",
            f"{by} (plugin '{plugin}') leaves in robot '{robot.name}' what no URDF can hold: "
            f"{error}",
        ) from error
    changes = [
        change
        for change in between(before, after)
        if not (change.kind in ("link-added", "joint-added") and change.name in base)
    ]
    if changes:
        conversion.changed.append(RobotChange(by, plugin, declared, changes))
