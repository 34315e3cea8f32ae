"""The commands: what the words of the command line mean, and what is printed."""

from __future__ import annotations

import argparse
import io
import json
import os
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, ConversionError, counted
from urdf2mbs.engine.config import Config, Lines, load, preset, presets, typed, word
from urdf2mbs.engine.hookspecs import Pass, hookimpl
from urdf2mbs.engine.pipeline import Bound, Pipeline
from urdf2mbs.engine.plugins import GROUP, Found, Plugins
from urdf2mbs.kit.dump import Dump
from urdf2mbs.output import write, write_files
from urdf2mbs.summary import Joints, Report, report


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same)."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # a robot's name may have letters that this terminal or pipe has not
            stream.reconfigure(errors="backslashreplace")
    arguments = _parser().parse_args(argv)
    try:
        code: int = arguments.command(arguments)
        sys.stdout.flush()
        return code
    except ConversionError as error:
        if arguments.debug:
            raise
        print(error, file=sys.stderr)
        if getattr(arguments, "json", False):
            _print_json(
                {
                    "error": {
                        k: getattr(error, k) for k in ("code", "message", "file", "line", "hint")
                    },
                    "diagnostics": error.said,
                }
            )
        return error.exit_code
    except BrokenPipeError:
        # whoever read our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return 130


