"""Replay a certificate of urdf2mbs.

Usage: python certificate.py ROBOT.urdf MODEL.mbs MODEL.proof.json

Is the .mbs the robot of the URDF?  This file answers with Python's standard library alone, and
uses no code of urdf2mbs.  It reads both files itself.  The certificate says which joints of the
.mbs are which joint of the URDF, and what was changed on purpose, which is printed.
Exit code: 0 the same, 3 not the same, 1 a file is unreadable or has something unknown.
The URDF of a xacro file: urdf2mbs convert ROBOT.xacro --dump DIR --stop-after expand

Method.  All bodies that no moving joint separates are one group.  With all joints at zero, each
joint must rotate about the same line of the world as in the URDF, or shift along it, and come after
the same joint.  The group that it moves must have the same mass, centre of mass and inertia.  The
pose of a group at the positions q is a product of exponentials (Brockett, 1984)

    T(q) = exp(S_1 q_1) exp(S_2 q_2) ... exp(S_n q_n) T(0)

with S_k the screws of the joints before it.  So equal screws mean equal motion at all positions,
and with equal inertias the equations of motion are the same.
"""

from __future__ import annotations

import json
import re
import sys
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import reduce
from math import cos, hypot, sin, sqrt
from operator import mul
from pathlib import Path
from typing import Any, NamedTuple

#: A larger deviation is a difference; see ``compare_groups`` for the scales.
TOLERANCE = 1e-9

# The elements that are known: their attributes (@), and the elements that may be in them.  Of those
# with * there may be several.  Elements without an entry of their own move nothing.

URDF_ELEMENTS = """
robot: @name @version link* joint* material* gazebo* transmission* sensor* ros2_control* mujoco*
link: @name inertial visual* collision* contact*
inertial: origin mass inertia
mass: @value
inertia: @ixx @ixy @ixz @iyy @iyz @izz
joint: @name @type parent child origin axis limit dynamics mimic safety_controller calibration
parent: @link
child: @link
origin: @xyz @rpy
axis: @xyz
limit: @lower @upper @effort @velocity
dynamics: @damping @friction
mimic: @joint @multiplier @offset
"""

MBS_ELEMENTS = """
mbsDescR7: mbsname mbsyspad_version base bodytree cuts links user_constraints user_models \
user_variables x3D
base: gravity baseBodyName point* graphics
gravity: coordinates
bodytree: body*
body: bodyname parent joint* mass com inertia point* graphics
parent: bodyname pointname
joint: jointname type nature initialvalue actuated symbols graphics
initialvalue: q qd qdd
symbols: q qd qdd
com: coordinates
coordinates: x y z
inertia: Ixx Ixy Ixz Iyy Iyz Izz
point: pointname coordinates graphics sensor extforce
cuts: ball* rod* solid*
user_models: user_model*
user_model: name parameter*
parameter: name type value*
"""

#: The coordinates of each type of URDF joint: rotations (R) and shifts (T).
COORDINATE_TYPES = {
    "fixed": "",
    "revolute": "R",
    "continuous": "R",
    "prismatic": "T",
    "planar": "TTR",
    "floating": "TTTRRR",
}
#: The user models that have numbers of a URDF joint: an element of the joint, and its attribute.
PARAMETERS = {
    "damping": ("dynamics", "damping"),
    "friction": ("dynamics", "friction"),
    "effort": ("limit", "effort"),
    "velocity": ("limit", "velocity"),
    "q_min": ("limit", "lower"),
    "q_max": ("limit", "upper"),
}
SYMBOLS = ["q", "qd", "qdd"]
#: Natures that are printed, but are not a difference.  No cut and no rule of <mimic> is compared.
ACCEPTED_NATURES: dict[Any, list[Any]] = {
    "follower": ["independent", "dependent", "driven"],
    "independent": ["dependent"],
}
#: The value of a fact that only the .mbs has, and that is printed.
NOT_COMPARED = "not compared"
DECIMAL = re.compile(r"[+-]?([0-9]{1,50}\.?[0-9]{0,50}|\.[0-9]{1,50})([eE][+-]?[0-9]{1,2})?")

Vector = Sequence[float]
Matrix = Sequence[Sequence[float]]

ZERO = (0.0, 0.0, 0.0)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TENSOR_KEYS = ("xx", "xy", "xz", "yy", "yz", "zz")


