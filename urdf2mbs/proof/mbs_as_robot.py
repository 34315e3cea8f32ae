"""A model as a robot of links and joints, to compare another model with it.

Every joint of an .mbs is elementary, and so is a URDF joint at the origin of the link before it:

* an anchor point, and each driven joint at its start, become the ``<origin>`` of the next joint, or
  a fixed joint if another one comes before;
* each joint that is not driven becomes a joint about or along its coordinate axis.

A body is the link after its last joint.  The links between the joints of a body have no mass.
"""

from __future__ import annotations

from urdf2mbs.mbs.model import BASE, Body, Joint, Mbs
from urdf2mbs.proof.parameters import read_user_models
from urdf2mbs.spatial import NO_INERTIA, ZERO, Vec
from urdf2mbs.urdf import model
from urdf2mbs.urdf.model import RATES, Dynamics, Inertial, Limit, Link, Origin, Robot

_AXES: tuple[Vec, Vec, Vec] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def convert_to_robot(mbs: Mbs, file: str) -> Robot:
    """Convert a model to a robot.

    Args:
        mbs: The model.
        file: The name of its file.
    """
    return _Conversion(mbs, file).convert()


class _Conversion:
    """Converts one body after the other."""

    def __init__(self, mbs: Mbs, file: str) -> None:
        self.mbs = mbs
        self.numbers = _read_numbers(mbs)
        self.points = mbs.points()
        self.bodies = {body.name for body in mbs.bodies}
        self.root = self._make_unique(mbs.base.name or BASE)
        self.robot = Robot(mbs.name, {self.root: Link(self.root)}, {}, file=file)

    def _make_unique(self, name: str) -> str:
        """Return a name that no body has."""
        while name in self.bodies:
            name += "_link"
        return name

    def convert(self) -> Robot:
        """Convert all bodies."""
        for body in self.mbs.bodies:
            self._add_body(body)
        return self.robot

    def _add_body(self, body: Body) -> None:
        """Add the joints of a body, and the body as a link."""
        steps = self._list_steps(body)
        parent = body.parent or self.root
        for number, (joint, origin) in enumerate(steps, start=1):
            is_last = number == len(steps)
            name = body.name if is_last else self._make_unique(f"{body.name}/{joint.name}")
            inertial = None
            if is_last and (body.mass or body.inertia):
                tensor = body.inertia or NO_INERTIA
                inertial = Inertial(body.mass or 0.0, tensor, Origin(body.com or ZERO))
            self.robot.links[name] = Link(name, inertial)
            joint.parent, joint.child, joint.origin = parent, name, origin
            self.robot.joints[joint.name] = joint
            parent = name

    def _list_steps(self, body: Body) -> list[tuple[model.Joint, Origin]]:
        """List the joints that lead to a body, each with its place after the one before."""
        xyz = ZERO
        if body.point is not None:
            xyz = self.points[body.parent, body.point].coordinates
        steps: list[tuple[model.Joint, Origin]] = []
        for joint in body.joints:
            if joint.nature == "driven":
                origin = _place_after(joint, xyz)
                steps.append((model.Joint(joint.name, "fixed", "", ""), origin))
            else:
                steps.append((self._convert_joint(joint), Origin(xyz)))
            xyz = ZERO
        if not steps:
            steps.append((model.Joint(f"{body.name}_fixed", "fixed", "", ""), Origin(xyz)))
        return steps

    def _convert_joint(self, joint: Joint) -> model.Joint:
        """Convert a joint that moves, with the numbers of its user models."""
        numbers = self.numbers.get(joint.name, {})
        joint_type = "prismatic" if joint.type[0] == "T" else "continuous"
        limit = None
        if not numbers.keys().isdisjoint(("q_min", "q_max", "effort", *RATES)):
            joint_type = "prismatic" if joint.type[0] == "T" else "revolute"
            others = {kind: numbers.get(kind) for kind in ("effort", *RATES)}
            limit = Limit(numbers.get("q_min"), numbers.get("q_max"), **others)
        dynamics = Dynamics(
            numbers.get("damping", 0.0),
            numbers.get("friction", 0.0),
            numbers.get("spring_stiffness", 0.0),
            numbers.get("spring_reference", 0.0),
        )
        axis = _AXES[int(joint.type[1]) - 1]
        return model.Joint(
            joint.name, joint_type, "", "", axis=axis, limit=limit, dynamics=dynamics
        )


def _place_after(joint: Joint, xyz: Vec) -> Origin:
    """Return the origin of what comes after a driven joint, which starts at a point (m)."""
    position = joint.q or 0.0
    x, y, z = (position * component for component in _AXES[int(joint.type[1]) - 1])
    if joint.type[0] == "T":
        return Origin((xyz[0] + x, xyz[1] + y, xyz[2] + z))
    return Origin(xyz, (x, y, z))


def _read_numbers(mbs: Mbs) -> dict[str, dict[str, float]]:
    """Read the numbers of joints in user models: joint, kind, number."""
    numbers: dict[str, dict[str, float]] = {}
    for kind, texts in read_user_models(mbs).items():
        for joint, text in texts.items():
            try:
                numbers.setdefault(joint, {})[kind] = float(text)
            except ValueError:
                continue
    return numbers
