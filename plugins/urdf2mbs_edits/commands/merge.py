"""`merge`: three versions of an .mbs become one, as git's merge driver.

Takes what each side changed since the base.  Names a conflict where both sides
changed the same value, and then ends with exit code 1.  If the changes do not
fit together, lists why with exit code 1, and writes nothing.
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
    """Add the arguments of the command."""
    command.add_argument("base", type=path, metavar="BASE.mbs", help="the version before both")
    command.add_argument("ours", type=path, metavar="OURS.mbs", help="one version; its file stays")
    command.add_argument("theirs", type=path, metavar="THEIRS.mbs", help="the other version")
    command.add_argument(
        "-o", "--output", type=path, metavar="OUT.mbs", help="default: OURS.mbs, as for git"
    )
    command.add_argument(
        "--path", type=path, metavar="FILE.mbs", help="the file that is merged, for messages (%%P)"
    )
    add_printing(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Return the exit code that git expects: 0 merged, 1 conflicts, 2 an error."""
    from urdf2mbs.plugin import read_mbs
    from urdf2mbs_edits.merge.base_file import is_base, renew_checksum
    from urdf2mbs_edits.merge.check import SideNames
    from urdf2mbs_edits.merge.merge import merge

    output: Path = arguments.output or arguments.ours
    name: Path = arguments.path or output
    files = [read_model(file) for file in (arguments.base, arguments.ours, arguments.theirs)]
    try:
        base, ours, theirs = (
            read_mbs(data, f"{name} ({side})")
            for data, side in zip(files, ("base", "ours", "theirs"), strict=True)
        )
    except ConversionError as error:
        error.exit_code = 2
        raise
    merged = merge(base, ours, theirs, None, str(name))
    data = merged.data
    if all(map(is_base, files)):
        data = renew_checksum(data)
    write_files({output: data}, replaces={output: files[1]}, force=arguments.force)
    sentences = merged.plan.describe(SideNames("theirs", "ours"))
    conflicts = sentences["in conflict"] + sentences["orphaned"]
    if arguments.json:
        print_json({"output": str(output), "merge": merged.plan})
    else:
        counts = f"{len(sentences['updated'])} of theirs, {len(sentences['kept'])} of ours"
        print(f"{name}: {counts}, {counted(len(conflicts), 'conflict')}")
        for conflict in conflicts:
            print(printable(f"{name}: conflict: {conflict}"), file=sys.stderr)
    return 1 if conflicts else 0