class _Version(argparse.Action):
    def __init__(self, option_strings: list[str], dest: str, **more: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **more)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version  # which takes time

        print(f"urdf2mbs {version('urdf2mbs')}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="urdf2mbs", description="Convert URDF and xacro robots to Robotran .mbs files."
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--debug", action="store_true", help="show the traceback of an error")
    common.add_argument("--no-plugins", action="store_true", help="leave out installed plugins")
    common.add_argument("--json", action="store_true", help="print the whole report as JSON")

    running = argparse.ArgumentParser(add_help=False)
    running.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )
    running.add_argument("--stop-after", metavar="PASS", help="run the passes up to this one")
    running.add_argument(
        "--dump", type=Path, metavar="DIR", help="write the state after every pass, as YAML"
    )

    levels = argparse.ArgumentParser(add_help=False)
    levels.add_argument(
        "--level", action="append", default=[], metavar="CODE=LEVEL",
        help="how much a warning weighs: error, warning, note or ignore",
    )  # fmt: skip
    levels.add_argument("--strict", action="store_true", help="warnings are errors")

    run = commands.add_parser(
        "run", parents=[common, running, levels], help="convert as a config file says"
    )
    run.add_argument("config", type=Path, metavar="CONFIG.yaml")
    run.set_defaults(command=_run)

    convert = commands.add_parser(
        "convert",
        parents=[common, running, levels],
        help="convert one robot, without a config file",
    )
    convert.add_argument("robot", metavar="ROBOT", help="a .urdf or .xacro file")
    convert.add_argument(
        "-o", "--output", metavar="OUT.mbs",
        help="the file; an existing folder, or DIR/, gets a whole Robotran project",
    )  # fmt: skip
    _add_settings(convert)
    convert.set_defaults(command=_convert)

    explain = commands.add_parser(
        "explain",
        parents=[common, levels],
        help="show the passes of a config, without running them",
    )
    explain.add_argument("config", type=Path, metavar="CONFIG.yaml")
    explain.add_argument(
        "--cost", action="store_true",
        help="convert after all, by each preset too, to count the joints; nothing is written",
    )  # fmt: skip
    explain.set_defaults(command=_explain)

    passes = commands.add_parser("passes", parents=[common], help="list every known pass")
    passes.add_argument("--plugin", action="append", default=[], metavar="FILE.py")
    passes.set_defaults(command=_passes)

    new = commands.add_parser(
        "new-pass", parents=[common], help="write a plugin with one pass, and its test"
    )
    new.add_argument("name", metavar="NAME")
    new.add_argument("-o", "--output", type=Path, metavar="DIR", default=Path())
    new.set_defaults(command=_new_pass)

    schema = commands.add_parser(
        "schema", parents=[common], help="print the JSON schema of a config, for editors"
    )
    schema.add_argument("--plugin", action="append", default=[], metavar="FILE.py")
    schema.set_defaults(command=_schema)

    page = commands.add_parser(
        "report",
        parents=[common, levels],
        help="convert, and write one HTML page to look at instead",
    )
    page.add_argument(
        "config", type=Path, metavar="CONFIG.yaml",
        help="or a .urdf or .xacro file, with the options below",
    )  # fmt: skip
    page.add_argument(
        "-o", "--output", type=Path, metavar="OUT.html", help="default: beside the output"
    )
    page.add_argument("-v", "--verbose", action="store_true", help="show each pass and all notes")
    _add_settings(page)
    page.set_defaults(command=_report)

    verify = commands.add_parser(
        "verify", parents=[common], help="compare a robot with an .mbs file: are they the same?"
    )
    verify.add_argument("robot", metavar="ROBOT", help="a .urdf or .xacro file")
    verify.add_argument("model", type=Path, metavar="MODEL.mbs")
    verify.add_argument("--package", action="append", default=[], metavar="NAME=DIR")
    verify.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )
    verify.add_argument(
        "--engine", choices=("own", "pinocchio"), default="own",
        help="pinocchio also compares mass matrix, gravity forces and inverse dynamics",
    )  # fmt: skip
    verify.add_argument(
        "--gravity", type=float, nargs=3, default=(0.0, 0.0, -9.81), metavar=("X", "Y", "Z"),
        help="what the .mbs should have, in m/s^2 (0 0 -9.81): a URDF has none",
    )  # fmt: skip
    verify.add_argument(
        "--frames", action="store_true",
        help="a link's frame that is elsewhere in the .mbs is a difference, too",
    )  # fmt: skip
    verify.add_argument("--tolerance", type=float, default=1e-9, help="relative (%(default)s)")
    verify.set_defaults(command=_verify)

    diagram = commands.add_parser(
        "diagram", parents=[common], help="draw the 2D diagram of an .mbs file as an SVG picture"
    )
    diagram.add_argument("model", type=Path, metavar="MODEL.mbs")
    diagram.add_argument(
        "-o", "--output", type=Path, metavar="OUT.svg", help="default: beside the model"
    )
    diagram.set_defaults(command=_diagram)

    equations = commands.add_parser(
        "equations", parents=[common], help="write Robotran's equations for an .mbs file"
    )
    equations.add_argument("model", type=Path, metavar="MODEL.mbs")
    equations.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="default: symbolicR of the project"
    )
    equations.add_argument("--language", choices=("python", "c"), default="python")
    equations.add_argument(
        "--fold", action="store_true", help="write masses, points and the like as numbers"
    )
    equations.add_argument(
        "--keep-turns", action="store_true",
        help="read the positions of joints that never move, too",
    )  # fmt: skip
    equations.add_argument(
        "--numba", action="store_true", help="let numba compile dirdyna and invdyna (python)"
    )
    equations.set_defaults(command=_equations)
    return parser


def _add_settings(command: argparse.ArgumentParser) -> None:
    """What a config says, for a robot without one."""
    command.add_argument("--base", choices=("auto", "floating", "fixed"))
    command.add_argument("--package", action="append", default=[], metavar="NAME=DIR")
    command.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )
    command.add_argument("--pipeline", metavar="PRESET", help="default: faithful")
    command.add_argument("--plugin", action="append", default=[], metavar="FILE.py")
    command.add_argument(
        "--after", action="append", default=[], metavar="PASS=NEW", help="put NEW after PASS"
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="PASS.OPTION=VALUE", help="option of a pass"
    )


def _run(arguments: argparse.Namespace) -> int:
    return _carry_out(*_configured(arguments), arguments)


