"""A conversion beside its URDF in Pinocchio: motion, matter, forces, shapes, names."""

import re
import zlib
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from support.oracle.mbs import GROUND, Evaluator, Shape
from support.oracle.multibody import Array, State, lump, translation
from support.oracle.pin import Pinocchio
from support.oracle.urdf import FLOATING_BASE, GRAVITY, Reference, Urdf, UrdfShape
from urdf2mbs import Result
from urdf2mbs.spatial import Pose

#: Turns (R) and shifts (T) of the .mbs for each type of joint.
KINDS = {
    "fixed": "",
    "revolute": "R",
    "continuous": "R",
    "prismatic": "T",
    "planar": "TTR",
    "floating": "TTTRRR",
}


class Comparison:
    """A conversion against Pinocchio's model of its URDF: the largest relative error of each kind.

    Each is relative to what it can be compared with at all:

    * ``pose``: positions to the farthest link, rotations as they are;
    * ``mass``, ``com``, ``inertia`` of each rigid group: its mass; the farthest link; its
      inertia plus mass times the distance of its centre squared;
    * ``matrix``: ``M_ij`` to ``sqrt(M_ii M_jj)``, so that a finger counts as much as the base;
    * ``gravity``: to ``9.81 sqrt(m M_ii)`` with the moved mass m, its bound by Cauchy-Schwarz;
    * ``dynamics``: forces over ``sqrt(M_ii)`` to the largest of these, weights included.

    A joint that moves almost nothing counts as if it moved its mass on 3e-3 of the size: its
    ``M_ii`` is a small difference of large numbers.
    """

    def __init__(self, result: Result, urdf: Urdf, *, floating: bool) -> None:
        self.result = result
        self.urdf = urdf
        self.mbs = Evaluator(result.data)
        self.floating = floating
        self.frozen = sorted(result.frozen)
        self.reals: dict[str, list[str]] = {}
        """The .mbs joints that are each URDF joint's own coordinates, in their order."""
        for joint in urdf.joints.values():
            if joint.name not in self.frozen:
                self._real(joint.name, joint.name, joint.type)
        new = [name for name in result.names.joints if name not in urdf.joints]
        if floating:
            (base,) = new
            self._real(FLOATING_BASE, base, "floating")
        own = [name for names in self.reals.values() for name in names]
        assert sorted(own) == sorted(self.mbs.moving), "what moves is not what the URDF moves"

    def _real(self, key: str, joint: str, kind: str) -> None:
        names = self.result.names.joints.get(joint, [])
        real = [name for name in names if self.mbs.joints[name].nature != "driven"]
        if real:
            self.reals[key] = real
        for name in real:
            kept = self.mbs.joints[name].symbols
            assert kept is None or {"q", "qd", "qdd"} <= set(kept), f"{name} moves, but {kept}"
        types = [self.mbs.joints[name].type for name in real]
        assert "".join(t[0] for t in types) == KINDS[kind], f"{joint} ({kind}) is {types}"

    @cached_property
    def planar(self) -> dict[str, Array]:
        """The first vector of each planar joint's basis, in the child's frame, off the .mbs: it
        must lie in the plane, and the second must follow from it and the axis."""
        planar = {}
        zero = self.mbs.positions({})
        at = self.link_poses({})
        for joint in self.urdf.joints.values():
            if joint.type == "planar" and joint.name in self.reals:
                first, _, turn = (self.mbs.joints[name] for name in self.reals[joint.name])
                back = at[joint.child][:3, :3].T
                axis = back @ zero.joint(turn.name)[:3, int(turn.type[1]) - 1]
                assert abs(axis - joint.axis).max() < 3e-9, f"{joint.name} does not turn about it"
                basis = back @ zero.joint(first.name)[:3, int(first.type[1]) - 1]
                assert abs(basis @ joint.axis) < 3e-9, f"{joint.name} shifts out of its plane"
                # an axis up to 1e-9 off is taken to be aligned, which turns the plane with it
                basis -= (basis @ joint.axis) * joint.axis
                planar[joint.name] = basis / np.linalg.norm(basis)
        return planar

    def link_poses(self, q: Mapping[str, float]) -> dict[str, Array]:
        """Every URDF link's frame as the .mbs has it, 4x4; q by .mbs name."""
        poses = self.mbs.positions(q)
        out: dict[str, Array] = {}
        for link in self.urdf.inertias:
            frame = self.result.frames[link]
            at = poses.joint(frame.joint) if frame.joint else poses.body(frame.body or GROUND)
            out[link] = at @ matrix_of(frame.pose)
        return out

    @cached_property
    def size(self) -> float:
        """The farthest link or matter (by its radius of gyration) from the root at zero (m)."""
        poses = Reference(self.urdf, floating=False).poses()
        far = [np.linalg.norm(pose[:3, 3]) for pose in poses.values()]
        far += [
            np.linalg.norm(poses[link][:3, 3] + poses[link][:3, :3] @ inertia.com)
            + np.sqrt(abs(np.trace(inertia.tensor)) / (inertia.mass or 1.0))
            for link, inertia in self.urdf.inertias.items()
            if inertia is not None
        ]
        return float(max(far)) or 1.0

    def random(self, rng: np.random.Generator) -> dict[str, float]:
        """A value for every moving .mbs joint: any angle, shifts up to the robot's size."""
        return {
            name: rng.uniform(-np.pi, np.pi)
            if self.mbs.joints[name].type[0] == "R"
            else rng.uniform(-self.size, self.size)
            for name in self.mbs.moving
        }

    def errors(
        self, model: Pinocchio, positions: Sequence[Mapping[str, float]]
    ) -> dict[str, float]:
        assert set(model.coordinates) == set(self.reals), "not the same joints"
        names = {
            theirs: ours
            for joint, real in self.reals.items()
            for ours, theirs in zip(real, model.coordinates[joint], strict=True)
        }
        order = [names[name] for name in model.dofs]
        found = self._group_errors(model)
        rng = np.random.default_rng(1)
        for q in positions:
            values = np.array([q.get(name, 0.0) for name in order])
            found += [("pose", self._pose_error(model, q, values))]
            found += self._force_errors(model, order, values, rng) if order else []
        # as np.max does, a nan stays
        return {
            kind: float(np.max([error for of, error in found if of == kind]))
            for kind in dict(found)
        }

    def _pose_error(self, model: Pinocchio, q: Mapping[str, float], values: Array) -> float:
        ours, wanted = self.link_poses(q), model.poses(values)
        a = np.array([ours[link] for link in wanted])
        b = np.array(list(wanted.values()))
        far = max(np.abs(b[:, :3, 3]).max(), self.size)
        shift = np.abs(a[:, :3, 3] - b[:, :3, 3]).max() / far
        return float(max(shift, np.abs(a[:, :3, :3] - b[:, :3, :3]).max()))

    def _group_errors(self, model: Pinocchio) -> list[tuple[str, float]]:
        zero = self.mbs.positions({})
        link_at = self.link_poses({})
        key_of = {real[-1]: joint for joint, real in self.reals.items()}
        bodies: dict[str | None, list[str]] = {}
        for name in self.mbs.bodies:
            mover = self.mbs.mover(name)
            bodies.setdefault(key_of[mover] if mover else None, []).append(name)
        errors: list[tuple[str, float]] = []
        groups = model.groups()
        assert set(key_of.values()) <= set(groups), "a joint moves no link"
        total = 0.0
        for name in bodies.get(None, []) if None not in groups else []:
            inertia = self.mbs.bodies[name].inertia
            assert not np.any([inertia.mass, *inertia.tensor.flat]), f"{name} cannot move"
        for key, (link, wanted) in groups.items():
            back = np.linalg.inv(link_at[link])
            ours = lump(
                self.mbs.bodies[name].inertia.seen_from(back @ zero.body(name))
                for name in bodies.get(key, [])
            )
            total += wanted.mass
            arm = max(float(np.linalg.norm(wanted.com)), 1e-4 * self.size)
            worth = np.abs(wanted.tensor).max() + wanted.mass * arm * arm
            for kind, difference, unit in (
                ("mass", ours.mass - wanted.mass, wanted.mass),
                # what has inertia but no mass has no centre
                ("com", (ours.com - wanted.com) * (wanted.mass != 0.0), self.size),
                ("inertia", ours.tensor - wanted.tensor, worth),
            ):
                largest = float(np.abs(difference).max())
                errors.append((kind, largest / unit if unit else largest))
        if total:
            errors.append(("mass", abs(self.mbs.total_mass() - total) / total))
        return errors

    def _force_errors(
        self, model: Pinocchio, order: list[str], q: Array, rng: np.random.Generator
    ) -> list[tuple[str, float]]:
        at = [self.mbs.joints[name].node for name in order]
        turns = self.mbs.system.turns[at]
        qd, qdd = rng.uniform(-1, 1, (2, len(order))) * np.where(turns, 1.0, self.size)
        vectors = np.array(
            [self.mbs.vector(self.mbs.driven), *np.zeros((2, len(self.mbs.joints) + 1))]
        )
        vectors[:, at] = q, qd, qdd
        matrix, holding = State(self.mbs.system, vectors[0]).equations()
        _, forces = State(self.mbs.system, *vectors).equations()
        wanted, gravity, force = model.dynamics(q, qd, qdd)
        moved = self.mbs.system.carried_mass()[at]
        lever = np.where(turns, self.size, 1.0)
        unit = np.sqrt(np.diag(wanted).clip(0.0) + 1e-5 * moved * lever**2)
        unit[unit == 0.0] = 1.0
        bound = 9.81 * np.sqrt(moved) * unit
        bound[bound == 0.0] = 1.0
        largest = max(np.abs(force / unit).max(), 9.81 * np.sqrt(moved).max()) or 1.0
        return [
            ("matrix", np.abs((matrix[np.ix_(at, at)] - wanted) / np.outer(unit, unit)).max()),
            ("gravity", np.abs((holding[at] - gravity) / bound).max()),
            ("dynamics", np.abs((forces[at] - force) / unit).max() / largest),
        ]


