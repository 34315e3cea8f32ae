"""Compare mujoco: does MuJoCo compute the same robot from its MJCF?

The proof of ``check`` compares the .mbs with the robot that was read.  This pass compares that
robot with MuJoCo's own numbers of the MJCF, at three random states: mass matrix without armature,
bias of gravity and inertia, and the pose of each body.  The verdict says what it finds.
"""

from __future__ import annotations

from math import ceil, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from urdf2mbs.plugin import (
    Conversion,
    Difference,
    Pass,
    SecondOpinions,
    Tolerance,
    read_text,
)
from urdf2mbs_mjcf.dynamics import Coordinates, Dynamics, compute_dynamics
from urdf2mbs_mjcf.frames import Frame
from urdf2mbs_mjcf.model import State, Written

if TYPE_CHECKING:
    from urdf2mbs.plugin import Robot

#: The smallest deviation that the verdict states.
_LEAST = 1e-13


class CompareMujoco(Pass):
    """Compare the robot that was read with what MuJoCo computes of the MJCF."""

    reads = ("robot",)

    tolerance: Tolerance = 1e-9
    """The largest relative deviation that is no difference."""

    def run(self, conversion: Conversion) -> None:
        """Compare at each state, and give the result to the verdict."""
        written = conversion.states.get(Written)
        if written is None:
            return
        opinions = conversion.state(SecondOpinions)
        cuts = conversion.input.settings.get("passes", {}).get("loops", {}).get("cuts", {})
        reason = f"in {conversion.settings.source.name}, whose ends are not read here"
        opinions.not_compared |= {f"cut '{name}' ({cuts[name]['kind']})": reason for name in cuts}
        if not written.model.joints:
            return
        robot = conversion.robot
        if conversion.checked.changed:  # by a pass that a config has put before this one
            given = conversion.input
            robot, _ = read_text(conversion.settings.source, given.data, given.expansion, {})
        deviations: dict[str, Deviation] = {}
        for state in written.model.states:
            for deviation in compare_state(robot, written, state):
                known = deviations.get(deviation.kind)
                if known is None or deviation.size > known.size:
                    deviations[deviation.kind] = deviation
        conversion.report["compare-mujoco"] = {
            "mujoco": written.model.version,
            **{deviation.kind: deviation.size for deviation in deviations.values()},
        }
        different = [each for each in deviations.values() if not each.size <= self.tolerance]
        opinions.differences += [
            Difference(
                "mujoco",
                f"MuJoCo computes another {each.kind} of the MJCF, at {each.place}: it deviates "
                f"by {each.size:.1e}",
                each.size,
            )
            for each in different
        ]
        if not different:
            worst = max(each.size for each in deviations.values())
            digits = 10.0 ** ceil(log10(max(worst, _LEAST)))
            opinions.confirmed.append(f"as MuJoCo computes it, to {digits:.0e}")


class Deviation(NamedTuple):
    """The largest relative deviation of a kind, and where it is."""

    kind: str
    size: float
    place: str


def compare_state(robot: Robot, written: Written, state: State) -> list[Deviation]:
    """Return the deviations of mass matrix, bias and poses at one state."""
    coordinates, names = {}, [""] * len(state.velocity)
    for joint, name, values in zip(written.model.joints, written.joints, state.angles, strict=True):
        hinge = f"{name}_R3" if joint.type == "ball" else name
        coordinates[hinge] = Coordinates(joint.dofadr, values)
        names[joint.dofadr : joint.dofadr + len(values)] = [f"joint '{name}'"] * len(values)
    velocity = np.array(state.velocity)
    dynamics = compute_dynamics(robot, coordinates, velocity, written.model.gravity)
    return [*_compare_forces(dynamics, state, names), _compare_poses(dynamics, written, state)]


def _compare_forces(dynamics: Dynamics, state: State, names: list[str]) -> list[Deviation]:
    """Return the deviations of mass matrix and bias.

    An element of the mass matrix is at most ``(M_ii M_jj)^(1/2)``, its scale.  That of the bias is
    ``M_ii^(1/2)`` times the largest of all ``|c_j| / M_jj^(1/2)``, or ``M_jj^(1/2) qd_j^2`` if that
    is larger.
    """
    mass_matrix, bias = np.array(state.mass_matrix), np.array(state.bias)
    roots = np.sqrt(np.maximum(mass_matrix.diagonal(), dynamics.mass_matrix.diagonal()))
    roots = np.maximum(roots, 1e-9 * roots.max(initial=0.0) + np.finfo(float).tiny)
    scaled = np.abs(dynamics.mass_matrix - mass_matrix) / np.outer(roots, roots)
    row = int(scaled.max(axis=1).argmax())
    speeds = roots * np.square(state.velocity)
    largest = max((np.abs(bias) / roots).max(), speeds.max()) + np.finfo(float).tiny
    scaled_bias = np.abs(dynamics.bias - bias) / (roots * largest)
    entry = int(scaled_bias.argmax())
    return [
        Deviation("mass matrix", float(scaled.max()), names[row]),
        Deviation("bias", float(scaled_bias.max()), names[entry]),
    ]


def _compare_poses(dynamics: Dynamics, written: Written, state: State) -> Deviation:
    """Return the largest deviation of a link's pose, relative to the reach of the robot."""
    reach = max(max(map(abs, position)) for position in state.body_pos) or 1.0
    worst = Deviation("pose", 0.0, "no link")
    for name, shift, position, quaternion in zip(
        written.links, written.shifts, state.body_pos, state.body_quat, strict=True
    ):
        frame, motion = Frame(position, quaternion), dynamics.links[name]
        distance = np.abs(motion.position - frame.place(shift)).max() / reach
        angle = np.abs(motion.rotation - np.reshape(frame.rot, (3, 3))).max()
        size = float(max(distance, angle))
        if not size <= worst.size:
            worst = Deviation("pose", size, f"link '{name}'")
    return worst