def _configured(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config file, with the levels of the command line."""
    return _with_levels(*load(arguments.config), arguments)


def _with_levels(
    config: Config, lines: Lines, arguments: argparse.Namespace
) -> tuple[Config, Lines]:
    given = typed(Config, {"source": config.source, **_levels(arguments)}, Lines())
    config.diagnostics = {**config.diagnostics, **given.diagnostics}
    config.strict = config.strict or given.strict
    return config, lines


def _levels(arguments: argparse.Namespace) -> dict[str, Any]:
    pairs = _pairs(arguments.level, "=", "--level", "CODE=LEVEL")
    return {"diagnostics": dict(pairs), "strict": arguments.strict}


def _convert(arguments: argparse.Namespace) -> int:
    output: Any = arguments.output
    if output == "":
        raise ConfigError("usage", "--output: the name of the file is empty")
    if output is not None and (output.endswith(_SEPARATORS) or Path(output).is_dir()):
        output = {"project": output}
    config, lines = _without_config(arguments.robot, output, arguments)
    return _carry_out(config, lines, arguments)


#: What ends the name of a folder.
_SEPARATORS = tuple(filter(None, (os.sep, os.altsep)))


def _without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config that the command line stands for."""
    options: dict[str, dict[str, Any]] = {}
    for key, value in _pairs(arguments.set, "=", "--set", "PASS.OPTION=VALUE"):
        pass_, dot, option = key.rpartition(".")
        if not dot:
            raise ConfigError("usage", f"--set {key}={value}: it reads PASS.OPTION=VALUE")
        options.setdefault(pass_, {})[option] = word(value)
    after: dict[str, list[str]] = {}
    for pass_, new in _pairs(arguments.after, "=", "--after", "PASS=NEW"):
        after.setdefault(pass_, []).append(new)
    given = {
        "source": robot,
        "output": output,
        "base": arguments.base or "auto",
        "packages": dict(_pairs(arguments.package, "=", "--package", "NAME=DIR")),
        "xacro_args": dict(_pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        "pipeline": arguments.pipeline or "faithful",
        "plugins": arguments.plugin,
        "after": after,
        "passes": options,
        **_levels(arguments),
    }
    lines = Lines()
    return typed(Config, given, lines), lines


def _verify(arguments: argparse.Namespace) -> int:
    from urdf2mbs.api import verify
    from urdf2mbs.proof.urdf_side import SIX

    verdict = verify(
        arguments.robot,
        arguments.model,
        packages=dict(_pairs(arguments.package, "=", "--package", "NAME=DIR")),
        xacro_args=dict(_pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        engine=arguments.engine,
        frames=arguments.frames,
        gravity=tuple(arguments.gravity),
        tolerance=arguments.tolerance,
    )
    code = 0 if verdict.same else 3
    if arguments.json:
        _print_json({"same": verdict.same, **msgspec.to_builtins(verdict)})
        return code
    own = [f"'{name}'" for name, joints in verdict.joints.items() if len(joints) == len(SIX)]
    base = ", and the floating base" if verdict.floating_base else ", the base is fixed"
    if own:
        base = f", {', '.join(own)} floats"
    print(f"{verdict.robot}: {len(verdict.joints)} of {verdict.moving} joints match by name{base}")
    print(f"  {verdict.mbs_mass:.6g} kg move in the .mbs, {verdict.urdf_mass:.6g} kg in the URDF")
    if verdict.flipped:
        print(f"  {_other_way(verdict.flipped)}")
    print(f"  {_proof(verdict.groups, verdict.positions, verdict.largest)}")
    if verdict.differences:
        print("not the same, by relative size:")
    for difference in verdict.differences:
        print(f"  {difference.size:8.2e}  {difference.message}")
    if verdict.frames:
        print("frames that are elsewhere, which by itself is no difference:")
    for difference in verdict.frames[:SHOWN]:
        print(f"  {difference.size:8.2e}  {difference.message}")
    if len(verdict.frames) > SHOWN:
        print(f"  and {len(verdict.frames) - SHOWN} more, which --json lists")
    for what, why in verdict.not_compared.items():
        print(f"not compared: {what}: {why}")
    for problem in verdict.schema:
        print(problem, file=sys.stderr)
    print("the same robot" if verdict.same else "NOT the same robot")
    return code


#: So many frames that are elsewhere are told; a compact model has moved nearly all.
SHOWN = 10


def _proof(groups: int, positions: int, largest: dict[str, float]) -> str:
    found = ", ".join(f"{kind} {off:.1e}" for kind, off in largest.items())
    return f"{counted(groups, 'rigid group')} at {positions} positions; largest deviations: {found}"


def _pairs(words: list[str], sign: str, flag: str, form: str) -> list[tuple[str, str]]:
    pairs = []
    for given in words:
        name, found, value = given.partition(sign)
        if not found or not name:
            raise ConfigError("usage", f"{flag} {given}: it reads {flag} {form}")
        pairs.append((name, value))
    return pairs


def _carry_out(config: Config, lines: Lines, arguments: argparse.Namespace) -> int:
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with _Progress(arguments.verbose) as progress:
        pipeline.plugins.watch(progress)
        dump = None if arguments.dump is None else Dump(arguments.dump)
        if dump is not None:
            pipeline.plugins.watch(dump)
        try:
            conversion = pipeline.run(stop_after=arguments.stop_after)
        finally:
            if dump is not None:
                dump.finish()
    write(conversion)
    found = report(conversion)
    if arguments.json:
        _print_json(found)
    else:
        _summarise(conversion, found, arguments)
        fewer = _fewer(conversion, config, lines, arguments)
        if fewer:
            print(f"  {fewer}")
    return 0 if conversion.rejected is None else 3


class _Progress:
    """Says on stderr where a run is: each pass with its time if asked, else only when it lasts."""

    PATIENCE = 2.0
    """Seconds of silence."""

    def __init__(self, verbose: bool) -> None:
        self._verbose = verbose
        self._at = ""
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._speak, daemon=True)

    def __enter__(self) -> _Progress:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()

    def _speak(self) -> None:
        while not self._done.wait(self.PATIENCE):
            print(f"... {self._at}", file=sys.stderr)

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass, conversion: Conversion) -> None:
        self._at = pass_.name

        def progress(text: str) -> None:
            self._at = f"{pass_.name}: {text}"

        conversion.progress = progress

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, seconds: float) -> None:
        if self._verbose:
            print(f"{1000 * seconds:9.2f} ms  {pass_.name}", file=sys.stderr)


