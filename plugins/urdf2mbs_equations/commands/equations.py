"""`equations`: Robotran's equations for an .mbs, or for a robot.

Writes the files of Robotran's symbolic engine: mass matrix, forces, inverse
dynamics, sensors and constraints of the model, as functions to call.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from msgspec import NODEFAULT
from msgspec.structs import FieldInfo, fields, replace

from urdf2mbs.plugin import (
    ALONE,
    ConfigError,
    Pipeline,
    Progress,
    Project,
    add_fields,
    add_printing,
    add_running,
    counted,
    field_docs,
    find_model,
    is_stream,
    near,
    path,
    print_json,
    project_of,
    read_model,
    refuse,
    robot_or_config,
    some,
    tell_diagnostics,
    write_files,
)
from urdf2mbs_equations.followers import list_followers
from urdf2mbs_equations.options import EquationOptions, Language, list_languages
from urdf2mbs_equations.projects import NAMES, find_languages
from urdf2mbs_equations.summary import describe_build

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Mbs
    from urdf2mbs_equations.files import Equations

EXAMPLES = (
    "urdf2mbs equations project",
    "urdf2mbs equations robot.urdf --language c",
    "urdf2mbs equations robot.mbs -o symbolicR --language c",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options: those of ``EquationOptions``, as words of a command line."""
    command.add_argument(
        "config",
        type=path,
        metavar="SOURCE",
        help="an .mbs of urdf2mbs, or drawn by hand; the folder of its project; or a robot or a "
        "CONFIG.yaml, which is converted in memory",
    )
    add_printing(command)
    add_running(command)
    add_fields(command, *ALONE)
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR", help="default: symbolicR of the project"
    )
    docs = {
        field: text[0].lower() + text[1:].rstrip(".").replace("``", "").replace("%", "%%")
        for field, text in field_docs(EquationOptions).items()
    }
    command.add_argument(
        "--language",
        choices=get_args(Language),
        default="project",
        help=f"{docs['language']} (default: project)",
    )
    for flag, field in _list_switches().items():
        text = f"turn off: {docs[field]}" if flag.startswith("--no-") else docs[field]
        command.add_argument(flag, action="store_true", help=text)


def _list_switches() -> dict[str, str]:
    """Return the field of each option without a value; ``--no-X`` sets a field X to False."""
    return {
        f"--no-{field.name}" if field.default is True else f"--{field.name}": field.name
        for field in fields(EquationOptions)
        if isinstance(field.default, bool)
    }


def read_options(arguments: argparse.Namespace) -> EquationOptions:
    """Return the options of a command line, with the defaults of the pass."""
    values: dict[str, bool] = {}
    for flag, field in _list_switches().items():
        is_given = getattr(arguments, flag[2:].replace("-", "_"))
        values[field] = is_given != flag.startswith("--no-")
    return EquationOptions(language=arguments.language, **values)


