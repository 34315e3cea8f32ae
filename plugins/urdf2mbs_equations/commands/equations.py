"""`equations`: Robotran's equations for an .mbs.

Writes the files of Robotran's symbolic engine: mass matrix, forces, inverse
dynamics, sensors and constraints of the model, as functions to call.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import (
    ConfigError,
    add_printing,
    counted,
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
from urdf2mbs_equations.projects import NAMES, SUFFIXES, find_languages
from urdf2mbs_equations.summary import describe_build

if TYPE_CHECKING:
    from urdf2mbs.plugin import Mbs
    from urdf2mbs_equations.files import Equations

#: The options without a value, and what they do.
SWITCHES = {
    "--fold": "write masses, points and the like as numbers",
    "--energy": "also write energy, momentum and centre of mass",
    "--derivatives": "also write derivatives and regressor of invdyna",
    "--no-pairs": "compute mirrored limbs one after the other, for compilers other than gcc and "
    "clang (c)",
}

EXAMPLES = (
    "urdf2mbs equations project",
    "urdf2mbs equations robot.mbs -o symbolicR --language c",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "model", type=path, metavar="MODEL.mbs",
        help="of urdf2mbs, or drawn by hand; or the folder of its project",
    )  # fmt: skip
    add_printing(command)
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR", help="default: symbolicR of the project"
    )
    command.add_argument(
        "--language",
        choices=tuple(SUFFIXES),
        help="default: those of the user functions in the project, else python",
    )
    for flag, does in SWITCHES.items():
        command.add_argument(flag, action="store_true", help=does)


def carry_out(arguments: argparse.Namespace) -> int:
    model: Path = arguments.model
    if is_stream(model) or is_stream(arguments.output):
        raise ConfigError("usage", "the equations are several files beside their model, not '-'")
    model = model_of(model) or model
    project = project_of(model)
    languages = [arguments.language] if arguments.language else find_languages(project)
    if "c" not in languages:
        refuse(arguments, ("no_pairs",), "C: leave it out, or add --language c")
    folder: Path = arguments.output or project / "symbolicR"
    mbs, made = _generate(arguments, model, languages)
    for warning in made.warnings:
        print(warning, file=sys.stderr)
    files = {folder / name: text for name, text in made.files.items()}
    write_files(files, force=arguments.force)
    if arguments.json:
        print_json(
            {
                "model": mbs.name,
                "output": str(folder),
                "languages": languages,
                "counts": made.counts,
                "fixed": {name: q for _, name, q in made.fixed},
                "not_generated": made.left_out,
                "warnings": made.warnings,
            }
        )
    else:
        _print_equations(mbs, made, folder, languages)
        _print_next_steps(project, languages)
    return 0


def _generate(
    arguments: argparse.Namespace, model: Path, languages: list[str]
) -> tuple[Mbs, Equations]:
    """Read a model, and generate its equations in some languages."""
    from urdf2mbs.plugin import read_mbs as read
    from urdf2mbs_equations.files import Equations, generate

    data = read_model(model)
    mbs = read(data, str(model), mechanics_only=True)
    made = Equations()
    for language in languages:
        equations = generate(
            mbs,
            data,
            str(model),
            language=language,
            fold=arguments.fold,
            pairs=not arguments.no_pairs,
            energy=arguments.energy,
            derivatives=arguments.derivatives,
        )
        made.files |= equations.files
        made.counts |= equations.counts
        made.left_out |= equations.left_out
        made.fixed, made.warnings = equations.fixed, equations.warnings
    return mbs, made


def _print_equations(mbs: Mbs, made: Equations, folder: Path, languages: list[str]) -> None:
    names = " and ".join(NAMES[language] for language in languages)
    joints = counted(len(mbs.numbers()), "joint")
    print(f"{mbs.name}: equations of {joints} written to {folder}, in {names}")
    for name, count in made.counts.items():
        if count.operations:
            print(
                f"  {name:10} {count.operations:6} operations: {count.products} products, "
                f"{count.sums} sums, {count.functions} sines, cosines and roots"
            )
    if made.fixed:
        joints = counted(len(made.fixed), "joint")
        print(f"  {joints} never move{'s' * (len(made.fixed) == 1)}: numbers")
    for name, reason in made.left_out.items():
        print(f"  {name} is not generated: {reason}")


def _print_next_steps(project: Path, languages: list[str]) -> None:
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
    print("      they belong to this model: make them again when it has changed")
