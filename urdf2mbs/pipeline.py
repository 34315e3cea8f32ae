"""Resolves a config's passes, checks what each needs against what is given, and runs them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec

from urdf2mbs.config import Config, Key, Lines, Project, preset, presets, typed
from urdf2mbs.conversion import Conversion, Settings
from urdf2mbs.diagnostics import ConfigError, ConversionError, nearest
from urdf2mbs.faults import check_left, hook_failed, pass_failed
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.plugins import FAILURES, GROUP, Found, Plugins


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
        self.passes = _resolve(config, lines, self.plugins)
        check_order(
            [bound.found.pass_ for bound in self.passes], lines, [one.at for one in self.passes]
        )

    def run(self, *, stop_after: str | None = None) -> Conversion:
        """Run the passes; raises ConversionError. Nothing is written to disk."""
        names = [bound.found.pass_.name for bound in self.passes]
        if stop_after is not None and stop_after not in names:
            raise ConfigError(
                "unknown-pass", f"there is no pass '{stop_after}' in this pipeline to stop after",
                hint=nearest(stop_after, names) or f"there are: {', '.join(names)}",
            )  # fmt: skip
        conversion = Conversion(self.settings)
        for plugin, brought in self._idle():
            conversion.warn(
                "plugin-idle",
                f"plugin '{plugin}' does nothing: none of its passes is in the pipeline "
                f"({', '.join(brought)})",
                hint=f"put one in, such as 'after: {{{self._place(brought[0])}: {brought[0]}}}'",
            )
        ran: list[Found] = []
        for bound in self.passes:
            found = bound.found
            pass_ = found.pass_
            self._call("urdf2mbs_before_pass", pass_, conversion)
            known = bool(conversion.robot.links)
            start = perf_counter()
            try:
                pass_.run(conversion, bound.options)
                seconds = perf_counter() - start
                if found.plugin != GROUP:
                    check_left(found, conversion, known)
            except ConversionError:
                raise
            except FAILURES as error:
                raise pass_failed(found, conversion, error, ran) from error
            ran.append(found)
            self._call("urdf2mbs_after_pass", pass_, conversion, seconds=seconds)
            if pass_.name == stop_after:
                break
        return conversion

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
        try:
            getattr(self.plugins.hook, hook)(pass_=pass_, conversion=conversion, **more)
        except ConversionError:
            raise
        except FAILURES as error:
            plugin = self.plugins.blame(error.__traceback__)
            if plugin is None:
                raise
            raise hook_failed(hook, *plugin, pass_.name, conversion, error) from error


def check_order(
    passes: Sequence[Pass], lines: Lines | None = None, keys: Sequence[Key] | None = None
) -> None:
    """Every need must be given by an earlier pass, and nothing by two; raises ConfigError.

    ``keys`` say where in the config each pass is named.
    """
    lines = lines or Lines()
    keys = keys or [()] * len(passes)
    givers: dict[str, str] = {}
    for pass_, at in zip(passes, keys, strict=True):
        for token in pass_.gives:
            if token in givers:
                raise lines.error(
                    "given-twice",
                    f"passes '{givers[token]}' and '{pass_.name}' both give '{token}'",
                    at, "leave one of them out of the pipeline",
                )  # fmt: skip
            givers[token] = pass_.name
    given: set[str] = set()
    for pass_, at in zip(passes, keys, strict=True):
        for token in pass_.needs:
            if token not in givers:
                raise lines.error(
                    "need-not-given",
                    f"pass '{pass_.name}' needs '{token}', which no pass of this pipeline gives",
                    at, "'urdf2mbs passes' lists what each pass gives; put one that does before it",
                )  # fmt: skip
            giver = givers[token]
            if token not in given:
                raise lines.error(
                    "wrong-order",
                    f"pass '{pass_.name}' needs '{token}', which '{giver}' gives only later",
                    at, f"put it after: 'after: {{{giver}: {pass_.name}}}', or so in 'pipeline'",
                )  # fmt: skip
        given.update(pass_.gives)


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
        output = _path(folder / f"{source.name.split('.')[0]}.mbs")
    if output == source:
        raise lines.error(
            "output-is-source", f"the output would overwrite the robot '{source}'", ("output",)
        )
    if output.is_dir():
        raise lines.error(
            "output-is-folder",
            f"the output '{output}' is a folder",
            ("output",),
            "name the .mbs file",
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
        languages, _path(folder),
    )  # fmt: skip


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
