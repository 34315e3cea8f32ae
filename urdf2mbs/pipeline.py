"""Resolves a config's passes, checks what each needs against what is given, and runs them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec

from urdf2mbs.config import Config, Key, Lines, Project, preset, presets, typed
from urdf2mbs.conversion import Conversion, LinkFrame, Names, Settings
from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic, nearest
from urdf2mbs.faults import check_left, hook_failed, pass_failed
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.plugins import FAILURES, GROUP, Found, Plugins
from urdf2mbs.urdf.model import Robot


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
    if isinstance(config.output, Project):
        project = _path(folder / config.output.project)
        output = project / "dataR" / f"{project.name}.mbs"
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
        source, output, config.base, packages, dict(config.xacro_args), config.gravity, project
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


class Result:
    """What a conversion gives: the model, the file's bytes, and the report."""

    def __init__(self, conversion: Conversion) -> None:
        self.conversion = conversion

    @property
    def mbs(self) -> Mbs:
        return self.conversion.mbs

    @property
    def data(self) -> bytes:
        """The .mbs file."""
        conversion = self.conversion
        return conversion.files[conversion.rejected or conversion.settings.output]

    @property
    def robot(self) -> Robot:
        """The URDF's robot, with the base that was inserted."""
        return self.conversion.robot

    @property
    def names(self) -> Names:
        return self.conversion.names

    @property
    def frames(self) -> dict[str, LinkFrame]:
        """Where each URDF link's frame is in the .mbs."""
        return self.conversion.frames

    @property
    def frozen(self) -> dict[str, str]:
        """Moving URDF joints that are not in the .mbs, and why."""
        return self.conversion.frozen

    @property
    def diagnostics(self) -> list[Diagnostic]:
        return self.conversion.diagnostics

    @property
    def report(self) -> dict[str, Any]:
        return report(self.conversion)


def convert(
    source: str | os.PathLike[str],
    *,
    base: str = "auto",
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    xacro_args: Mapping[str, str] | None = None,
    pipeline: str | list[str] = "faithful",
    options: Mapping[str, Mapping[str, Any]] | None = None,
    plugins: Sequence[str | os.PathLike[str]] = (),
    after: Mapping[str, str | list[str]] | None = None,
    swap: Mapping[str, str] | None = None,
) -> Result:
    """Convert a URDF or xacro file, without writing anything.

    ``base`` is ``auto``, ``floating`` or ``fixed``; ``packages`` maps ROS packages to
    directories; ``options`` maps passes to their options; ``plugins`` are Python files,
    ``after`` maps a pass to those to put right after it, ``swap`` a pass to the plugin whose
    pass of the same name replaces it.  Paths are relative to the working folder.
    Raises ConversionError.
    """
    given = {
        "source": os.fspath(source),
        "base": base,
        "packages": {name: os.fspath(path) for name, path in (packages or {}).items()},
        "xacro_args": dict(xacro_args or {}),
        "pipeline": pipeline,
        "passes": {name: dict(values) for name, values in (options or {}).items()},
        "plugins": [os.fspath(plugin) for plugin in plugins],
        "after": dict(after or {}),
        "swap": dict(swap or {}),
    }
    lines = Lines()
    return Result(Pipeline(typed(Config, given, lines), lines).run())


def report(conversion: Conversion) -> dict[str, Any]:
    """What became of the robot, as plain data for JSON."""
    mbs, robot = conversion.mbs, conversion.robot
    joints = [joint for body in mbs.bodies for joint in body.joints]
    driven = sum(joint.nature == "driven" for joint in joints)
    inserted = 1 if conversion.inserted else 0
    return {
        "robot": robot.name,
        "source": str(conversion.settings.source),
        "output": str(conversion.settings.output),
        "base": "floating" if conversion.floating else "fixed",
        "links": len(robot.links) - inserted,
        "bodies": len(mbs.bodies),
        "joints": {
            "urdf": len(robot.joints) - inserted,
            "mbs": len(joints),
            "independent": len(joints) - driven,
            "driven": driven,
            "per_degree_of_freedom": len(joints) / max(len(joints) - driven, 1),
        },
        "mass": sum(body.mass or 0.0 for body in mbs.bodies),
        "gravity": mbs.base.gravity,
        "names": msgspec.to_builtins(conversion.names),
        "numbers": mbs.numbers(),
        "frames": {
            link: {
                "body": frame.body,
                "joint": frame.joint,
                "xyz": frame.pose.xyz,
                "rotation": frame.pose.rot,
            }
            for link, frame in conversion.frames.items()
        },
        "frozen": conversion.frozen,
        "diagnostics": [msgspec.to_builtins(found) for found in conversion.diagnostics],
        **conversion.report,
    }


#: In a project folder, what we wrote there, in the form of ``sha256sum``.
RECORD = ".urdf2mbs"


def write(conversion: Conversion) -> None:
    """Write what a conversion made, and for a project the folders that Robotran expects.

    An .mbs in a project that was edited since (in MBSysPad, say) is not ours any more and is
    never overwritten: that is a ConfigError.
    """
    settings = conversion.settings
    files = dict(conversion.files)
    if settings.project is not None and settings.output in files:
        record = settings.project / RECORD
        line = _checksum(settings.project, settings.output, files[settings.output])
        if settings.output.exists():
            there = _checksum(settings.project, settings.output, settings.output.read_bytes())
            if there != line and not (record.exists() and record.read_text("utf-8") == there):
                raise ConfigError(
                    "output-not-ours",
                    f"'{settings.output}' was not written by urdf2mbs, or was edited since",
                    hint="move it away, or convert into another project",
                )
        files[record] = line.encode()
    write_files(files)
    if settings.project is not None:
        for name in ("animationR", "dataR", "symbolicR", "userfctR", "workR"):
            (settings.project / name).mkdir(exist_ok=True)


def _checksum(folder: Path, file: Path, data: bytes) -> str:
    from hashlib import sha256

    return f"{sha256(data).hexdigest()}  {file.relative_to(folder).as_posix()}\n"


def write_files(files: Mapping[Path, bytes]) -> None:
    """Write each file beside its place, then rename all: there is never half a file.

    Raises ConfigError where a folder or file cannot be written.
    """
    parts: list[tuple[Path, Path]] = []
    path = Path()
    try:
        for path, data in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            part = path.with_name(f".{path.name}.{os.getpid()}.part")
            parts.append((part, path))
            part.write_bytes(data)
        for part, path in parts:
            part.replace(path)
    except OSError as error:
        raise ConfigError(
            "output-unwritable", f"cannot write '{path}': {error.strerror or error}"
        ) from None
    finally:
        for part, _ in parts:
            part.unlink(missing_ok=True)
