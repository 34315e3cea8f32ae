"""`equations`: Robotran's equations for an .mbs.

Writes the files of Robotran's symbolic engine: mass matrix, forces, inverse
dynamics, sensors and constraints of the model, as functions to call.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from msgspec.structs import fields, replace

from urdf2mbs.plugin import (
    ConfigError,
    add_printing,
    counted,
    field_docs,
    is_stream,
    model_of,
    near,
    path,
    print_json,
    project_of,
    read_model,
    refuse,
    write_files,
)
from urdf2mbs_equations.options import EquationOptions, Language, list_languages
from urdf2mbs_equations.projects import NAMES, find_languages
from urdf2mbs_equations.summary import describe_build

if TYPE_CHECKING:
    from urdf2mbs.plugin import Mbs
    from urdf2mbs_equations.files import Equations

EXAMPLES = (
    "urdf2mbs equations project",
    "urdf2mbs equations robot.mbs -o symbolicR --language c",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options: those of ``EquationOptions``, as words of a command line."""
    command.add_argument(
        "model",
        type=path,
        metavar="MODEL.mbs",
        help="of urdf2mbs, or drawn by hand; or the folder of its project",
    )
    add_printing(command)
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


def _read_options(arguments: argparse.Namespace) -> EquationOptions:
    """Return the options of a command line."""
    values: dict[str, bool] = {}
    for flag, field in _list_switches().items():
        is_given = getattr(arguments, flag[2:].replace("-", "_"))
        values[field] = is_given != flag.startswith("--no-")
    return EquationOptions(language=arguments.language, **values)


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the equations of a model, and return the exit code."""
    model: Path = arguments.model
    if is_stream(model) or is_stream(arguments.output):
        raise ConfigError("usage", "expected files and folders, got '-': equations are many files")
    model = model_of(model) or model
    project = project_of(model)
    options = _read_options(arguments)
    languages = list_languages(options.language, find_languages(project))
    if "c" not in languages:
        refuse(arguments, ("no_pairs",), "C: leave it out, or add --language c")
    if languages == ("latex",):
        other = "programs: leave it out, or name another language"
        refuse(arguments, ("fold", "energy", "derivatives"), other)
    folder: Path = arguments.output or project / "symbolicR"
    mbs, equations = _generate(model, options, languages)
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
                "not_generated": equations.left_out,
                "warnings": equations.warnings,
            }
        )
    else:
        _print_equations(mbs, equations, folder, languages)
        if languages == ("latex",):
            print(f"Next: pdflatex {near(next(iter(files)))}, or copy the formulas")
        else:
            _print_next_steps(project, languages)
    return 0


def _generate(
    model: Path, options: EquationOptions, languages: tuple[str, ...]
) -> tuple[Mbs, Equations]:
    """Read a model, and generate its equations in some languages."""
    from urdf2mbs.plugin import read_mbs
    from urdf2mbs_equations.files import Equations, generate

    data = read_model(model)
    mbs = read_mbs(data, str(model), mechanics_only=True)
    equations = Equations()
    for language in languages:
        part = generate(mbs, data, str(model), replace(options, language=language))
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
    for name, reason in equations.left_out.items():
        verb = "are" if name == "formulas" else "is"
        print(f"  {name} {verb} not generated: {reason}")


def _print_next_steps(project: Path, languages: tuple[str, ...]) -> None:
    steps = []
    main = project / "workR" / "main.py"
    if "python" in languages and main.is_file():
        steps.append(f"python {near(main)}, or urdf2mbs simulate {near(project)}")
    build = describe_build(project) if "c" in languages else None
    if build is not None:
        steps.append(build)
    if not steps:
        steps.append("call them, as docs/equations.md says; in a project Robotran does")
    print("Next: " + "\n      in C: ".join(steps))
    print("      the equations are of this model only: generate them again after a change")
