"""Is this file the same robot as that one: what ``urdf2mbs verify`` says of a pair of files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec

from urdf2mbs.config import Config, Lines, typed
from urdf2mbs.conversion import LinkFrame, Settings
from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.mbs.reader import read, validate
from urdf2mbs.pipeline import Pipeline
from urdf2mbs.spatial import Pose, Vec
from urdf2mbs.urdf.model import Joint as UrdfJoint
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.xacro import expand
from urdf2mbs.verify import SIX, TOLERANCE, Difference, carriers, compare


class Verdict(msgspec.Struct):
    """What was compared and what differs."""

    robot: str
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    floating_base: tuple[str, ...]
    """The six .mbs joints of a base that the URDF does not have itself."""
    joints: dict[str, tuple[str, ...]]
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    moving: int
    """How many moving joints the URDF has."""
    urdf_mass: float
    """kg, of all that can move."""
    mbs_mass: float
    """kg, of all that can move."""
    groups: int
    positions: int
    largest: dict[str, float]
    """The largest relative deviation of each kind."""
    differences: list[Difference]
    """Where the two are not the same robot, the largest first."""
    frames: list[Difference]
    """Frames that are elsewhere in the .mbs: by itself a matter of convention."""
    not_compared: dict[str, str]
    """What only one of the two has or can have, and why it does not count."""
    schema: list[str]
    """Where the file departs from the format."""

    @property
    def same(self) -> bool:
        return not self.differences


class Match(msgspec.Struct):
    """Which .mbs joints and frames are a URDF's, by their names."""

    joints: dict[str, tuple[str, ...]] = {}
    frames: dict[str, LinkFrame] = {}
    frozen: dict[str, str] = {}
    orders: dict[str, tuple[str, ...]] = {}
    """In which order floating joints have their coordinates."""


def verify(
    source: str,
    model: Path,
    *,
    packages: Mapping[str, str] | None = None,
    xacro_args: Mapping[str, str] | None = None,
    engine: str = "own",
    gravity: Vec = (0.0, 0.0, -9.81),
    tolerance: float = TOLERANCE,
) -> Verdict:
    """Compare a URDF or xacro file with an .mbs, which may have been edited by hand.

    Whether the base floats is read off the .mbs; joints are matched by name; ``gravity`` (m/s^2)
    is what the .mbs should have, since a URDF has none.  ``engine`` is ``own`` or ``pinocchio``,
    which compares the equations of motion too.  Raises ConversionError.
    """
    try:
        data = model.read_bytes()
    except OSError as error:
        raise ConfigError("file-unreadable", f"cannot read '{model}': {error.strerror}") from None
    mbs = read(data, str(model))
    base = "floating" if floating_joints(mbs) else "fixed"
    given = {
        "source": source,
        "output": f"{source}.mbs",  # never written
        "base": base,
        "packages": dict(packages or {}),
        "xacro_args": dict(xacro_args or {}),
        "pipeline": ["expand", "insert-base"],
    }
    lines = Lines()
    conversion = Pipeline(typed(Config, given, lines), lines, installed_plugins=False).run()
    robot = conversion.robot
    found = match(robot, mbs)
    comparison = compare(
        robot, mbs, found.joints,
        frames=found.frames, frozen=found.frozen, orders=found.orders,
        gravity=gravity, tolerance=tolerance,
    )  # fmt: skip
    inserted = next(iter(robot.joints)) if conversion.floating else ""
    floating_base = found.joints.get(inserted, ())
    differences, largest = comparison.differences, comparison.largest
    if engine == "pinocchio":
        from urdf2mbs.dynamics import compare_dynamics

        more, deviations = compare_dynamics(
            _text(conversion.settings), mbs, found.joints,
            orders=found.orders, floating_base=floating_base,
            gravity=gravity, tolerance=tolerance,
        )  # fmt: skip
        differences = sorted(differences + more, key=lambda difference: -difference.size)
        largest = {**largest, **deviations}
    moving = [joint.name for joint in robot.joints.values() if joint.moves]
    return Verdict(
        robot.name,
        base,
        floating_base,
        {name: names for name, names in found.joints.items() if name != inserted},
        sum(name not in (inserted, *found.frozen) for name in moving),
        comparison.urdf_mass,
        comparison.mbs_mass,
        comparison.groups,
        comparison.positions,
        largest,
        differences,
        comparison.frames,
        _not_compared(mbs, found.frozen),
        [str(problem) for problem in validate(data, str(model))],
    )


def _not_compared(mbs: Mbs, frozen: Mapping[str, str]) -> dict[str, str]:
    why = "a URDF has nothing of the kind"
    return {
        **{f"joint '{name}'": reason for name, reason in frozen.items()},
        **{f"cut '{cut.name}' ({cut.kind})": why for cut in mbs.cuts},
        **{f"link '{link.name}' ({link.kind})": why for link in mbs.links},
        **{f"user constraint '{found.name}'": why for found in mbs.user_constraints},
    }


