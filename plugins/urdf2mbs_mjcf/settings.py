"""Settings of a config that an MJCF states, and a URDF cannot."""

from __future__ import annotations

from math import isclose, sqrt
from typing import Any

from urdf2mbs.plugin import ROUNDING, Vec, free_name
from urdf2mbs_mjcf.frames import Frame
from urdf2mbs_mjcf.losses import Losses
from urdf2mbs_mjcf.model import Equality
from urdf2mbs_mjcf.urdf import UrdfWriter

_EARTH = (0.0, 0.0, -9.81)
#: The length of the arms that keep the axes of two welded bodies parallel (m).
_ARM = 0.1


def make_settings(writer: UrdfWriter, losses: Losses) -> dict[str, Any]:
    """Return the settings, as the keys of a config.

    Args:
        writer: Has written the URDF.
        losses: Gets the equalities and tendons that no cut replaces.
    """
    model = writer.model
    settings: dict[str, Any] = {}
    if not all(isclose(a, b, abs_tol=1e-12) for a, b in zip(model.gravity, _EARTH, strict=True)):
        settings["gravity"] = list(model.gravity)
    passes: dict[str, Any] = {}
    if any(dof.armature for dof in model.dofs):
        passes["rotors"] = {"from_urdf": True}
    if gains := _list_gains(writer):
        passes["posture"] = {"hold": {"joints": list(gains), "gains": gains}}
    if cuts := CutMaker(writer, losses).make():
        passes["loops"] = {"cuts": cuts}
    if passes:
        settings["passes"] = passes
    return settings


def _list_gains(writer: UrdfWriter) -> dict[str, dict[str, float]]:
    """Return the gains of position controllers, by joint.

    The force of such an actuator is ``gear (k u - kp gear q - kv gear qd)``.
    """
    gains: dict[str, dict[str, float]] = {}
    for actuator, joint, gear in writer.list_motors():
        _, position, velocity = actuator.biasprm[:3]
        if actuator.biastype == "affine" and position < 0.0 and joint not in writer.leaders:
            name = writer.joints[joint]
            gain = gains.setdefault(name, {"stiffness": 0.0, "damping": 0.0})
            gain["stiffness"] -= position * gear**2
            gain["damping"] -= min(velocity, 0.0) * gear**2
    return gains