class _Source(NamedTuple):
    """A model whose equations are made."""

    model: Path
    """Its file, which need not exist if it was converted in memory."""
    data: bytes
    call: str
    """The arguments of ``load_equations`` in Python."""
    conversion: Conversion | None = None
    """That of a robot or a config, which knows what ``<mimic>`` couples."""


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the equations of a model, and return the exit code."""
    if is_stream(arguments.config) or is_stream(arguments.output):
        raise ConfigError("usage", "expected files and folders, got '-': equations are many files")
    model = find_model(arguments.config, arguments, "robot", "config")
    if model is None:
        source = _convert(arguments)
        if source is None:
            return 3
    else:
        source = _Source(model, read_model(model), _quote(near(arguments.config)))
    project = project_of(source.model)
    options = read_options(arguments)
    languages = list_languages(options.language, find_languages(project))
    if "c" not in languages:
        refuse(arguments, ("no_pairs",), "C: leave it out, or add --language c")
    if languages == ("latex",):
        other = "programs: leave it out, or name another language"
        refuse(arguments, ("fold", "energy", "derivatives"), other)
    folder: Path = arguments.output or project / "symbolicR"
    mbs, equations = _generate(source, options, languages)
    for warning in equations.warnings:
        print(warning, file=sys.stderr)
    files = {folder / name: text for name, text in equations.files.items()}
    write_files(files, force=arguments.force)
    if arguments.json:
        print_json(
            {
                "model": mbs.name,
                "output": str(folder),
                "languages": languages,
                "counts": equations.counts,
                "fixed": {joint.name: joint.q for joint in equations.fixed},
                "followers": equations.followers,
                "not_generated": equations.left_out,
                "warnings": equations.warnings,
            }
        )
    else:
        _print_equations(mbs, equations, folder, languages)
        if languages == ("latex",):
            print(f"Next: pdflatex {near(next(iter(files)))}, or copy the formulas")
        else:
            steps = _list_project_steps(project, languages)
            if not steps:
                steps = [_write_program(mbs.name, folder, languages, source.call)]
            print("  they are of this model only: generate them again after a change")
            print("Next: " + "\n      in C: ".join(steps))
    return 0


def _convert(arguments: argparse.Namespace) -> _Source | None:
    """Convert a robot or a config in memory; None if the .mbs is not the same robot."""
    config, lines = robot_or_config(arguments)
    installed = not arguments.no_plugins
    model = Pipeline(config, lines, installed_plugins=installed).settings.output
    with TemporaryDirectory(prefix="urdf2mbs-") as folder, Progress(arguments) as progress:
        # As load_equations does: a plain .mbs cannot hold the constraints of <mimic>.
        project = Project(str(Path(folder, model.stem)))
        if not isinstance(config.output, Project):
            config = replace(config, output=project)
        pipeline = Pipeline(config, lines, installed_plugins=installed)
        pipeline.watch(progress)
        conversion = pipeline.run()
    if not arguments.json:
        tell_diagnostics(conversion.diagnostics, arguments.verbose)
    if conversion.checked.rejected is not None:
        return None
    call = [_quote(near(arguments.config))]
    if arguments.config.suffix.lower() not in (".yaml", ".yml"):
        call += [
            f"{field.name}={_write_value(getattr(config, field.name))}"
            for field in fields(config)
            if field.name not in ("source", "output")
            and getattr(config, field.name) != _get_default(field)
        ]
    data = bytes(conversion.files[conversion.settings.output])
    return _Source(model, data, ", ".join(call), conversion)


def _get_default(field: FieldInfo) -> Any:
    factory = field.default_factory
    return field.default if factory is NODEFAULT else factory()


def _write_value(value: Any) -> str:
    """Return a value of a config as Python."""
    return _quote(value) if isinstance(value, str) else repr(value)


def _quote(text: object) -> str:
    """Return a text in Python's and JSON's double quotes."""
    return json.dumps(str(text), ensure_ascii=False)


def _generate(
    source: _Source, options: EquationOptions, languages: tuple[str, ...]
) -> tuple[Mbs, Equations]:
    """Read a model, and generate its equations in some languages."""
    from urdf2mbs.plugin import read_mbs
    from urdf2mbs_equations.files import Equations, generate

    model = str(source.model)
    mbs = read_mbs(source.data, model, mechanics_only=True)
    followers = [] if source.conversion is None else list_followers(source.conversion, mbs)
    names = list(mbs.joints())
    equations = Equations(followers=[names[follower.joint - 1] for follower in followers])
    for language in languages:
        of_language = replace(options, language=language)
        part = generate(mbs, source.data, model, of_language, followers=followers)
        equations.files |= part.files
        equations.counts |= part.counts
        equations.left_out |= part.left_out
        equations.fixed, equations.warnings = part.fixed, part.warnings
    return mbs, equations


def _print_equations(
    mbs: Mbs, equations: Equations, folder: Path, languages: tuple[str, ...]
) -> None:
    names = " and ".join(NAMES[language] for language in languages)
    joints = counted(len(mbs.numbers()), "joint")
    print(f"{mbs.name}: equations of {joints} written to {folder}, in {names}")
    for name, count in equations.counts.items():
        if count.operations:
            print(
                f"  {name:10} {count.operations:6} operations: {count.products} products, "
                f"{count.sums} sums, {count.functions} sines, cosines and roots"
            )
    if equations.fixed and equations.counts:
        joints = counted(len(equations.fixed), "joint")
        verb = "moves" if len(equations.fixed) == 1 else "move"
        print(f"  {joints} never {verb}; their coordinates are numbers in the equations")
    reducing = {"c": f"mbs_followers_{mbs.name}.c", "matlab": f"{mbs.name}_example.m"}
    for file in [reducing[language] for language in languages if language in reducing]:
        if followers := some(f"'{name}'" for name in equations.followers):
            print(f"  followers: {followers}; {file} reduces M and c to the joints that lead")
    if mbs.user_constraints and not equations.followers and "matlab" in languages:
        names = some(f"'{constraint.name}'" for constraint in mbs.user_constraints)
        print(f"  user constraints {names} are not called in MATLAB; if they are of <mimic>, name")
        print("  the robot or its config in place of the .mbs: their joints are then reduced")
    for name, reason in equations.left_out.items():
        verb = "are" if name == "formulas" else "is"
        print(f"  {name} {verb} not generated: {reason}")


def _list_project_steps(project: Path, languages: tuple[str, ...]) -> list[str]:
    """Return the commands that run a project, and that build its C."""
    steps = []
    main = project / "workR" / "main.py"
    if "python" in languages and main.is_file():
        steps.append(f"python {near(main)}, or urdf2mbs simulate {near(project)}")
    build = describe_build(project) if "c" in languages else None
    if build is not None:
        steps.append(build)
    return steps


def _write_program(name: str, folder: Path, languages: tuple[str, ...], call: str) -> str:
    """Return three lines that call equations, in their language; Python calls those in C, too."""
    if languages == ("matlab",):
        words = "in MATLAB or GNU Octave"
        path = str(near(folder)).replace("'", "''")
        lines = [
            f"addpath('{path}')",
            f"s = {name}_data();",
            f"[qdd, M, c] = {name}_example(s)",
        ]
    else:
        words = "in Python, which compiles the C" if languages == ("c",) else "in Python"
        lines = [
            "from urdf2mbs import load_equations",
            f"robot = load_equations({call})",
            "print(robot.mass_matrix([0.0] * len(robot.joints)))",
        ]
    return "\n      ".join([f"{words}:", *lines])
