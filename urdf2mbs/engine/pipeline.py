"""Resolves a config's passes, checks what each needs against what is given, and runs them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion, RobotChange, Settings
from urdf2mbs.diagnostics import ConfigError, ConversionError, nearest
from urdf2mbs.engine.config import Config, Key, Lines, Project, preset, presets, typed
from urdf2mbs.engine.faults import check_left, hook_failed, pass_failed
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.engine.plugins import FAILURES, GROUP, Found, Plugins
from urdf2mbs.levels import DEFAULTS, Levels
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.urdf.changes import between, snapshot
from urdf2mbs.urdf.reader import stem


class Bound(msgspec.Struct):
    """A pass of a pipeline, with its options."""

    found: Found
    options: Any
    swapped: bool = False
    """Whether it stands in for the built-in pass of its name."""
    at: Key = ()
    """Where in the config it is named."""


class Pipeline:
    """The passes of one config, in an order that has been checked."""

    def __init__(self, config: Config, lines: Lines, *, installed_plugins: bool = True) -> None:
        folder = lines.file.parent if lines.file else Path()
        self.settings = _settings(config, lines, folder)
        files = [folder / file for file in config.plugins]
        for index, file in enumerate(files):
            if not file.is_file():
                raise lines.error(
                    "plugin-missing", f"plugin file '{file}' does not exist", ("plugins", index)
                )
        self._files = files
        self.plugins = Plugins(files, installed=installed_plugins)
        try:
            self.passes = _resolve(config, lines, self.plugins)
        except ConfigError as error:
            # what is missing may be in a plugin that was left out
            error.hint = "\n  ".join([error.hint or "", *map(str, self.plugins.broken)]).lstrip()
            raise
        self._check_levels(config, lines)
        passes = [bound.found.pass_ for bound in self.passes]
        check_order(passes, lines, [one.at for one in self.passes])
        _check_output(self.settings, passes, lines)

    def run(self, *, stop_after: str | None = None) -> Conversion:
        """Run the passes; raises ConversionError. Nothing is written to disk.

        What is said gets the user's levels here, and only here: after each pass, and with the
        error that ends a run.  An error of which something can be made is raised at the end, so
        that all are told at once.
        """
        names = [bound.found.pass_.name for bound in self.passes]
        if stop_after is not None and stop_after not in names:
            raise ConfigError(
                "unknown-pass", f"there is no pass '{stop_after}' in this pipeline to stop after",
                hint=nearest(stop_after, names) or f"there are: {', '.join(names)}",
            )  # fmt: skip
        conversion = Conversion(self.settings)
        conversion.diagnostics += self.plugins.broken
        for plugin, brought in self._idle():
            conversion.warn(
                "plugin-idle",
                f"plugin '{plugin}' does nothing: none of its passes is in the pipeline "
                f"({', '.join(brought)})",
                hint=f"put one in, such as 'after: {{{self._place(brought[0])}: {brought[0]}}}'",
            )
        levels = self.settings.levels
        try:
            self._run(conversion, stop_after)
        except ConversionError as error:
            error.said = levels.applied([*conversion.diagnostics, *error.said])
            raise
        levels.judge(conversion.diagnostics)
        return conversion

    def _run(self, conversion: Conversion, stop_after: str | None) -> None:
        levels = self.settings.levels
        ran: list[Found] = []
        for bound in self.passes:
            found = bound.found
            pass_ = found.pass_
            self._call("urdf2mbs_before_pass", pass_, conversion)
            known = bool(conversion.robot.links)
            before = snapshot(conversion.robot) if known and _may_change(bound) else None
            start = perf_counter()
            try:
                pass_.run(conversion, bound.options)
                seconds = perf_counter() - start
                if found.plugin != GROUP:
                    check_left(found, conversion, known)
                if before is not None:
                    declared = "robot" in pass_.changes
                    _note_change(conversion, before, pass_.name, found.plugin, declared)
            except ConversionError:
                raise
            except FAILURES as error:
                raise pass_failed(found, conversion, error, ran) from error
            ran.append(found)
            conversion.diagnostics = levels.applied(conversion.diagnostics)
            self._call("urdf2mbs_after_pass", pass_, conversion, seconds=seconds)
            if pass_.name == stop_after:
                break

    def _check_levels(self, config: Config, lines: Lines) -> None:
        """A code is one whose level can be changed, or may be a plugin's."""
        if any(name != GROUP for name in self.plugins.names()):
            return
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
        used = {bound.found.plugin for bound in self.passes}
        return [
            (file.stem, self.plugins.only_passes(file.stem))
            for file in self._files
            if file.stem not in used and self.plugins.only_passes(file.stem)
        ]

    def _place(self, name: str) -> str:
        """After which pass of the pipeline all that a pass needs is given."""
        needs = set(self.plugins.passes[name][0].pass_.needs)
        givers = [b.found.pass_.name for b in self.passes if needs & set(b.found.pass_.gives)]
        return (givers or [self.passes[0].found.pass_.name])[-1]

    def _call(self, hook: str, pass_: Pass, conversion: Conversion, **more: float) -> None:
        """Call a hook of all plugins."""
        strangers = self.plugins.hooked(hook)
        before = snapshot(conversion.robot) if strangers else None
        try:
            getattr(self.plugins.hook, hook)(pass_=pass_, conversion=conversion, **more)
            if before is not None:
                when = "before" if "before" in hook else "after"
                who = f"the hook {when} '{pass_.name}'"
                _note_change(conversion, before, who, "' or '".join(strangers), declared=False)
        except ConversionError:
            raise
        except FAILURES as error:
            plugin = self.plugins.blame(error.__traceback__)
            if plugin is None:
                raise
            raise hook_failed(hook, *plugin, pass_.name, conversion, error) from error