class Body(NamedTuple):
    """A rigid body, in the world with all joints at zero."""

    mass: float
    """kg."""
    tensor: Vector
    """xx, xy, xz, yy, yz, zz, about the centre of mass, in the axes of ``frame`` (kg m^2)."""
    frame: Matrix
    """4 x 4; its origin is the centre of mass (m)."""


class Screw(NamedTuple):
    """A joint in the world, for a unit of its velocity: what it does to a body at the origin."""

    angular: Vector
    """The axis of a rotation, or zero."""
    linear: Vector
    """The velocity of the body's point at the origin of the world."""


class Group(NamedTuple):
    """The bodies that no moving joint separates; it has the name of its coordinate."""

    parent: str
    """The group to which it is attached; "" is the ground."""
    screw: Screw
    """Of its coordinate."""
    bodies: list[Body]


class Robot(NamedTuple):
    """A robot as one of the two files states it."""

    groups: dict[str, Group]
    """By the names of coordinates, which are joints of the .mbs; the ground is first."""
    facts: dict[tuple[str, str], Any]
    """All else that is compared, by its kind and its name."""


class PlacedFrame(NamedTuple):
    """A frame of a group, in the world with all joints at zero."""

    group: str
    frame: Matrix


def create_robot(gravity: Vector) -> Robot:
    """Create a robot that has the ground alone."""
    return Robot({"": Group("", Screw(ZERO, ZERO), [])}, {("gravity", "base"): tuple(gravity)})


def require(condition: bool, message: str) -> None:
    """Refuse a file that has something unknown.

    Raises:
        ValueError: The condition is false.
    """
    if not condition:
        raise ValueError(message)


# --- matrices, row by row ---


def multiply(*matrices: Matrix) -> Matrix:
    """Return the product of matrices."""
    return reduce(
        lambda a, b: [[sum(map(mul, row, column)) for column in zip(*b)] for row in a], matrices
    )


def make_frame(rotation: Matrix = AXES, origin: Vector = ZERO) -> Matrix:
    """Return the 4 x 4 matrix of a frame: a rotation matrix, and an origin (m)."""
    rows = [[*row, coordinate] for row, coordinate in zip(rotation, origin)]
    return [*rows, [0.0, 0.0, 0.0, 1.0]]


def compute_motion(kind: str, axis: Vector, q: float) -> Matrix:
    """Compute the frame after a joint: a shift (T) or a rotation (R).

    Rodrigues' formula: ``R = 1 + sin(q) K + (1 - cos(q)) K^2``, with ``K v = axis x v``.

    Args:
        kind: T or R.
        axis: Of length 1.
        q: Position of the joint (rad or m).
    """
    if kind == "T":
        return make_frame(origin=[q * component for component in axis])
    x, y, z = axis
    k_matrix = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))
    sine, versine = sin(q), 1.0 - cos(q)
    rotation = [
        [unit + sine * k + versine * k2 for unit, k, k2 in zip(*rows)]
        for rows in zip(AXES, k_matrix, multiply(k_matrix, k_matrix))
    ]
    return make_frame(rotation)


def compute_screw(kind: str, axis: Vector, frame: Matrix) -> Screw:
    """Compute the screw of a joint: for a rotation about e through p, ``(e, p x e)``.

    Args:
        kind: R for a rotation, T for a shift.
        axis: Of length 1, in the frame.
        frame: Where the joint is, in the world.
    """
    x, y, z = (sum(map(mul, row, axis)) for row in frame[:3])
    if kind == "T":
        return Screw(ZERO, (x, y, z))
    a, b, c = (row[3] for row in frame[:3])
    return Screw((x, y, z), (b * z - c * y, c * x - a * z, a * y - b * x))


