"""`equations`: Robotran's equations for an .mbs.

Writes the files of Robotran's symbolic engine: mass matrix, forces, inverse
dynamics, sensors and constraints of the model, as functions to call.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from urdf2mbs.commands.printing import near, print_json
from urdf2mbs.commands.settings import add_printing, path, refuse
from urdf2mbs.commands.streams import is_stream
from urdf2mbs.disk.files import project_of, read_model
from urdf2mbs.engine.output import write_files
from urdf2mbs.messages.diagnostics import ConfigError, counted

#: The options without a value, and what they do.
SWITCHES = {
    "--fold": "write masses, points and the like as numbers",
    "--energy": "also write energy, momentum and centre of mass",
    "--derivatives": "also write derivatives and regressor of invdyna",
    "--standalone": "also write headers that stand for Robotran's: C that runs alone (c)",
    "--no-pairs": "compute mirrored limbs one after the other, for compilers other than gcc and "
    "clang (c)",
}

EXAMPLES = (
    "urdf2mbs equations project/dataR/project.mbs",
    "urdf2mbs equations robot.mbs -o symbolicR --language c",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "model", type=path, metavar="MODEL.mbs", help="of urdf2mbs, or drawn by hand"
    )
    add_printing(command)
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR", help="default: symbolicR of the project"
    )
    command.add_argument(
        "--language", choices=("python", "c", "matlab"), default="python", help="default: python"
    )
    for flag, does in SWITCHES.items():
        command.add_argument(flag, action="store_true", help=does)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.mbs.reader import read
    from urdf2mbs_equations.files import generate

    if arguments.language != "c":
        refuse(arguments, ("no_pairs", "standalone"), "C: leave it out, or add --language c")
    if arguments.standalone and arguments.output is None:
        raise ConfigError(
            "usage", "--standalone writes headers with the names of Robotran's: it needs a folder "
            "of its own", hint="-o DIR",
        )  # fmt: skip
    model: Path = arguments.model
    if is_stream(model) or is_stream(arguments.output):
        raise ConfigError("usage", "the equations are several files beside their model, not '-'")
    data = read_model(model)
    mbs = read(data, str(model), mechanics_only=True)
    project = project_of(model)
    folder: Path = arguments.output or project / "symbolicR"
    made = generate(
        mbs, data, str(model), language=arguments.language, fold=arguments.fold,
        pairs=not arguments.no_pairs, energy=arguments.energy, derivatives=arguments.derivatives,
        standalone=arguments.standalone,
    )  # fmt: skip
    for warning in made.warnings:
        print(warning, file=sys.stderr)
    files = {folder / name: text for name, text in made.files.items()}
    write_files(files, force=arguments.force)
    if arguments.json:
        fixed = {name: q for _, name, q in made.fixed}
        print_json(
            {"model": mbs.name, "output": str(folder), "counts": made.counts, "fixed": fixed,
             "not_generated": made.left_out, "warnings": made.warnings}
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
    main = project / "workR" / "main.py"
    if arguments.language == "python" and main.is_file():
        print(f"Next: python {near(main)}, or urdf2mbs simulate {near(project)}")
    else:
        print("Next: call them, as docs/equations.md says; in a project Robotran does")
    print("      they belong to this model: make them anew when it has changed")
    return 0