def _may_change(bound: Bound) -> bool:
    """Whether a pass may change the robot that the URDF states: any of a plugin, and of ours
    those that do when they are told to (insert-base only puts a base under it)."""
    found = bound.found
    return found.plugin != GROUP or (
        "robot" in found.pass_.changes and bound.options != found.pass_.options()
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


def check_order(
    passes: Sequence[Pass], lines: Lines | None = None, keys: Sequence[Key] | None = None
) -> None:
    """Every need must be given by an earlier pass and still hold; raises ConfigError.

    ``keys`` say where in the config each pass is named.
    """
    lines = lines or Lines()
    known = _Known(passes, lines)
    for pass_, at in zip(passes, keys or [()] * len(passes), strict=True):
        for token in (*pass_.needs, *pass_.changes):
            known.need(token, pass_, at)
        for token in pass_.changes:
            known.change(token, pass_)
        for token in pass_.gives:
            known.give(token, pass_, at)
    known.end()


class _Known:
    """What is known at one place of a pipeline, and what of it no longer holds."""

    def __init__(self, passes: Sequence[Pass], lines: Lines) -> None:
        self.lines = lines
        self.ever = {token: pass_.name for pass_ in reversed(passes) for token in pass_.gives}
        """Who first gives each token, here or later."""
        self.giver: dict[str, str] = {}
        self.sources: dict[str, set[str]] = {}
        """What each token was derived from, all the way."""
        self.stale: dict[str, tuple[str, str]] = {}
        """The tokens that no longer hold: who changed which of their sources."""

    def need(self, token: str, pass_: Pass, at: Key) -> None:
        if token not in self.ever:
            raise self.lines.error(
                "need-not-given",
                f"pass '{pass_.name}' needs '{token}', which no pass of this pipeline gives",
                at, "'urdf2mbs passes' lists what each pass gives; put one that does before it",
            )  # fmt: skip
        if token not in self.giver:
            giver = self.ever[token]
            raise self.lines.error(
                "wrong-order",
                f"pass '{pass_.name}' needs '{token}', which '{giver}' gives only later",
                at, f"put it after: 'after: {{{giver}: {pass_.name}}}', or so in 'pipeline'",
            )  # fmt: skip
        if token in self.stale:
            giver, (changer, source) = self.giver[token], self.stale[token]
            raise self.lines.error(
                "stale",
                f"pass '{pass_.name}' needs '{token}', which '{giver}' made from '{source}' "
                f"before pass '{changer}' changed that",
                at, f"put '{changer}' before '{giver}'",
            )  # fmt: skip

    def change(self, token: str, pass_: Pass) -> None:
        for other, sources in self.sources.items():
            if token in sources and other not in pass_.changes:
                self.stale.setdefault(other, (pass_.name, token))
        self.sources[token] |= self._sources(pass_) - {token}

    def give(self, token: str, pass_: Pass, at: Key) -> None:
        if token in self.giver and token not in self.stale:
            raise self.lines.error(
                "given-twice",
                f"passes '{self.giver[token]}' and '{pass_.name}' both give '{token}'",
                at, "leave one of them out of the pipeline",
            )  # fmt: skip
        self.stale.pop(token, None)
        self.giver[token] = pass_.name
        self.sources[token] = self._sources(pass_)

    def _sources(self, pass_: Pass) -> set[str]:
        tokens = {*pass_.needs, *pass_.changes}
        return tokens.union(*(self.sources[token] for token in tokens))

    def end(self) -> None:
        """What a pass made and another made stale would be written all the same."""
        for token, (changer, source) in reversed(self.stale.items()):
            raise self.lines.error(
                "stale",
                f"pass '{changer}' changes '{source}' after pass '{self.giver[token]}' made "
                f"'{token}' from it",
                hint=f"put '{changer}' before '{self.giver[token]}'",
            )


def _settings(config: Config, lines: Lines, folder: Path) -> Settings:
    source = _path(folder / config.source)
    project = None
    languages: tuple[str, ...] = ()
    if isinstance(config.output, Project):
        project = _path(folder / config.output.project)
        output = project / "dataR" / f"{identifiers([project.name])[0]}.mbs"
        language = config.output.language
        if language == "both":
            language = ["python", "c"]
        languages = (language,) if isinstance(language, str) else tuple(dict.fromkeys(language))
    elif config.output is not None:
        output = _path(folder / config.output)
    else:
        output = _path(folder / f"{stem(source)}.mbs")
    if not all(map(isfinite, config.gravity)):
        raise lines.error(
            "gravity-infinite",
            f"gravity is {list(config.gravity)}: each part must be a finite number, in m/s^2",
            ("gravity",),
        )
    packages = {}
    for name, directory in config.packages.items():
        packages[name] = _path(folder / directory)
        if not packages[name].is_dir():
            raise lines.error(
                "package-missing",
                f"package '{name}': there is no folder '{packages[name]}'",
                ("packages", name),
            )
    return Settings(
        source, output, config.base, packages, dict(config.xacro_args), config.gravity, project,
        Levels(config.diagnostics, config.strict), languages, _path(folder),
    )  # fmt: skip


def _check_output(settings: Settings, passes: Sequence[Pass], lines: Lines) -> None:
    """Where an .mbs is written to; a pipeline that makes none needs no place."""
    if not any("mbs-file" in pass_.gives for pass_ in passes) or settings.source.is_dir():
        return
    if settings.output == settings.source:
        raise lines.error(
            "output-is-source",
            f"the output would overwrite the robot '{settings.source}'",
            ("output",),
        )
    if settings.output.is_dir():
        raise lines.error(
            "output-is-folder",
            f"the output '{settings.output}' is a folder",
            ("output",),
            "name the .mbs file; for a whole project: 'output: {project: FOLDER}'",
        )


def _path(path: Path) -> Path:
    return Path(os.path.abspath(path))  # noqa: PTH100 unlike resolve(), links keep their name


def _resolve(config: Config, lines: Lines, plugins: Plugins) -> list[Bound]:
    names: list[str]
    options: dict[str, dict[str, Any]] = {}
    if isinstance(config.pipeline, str):
        names, options = preset(config.pipeline, lines)
    else:
        names = config.pipeline
    known = plugins.passes
    names, keys = _placed(names, config, known, lines)
    for key, mentioned in (("passes", config.passes), ("swap", config.swap)):
        for name in mentioned:
            if name not in names:
                why = "is not in this pipeline" if name in known else ""
                raise _unknown(lines, (key, name), name, [*names, *known], why)
    bound: list[Bound] = []
    for index, (name, at) in enumerate(zip(names, keys, strict=True)):
        if name not in known:
            hint = (
                "a preset's name stands alone: 'pipeline: " + name + "'"
                if name in presets()
                else ""
            )
            raise _unknown(lines, at, name, known, "", hint)
        if name in names[:index]:
            mine = [key for key in (keys[names.index(name)], at) if key[0] == "after"]
            raise lines.error(
                "pass-doubled", f"pass '{name}' is in the pipeline twice", (*mine, at)[0]
            )
        found = _chosen(name, known[name], config.swap.get(name), lines)
        given = {**options.get(name, {}), **config.passes.get(name, {})}
        filled = typed(found.pass_.options, given, lines, ("passes", name))
        bound.append(Bound(found, filled, name in config.swap, at))
    return bound


def _placed(
    names: list[str], config: Config, known: Mapping[str, Any], lines: Lines
) -> tuple[list[str], list[Key]]:
    """The pipeline with what the config puts ``after`` its passes, and where each is named."""
    out: list[str] = []
    keys: list[Key] = []
    todo: list[tuple[str, Key]] = [(name, ("pipeline", n)) for n, name in enumerate(names)]
    todo.reverse()
    placed: set[str] = set()
    while todo:
        name, key = todo.pop()
        out.append(name)
        keys.append(key)
        if name in config.after and name not in placed:
            placed.add(name)
            followers = config.after[name]
            followers = [followers] if isinstance(followers, str) else followers
            todo += [(follower, ("after", name)) for follower in reversed(followers)]
    for name in config.after:
        if name not in placed:
            why = "is not in this pipeline" if name in known else ""
            raise _unknown(lines, ("after", name), name, [*out, *known], why)
    return out, keys


def _chosen(name: str, offered: list[Found], plugin: str | None, lines: Lines) -> Found:
    by_plugin = {found.plugin: found for found in offered}
    if plugin is not None:
        if plugin not in by_plugin:
            raise lines.error(
                "unknown-plugin", f"no plugin '{plugin}' brings a pass '{name}'", ("swap", name),
                nearest(plugin, by_plugin) or f"those that do: {', '.join(by_plugin)}",
            )  # fmt: skip
        return by_plugin[plugin]
    if GROUP in by_plugin:
        return by_plugin[GROUP]
    if len(offered) > 1:
        raise ConfigError(
            "pass-ambiguous", f"plugins {' and '.join(by_plugin)} each bring a pass '{name}'",
            hint=f"say which: 'swap: {{{name}: {offered[0].plugin}}}'",
        )  # fmt: skip
    return offered[0]


def _unknown(lines: Lines, at: Key, name: str, known: Any, why: str, hint: str = "") -> ConfigError:
    return lines.error(
        "unknown-pass", f"pass '{name}' {why}" if why else f"there is no pass '{name}'", at,
        hint or nearest(name, known) or "'urdf2mbs passes' lists all",
    )  # fmt: skip