def sum_pseudo_inertias(bodies: Sequence[Body], centre: Vector) -> Matrix:
    """Compute the pseudo-inertia of bodies: the integral of r r^T dm, with r = (x, y, z, 1).

    It has the second moments of the mass, its first moments, and the mass::

        | Sigma   m c |      Sigma = trace(I)/2 1 - I, for the tensor I at the same point
        | m c^T   m   |

    In another frame T it is ``T J T^T``.

    Args:
        bodies: The bodies.
        centre: The point to which r is relative, in the world (m).
    """
    total: Matrix = [[0.0] * 4] * 4
    to_centre = make_frame(AXES, [-coordinate for coordinate in centre])
    for mass, (xx, xy, xz, yy, yz, zz), body_frame in bodies:
        require(mass >= 0.0, f"a body has a mass of {mass} kg")
        half_trace = (xx + yy + zz) / 2
        pseudo_inertia = [
            [half_trace - xx, -xy, -xz, 0.0],
            [-xy, half_trace - yy, -yz, 0.0],
            [-xz, -yz, half_trace - zz, 0.0],
            [0.0, 0.0, 0.0, mass],
        ]
        frame = multiply(to_centre, body_frame)
        moved = multiply(frame, pseudo_inertia, [*zip(*frame)])
        total = [[a + b for a, b in zip(*rows)] for rows in zip(total, moved)]
    return total


def compute_deviation(a: Matrix, b: Matrix, scales: Vector = (1.0, 1.0, 1.0, 1.0)) -> float:
    """Compute the sum of the differences between the elements of two matrices.

    Each difference is divided by the scales of its row and of its column.  NaN is never small.
    """
    return sum(
        abs(element_a - element_b) / row_scale / column_scale
        for row_a, row_b, row_scale in zip(a, b, scales)
        for element_a, element_b, column_scale in zip(row_a, row_b, scales)
    )


# --- reading ---


class Builder(ET.TreeBuilder):
    """Accepts elements and comments, but no DOCTYPE, and no processing instruction."""

    def doctype(self, name: str, *_: object) -> None:
        """Refuse a DOCTYPE, which could declare entities."""
        raise ValueError(f"<!DOCTYPE or <? {name}: unknown")

    def pi(self, target: str, text: str | None = None) -> ET.Element:
        """Refuse a processing instruction."""
        raise ValueError(f"<!DOCTYPE or <? {target}: unknown")


def read(data: bytes, table: str, notes: list[str], changes: Sequence[Any] = ()) -> ET.Element:
    """Read an XML file; refuse elements that are unknown, or of which there are two.

    Args:
        data: The file.
        table: The known elements, as ``URDF_ELEMENTS``.
        notes: Unknown attributes, and changes, are added here.
        changes: The changes of the certificate.

    Returns:
        The root, after the changes.
    """
    entries = dict(line.split(":") for line in table.strip().splitlines())
    parser = ET.XMLParser(target=Builder())
    parser.feed(data.removeprefix(b"\xef\xbb\xbf").lstrip())
    root: ET.Element = parser.close()
    apply_changes(root, changes, notes)
    require(root.tag == next(iter(entries)), f"<{root.tag}> is unknown as the root")
    elements = [root]
    for element in elements:  # which grows
        check_element(element, entries[element.tag].split(), entries, notes)
        elements += [child for child in element if child.tag in entries]
    return root


def check_element(
    element: ET.Element, content: list[str], entries: Collection[str], notes: list[str]
) -> None:
    """Refuse an element with unknown or doubled children; note its unknown attributes.

    Args:
        element: The element.
        content: Its entry in the table of known elements.
        entries: All elements that have an entry.
        notes: Where to note.
    """
    name = (element.tag, get_name(element))
    for key, value in element.items():
        if f"@{key}" not in content:
            notes.append(f"{name}: unknown {key}={value!r}")
    unknown, children, doubled = [], set(), []
    for child in element:
        if child.tag not in content and f"{child.tag}*" not in content:
            unknown.append(child.tag)
        is_single = child.tag in content
        if is_single or child.tag in entries:
            key = f"<{child.tag}>" if is_single else f"<{child.tag}> {get_name(child)!r}"
            if key in children:
                doubled.append(key)
            children.add(key)
    require(not unknown + doubled, f"{name}: unknown {unknown}, doubled {doubled}")


def get_name(element: ET.Element) -> str | None:
    """Return the name of an element: its attribute ``name``, or the text of its first child."""
    return element.get("name", element.findtext("*"))