def beside_its_urdf(
    result: Result, urdf: Urdf, text: bytes, base: str, *, positions: int = 1
) -> tuple[Comparison, dict[str, float]]:
    """A conversion beside Pinocchio, at zero and at random positions: the largest error of each
    kind."""
    comparison = Comparison(result, urdf, floating=urdf.floats(base))
    rng = np.random.default_rng(zlib.crc32(text))
    at = [{}, *(comparison.random(rng) for _ in range(positions))]
    own = {name: getattr(comparison, name) for name in ("floating", "frozen", "planar")}
    return comparison, comparison.errors(Pinocchio(urdf, text, **own), at)


def matrix_of(pose: Pose) -> Array:
    """4x4"""
    out = translation(pose.xyz)
    out[:3, :3] = np.reshape(pose.rot, (3, 3))
    return out


def lost_shapes(comparison: Comparison, tolerance: float = 1e-12) -> list[str]:
    """The visuals that the .mbs does not show where the URDF does, and shapes it has besides."""
    result, urdf = comparison.result, comparison.urdf
    left = {name: list(body.shapes) for name, body in comparison.mbs.bodies.items()}
    lost: list[str] = []
    pairs: set[tuple[str, str]] = set()
    for link, visuals in urdf.shapes.items():
        frame = result.frames[link]
        if visuals and frame.joint is not None:
            lost.append(f"{link} has no body to show its shapes on")
            continue
        at, there = matrix_of(frame.pose), left[frame.body or GROUND]
        for visual in visuals:
            match = [s for s in there if _same(s, visual, at @ visual.pose, tolerance)]
            if match:
                there.remove(match[0])
                if visual.mesh is not None:
                    pairs.add((visual.mesh, str(match[0].url).lower()))
            else:
                lost.append(f"{link}: {visual.kind} {visual.size}")
    lost += [f"{name}: {s.kind} {s.name} is of no link" for name in left for s in left[name]]
    # one file for each mesh, also where letter case does not count
    if not len(pairs) == len({mesh for mesh, _ in pairs}) == len({url for _, url in pairs}):
        lost.append(f"meshes are mixed up: {sorted(pairs)}")
    return lost


