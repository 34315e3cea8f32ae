"""What `compact` saves: joints, joints a degree of freedom, and the time of the equations.

    pip install -e ".[test]"
    python benchmarks/compact.py [--large] [FOLDER OF ROBOTS]

Massless links are kept (prune-massless: {keep: ["*"]}), the joints of a floating base are not
counted.  The time is that of Pinocchio's mass matrix and bias (crba, nonLinearEffects) on a
model in which every joint of the file is one of the model, driven ones too, as in Robotran's
equations.  The deviation is the largest that ``check`` finds of a motion, a mass, a centre, an
inertia or a frame, relative to the robot's own.

Pinocchio's data takes 64 n^3 bytes for n joints, 14 GB for the faithful iCub: what takes more
than 4 GB is not timed without --large.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec
import numpy as np
import pinocchio as pin

from urdf2mbs import convert
from urdf2mbs.mbs.model import Mbs

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))
from support.oracle.pin import to_pinocchio

SHARED = Path(__file__).resolve().parents[2] / "shared" / "robots"

#: Humanoids, arms and legs: file, and whether the base floats.
ROBOTS = {
    "iCub V2.5": ("icub/iCub/robots/iCubGazeboV2_5/model.urdf", True),
    "iCub Genova02": ("icub/iCub/robots/iCubGenova02/model.urdf", True),
    "iCub Lisboa01": ("icub/iCub/robots/iCubLisboa01/model.urdf", True),
    "iCub Nancy01": ("icub/iCub/robots/iCubNancy01/model.urdf", True),
    "NAO V50": ("nao/nao_description/urdf/naoV50_generated_urdf/nao.urdf", True),
    "NAO V40": ("nao/nao_description/urdf/naoV40_generated_urdf/nao.urdf", True),
    "NAO V33": ("nao/nao_description/urdf/naoV33_generated_urdf/nao.urdf", True),
    "WalkMan": ("walkman/robotran_edu_2017/bigman.urdf", True),
    "Atlas v5": ("atlas/expanded/atlas_v5.urdf", True),
    "Atlas v4": ("atlas/expanded/atlas_v4.urdf", True),
    "Atlas v3": ("atlas/expanded/atlas_v3.urdf", True),
    "Cassie": ("cassie/cassie_description/urdf/cassie_v4.urdf", True),
    "Solo12": ("solo12/expanded/solo12.urdf", True),
    "Solo8": ("solo12/expanded/solo8.urdf", True),
    "T12": ("t12/T12/urdf/T12.URDF", True),
    **{
        name.upper(): (f"ur/expanded/{name}.urdf", False)
        for name in ("ur3", "ur3e", "ur5", "ur5e", "ur10", "ur10e", "ur16e", "ur20", "ur30")
    },
    "FR3": ("franka/expanded/fr3.urdf", False),
    "FR3 without hand": ("franka/expanded/fr3_nohand.urdf", False),
    "FER": ("franka/expanded/fer.urdf", False),
    "IRB 2400": ("abb_irb2400/abb_irb2400_support/urdf/irb2400.urdf", False),
}
KEEP = {"prune-massless": {"keep": ["*"]}}


def joints(mbs: Mbs, floating: bool) -> int:
    return sum(len(body.joints) for body in mbs.bodies) - (6 if floating else 0)


def equations(mbs: Mbs) -> float:
    """Microseconds of mass matrix and bias, every joint of the file being one of the model."""
    everything = msgspec.convert(msgspec.to_builtins(mbs), Mbs)
    for body in everything.bodies:
        for joint in body.joints:
            joint.nature = "independent"
    model = to_pinocchio(everything)
    data = model.createData()
    q, v = np.full(model.nq, 0.3), np.full(model.nv, 0.2)
    best = float("inf")
    for _ in range(200):
        start = perf_counter()
        for _ in range(10):
            pin.crba(model, data, q)
            pin.nonLinearEffects(model, data, q, v)
        best = min(best, (perf_counter() - start) / 10)
    return best * 1e6


def row(name: str, source: Path, floating: bool, large: bool) -> tuple[Any, ...]:
    base = "floating" if floating else "fixed"
    plain = convert(source, base=base, passes=KEEP)
    compact = convert(source, base=base, passes=KEEP, pipeline="compact")
    dof = compact.report.joints.independent - (6 if floating else 0)
    small = 64 * joints(plain.mbs, floating=False) ** 3 < 4e9
    return (
        name, dof, joints(plain.mbs, floating), joints(compact.mbs, floating),
        equations(plain.mbs) if small or large else float("nan"), equations(compact.mbs),
        max(compact.report.proof.largest.values()),
    )  # fmt: skip


def rounded(folder: Path, tolerance: float) -> tuple[dict[str, int], float]:
    """The joints of each robot, and the largest deviation of a pose, with a tolerance."""
    options = {**KEEP, "align-frames": {"tolerance": tolerance}}
    found, off = {}, 0.0
    for name, (file, floating) in ROBOTS.items():
        base = "floating" if floating else "fixed"
        compact = convert(folder / file, base=base, passes=options, pipeline="compact")
        found[name] = joints(compact.mbs, floating)
        largest = compact.report.proof.largest
        off = max(off, largest["motion"], largest["frame"])
    return found, off


def main() -> None:
    words = [word for word in sys.argv[1:] if word != "--large"]
    folder = Path(words[0]) if words else SHARED
    print("| robot | dof | faithful | compact | per dof | equations, µs | ratio | deviation |")
    print("|---|---|---|---|---|---|---|---|")
    rows = [
        row(name, folder / file, floating, large="--large" in sys.argv)
        for name, (file, floating) in ROBOTS.items()
    ]
    for name, dof, plain, compact, slow, fast, off in rows:
        print(
            f"| {name} | {dof} | {plain} | {compact} | {compact / dof:.2f} | "
            f"{slow:.1f} / {fast:.1f} | {slow / fast:.1f} | {off:.0e} |".replace("nan", "-")
        )
    dof, plain, compact = (sum(r[k] for r in rows) for k in (1, 2, 3))
    off = max(r[6] for r in rows)
    print(f"| all | {dof} | {plain} | {compact} | {compact / dof:.2f} | | | {off:.0e} |")
    shown = ("UR5", "NAO V50", "iCub Lisboa01", "T12")
    print(f"\n| tolerance, rad | {' | '.join(shown)} | all, per dof | largest error of a pose |")
    print("|---" * (len(shown) + 3) + "|")
    for tolerance in (1e-12, 1e-9, 1e-6):
        found, off = rounded(folder, tolerance)
        counts = " | ".join(str(found[name]) for name in shown)
        per_dof = sum(found.values()) / dof
        print(f"| {tolerance:.0e} | {counts} | {per_dof:.2f} | {off:.0e} |")


if __name__ == "__main__":
    main()