def _text(settings: Settings) -> bytes:
    if settings.source.suffix.lower() != ".xacro":
        return settings.source.read_bytes()
    return expand(
        settings.source, Packages(settings.packages, settings.source), settings.xacro_args
    ).text


# --- which is which ---------------------------------------------------------------------------


def match(robot: Robot, mbs: Mbs) -> Match:
    """Match by name a URDF with an .mbs that may have been drawn or edited by hand.

    A joint's name counts as it is, or as the identifier that a conversion makes of it.  The
    floating base's six joints are known by their types.  A moving link's frame should be that
    of the body that its joint leads to; a fixed link's that of the body of its name.
    """
    owners = {joint.name: (body, joint) for body in mbs.bodies for joint in body.joints}
    free = floating_joints(mbs)
    found = Match()
    taken: set[str] = set()
    useful = carriers(robot)
    for exact in (True, False):  # a name that is right as it is goes first
        for joint in robot.joints.values():
            if joint.moves and joint.name not in found.joints:
                names = _named(joint, owners, taken, exact)
                if names:
                    found.joints[joint.name] = names
                    taken.update(names)
    for joint in robot.joints.values():
        if not joint.moves or joint.name in found.joints:
            continue
        if joint.type == "floating" and free and taken.isdisjoint(free):
            found.joints[joint.name] = free
            found.orders[joint.name] = tuple(owners[name][1].type for name in free)
            taken.update(free)
        elif joint.child not in useful:
            found.frozen[joint.name] = "nothing that it moves has mass"
    found.joints = {name: found.joints[name] for name in robot.joints if name in found.joints}
    _match_frames(robot, mbs, found)
    return found


def floating_joints(mbs: Mbs) -> tuple[str, ...]:
    """The six joints of a floating base, in the order of the file; none if it is fixed."""
    for body in mbs.bodies:
        first = [joint for joint in body.joints if joint.nature != "driven"][:6]
        if body.parent is None and {joint.type for joint in first} == set(SIX):
            return tuple(joint.name for joint in first)
    return ()


def _named(
    joint: UrdfJoint, owners: Mapping[str, tuple[Body, Joint]], taken: set[str], exact: bool
) -> tuple[str, ...]:
    """The .mbs joints of a URDF joint's name that have its coordinates: those that move in the
    right way, else those of the name."""
    of_name: list[tuple[str, ...]] = []
    for name in [joint.name] if exact else _spellings(joint.name, "joint"):
        if joint.type == "floating":
            candidates = [tuple(f"{name}_{kind}" for kind in SIX)]
        elif joint.type == "planar":
            candidates = [
                (f"{name}_T{k % 3 + 1}", f"{name}_T{(k + 1) % 3 + 1}", f"{name}_R{k}")
                for k in (1, 2, 3)
            ]
        else:
            candidates = [(name,)]
        of_name += [c for c in candidates if all(n in owners and n not in taken for n in c)]
    kinds = {"floating": "TTTRRR", "planar": "TTR", "prismatic": "T"}.get(joint.type, "R")
    for names in of_name:
        joints = [owners[name][1] for name in names]
        if all(j.nature != "driven" and j.type[0] == k for j, k in zip(joints, kinds, strict=True)):
            return names
    return of_name[0] if of_name and not exact else ()


def _spellings(name: str, kind: str) -> list[str]:
    """What a conversion may have made of a name."""
    plain = identifiers([name])[0]
    more = f"{plain}_{kind}"
    return [name, plain, more, *(f"{more}_{number}" for number in range(2, 6))]


def _match_frames(robot: Robot, mbs: Mbs, found: Match) -> None:
    owners = {joint.name: body for body in mbs.bodies for joint in body.joints}
    bodies = {body.name: body for body in mbs.bodies}
    fixed = {
        name
        for joint in robot.joints.values()
        if not joint.moves
        for name in _spellings(joint.name, "joint")
    }
    for joint in robot.joints.values():
        names = found.joints.get(joint.name)
        if names is not None:
            body = owners[names[-1]]
            after = _last_of(body, names[-1], fixed)
            found.frames[joint.child] = LinkFrame(body.name, after, Pose())
        elif not joint.moves:
            for name in _spellings(joint.child, "body"):
                if name in bodies:
                    found.frames[joint.child] = LinkFrame(name, None, Pose())
                    break


def _last_of(body: Body, name: str, fixed: set[str]) -> str | None:
    """The last joint of a body that comes with a moving one: what is driven after it, up to the
    next URDF joint's; None if that is the body's last."""
    own = [joint.name for joint in body.joints]
    end = own.index(name)
    for joint in body.joints[end + 1 :]:
        if joint.nature != "driven" or joint.name in fixed or "_origin_R" in joint.name:
            return own[end]
        end += 1
    return None