def read_numbers(
    element: ET.Element, path: str, attribute: str | None = None, default: str = "0"
) -> list[float]:
    """Read the decimal numbers of an attribute, or of the text of an element.

    Args:
        element: The element from which the path starts.
        path: The element that has the numbers.
        attribute: Its attribute; None: its text.
        default: The value if there is none.  It has as many numbers as are expected.
    """
    parts = element.findall(path)
    text = default
    if parts:
        text = parts[0].get(attribute, default) if attribute else parts[0].text or ""
    is_plain = text.isascii() and len(parts) <= 1 and not any(len(part) for part in parts)
    words = text.split()
    require(
        is_plain and len(words) == len(default.split()) and all(map(DECIMAL.fullmatch, words)),
        f"<{element.tag}> {get_name(element)!r}: {text!r} of <{path}> is not a finite decimal",
    )
    return [float(word) for word in words]


def read_vector(element: ET.Element, path: str, keys: Sequence[str] = "xyz") -> list[float]:
    """Read a number from each of the elements whose paths end with the keys."""
    return [read_numbers(element, path + key)[0] for key in keys]


def read_origin(element: ET.Element, path: str) -> Matrix:
    """Read an <origin> of URDF: the frame of x, y, z, roll, pitch, yaw."""
    angles = read_numbers(element, path, "rpy", "0 0 0")
    roll, pitch, yaw = (compute_motion("R", axis, angle) for axis, angle in zip(AXES, angles))
    xyz = read_numbers(element, path, "xyz", "0 0 0")
    return multiply(make_frame(AXES, xyz), yaw, pitch, roll)


def apply_changes(root: ET.Element, changes: Sequence[Any], notes: list[str]) -> None:
    """Change a URDF as passes did on purpose, and note each change.

    Args:
        root: The URDF's root.
        changes: Of each change: the tag and the name of a link or joint, and the XML of the new
            element in it.  A new link or joint is an element of ``["robot", null]``.
        notes: The changes are added here.
    """
    owners = {(element.tag, element.get("name")): element for element in root}
    owners["robot", None] = root
    for (tag, name), text in changes:
        owner, new = owners[tag, name], ET.fromstring(text)
        replaced = [] if owner is root else owner.findall(new.tag)
        before = "".join(ET.canonicalize(ET.tostring(old), strip_text=True) for old in replaced)
        notes.append(f"<{tag}> {name!r} has {text!r} on purpose, and {before!r} in the URDF")
        owner[:] = [*(child for child in owner if child not in replaced), new]


# --- the URDF ---


def build_urdf_robot(urdf: ET.Element, certificate: Mapping[str, Any], notes: list[str]) -> Robot:
    """Build the groups and facts of a URDF; note its joints that are constant."""
    robot = create_robot((0.0, 0.0, -9.81))
    links: dict[str | None, ET.Element] = {}
    if urdf.find("joint/parent[@link='world']") is not None:
        links["world"] = ET.Element("link")  # which need not be declared
    links |= {link.get("name"): link for link in urdf.iterfind("link")}
    joints = urdf.findall("joint[parent][child]")
    child_links = {get_link(joint, "child") for joint in joints}
    # Otherwise the walk from the roots might not end.
    require(len(child_links) == len(joints), "a link is the child of two joints")
    joints_of_link: dict[str | None, list[ET.Element]] = {}
    for joint in joints:
        joints_of_link.setdefault(get_link(joint, "parent"), []).append(joint)
    roots = [name for name in links if name not in child_links]
    placed_links = [(name, PlacedFrame("", make_frame())) for name in roots]
    for name, placed in placed_links:  # which grows
        add_link(robot, links.get(name, ET.Element("link")), placed)
        for joint in joints_of_link.get(name, []):
            child_frame = add_urdf_joint(robot, joint, placed, certificate, notes)
            placed_links.append((get_link(joint, "child"), child_frame))
    is_tree = len(placed_links) == len(links) == len(child_links) + 1
    require(is_tree and len(urdf.findall("joint")) + 1 == len(links), "the links are not a tree")
    return robot


def get_link(joint: ET.Element, end: str) -> str | None:
    """Return the link at an end of a joint, ``parent`` or ``child``."""
    element = joint.find(end)
    return None if element is None else element.get("link")


def add_link(robot: Robot, link: ET.Element, placed: PlacedFrame) -> None:
    """Add the body of a link to its group."""
    body = Body(
        mass=read_numbers(link, "inertial/mass", "value")[0],
        tensor=[read_numbers(link, "inertial/inertia", f"i{key}")[0] for key in TENSOR_KEYS],
        frame=multiply(placed.frame, read_origin(link, "inertial/origin")),
    )
    robot.groups[placed.group].bodies.append(body)


