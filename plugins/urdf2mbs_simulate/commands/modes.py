"""`modes`: how a model swings about its equilibrium."""

from __future__ import annotations

import argparse

from urdf2mbs.plugin import (
    ALONE,
    ConfigError,
    add_fields,
    add_printing,
    add_running,
    near,
    path,
    print_json,
)
from urdf2mbs_simulate.commands.simulate import is_page, make_project

EXAMPLES = (
    "urdf2mbs modes robot.yaml",
    "urdf2mbs modes project -o mode.html --mode 2",
    "urdf2mbs modes robot.mbs --drawn",
)


def add_options(command: argparse.ArgumentParser) -> None:
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config", type=path, metavar="SOURCE",
        help="a project's folder, an .mbs, a CONFIG.yaml, or a .urdf or .xacro file",
    )  # fmt: skip
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR|PAGE.html",
        help="the folder of the project that a robot becomes (default: NAME_robotran); or a page "
        "on which a mode swings",
    )  # fmt: skip
    command.add_argument(
        "--drawn", action="store_true", help="the modes about the drawn pose, not an equilibrium"
    )
    command.add_argument(
        "--mode", type=int, default=1, metavar="N", help="the mode on the page (default: 1)"
    )
    command.add_argument(
        "--language",
        choices=("c", "python"),
        help="of the user functions (default: c, if those in Python are unchanged)",
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.plugin import Progress, model_of, write_files
    from urdf2mbs_report.page import make_model_page
    from urdf2mbs_simulate.project import modes

    model = model_of(arguments.config) or make_project(arguments)
    with Progress(arguments) as progress:
        progress.at = "looking for an equilibrium"
        found = modes(model, drawn=arguments.drawn, language=arguments.language)
    data, count = found.data, len(found.modes)
    if not 1 <= arguments.mode <= max(count, 1):
        raise ConfigError("usage", f"--mode {arguments.mode}: the model has {count} modes")
    files = found.write(arguments.mode, force=arguments.force)
    if is_page(arguments.output) and count:
        page = make_model_page(data._run.mbs, model, files[1].name)
        write_files({arguments.output: page.data}, force=arguments.force)
        files.insert(0, arguments.output)
    if arguments.json:
        rows = [
            {"frequency": mode.frequency, "damping": mode.damping, "value": [mode.value.real,
             mode.value.imag], "joints": [list(data.joint_id)[k - 1] for k in mode.joints()]}
            for mode in found.modes
        ]  # fmt: skip
        print_json({"model": data.mbs_name, "modes": rows, "stable": found.stable,
                    "files": [str(file) for file in files]})  # fmt: skip
        return 0
    print(f"{data.mbs_name}: {count} modes")
    for line in (*data._run.notes, *found.lines(), *map(near, files)):
        print(f"  {line}")
    see = (
        f"open {near(files[0])}" if is_page(files[0]) else "add '-o PAGE.html' to see a mode swing"
    )
    print(f"Next: {see}")
    return 0
