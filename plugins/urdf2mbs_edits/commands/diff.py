"""`diff`: what differs between two .mbs files.

Compares bodies, joints, points and forces by their names, in the words of
MBSysPad.  Writes nothing.  Exit code 0: no difference; 1: differences.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from urdf2mbs.plugin import (
    ConfigError,
    ConversionError,
    add_json,
    counted,
    find_kind,
    find_model,
    is_file,
    is_stream,
    path,
    print_json,
    printable,
    read_mbs_file,
)

EXAMPLES = (
    "urdf2mbs diff before.mbs after.mbs",
    "urdf2mbs diff before.mbs after.mbs --physics",
    "git show HEAD:robot.mbs | urdf2mbs diff - robot.mbs",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    command.add_argument("before", type=path, metavar="A.mbs", help="a file, or - for stdin")
    command.add_argument("after", type=path, metavar="B.mbs", help="the file to compare with it")
    command.add_argument(
        "--physics", action="store_true", help="leave out the diagram, shapes and viewpoints"
    )
    command.add_argument(
        "--drawing", action="store_true", help="list the differences of the drawing, too"
    )
    add_json(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Return the exit code of diff: 0 no difference, 1 differences, 2 an error."""
    from urdf2mbs_edits.diff.changes import find_differences
    from urdf2mbs_edits.diff.wording import describe_changes, describe_remarks

    files: tuple[Path, Path] = (arguments.before, arguments.after)
    try:
        before, after = (read_mbs_file(_find_model(file, arguments)) for file in files)
    except ConversionError as error:
        error.exit_code = 2
        raise
    differences = find_differences(before, after, physics=arguments.physics)
    changes = differences.changes
    if arguments.json:
        print_json({"same": not changes, "differences": differences})
        return 1 if changes else 0
    physics = [change for change in changes if not change.drawing]
    count = counted(len(physics), "difference") if physics else "no difference"
    if len(physics) < len(changes):
        count += ", and the drawing" if physics else ", but for the drawing"
    print(f"{files[0]} -> {files[1]}: {count}")
    hint = "--drawing lists them"
    for sentence in describe_changes(differences, drawing=arguments.drawing, hint=hint):
        print(printable(f"  {sentence}"))
    for sentence in describe_remarks(differences):
        print(printable(f"  ({sentence})"))
    return 1 if changes else 0


def _find_model(file: Path, arguments: argparse.Namespace) -> Path:
    """Return the .mbs that a command line names, by itself or by the folder of its project."""
    if is_stream(file):
        return file
    if find_kind(file) in ("robot", "config") and is_file(file):
        message = f"'diff' compares two models (.mbs), and '{file}' is none"
        hint = f"urdf2mbs verify {arguments.before} {arguments.after} compares what they describe"
        raise ConfigError("usage", message, hint=hint)
    return find_model(file, arguments) or file