def _summarise(conversion: Conversion, found: Report, arguments: argparse.Namespace) -> None:
    output = conversion.rejected or conversion.settings.output
    if output in conversion.files:
        print(f"{found.robot}: written to {_near(output)}")
        _tell(conversion, found, arguments.verbose)
    else:
        print(f"stopped after '{arguments.stop_after}': nothing is written")
        _tell_diagnostics(conversion, arguments.verbose)


def _tell(conversion: Conversion, found: Report, verbose: bool) -> None:
    """What became of the robot: the same for every command that converts."""
    joints = found.joints
    links, bodies = counted(found.links, "link"), counted(found.bodies, "body")
    print(f"  {links} -> {bodies}, mass {found.mass:.6g} kg")
    if any(said.code == "no-mass" for said in conversion.diagnostics):
        print("  NO DYNAMICS: no link has a mass")
    print(f"  {counted(joints.urdf, 'URDF joint')} -> {_joints(joints)}; {found.base_in_words}")
    if conversion.names.flipped:
        print(f"  {_other_way(conversion.names.flipped)}")
    if found.proof is not None:
        proof = found.proof
        verdict = found.verdict if proof.same else "NOT THE SAME ROBOT, kept under this name"
        print(f"  {verdict}: {_proof(proof.groups, proof.positions, proof.largest)}")
        for difference in proof.differences:
            print(f"error[not-the-same]: {difference.message}", file=sys.stderr)
    _tell_diagnostics(conversion, verbose)


def _tell_diagnostics(conversion: Conversion, verbose: bool) -> None:
    warnings = [d for d in conversion.diagnostics if d.level == "warning"]
    notes = [d for d in conversion.diagnostics if d.level == "note"]
    more = "" if verbose or not notes else " (-v shows them)"
    print(f"  {counted(len(warnings), 'warning')}, {counted(len(notes), 'note')}{more}")
    for diagnostic in warnings + (notes if verbose else []):
        print(diagnostic, file=sys.stderr)


