"""`verify`: is an .mbs the same robot?"""

from __future__ import annotations

import argparse
import sys

import msgspec

from urdf2mbs.commands.printing import other_way, print_json, proof_in_words, tell_diagnostics
from urdf2mbs.commands.settings import (
    add_base,
    add_levels,
    add_model,
    add_robot,
    add_telling,
    add_trust,
    levels,
    pairs,
)
from urdf2mbs.commands.streams import STREAM
from urdf2mbs.diagnostics import counted
from urdf2mbs.urdf import standard_input

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
    add_telling(command, writes=False)
    add_levels(command)
    add_robot(command)
    add_trust(command)
    command.add_argument(
        "--engine", choices=("own", "pinocchio"), default="own",
        help="own (the default), or pinocchio, which compares mass matrix and forces, too",
    )  # fmt: skip
    add_base(command)
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
        base=arguments.base or "auto",
        engine=arguments.engine,
        frames=arguments.frames,
        gravity=tuple(arguments.gravity),
        tolerance=arguments.tolerance,
        trust_xacro=arguments.trust_xacro,
        **levels(arguments),
    )
    code = 0 if verdict.same else 3
    if arguments.json:
        words = {"same": verdict.same, "verdict": verdict.verdict}
        print_json({**words, **msgspec.to_builtins(verdict)})
        return code
    own = [f"'{name}'" for name, joints in verdict.joints.items() if len(joints) == len(SIX)]
    base = ", and the floating base" if verdict.floating_base else ", the base is fixed"
    if own:
        base = f", {', '.join(own)} floats"
    print(f"{verdict.robot}: {len(verdict.joints)} of {verdict.moving} joints match by name{base}")
    print(f"  {verdict.mbs_mass:.6g} kg move in the .mbs, {verdict.urdf_mass:.6g} kg in the URDF")
    if verdict.flipped:
        print(f"  {other_way(verdict.flipped)}")
    print(f"  {proof_in_words(verdict)}")
    if verdict.frames:
        print(
            f"  {counted(len(verdict.frames), 'frame')} of links and points elsewhere than by the "
            "URDF, as a model may choose (--frames lists them, as differences)"
        )
    if verdict.differences:
        print("not the same, by relative size:")
    for difference in verdict.differences:
        print(f"  {difference.size:8.2e}  {difference.message}")
    for problem in verdict.schema:
        print(problem, file=sys.stderr)
    tell_diagnostics(verdict.diagnostics, arguments.verbose)
    print(verdict.verdict)
    return code
