"""`modes`: compute the modes of a model about its equilibrium."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import (
    ALONE,
    ConfigError,
    add_fields,
    add_printing,
    add_running,
    find_model,
    near,
    path,
    print_json,
)
from urdf2mbs_simulate.commands.simulate import check_output, is_page, make_project

if TYPE_CHECKING:
    from urdf2mbs_simulate.modal import Modes

EXAMPLES = (
    "urdf2mbs modes robot.yaml",
    "urdf2mbs modes project -o modes.html",
    "urdf2mbs modes robot.mbs --drawn",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config",
        type=path,
        metavar="SOURCE",
        help="a project's folder, an .mbs, a CONFIG.yaml, or a .urdf, .xacro or MJCF file",
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="DIR|PAGE.html",
        help="the folder of the project that a robot becomes (default: NAME_robotran); or a page "
        "that lists and animates the modes",
    )
    command.add_argument(
        "--drawn", action="store_true", help="the modes about the drawn pose, not an equilibrium"
    )
    command.add_argument(
        "--mode",
        type=int,
        default=1,
        metavar="N",
        help="the mode that is shown at first, and written to mode.csv (default: 1)",
    )
    command.add_argument(
        "--language",
        choices=("c", "python"),
        help="of the user functions (default: c, if those in Python are unchanged)",
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    """Compute the modes, write them, and print the table; return the exit code."""
    from urdf2mbs.plugin import Progress, write_files
    from urdf2mbs_simulate.project import make_modes_page, modes

    check_output(arguments.output)
    model, conversion = find_model(arguments.config, arguments, "robot", "config"), None
    if model is None:
        conversion = make_project(arguments)
        model = conversion.settings.output
    with Progress(arguments) as progress:
        progress.at = "looking for an equilibrium"
        results = modes(model, drawn=arguments.drawn, language=arguments.language)
    results.conversion = conversion
    count = len(results.modes)
    if not 1 <= arguments.mode <= max(count, 1):
        raise ConfigError("usage", f"--mode {arguments.mode}: the model has {count} modes")
    files = results.write(arguments.mode, force=arguments.force)
    if is_page(arguments.output) and count:
        page = make_modes_page(results, arguments.mode)
        write_files({arguments.output: page.data}, force=arguments.force)
        files.insert(0, arguments.output)
    if arguments.json:
        print_json(_describe_modes(results, files))
    else:
        _print_modes(results, files)
    return 0


def _describe_modes(results: Modes, files: list[Path]) -> dict[str, object]:
    """Return the modes as data for --json."""
    names = list(results.data.joint_id)
    rows = [
        {
            "frequency": mode.frequency,
            "damping": mode.damping,
            "value": [mode.value.real, mode.value.imag],
            "joints": [names[number - 1] for number in mode.joints()],
        }
        for mode in results.modes
    ]
    return {
        "model": results.data.mbs_name,
        "modes": rows,
        "stable": results.stable,
        "files": [str(file) for file in files],
    }


def _print_modes(results: Modes, files: list[Path]) -> None:
    data = results.data
    print(f"{data.mbs_name}: {len(results.modes)} modes")
    for line in (*data._run.notes, *results.lines(), *map(near, files)):
        print(f"  {line}")
    if not results.modes:
        print("Next: simulate it; nothing brings it back to this pose: there is no page")
    elif is_page(files[0]):
        print(f"Next: open {near(files[0])}")
    else:
        print("Next: add '-o PAGE.html' to see the modes swing")