def _other_way(names: Sequence[str]) -> str:
    return (
        f"{counted(len(names), 'joint')} the other way round (minus the URDF's): {', '.join(names)}"
    )


def _near(path: Path) -> str:
    return os.path.relpath(path) if path.is_relative_to(Path.cwd()) else str(path)


def _explain(arguments: argparse.Namespace) -> int:
    config, lines = _configured(arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    _warn_of(pipeline.plugins)
    if arguments.json:
        described = [
            {**_described(bound.found), "swapped": bound.swapped, "options": bound.options}
            for bound in pipeline.passes
        ]
        if not arguments.cost:
            _print_json(described)
            return 0
        cost = {
            name: {**msgspec.structs.asdict(found.joints), "bound": _bound(found)}
            for name, found in _cost(config, lines, pipeline, arguments).items()
        }
        _print_json({"passes": described, "cost": cost})
        return 0
    settings = pipeline.settings
    print(f"source  {settings.source}\noutput  {settings.output}\nbase    {settings.base}")
    for name, folder in settings.packages.items():
        print(f"package {name} = {folder}")
    for name, value in settings.xacro_args.items():
        print(f"arg     {name} := {value}")
    for number, bound in enumerate(pipeline.passes, start=1):
        pass_ = bound.found.pass_
        print(f"\n{number}. {pass_.name}: {pass_.summary}")
        print(f"   from     {_origin(bound.found)}{_instead(bound, pipeline.plugins)}")
        for other in pipeline.plugins.passes[pass_.name]:
            if other.plugin not in (bound.found.plugin, GROUP):
                print(
                    f"   not      {_origin(other)}, which brings a '{pass_.name}' too; "
                    f"'swap: {{{pass_.name}: {other.plugin}}}' takes it"
                )
        print(f"   needs    {', '.join(pass_.needs) or '-'}")
        if pass_.changes:
            print(f"   changes  {', '.join(pass_.changes)}")
        print(f"   gives    {', '.join(pass_.gives) or '-'}")
        options = msgspec.to_builtins(bound.options)
        print(f"   options  {', '.join(f'{k}: {v!r}' for k, v in options.items()) or '-'}")
    print(f"\n{METHOD}")
    if arguments.cost:
        print("\ncost")
        for name, found in _cost(config, lines, pipeline, arguments).items():
            least = _bound(found)
            fewest = "" if least is None else f"; no frames do with fewer than {least} driven"
            print(f"   {name:13}  {_joints(found.joints)}{fewest}")
    return 0


def _cost(
    config: Config, lines: Lines, pipeline: Pipeline, arguments: argparse.Namespace
) -> dict[str, Report]:
    """What becomes of the joints by the config as it is, and of it by each other preset."""
    pipelines = {"this config": pipeline, **_by_presets(config, lines, arguments)}
    with _Progress(verbose=False) as progress:
        for each in pipelines.values():
            each.plugins.watch(progress)
        return {name: report(each.run()) for name, each in pipelines.items()}


def _bound(found: Report) -> int | None:
    """How few driven joints there could be, if that is known."""
    bound: int | None = found.passes.get("align-frames", {}).get("bound")
    return bound


def _by_presets(config: Config, lines: Lines, arguments: argparse.Namespace) -> dict[str, Pipeline]:
    """The config by each preset but its own."""
    pipelines: dict[str, Pipeline] = {}
    for name in presets():
        if name == config.pipeline:
            continue
        after = {key: new for key, new in config.after.items() if key in preset(name, lines)[0]}
        added = [
            new for news in after.values() for new in ([news] if isinstance(news, str) else news)
        ]
        there = {*preset(name, lines)[0], *added}
        other = msgspec.structs.replace(
            config, pipeline=name, after=after,
            swap={key: value for key, value in config.swap.items() if key in there},
            passes={key: value for key, value in config.passes.items() if key in there},
        )  # fmt: skip
        pipelines[name] = Pipeline(other, lines, installed_plugins=not arguments.no_plugins)
    return pipelines


def _fewer(
    conversion: Conversion, config: Config, lines: Lines, arguments: argparse.Namespace
) -> str:
    """How many joints the other presets make, where Robotran's generator minds."""
    if all(one.code != "generator-limits" for one in conversion.diagnostics):
        return ""
    others = []
    for name, other in _by_presets(config, lines, arguments).items():
        try:
            made = other.run(stop_after="decompose-joints").mbs.numbers()
        except ConversionError:
            continue  # this is not what was asked for
        others.append(f"the preset '{name}' makes {counted(len(made), 'joint')}")
    return "; ".join(others)


def _joints(joints: Joints) -> str:
    return f"{joints}; {joints.per_degree_of_freedom:.2f} joints for each degree of freedom"


def _instead(bound: Bound, plugins: Plugins) -> str:
    """What a pass stands in for."""
    others = [found for found in plugins.passes[bound.found.pass_.name] if found != bound.found]
    if not bound.swapped or not others:
        return ""
    built_in = any(found.plugin == GROUP for found in others)
    return ", in place of " + ("the built-in pass" if built_in else _origin(others[0]))


def _passes(arguments: argparse.Namespace) -> int:
    plugins = Plugins([Path(file) for file in arguments.plugin], installed=not arguments.no_plugins)
    _warn_of(plugins)
    found = [one for offered in plugins.passes.values() for one in offered]
    if arguments.json:
        _print_json([_described(one) for one in found])
        return 0
    width = max(len(one.pass_.name) for one in found)
    for one in found:
        pass_ = one.pass_
        out = [*(f"{token} (changed)" for token in pass_.changes), *pass_.gives]
        trade = f"{', '.join(pass_.needs) or '-'} -> {', '.join(out) or '-'}"
        print(f"{pass_.name:{width}}  {pass_.summary}")
        print(f"{'':{width}}  {trade}; {_origin(one)}")
    print(f"\n{METHOD}")
    return 0


#: What the summaries of the passes call "the method".
METHOD = (
    '"The method" is Appendix A, "URDF to MBS Converter", of the thesis on gait controllers in\n'
    "Robotran that urdf2mbs follows; the pages in docs/passes quote it, pass by pass."
)


def _report(arguments: argparse.Namespace) -> int:
    from urdf2mbs.report.page import make

    config, lines = _with_levels(*_robot_or_config(arguments), arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with _Progress(arguments.verbose) as progress:
        pipeline.plugins.watch(progress)
        conversion = pipeline.run()
        conversion.progress("the page")
        page = make(conversion)
    output = arguments.output or _beside(conversion.settings.output, ".html")
    write_files({output: page.data})
    found = report(conversion)
    if arguments.json:
        _print_json({"page": str(output), "sizes": page.sizes, "missing": page.missing})
    else:
        sizes = page.sizes
        print(f"{found.robot}: report written to {_near(output)} ({found.verdict})")
        print(
            f"  {sizes['all'] / 1e6:.2f} MB: three.js {sizes['viewer'] / 1e6:.2f}, "
            f"meshes {sizes['meshes'] / 1e6:.2f}"
        )
        if page.missing:
            print(f"  {counted(len(page.missing), 'mesh')} not drawn; the page names them")
        _tell(conversion, found, arguments.verbose)
    return 0 if conversion.rejected is None else 3


def _robot_or_config(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """A config is told from a robot by the file's ending."""
    file: Path = arguments.config
    if file.suffix.lower() not in (".yaml", ".yml", "") and not file.is_dir():
        return _without_config(str(file), None, arguments)
    for name in ("base", "package", "arg", "pipeline", "plugin", "after", "set"):
        if getattr(arguments, name):
            raise ConfigError(
                "usage", f"--{name} is for a robot without a config",
                hint=f"write it in '{file}', or name the .urdf or .xacro file instead",
            )  # fmt: skip
    return load(file)


def _beside(model: Path, suffix: str) -> Path:
    """The model's name with another ending; only .mbs is one (``panda_v1.0`` has none)."""
    return model.with_name(model.name.removesuffix(".mbs") + suffix)


def _diagram(arguments: argparse.Namespace) -> int:
    from urdf2mbs.diagram.draw import draw
    from urdf2mbs.mbs.reader import read

    try:
        data = arguments.model.read_bytes()
    except OSError as error:
        raise ConfigError(
            "model-unreadable", f"cannot read '{arguments.model}': {error.strerror}"
        ) from None
    mbs = read(data, str(arguments.model))
    output = arguments.output or _beside(arguments.model, ".svg")
    write_files({output: draw(mbs).encode()})
    if arguments.json:
        _print_json({"model": mbs.name, "output": str(output)})
    else:
        print(f"{mbs.name}: diagram of {counted(len(mbs.bodies), 'body')} written to {output}")
    return 0


def _equations(arguments: argparse.Namespace) -> int:
    from urdf2mbs.equations import equations, not_ours
    from urdf2mbs.mbs.reader import read

    if arguments.numba and arguments.language == "c":
        raise ConfigError("usage", "--numba is for Python: leave it out, or --language c")
    model: Path = arguments.model
    try:
        data = model.read_bytes()
    except OSError as error:
        raise ConfigError("model-unreadable", f"cannot read '{model}': {error.strerror}") from None
    mbs = read(data, str(model), mechanics_only=True)
    project = model.parent.parent if model.parent.name == "dataR" else model.parent
    folder: Path = arguments.output or project / "symbolicR"
    made = equations(
        mbs, data, str(model), language=arguments.language, fold=arguments.fold,
        keep_turns=arguments.keep_turns, numba=arguments.numba,
    )  # fmt: skip
    not_ours(folder, made)
    write_files({folder / name: text for name, text in made.files.items()})
    if arguments.json:
        counts = {name: msgspec.to_builtins(count) for name, count in made.counts.items()}
        fixed = {name: q for _, name, q in made.fixed}
        _print_json(
            {"model": mbs.name, "output": str(folder), "counts": counts, "fixed": fixed,
             "not_generated": made.left_out}
        )  # fmt: skip
        return 0
    print(f"{mbs.name}: equations of {len(mbs.numbers())} joints written to {folder}")
    for name, count in made.counts.items():
        if count.operations:
            print(
                f"  {name:10} {count.operations:6} operations: {count.products} products, "
                f"{count.sums} sums, {count.functions} sines, cosines and roots"
            )
    if made.fixed:
        never = counted(len(made.fixed), "joint")
        print(f"  {never} never move{'s' * (len(made.fixed) == 1)}: numbers")
    for name, why in made.left_out.items():
        print(f"  {name} is not generated: {why}")
    return 0


def _new_pass(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.new_pass import new_pass

    print(new_pass(arguments.name, arguments.output))
    return 0


def _schema(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.schema import schema

    files = [Path(file) for file in arguments.plugin]
    plugins = Plugins(files, installed=not arguments.no_plugins)
    _warn_of(plugins)
    _print_json(schema(plugins))
    return 0


def _warn_of(plugins: Plugins) -> None:
    for broken in plugins.broken:
        print(broken, file=sys.stderr)


def _origin(found: Found) -> str:
    of = f" of {found.package}" if found.package not in ("", found.plugin) else ""
    version = f" {found.version}" if found.version else ""
    return f"{found.plugin}{of}{version} ({found.file})"


def _described(found: Found) -> dict[str, Any]:
    pass_ = found.pass_
    return {
        "name": pass_.name, "summary": pass_.summary, "plugin": found.plugin,
        "package": found.package, "version": found.version, "file": found.file,
        "needs": pass_.needs, "changes": pass_.changes, "gives": pass_.gives,
    }  # fmt: skip


def _print_json(data: Any) -> None:
    print(json.dumps(msgspec.to_builtins(data), indent=2))


if __name__ == "__main__":
    sys.exit(main())
