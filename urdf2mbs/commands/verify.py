"""`verify`: is an .mbs the same robot?"""

from __future__ import annotations

import argparse
import sys

import msgspec

from urdf2mbs.commands.printing import other_way, print_json, proof_in_words, tell_diagnostics
from urdf2mbs.commands.settings import (
    add_isolate,
    add_levels,
    add_model,
    add_robot,
    add_telling,
    levels,
    pairs,
)
from urdf2mbs.commands.streams import STREAM
from urdf2mbs.urdf import standard_input

#: So many frames that are elsewhere are told; a compact model has moved nearly all.
SHOWN = 10

EXAMPLES = (
    "urdf2mbs verify robot.urdf robot.mbs",
    "urdf2mbs verify robot.urdf robot.mbs --engine pinocchio",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "robot", metavar="ROBOT",
        help="a .urdf or .xacro file, robot_descriptions:NAME, or - for standard input",
    )  # fmt: skip
    add_model(command)
    add_telling(command)
    add_levels(command)
    add_robot(command)
    add_isolate(command)
    command.add_argument(
        "--engine", choices=("own", "pinocchio"), default="own",
        help="own (the default), or pinocchio, which compares mass matrix and forces, too",
    )  # fmt: skip
    command.add_argument(
        "--gravity", type=float, nargs=3, default=(0.0, 0.0, -9.81), metavar=("X", "Y", "Z"),
        help="what the .mbs should have, in m/s^2 (0 0 -9.81): a URDF has none",
    )  # fmt: skip
    command.add_argument(
        "--frames", action="store_true",
        help="a link's frame that is elsewhere in the .mbs is a difference, too",
    )  # fmt: skip
    command.add_argument("--tolerance", type=float, default=1e-9, help="relative (%(default)s)")


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.api import verify
    from urdf2mbs.proof.urdf_side import SIX

    verdict = verify(
        standard_input.take() if arguments.robot == STREAM else arguments.robot,
        arguments.model,
        packages=dict(pairs(arguments.package, "=", "--package", "NAME=DIR")),
        xacro_args=dict(pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        engine=arguments.engine,
        frames=arguments.frames,
        gravity=tuple(arguments.gravity),
        tolerance=arguments.tolerance,
        isolate={} if arguments.isolate else None,
        **levels(arguments),
    )
    code = 0 if verdict.same else 3
    if arguments.json:
        print_json({"same": verdict.same, **msgspec.to_builtins(verdict)})
        return code
    own = [f"'{name}'" for name, joints in verdict.joints.items() if len(joints) == len(SIX)]
    base = ", and the floating base" if verdict.floating_base else ", the base is fixed"
    if own:
        base = f", {', '.join(own)} floats"
    print(f"{verdict.robot}: {len(verdict.joints)} of {verdict.moving} joints match by name{base}")
    print(f"  {verdict.mbs_mass:.6g} kg move in the .mbs, {verdict.urdf_mass:.6g} kg in the URDF")
    if verdict.flipped:
        print(f"  {other_way(verdict.flipped)}")
    print(f"  {proof_in_words(verdict.groups, verdict.positions, verdict.largest)}")
    if verdict.differences:
        print("not the same, by relative size:")
    for difference in verdict.differences:
        print(f"  {difference.size:8.2e}  {difference.message}")
    if verdict.frames:
        print("frames that are elsewhere, which by itself is no difference:")
    for difference in verdict.frames[:SHOWN]:
        print(f"  {difference.size:8.2e}  {difference.message}")
    if len(verdict.frames) > SHOWN:
        print(f"  and {len(verdict.frames) - SHOWN} more, which --json lists")
    for what, why in verdict.not_compared.items():
        print(f"not compared: {what}: {why}")
    for problem in verdict.schema:
        print(problem, file=sys.stderr)
    tell_diagnostics(verdict.diagnostics, arguments.verbose)
    print("the same robot" if verdict.same else "NOT the same robot")
    return code