class CutMaker:
    """Makes the cuts of loops from equalities and tendons.

    A ``connect`` is a ball, whose point each body has in its own frame.  A ``weld`` of bodies with
    parallel axes is a solid.  Otherwise it is a ball and three rods, each from an axis of one
    body to another axis of the other: they keep three right angles.
    """

    def __init__(self, writer: UrdfWriter, losses: Losses) -> None:
        self.writer = writer
        self.losses = losses
        self.cuts: dict[str, Any] = {}
        self._tendons: set[int] = set()
        """The tendons that are rods."""

    def make(self) -> dict[str, Any]:
        """Return the cuts by name."""
        for number, equality in enumerate(self.writer.model.equalities):
            name = equality.name or f"equality{number}"
            reason = self._add_equality(equality, name)
            if reason:
                self.losses.add("mjcf-coupling", f"equalities are left out: {reason}", name)
        for number, tendon in enumerate(self.writer.model.tendons):
            if number not in self._tendons:
                self.losses.add("mjcf-tendon", "tendons are left out", tendon.name)
        return self.cuts

    def _add_equality(self, equality: Equality, name: str) -> str:
        """Add the cuts of an equality; return why there are none."""
        if equality.type == "joint":
            return self._explain_joint(equality)
        if not equality.active0:
            return "not active at the start"
        if equality.type == "tendon":
            return self._add_rod(equality, name)
        if equality.type not in ("connect", "weld"):
            return f"of the type {equality.type}"
        return self._add_tie(equality, name)

    def _explain_joint(self, equality: Equality) -> str:
        """Return why an equality of joints is no ``<mimic>``; empty if it is one."""
        if not equality.active0:
            return "not active at the start"
        if equality.obj2id < 0:
            return "a joint at a constant position"
        if any(equality.data[2:5]):
            return "polynomial couplings of joints"
        if self.writer.leaders.get(equality.obj1id) == equality.obj2id:
            return ""
        return "the joint follows another already"

    def _add_rod(self, equality: Equality, name: str) -> str:
        """Add the rod of a tendon between two sites that keeps its length."""
        model = self.writer.model
        tendon = model.tendons[equality.obj1id]
        wraps = model.wraps[tendon.adr : tendon.adr + tendon.num]
        if equality.obj2id >= 0 or [wrap.type for wrap in wraps] != ["site", "site"]:
            return "of tendons"
        self._tendons.add(equality.obj1id)
        points = []
        for wrap in wraps:
            site = model.sites[wrap.objid]
            points.append((site.bodyid, site.pos))
        length = tendon.length0 + equality.data[0]
        self._add_cut(name, "rod", points, length)
        return ""

    def _add_tie(self, equality: Equality, name: str) -> str:
        """Add the cuts of a ``connect`` or ``weld``."""
        model = self.writer.model
        bodies, frames = self._find_ends(equality)
        if any(model.bodies[body].mocapid >= 0 for body in bodies):
            self.losses.add("mjcf-mocap", "welds to bodies that a user moves (mocap)", name)
            return ""
        if bodies[0] == bodies[1]:
            return "of a body with itself"
        first, second = zip(bodies, frames, strict=True)
        points = [(body, frame.xyz) for body, frame in (first, second)]
        if equality.type == "connect":
            self._add_cut(name, "ball", points)
            return ""
        relative = frames[0].compose(Frame(quat=frames[1].inverse().quat))
        if max(map(abs, relative.quat[1:])) < ROUNDING:
            self._add_cut(name, "solid", points)
            return ""
        self._add_cut(name, "ball", points)
        for axis in range(3):
            ends = []
            for (body, frame), direction in ((first, axis), (second, (axis + 1) % 3)):
                arm = [0.0, 0.0, 0.0]
                arm[direction] = _ARM
                ends.append((body, frame.place((arm[0], arm[1], arm[2]))))
            self._add_cut(f"{name}_{'xyz'[axis]}", "rod", ends, _ARM * sqrt(2.0))
        return ""

    def _find_ends(self, equality: Equality) -> tuple[tuple[int, int], tuple[Frame, Frame]]:
        """Return the two bodies, and the frames on them that are to coincide."""
        model, data = self.writer.model, equality.data
        if equality.objtype == "site":
            first, second = model.sites[equality.obj1id], model.sites[equality.obj2id]
            frames = Frame(first.pos, first.quat), Frame(second.pos, second.quat)
            return (first.bodyid, second.bodyid), frames
        bodies = equality.obj1id, equality.obj2id
        ends = (data[0], data[1], data[2]), (data[3], data[4], data[5])
        if equality.type == "connect":
            return bodies, (Frame(ends[0]), Frame(ends[1]))
        # the anchor of a weld is in the second body; its pose is that of the second in the first
        w, x, y, z = data[6:10]
        return bodies, (Frame(ends[1], (w, x, y, z)), Frame(ends[0]))

    def _add_cut(
        self, name: str, kind: str, points: list[tuple[int, Vec]], length: float | None = None
    ) -> None:
        """Add a cut between two points (m), each in the frame of a body."""
        used = {*self.cuts, *self.writer.list_links()}
        cut: dict[str, Any] = {
            "kind": kind,
            "ends": [
                {
                    "link": self.writer.links[body],
                    "at": list(self.writer.to_link(body, Frame(point)).xyz),
                }
                for body, point in points
            ],
        }
        if length is not None:
            cut["length"] = length
        self.cuts[free_name(name, used)] = cut
