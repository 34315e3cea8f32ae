"""`edits`: what people changed in an .mbs since it was written, as a file of edits."""

from __future__ import annotations

import argparse
from pathlib import Path

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import add_printing, path
from urdf2mbs.disk import files
from urdf2mbs.disk.output import write_files
from urdf2mbs.messages.diagnostics import ConfigError, counted, printable

EXAMPLES = ("urdf2mbs edits project -o edits.yaml", "urdf2mbs edits robot.mbs -o edits.yaml")


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "model", type=path, metavar="PROJECT", help="the folder of a project, or an .mbs"
    )
    command.add_argument(
        "-o", "--output", type=path, metavar="EDITS.yaml",
        help="gets the edits, behind those of its own that were applied; default: none is written",
    )  # fmt: skip
    add_printing(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.diff.changes import differences
    from urdf2mbs.diff.words import line
    from urdf2mbs.mbs.reader import read
    from urdf2mbs.merge import base, overlay

    model: Path = arguments.model
    if files.is_folder(model):
        model = model / "dataR" / f"{model.resolve().name}.mbs"
    if not files.is_file(model):
        raise ConfigError("model-unreadable", f"there is no '{model}'")
    written = base.read(model)
    if written is None:
        raise ConfigError(
            "edits-no-base",
            f"what urdf2mbs wrote last is not known: '{base.path(model)}' is not there, or edited",
            hint="convert again, with --fresh or elsewhere",
        )
    edited = read(files.read(model), str(model))
    changes = differences(read(written, str(base.path(model))), edited).changes
    output: Path | None = arguments.output
    if output is not None:
        there = files.read(output) if files.is_file(output) else b""
        data = base.applied(written, there) + overlay.text(changes).encode()
        write_files({output: data}, force=arguments.force)
    if arguments.json:
        print_json({"model": str(model), "edits": changes})
        return 0
    where = "" if output is None else f" written to {output}"
    print(f"{model}: {counted(len(changes), 'edit')}{where}")
    for change in changes:
        print(printable(f"  {line(change)}"))
    if output is not None:
        print(f"Next: passes: {{apply-edits: {{file: {output}}}}} in a config makes them again")
    return 0
