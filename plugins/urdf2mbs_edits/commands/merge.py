"""`merge`: three versions of an .mbs become one, as a merge driver of git wants it.

Takes what each side changed since the base.  Names a conflict where both sides
changed the same thing, and then ends with exit code 1.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from urdf2mbs.plugin import (
    ConversionError,
    add_printing,
    counted,
    path,
    print_json,
    printable,
    read_model,
    write_files,
)

EXAMPLES = (
    "urdf2mbs merge base.mbs ours.mbs theirs.mbs -o merged.mbs",
    "urdf2mbs merge base.mbs ours.mbs theirs.mbs --json",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("base", type=path, metavar="BASE.mbs", help="the version before both")
    command.add_argument("ours", type=path, metavar="OURS.mbs", help="one version; its file stays")
    command.add_argument("theirs", type=path, metavar="THEIRS.mbs", help="the other version")
    command.add_argument(
        "-o", "--output", type=path, metavar="OUT.mbs", help="default: OURS.mbs, as git wants it"
    )
    command.add_argument(
        "--path", type=path, metavar="FILE.mbs", help="the file that is merged, for messages (%%P)"
    )
    add_printing(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Exit code as git wants it: 0 merged, 1 conflicts, 2 trouble."""
    from urdf2mbs.plugin import read_mbs as read
    from urdf2mbs_edits.merge.base import is_base, renewed
    from urdf2mbs_edits.merge.merge import merge, with_those_before

    output: Path = arguments.output or arguments.ours
    name: Path = arguments.path or output
    files = [read_model(file) for file in (arguments.base, arguments.ours, arguments.theirs)]
    try:
        base, ours, theirs = (
            read(data, f"{name} ({side})")
            for data, side in zip(files, ("base", "ours", "theirs"), strict=True)
        )
        merged = merge(base, ours, theirs, None)
    except ConversionError as error:
        error.exit_code = 2
        raise
    data = merged.data
    if all(map(is_base, files)):
        data = renewed(data)
    written, there = {output: data}, {output: files[1]}
    if merged.orphans is not None:
        place = name.with_name(f"{name.stem}.orphaned.mbs")
        there[place] = place.read_bytes() if place.is_file() else b""
        written[place] = with_those_before(merged.orphans, there[place])
    write_files(written, replaces=there, force=arguments.force)
    words = merged.plan.words("theirs", "ours")
    conflicts = words["in conflict"] + words["orphaned"]
    if arguments.json:
        print_json({"output": str(output), "merge": merged.plan})
    else:
        said = f"{len(words['updated'])} of theirs, {len(words['kept'])} of ours"
        print(f"{name}: {said}, {counted(len(conflicts), 'conflict')}")
        for conflict in conflicts:
            print(printable(f"{name}: conflict: {conflict}"), file=sys.stderr)
    return 1 if conflicts else 0
