"""`verify`: is an .mbs the same robot?"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.commands.printing import (
    other_way,
    print_json,
    proof_in_words,
)
from urdf2mbs.commands.settings import (
    Parents,
    pairs,
)


def add(commands: Any, parents: Parents) -> None:
    verify = commands.add_parser(
        "verify",
        parents=[parents.common],
        help="compare a robot with an .mbs file: are they the same?",
    )
    verify.add_argument("robot", metavar="ROBOT", help="a .urdf or .xacro file")
    verify.add_argument("model", type=Path, metavar="MODEL.mbs")
    verify.add_argument("--package", action="append", default=[], metavar="NAME=DIR")
    verify.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )
    verify.add_argument(
        "--engine", choices=("own", "pinocchio"), default="own",
        help="pinocchio also compares mass matrix, gravity forces and inverse dynamics",
    )  # fmt: skip
    verify.add_argument(
        "--gravity", type=float, nargs=3, default=(0.0, 0.0, -9.81), metavar=("X", "Y", "Z"),
        help="what the .mbs should have, in m/s^2 (0 0 -9.81): a URDF has none",
    )  # fmt: skip
    verify.add_argument(
        "--frames", action="store_true",
        help="a link's frame that is elsewhere in the .mbs is a difference, too",
    )  # fmt: skip
    verify.add_argument("--tolerance", type=float, default=1e-9, help="relative (%(default)s)")
    verify.set_defaults(command=_verify)


#: So many frames that are elsewhere are told; a compact model has moved nearly all.
SHOWN = 10


def _verify(arguments: argparse.Namespace) -> int:
    from urdf2mbs.api import verify
    from urdf2mbs.proof.urdf_side import SIX

    verdict = verify(
        arguments.robot,
        arguments.model,
        packages=dict(pairs(arguments.package, "=", "--package", "NAME=DIR")),
        xacro_args=dict(pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        engine=arguments.engine,
        frames=arguments.frames,
        gravity=tuple(arguments.gravity),
        tolerance=arguments.tolerance,
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
    print("the same robot" if verdict.same else "NOT the same robot")
    return code
