"""`diagram`: the 2D diagram of an .mbs as a picture.

Draws bodies, joints and points as MBSysPad shows them.  Writes one .svg file.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from urdf2mbs.plugin import (
    add_printing,
    beside,
    counted,
    is_stream,
    path,
    print_json,
    read_mbs_file,
    saving,
)

EXAMPLES = (
    "urdf2mbs diagram robot.mbs",
    "urdf2mbs diagram robot.mbs -o picture.svg",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    command.add_argument(
        "model", type=path, metavar="MODEL.mbs", help="the file, or - for standard input"
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="OUT.svg",
        help="default: beside the model; - for standard output",
    )
    add_printing(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the picture; return the exit code."""
    from urdf2mbs_report.draw import draw

    model_file: Path = arguments.model
    model = read_mbs_file(model_file)
    picture = draw(model).encode()
    default_output = model_file if is_stream(model_file) else beside(model_file, ".svg")
    output: Path = arguments.output or default_output
    with saving(arguments, is_stream(output)) as save:
        save(output, picture)
    if is_stream(output):
        return 0
    if arguments.json:
        print_json({"model": model.name, "output": str(output)})
    else:
        print(f"{model.name}: diagram of {counted(len(model.bodies), 'body')} written to {output}")
        print(f"Next: open {output} in a browser, and {model_file} in MBSysPad: they look alike")
        print(f"      is it the robot? urdf2mbs verify ROBOT {model_file}")
    return 0
