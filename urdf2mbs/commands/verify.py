"""`verify`: is an .mbs, or another URDF, the same robot?

Splits both descriptions into rigid groups, and compares motion, mass, centre
and inertia of each group.  The .mbs may be of any origin; a second URDF is
compared as well.  Writes nothing.  Exit code 0: the same robot; 3: not.
"""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.commands.printing import print_json, tell_diagnostics
from urdf2mbs.commands.settings import (
    READING,
    add_fields,
    add_printing,
    add_verbose,
    choose_fields,
    path,
)
from urdf2mbs.commands.streams import STREAM
from urdf2mbs.disk import files
from urdf2mbs.engine.plugins import of_ours
from urdf2mbs.messages.diagnostics import counted, printable

if TYPE_CHECKING:
    from urdf2mbs.api import Verdict

EXAMPLES = (
    "urdf2mbs verify robot.urdf robot.mbs",
    "urdf2mbs verify robot.urdf PROJECT",
    "urdf2mbs verify robot.xacro robot.urdf",
    "urdf2mbs verify robot.urdf robot.mbs --ci --sarif urdf2mbs.sarif",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "robot", metavar="ROBOT",
        help="a .urdf or .xacro file, robot_descriptions:NAME, or - for standard input",
    )  # fmt: skip
    command.add_argument(
        "model", type=path, metavar="MODEL.mbs",
        help="of urdf2mbs, or drawn by hand; a project's folder; or another .urdf or .xacro",
    )  # fmt: skip
    add_printing(command, writes=False)
    add_verbose(command)
    add_fields(command, *READING, "packages", "xacro_args", "base")
    command.add_argument(
        "--gravity", type=float, nargs=3, default=(0.0, 0.0, -9.81), metavar=("X", "Y", "Z"),
        help="the gravity that the .mbs should have, in m/s^2 (0 0 -9.81)",
    )  # fmt: skip
    command.add_argument(
        "--frames", action="store_true",
        help="a link's frame that is elsewhere in the .mbs is a difference, too",
    )  # fmt: skip
    findings = of_ours("findings")
    if findings is not None:
        findings.add_options(command)
    command.add_argument("--tolerance", type=float, default=1e-9, help="relative (%(default)s)")


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.api import verify

    source = files.take_stdin() if arguments.robot == STREAM else arguments.robot
    findings = of_ours("findings")
    with findings.collecting(arguments.sarif, source) if findings else nullcontext() as found:
        verdict = verify(
            source, arguments.model, frames=arguments.frames, gravity=tuple(arguments.gravity),
            tolerance=arguments.tolerance, **choose_fields(arguments),
        )  # fmt: skip
        if found is not None:
            found.said += [*verdict.diagnostics, *findings.differences(verdict.differences)]
    code = 0 if verdict.same else 3
    if arguments.json:
        words = {"same": verdict.same, "verdict": verdict.verdict}
        print_json({**words, **msgspec.to_builtins(verdict)})
        return code
    if found is not None and arguments.ci:
        found.tell(arguments.verbose)
        print(verdict.verdict)
        return code
    _tell_match(verdict)
    print(f"  {verdict.compared}")
    if verdict.frames:
        frames = counted(len(verdict.frames), "frame")
        print(f"  {frames} of links and points elsewhere than by the URDF, as a model may choose "
              "(--frames lists them, as differences)")  # fmt: skip
    if verdict.differences:
        print("not the same, by relative size:")
    for difference in verdict.differences:
        print(printable(f"  {difference.size:8.2e}  {difference.message}"))
    tell_diagnostics(verdict.diagnostics, arguments.verbose)
    print(verdict.verdict)
    return code


def _tell_match(verdict: Verdict) -> None:
    """Which joints of the URDF and of the .mbs are the same, and what they move."""
    own = [f"'{name}'" for name, joints in verdict.joints.items() if len(joints) == 6]
    base = ", and the floating base" if verdict.floating_base else ", the base is fixed"
    if own:
        base = f", {', '.join(own)} floats"
    print(f"{verdict.robot}: {len(verdict.joints)} of {verdict.moving} joints match by name{base}")
    if verdict.made_of:
        print(f"  the .mbs is {verdict.made_of}, converted in memory")
    print(f"  {verdict.mbs_mass:.6g} kg move in the .mbs, {verdict.urdf_mass:.6g} kg in the URDF")