def add_urdf_joint(
    robot: Robot,
    joint: ET.Element,
    placed: PlacedFrame,
    certificate: Mapping[str, Any],
    notes: list[str],
) -> PlacedFrame:
    """Add the groups that a joint of a URDF moves, and its facts.

    Args:
        robot: The robot.
        joint: The joint.
        placed: The frame of its parent link.
        certificate: The certificate.
        notes: Where to note a joint that is constant.

    Returns:
        The frame of its child link.
    """
    placed = placed._replace(frame=multiply(placed.frame, read_origin(joint, "origin")))
    for coordinate, kind, axis in list_coordinates(joint, certificate, notes):
        require(coordinate not in robot.groups, f"the certificate has joint {coordinate!r} twice")
        screw = compute_screw(kind, axis, placed.frame)
        robot.groups[coordinate] = Group(placed.group, screw, [])
        placed = placed._replace(group=coordinate)
        is_follower = joint.find("mimic") is not None
        robot.facts["nature", coordinate] = "follower" if is_follower else "independent"
        robot.facts["motion", coordinate] = describe_constant_follower(joint)
        for model, (element, attribute) in PARAMETERS.items():
            robot.facts[model, coordinate] = read_numbers(joint, element, attribute)[0]
    return placed


def list_coordinates(
    joint: ET.Element, certificate: Mapping[str, Any], notes: list[str]
) -> Iterator[tuple[str, str, Vector]]:
    """List the coordinates of a URDF joint.

    Args:
        joint: The joint.
        certificate: The certificate; it has the names, and the directions of planar joints.
        notes: The joint is added here if it is constant.

    Returns:
        Of each coordinate: its joint in the .mbs, T or R, and the axis, of length 1.
    """
    name, joint_type = joint.get("name"), joint.get("type", "")
    names = certificate["joints"].get(name, ())
    axis = read_numbers(joint, "axis", "xyz", "1 0 0")
    length = hypot(*axis) or 1.0
    axis = [component / length for component in axis]
    # A URDF leaves open in which two directions of its plane a planar joint shifts.
    axes = [*certificate["planes"].get(name, ()), axis]
    if joint_type == "floating":
        axes = [*AXES, *AXES]
    last_three = axes[-3:]
    are_orthonormal = len(axes) == 1 or (
        compute_deviation(multiply(last_three, [*zip(*last_three)]), AXES) < TOLERANCE
    )
    is_possible = joint_type in COORDINATE_TYPES and (
        not names or len(names) == len(COORDINATE_TYPES[joint_type]) == len(axes)
    )
    require(
        is_possible and (not names or are_orthonormal),
        f"joint {name!r} of type {joint_type!r} cannot be {names} along {axes}",
    )
    if COORDINATE_TYPES[joint_type] and not names:
        notes.append(f"joint {name!r} is held at zero: {certificate['held'].get(name)!r}")
    return zip(names, COORDINATE_TYPES[joint_type], axes)


def describe_constant_follower(joint: ET.Element) -> str | None:
    """Return the motion of a follower whose multiplier is zero, as of an .mbs; None of others."""
    if read_numbers(joint, "mimic", "multiplier", "1") != [0.0]:
        return None
    position = read_numbers(joint, "mimic", "offset")[0] + 0.0  # makes 0 of -0
    return describe_motion("driven", [position, 0.0, 0.0], ["q"])


def describe_motion(nature: str, values: Vector, symbols: Sequence[str]) -> str:
    """Return the nature of a joint, its q, qd and qdd at the start, and its symbols, as a text."""
    return f"{nature}, {values} with {symbols}"


# --- the .mbs ---

#: Frames by the names of a body and of its point.
Frames = dict[tuple[str | None, str | None], PlacedFrame]