def _same(shape: Shape, visual: UrdfShape, at: Array, tolerance: float) -> bool:
    if (shape.kind, shape.size, shape.scale) != (visual.kind, visual.size, visual.scale):
        return False
    if visual.color is not None:
        *color, alpha = np.clip(visual.color, 0.0, 1.0)
        away = np.abs(np.array(shape.color) - 255 * np.array(color)).max()
        if not (away <= 0.5 and abs(shape.transparency - (1.0 - alpha)) <= 1e-12):
            return False
    ours, wanted = shape.pose[:3, :3], at[:3, :3]
    if shape.kind == "sphere":
        turned = 0.0
    elif shape.kind == "cylinder":  # .mbs's axis is y, URDF's z; which end is which is not seen
        turned = min(np.abs(ours[:, 1] - sign * wanted[:, 2]).max() for sign in (1.0, -1.0))
    else:
        turned = np.abs(ours - wanted).max()
    unit = max(1.0, float(np.abs(at[:3, 3]).max()))
    shifted = np.abs(shape.pose[:3, 3] - at[:3, 3]).max() / unit
    return bool(max(turned, shifted) <= tolerance)


#: Those of what C and the format have for themselves that the tests try.
KEYWORDS = {"base", "origin", "int", "double"}
IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def structure_faults(comparison: Comparison, *, faithful: bool = True) -> list[str]:
    """What the .mbs must hold besides its equations: names, anchors, quiet joints, gravity;
    the faithful one, every angle and mass of the URDF to its last digit too."""
    result, urdf, mbs = comparison.result, comparison.urdf, comparison.mbs
    faults: list[str] = []
    if tuple(mbs.gravity) != GRAVITY:
        faults.append(f"gravity is {mbs.gravity}")
    faults += [
        f"{name!r} is no identifier"
        for name in [*mbs.bodies, *mbs.joints, mbs.base_name]
        if not IDENTIFIER.fullmatch(name)
    ]
    for joint in mbs.joints.values():
        if joint.nature == "driven" and joint.symbols != ("q",):
            faults.append(f"{joint.name}: stands still, but {joint.symbols} are in the equations")
        if joint.nature != "driven" and joint.q != 0.0:
            faults.append(f"{joint.name}: starts at {joint.q}")
    for joint in urdf.joints.values():
        names = result.names.joints.get(joint.name, [])
        real = [name for name in names if mbs.joints[name].nature != "driven"]
        usable = IDENTIFIER.fullmatch(joint.name) and joint.name not in {*KEYWORDS, mbs.base_name}
        if len(real) == 1 and usable and joint.name not in mbs.moving:
            faults.append(f"{joint.name} is called {real[0]}")
        if not faithful:
            continue
        r, p, y = joint.rpy
        wanted = [turn for turn in (("R3", y), ("R2", p), ("R1", r)) if turn[1]]
        found = [(mbs.joints[name].type, mbs.joints[name].q) for name in names[: len(wanted)]]
        if names and found != wanted:
            faults.append(f"{joint.name} is turned by {found}, not {wanted}")
    for link in urdf.inertias:
        frame = result.frames[link]
        body = mbs.bodies[frame.body or GROUND]
        own = result.names.bodies.get(link)
        inertia = urdf.inertias[link]
        mass = inertia.mass if inertia else 0.0
        if faithful and own is None and not urdf.massless(link):
            faults.append(f"{link} has mass, but no body")
        elif faithful and own is not None and body.inertia.mass != mass:
            faults.append(f"{link} has another mass than body {own}, if by a rounding only")
        elif own is not None and (frame.body, frame.joint) != (own, None):
            faults.append(f"{link} is body {own}, but its frame is said to be in {frame.body}")
        elif own is None and frame.joint is None and (frame.body or link != urdf.root):
            at = [p for p in body.points.values() if tuple(p) == tuple(frame.pose.xyz)]
            if not at:
                faults.append(f"{link} is neither body nor anchor point")
    return faults
