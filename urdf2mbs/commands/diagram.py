"""`diagram`: the 2D diagram of an .mbs as a picture."""

from __future__ import annotations

import argparse
from pathlib import Path

from urdf2mbs.commands.printing import beside, print_json
from urdf2mbs.commands.settings import add_printing, path
from urdf2mbs.commands.streams import STREAM, file_to_stdout, read_model
from urdf2mbs.disk.output import write_files
from urdf2mbs.disk.standard_input import NAME as STDIN
from urdf2mbs.messages.diagnostics import counted

EXAMPLES = (
    "urdf2mbs diagram robot.mbs",
    "urdf2mbs diagram robot.mbs -o picture.svg",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "model", type=path, metavar="MODEL.mbs", help="the file, or - for standard input"
    )
    command.add_argument(
        "-o", "--output", type=path, metavar="OUT.svg",
        help="default: beside the model; - for standard output",
    )  # fmt: skip
    add_printing(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.diagram.draw import draw
    from urdf2mbs.mbs.reader import read

    model: Path = arguments.model
    mbs = read(read_model(model), STDIN if str(model) == STREAM else str(model))
    picture = draw(mbs).encode()
    default = Path(STREAM) if str(model) == STREAM else beside(model, ".svg")
    output: Path = arguments.output or default
    if str(output) == STREAM:
        with file_to_stdout(arguments) as give:
            give(picture)
        return 0
    write_files({output: picture}, force=arguments.force)
    if arguments.json:
        print_json({"model": mbs.name, "output": str(output)})
    else:
        print(f"{mbs.name}: diagram of {counted(len(mbs.bodies), 'body')} written to {output}")
        print(f"Next: open {output} in a browser, and {model} in MBSysPad: they look alike")
        print(f"      is it the robot? urdf2mbs verify ROBOT {model}")
    return 0