def build_mbs_robot(model: ET.Element, coordinates: Collection[str]) -> Robot:
    """Build the groups and facts of an .mbs.

    Args:
        model: The root of the file.
        coordinates: The joints that are the URDF's.  All others must be constant.
    """
    robot = create_robot(read_vector(model, "base/gravity/coordinates/"))
    frames: Frames = {(None, None): PlacedFrame("", make_frame())}
    for body in (*model.iterfind("base"), *model.iterfind("bodytree/body")):
        add_body(robot, frames, body, coordinates)
    for user_model in model.iterfind("user_models/user_model"):
        kind = user_model.findtext("name", "")
        for parameter in user_model.iterfind("parameter") if kind in PARAMETERS else ():
            joint = parameter.findtext("name", "")
            robot.facts[kind, joint] = read_numbers(parameter, "value")[0]
    lower, upper = ({name for kind, name in robot.facts if kind == k} for k in ("q_min", "q_max"))
    require(lower == upper, f"limits at one end alone: {lower ^ upper}")
    for cut in model.iterfind("cuts/*"):
        robot.facts[cut.tag, " ".join(cut.itertext())] = NOT_COMPARED
    return robot


def add_body(robot: Robot, frames: Frames, body: ET.Element, coordinates: Collection[str]) -> None:
    """Add a body of an .mbs, or the base, to its group; add its frame and those of its points."""
    name = body.findtext("bodyname", "base")
    parent = body.findtext("parent/bodyname"), body.findtext("parent/pointname")
    is_possible = parent in frames and (name, "origin") not in frames
    require(is_possible, f"body {name!r}: its parent {parent} is unknown, or it is doubled")
    placed = frames[parent]
    for joint in body.iterfind("joint"):
        placed = add_mbs_joint(robot, joint, placed, coordinates)
    frames[name, "origin"] = placed
    for point in body.iterfind("point"):
        xyz, key = read_vector(point, "coordinates/"), (name, point.findtext("pointname"))
        require(key not in frames or not any(xyz), f"point {key} is doubled, at another position")
        frames[key] = placed._replace(frame=multiply(placed.frame, make_frame(AXES, xyz)))
    centre = make_frame(AXES, read_vector(body, "com/coordinates/"))
    tensor = read_vector(body, "inertia/I", TENSOR_KEYS)
    mass = read_numbers(body, "mass")[0]
    robot.groups[placed.group].bodies.append(Body(mass, tensor, multiply(placed.frame, centre)))


def add_mbs_joint(
    robot: Robot, joint: ET.Element, placed: PlacedFrame, coordinates: Collection[str]
) -> PlacedFrame:
    """Add the group that a joint of an .mbs moves, and its facts; return the frame after it."""
    name, joint_type = joint.findtext("jointname", ""), joint.findtext("type", "")
    is_possible = name not in robot.groups and re.fullmatch("[TR][123]", joint_type) is not None
    require(is_possible, f"joint {name!r} of type {joint_type!r}: expected a new name, T1 to R3")
    kind, axis = joint_type[0], AXES[int(joint_type[1]) - 1]
    nature = joint.findtext("nature", "unknown")
    q, *velocities = read_vector(joint, "initialvalue/", SYMBOLS)
    symbols = joint.find("symbols")
    kept_symbols = SYMBOLS if symbols is None else [symbol.tag for symbol in symbols]
    if name in coordinates:
        robot.groups[name] = Group(placed.group, compute_screw(kind, axis, placed.frame), [])
        robot.facts["nature", name] = nature
        is_expected = len(kept_symbols) == len(SYMBOLS)
        placed = placed._replace(group=name)
    else:  # A constant joint may have a position, if the equations have it, too.
        is_constant = nature == "driven" and not any(velocities)
        is_expected = is_constant and (not q or "q" in kept_symbols)
        placed = placed._replace(frame=multiply(placed.frame, compute_motion(kind, axis, q)))
    if not is_expected:
        motion = describe_motion(nature, [q, *velocities], kept_symbols)
        robot.facts["motion", name] = motion
    return placed


# --- the comparison ---


