"""`diagram`: the 2D diagram of an .mbs as a picture."""

from __future__ import annotations

import argparse

from urdf2mbs import files
from urdf2mbs.commands.printing import beside, print_json
from urdf2mbs.diagnostics import ConfigError, counted
from urdf2mbs.output import write_files


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.diagram.draw import draw
    from urdf2mbs.mbs.reader import read

    try:
        data = files.read(arguments.model)
    except OSError as error:
        raise ConfigError(
            "model-unreadable", f"cannot read '{arguments.model}': {error.strerror}"
        ) from None
    mbs = read(data, str(arguments.model))
    output = arguments.output or beside(arguments.model, ".svg")
    write_files({output: draw(mbs).encode()})
    if arguments.json:
        print_json({"model": mbs.name, "output": str(output)})
    else:
        print(f"{mbs.name}: diagram of {counted(len(mbs.bodies), 'body')} written to {output}")
    return 0