def compare_groups(urdf: Robot, mbs: Robot) -> dict[str, str]:
    """Compare how each group moves, and its inertia; return the differences by their names.

    Lengths are relative to the distance of the joint from the origin, but at least to 1 mm and at
    most to 1 m.  The pseudo-inertia is relative to its largest second moment, but at least to that
    of the mass at 1 mm.
    """
    differences: dict[str, str] = {}
    for name, group in [*urdf.groups.items()][1:]:
        mbs_group = mbs.groups[name]
        angular = compute_deviation([group.screw.angular], [mbs_group.screw.angular])
        linear = compute_deviation([group.screw.linear], [mbs_group.screw.linear])
        scale = min(max(hypot(*group.screw.linear), 1e-3), 1.0)
        deviations = {
            f"motion of {name!r}": angular + linear / scale + (group.parent != mbs_group.parent),
            f"mass or inertia of {name!r}": compare_bodies(group.bodies, mbs_group.bodies),
        }
        for name_of_deviation, deviation in deviations.items():
            if not deviation <= TOLERANCE:
                differences[name_of_deviation] = f"{deviation:.1e} off"
    return differences


def compare_bodies(urdf: Sequence[Body], mbs: Sequence[Body]) -> float:
    """Compute the deviation of the pseudo-inertias of two groups, about the URDF's centre."""
    mass = sum(body.mass for body in urdf)
    centre = [sum(body.mass * body.frame[k][3] for body in urdf) / (mass or 1.0) for k in range(3)]
    sums = sum_pseudo_inertias(urdf, centre), sum_pseudo_inertias(mbs, centre)
    largest_moment = max(abs(element) for total in sums for row in total[:3] for element in row[:3])
    moment_scale = sqrt(max(largest_moment, mass * 1e-6)) or 1.0
    mass_scale = sqrt(max(total[3][3] for total in sums)) or 1.0
    scales = (moment_scale, moment_scale, moment_scale, mass_scale)
    return compute_deviation(*sums, scales)


def compare_facts(
    urdf: Robot, mbs: Robot, gravity: tuple[float, ...], notes: list[str]
) -> dict[str, str]:
    """Compare gravity, natures, symbols and numbers; return the differences by their names.

    A number of zero is the same as none.

    Args:
        urdf: The robot of the URDF.
        mbs: The robot of the .mbs.
        gravity: As the config wanted it (m/s^2).
        notes: Differences that are accepted are added here.
    """
    differences: dict[str, str] = {}
    for kind, name in urdf.facts | mbs.facts:
        expected = urdf.facts.get((kind, name)) or None
        value = mbs.facts.get((kind, name)) or None
        if value == expected:
            continue
        words = f"{value!r}, and {expected!r} in the URDF"
        accepted = ACCEPTED_NATURES.get(expected, [gravity, NOT_COMPARED])
        if value is None or value in accepted:
            notes.append(f"{kind} of {name!r}: {words}")
        else:
            differences[f"{kind} of {name!r}"] = words
    return differences


def replay(urdf: bytes, mbs: bytes, certificate: bytes) -> tuple[dict[str, str], list[str]]:
    """Compare a URDF with an .mbs.

    Args:
        urdf: The file.
        mbs: The file.
        certificate: The file.

    Returns:
        The differences by their names, and notes of accepted deviations.

    Raises:
        ValueError: A file has something unknown.
    """
    notes: list[str] = []
    content = json.loads(certificate)
    urdf_root = read(urdf, URDF_ELEMENTS, notes, content["changes"])
    urdf_robot = build_urdf_robot(urdf_root, content, notes)
    mbs_robot = build_mbs_robot(read(mbs, MBS_ELEMENTS, notes), urdf_robot.groups)
    missing = sorted(urdf_robot.groups.keys() - mbs_robot.groups.keys())
    require(not missing, f"not in the .mbs: {missing}")
    differences = compare_groups(urdf_robot, mbs_robot)
    differences |= compare_facts(urdf_robot, mbs_robot, tuple(content["gravity"]), notes)
    edited = [name for name in differences if name in content["edited"]]
    notes += [f"{name}: {differences.pop(name)}, as edited" for name in edited]
    return differences, notes


def main(files: list[str]) -> int:
    """Print the verdict, and return the exit code."""
    try:
        differences, notes = replay(*(Path(file).read_bytes() for file in files))
    except Exception as error:  # whatever is wrong with a file
        print(f"{type(error).__name__}: {str(error)!r}", file=sys.stderr)
        return 1
    verdict = "the same robot" + (", but for:" if notes else "")
    if differences:
        verdict = "NOT the same robot"
    lines = [f"{name}: {difference}" for name, difference in differences.items()]
    print(verdict, *lines, *notes, sep="\n  ")
    return 3 if differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) if len(sys.argv) == 4 else __doc__)
