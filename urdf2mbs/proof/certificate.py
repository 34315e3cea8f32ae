"""Replay a certificate of urdf2mbs: python certificate.py ROBOT.urdf MODEL.mbs MODEL.proof.json

Is the .mbs the robot of the URDF?  This file answers with Python's standard library alone, and
uses no code of urdf2mbs.  It reads three robots: that of the URDF, that of the numbers in the
certificate, and that of the .mbs.  At random positions each link must be at the same place in all
three, and each joint must move the same masses: then the equations of motion are the same.
Exit code: 0 the same, 3 not the same, 1 a file is unreadable.
The URDF of a xacro file: urdf2mbs convert ROBOT.xacro --dump DIR --stop-after expand
"""

import json
import sys
import xml.etree.ElementTree as ET
from hashlib import sha256
from math import cos, hypot, pi, sin, sqrt
from pathlib import Path
from random import Random

TOLERANCE = 1e-9
AXES, ZERO = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0)
MOMENTS = ("xx", "xy", "xz", "yy", "yz", "zz")
#: What the coordinates of a joint do: turn (R), or shift (T).
WAYS = {"revolute": "R", "continuous": "R", "prismatic": "T", "planar": "TTR", "floating": "TTTRRR"}


# --- frames: 4 x 4 matrices of a rotation, row by row, and an origin (m) ---


def frame(rotation=AXES, xyz=ZERO):
    return [[*row, x] for row, x in zip(rotation, xyz)] + [[0.0, 0.0, 0.0, 1.0]]


def product(first, *others):
    for other in others:
        columns = [*zip(*other)]
        first = [[sum(a * b for a, b in zip(row, column)) for column in columns] for row in first]
    return first


def inverse(at):
    rotation, xyz = [*zip(*at[:3])][:3], [row[3] for row in at[:3]]
    return frame(rotation, [-sum(a * b for a, b in zip(row, xyz)) for row in rotation])


def step(kind, axis, q):
    """A frame after a joint: a shift, or a turn about a unit axis by Rodrigues' formula."""
    if kind == "T":
        return frame(AXES, [q * c for c in axis])
    x, y, z = axis
    k, s, c = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)), sin(q), 1.0 - cos(q)
    return frame([[i + s * a + c * b for i, a, b in zip(*r)] for r in zip(AXES, k, product(k, k))])


def origin(xyzrpy):
    """The frame of an <origin>: x, y, z, roll, pitch, yaw."""
    x, y, z = (step("R", axis, angle) for axis, angle in zip(AXES, xyzrpy[3:]))
    return product(frame(AXES, xyzrpy), z, y, x)


def moments(mass, tensor, at):
    """The sum of m r r^T, r = (x, y, z, 1), of a mass (kg) whose centre and axes are the frame
    ``at``, and of its inertia about the centre (kg m^2).  Such sums of parts add up."""
    xx, xy, xz, yy, yz, zz = tensor
    a, b, c = (yy + zz - xx) / 2, (xx + zz - yy) / 2, (xx + yy - zz) / 2
    own = [[a, -xy, -xz, 0.0], [-xy, b, -yz, 0.0], [-xz, -yz, c, 0.0], [0.0, 0.0, 0.0, mass]]
    return product(at, own, [*zip(*at)])


# --- robots: dicts of parts, parents first: the part before, the way to it, and its moments, which
# may be None.  A way is a list of names, each with a frame, or with T or R and the axis of a joint


def poses(robot, position):
    """Where each part and each name of a way is, and the joint that moves it last."""
    at, mover = {"": frame()}, {"": ""}
    for part, (before, way, _) in robot.items():
        here, last = at[before], mover[before]
        for name, motion in (*way, (part, frame())):
            if len(motion) == 2:
                motion, last = step(*motion, position[name]), name
            at[name] = here = product(here, motion)
            mover[name] = last
    return at, mover


def carried(robot, at, mover, joint, back):
    """The moments of what a joint moves last, in the frame whose inverse is ``back``."""
    total = [[0.0] * 4] * 4
    for part, (_, _, own) in robot.items():
        if own and mover[part] == joint:
            there = product(back, at[part])
            seen = product(there, own, [*zip(*there)])
            total = [[a + b for a, b in zip(*rows)] for rows in zip(total, seen)]
    return total


def apart(one, two, by):
    """How far two matrices are apart: the sum of their elements' differences, over ``by``, the
    sizes of row and column.  NaN is never small."""
    return sum(abs(a - b) / (k * m) for x, y, k in zip(one, two, by) for a, b, m in zip(x, y, by))


def compare(one, two, places, joints, what, wrong):
    """Compare two robots at random positions; gives the largest deviation, relative.

    ``places``: a name in the first robot, a name in the second, and the frame seen from there.
    """
    chance, worst = Random(what), dict.fromkeys((name for name, *_ in places), 0.0)
    for reach in (0.0, pi, pi, pi):
        position = {name: chance.uniform(-reach, reach) for name in joints}
        (at, mover), (there, their_mover) = poses(one, position), poses(two, position)
        size = max((abs(row[3]) for pose in at.values() for row in pose[:3]), default=0.0) or 1.0
        for name, other, place in places:
            worst[name] += apart(at[name], product(there[other], place), (1.0, 1.0, 1.0, size))
    sides = (one, at, mover), (two, there, their_mover)
    for name in joints:
        ours, theirs = (carried(*side, name, inverse(at[name])) for side in sides)
        k = sqrt(max(abs(value) for row in ours[:3] for value in row[:3])) or 1.0
        worst[f"mass behind {name}"] = apart(ours, theirs, (k, k, k, sqrt(abs(ours[3][3])) or 1.0))
    wrong(f"{what}: {name} is {off:.1e} off" for name, off in worst.items() if not off <= TOLERANCE)
    return max(worst.values(), default=0.0)


def read(text: bytes) -> ET.Element:
    """Read an XML file.  Comments and blank lines may stand before the declaration, and no tag
    should get the default namespace of Drake's URDFs."""
    return ET.fromstring(text[max(0, text.find(b"<?xml")) :].replace(b"xmlns=", b"was="))


def change(urdf, changes, wrong):
    """What passes changed on purpose: elements must be as they were, and get new attributes."""
    for extra in urdf.iterfind("gazebo"):
        for joint in urdf.iterfind("joint"):
            joint.extend(extra if joint.get("name") == extra.get("reference") else ())
    for (tag, name, *path), before, after in changes:
        known = [part for part in urdf.iterfind(tag) if part.get("name") == name]
        part = known[0] if known else ET.SubElement(urdf, tag)
        for inner in path:
            part = ET.SubElement(part, inner) if part.find(inner) is None else part.find(inner)
        if [(part.text or "").strip(), part.attrib] != before:
            wrong([f"{tag} '{name}' {' '.join(path)} is not {before}, but {part.attrib}"])
        part.attrib.update(after)


def numbers(element, path, keys, unsaid="0 0 0"):
    """The numbers of some attributes; ``unsaid``: what the URDF means where it says nothing."""
    said = getattr(element.find(path), "attrib", {})
    return [float(x) for k in keys.split() for x in said.get(k, unsaid).replace(",", " ").split()]


def motions(joint, proof, wrong):
    """The coordinates of a URDF joint, each with T or R, and its axis."""
    name, kinds = joint.get("name"), WAYS.get(joint.get("type"), "")
    own = [group for group in proof["groups"] if group["joint"] == name]
    axis = numbers(joint, "axis", "xyz", "1 0 0") if own else AXES[0]
    # which two axes of its plane a planar joint has, the URDF leaves open
    axes = [*(group["axis"] for group in own[:-1]), [c / (hypot(*axis) or 1.0) for c in axis]]
    axes = [*AXES, *AXES] if len(own) == 6 else axes
    square = apart(product(axes[-3:], [*zip(*axes[-3:])]), AXES, (1.0, 1.0, 1.0)) < TOLERANCE
    if not square or (len(own) != len(kinds) and (own or f"'{name}': held" not in proof["said"])):
        wrong([f"the {len(own)} coordinates of joint '{name}' are not those of its type"])
    return [(f"joint '{g['coordinate']}'", motion) for g, *motion in zip(own, kinds, axes)]


def urdf_robot(urdf, proof, wrong):
    """The robot of the URDF: each link is a part."""
    joints = {joint.find("child").get("link"): joint for joint in urdf.iterfind("joint")}
    links = {joint.find("parent").get("link"): ET.Element("world") for joint in joints.values()}
    links |= {link.get("name"): link for link in urdf.iterfind("link")}
    robot, todo = {}, [(name, "", []) for name in links if name not in joints]
    for name, before, way in todo:
        mass = numbers(links[name], "inertial/mass", "value", "0")
        tensor = numbers(links[name], "inertial[mass]/inertia", "ixx ixy ixz iyy iyz izz", "0")
        centre = origin(numbers(links[name], "inertial[mass]/origin", "xyz rpy"))
        robot[f"link '{name}'"] = before, way, moments(*mass, tensor, centre)
        for child, joint in joints.items():
            if joint.find("parent").get("link") == name:
                way = [(None, origin(numbers(joint, "origin", "xyz rpy")))]
                todo.append((child, f"link '{name}'", way + motions(joint, proof, wrong)))
    return robot


def certified_robot(groups, urdf):
    """The robot of the certificate: each group is a part.  Links are where the URDF has them."""
    robot = {}
    for name, group in groups.items():
        way = (None, group["place"]), (name, ("TR"[group["turns"]], group["axis"]))
        own = moments(group["mass"], group["inertia"], frame(AXES, group["centre"]))
        robot[f"behind {name}"] = group["parent"] and f"joint '{group['parent']}'", way, own
    at, mover = poses(urdf, dict.fromkeys(groups, 0.0))
    for link in urdf:
        robot[link] = mover[link], [(None, product(inverse(at[mover[link]]), at[link]))], None
    return robot


def values(element, path, keys):
    return [float(element.findtext(path + key, "0")) for key in keys]


def mbs_robot(model, names):
    """The robot of the .mbs: each body is a part, and each point.

    ``names``: the URDF's joint of each joint of the .mbs that moves.
    """
    robot = {}
    for body in (model.find("base"), *model.iterfind("bodytree/body")):
        name, way = body.findtext("bodyname", "base"), []
        for joint in body.iterfind("joint"):
            own, (kind, axis) = joint.findtext("jointname"), joint.findtext("type")
            motion = kind, AXES[int(axis) - 1]
            if own not in names:
                motion = step(*motion, *values(joint, "initialvalue/", "q"))
            way.append((names.get(own, f"held {own}"), motion))
        tensor, centre = values(body, "inertia/I", MOMENTS), values(body, "com/coordinates/", "xyz")
        own = moments(*values(body, "", ["mass"]), tensor, frame(AXES, centre))
        before = f"point {body.findtext('parent/bodyname')} {body.findtext('parent/pointname')}"
        robot[f"body {name}"] = before if name != "base" else "", way, own
        robot[f"point {name} origin"] = f"body {name}", [], None
        for point in body.iterfind("point"):
            way = [(None, frame(AXES, values(point, "coordinates/", "xyz")))]
            robot[f"point {name} {point.findtext('pointname')}"] = f"body {name}", way, None
    return robot


def compare_joints(model, urdf, proof, names, wrong):
    """Compare natures, <symbols>, and the numbers of the URDF's joints."""
    joints = {f"joint '{joint.get('name')}'": joint for joint in urdf.iterfind("joint")}
    for joint in model.iterfind("bodytree/body/joint"):
        own, nature = names.get(joint.findtext("jointname")), joint.findtext("nature")
        symbols = joint.find("symbols")
        lost = set() if symbols is None else {"q", "qd", "qdd"} - {one.tag for one in symbols}
        moved = {value.tag for value in joint.iterfind("initialvalue/*") if float(value.text)}
        # what is held may have a position, if its symbols have it, and no speed
        fine = not lost if own else not (moved & {"q"} & lost or moved - {"q"} - lost)
        free = f"joint '{joint.findtext('jointname')}' of body " in proof["said"]
        free = free or joints.get(own, urdf).find("mimic") is not None
        if not fine or ((own is None) != (nature == "driven") and not free):
            wrong([f"{ET.tostring(joint, 'unicode')} does not move as it should"])
    for kind, (path, key, unsaid) in proof["numbers"].items():
        for one in model.iterfind(f"user_models/user_model[name='{kind}']/parameter"):
            own, text = names.get(one.findtext("name")), one.findtext("value")
            part = joints.get(own, urdf).find(path)
            should = unsaid if part is None else part.get(key, part.text or "0")
            if float(text) != float(should) and f"{own}: {kind} is {text}, " not in proof["said"]:
                wrong([f"{kind} of {own} is {text}, and in the URDF {should}"])


def rest_of(model: ET.Element) -> list[str]:
    """What the .mbs says beside masses and shapes: each thing as XML."""
    things = [thing for part in model if part.tag not in ("base", "bodytree") for thing in part]
    things += [thing for tag in ("gravity", "joint", "point") for thing in model.iter(tag)]
    return [" ".join(ET.tostring(thing, "unicode").split()) for thing in things]


def replay(*files):
    """Print what does not hold, and the verdict; gives the exit code."""
    data, wrong = [Path(file).read_bytes() for file in files], []
    urdf, model = map(read, data[:2])
    predicate = json.loads(data[2])["predicate"]
    # what the URDF does not say is right only where it is printed below
    proof = predicate["urdf2mbs"] | {"said": "\n".join(predicate["warnedTests"])}
    for file, text in zip(files, data[:2]):
        forms = text, ET.canonicalize(text[max(0, text.find(b"<?xml")) :]).encode()
        if not any(sha256(form).hexdigest().encode() in data[2] for form in forms):
            wrong.append(f"{file} is not the file that was certified")
    change(urdf, proof["changes"], wrong.extend)
    robot = urdf_robot(urdf, proof, wrong.extend)
    groups = {f"joint '{group['coordinate']}'": group for group in proof["groups"]}
    edited = {name: group | group.get("found", {}) for name, group in groups.items()}
    names = {group["mbs"]: name for name, group in groups.items()}
    same = [(name, name, frame()) for name in groups]
    compare(robot, certified_robot(groups, robot), same, groups, "the certificate", wrong.extend)
    places = [(f"link '{link}'", there, place) for link, there, place in proof["frames"]]
    ours, theirs = certified_robot(edited, robot), mbs_robot(model, names)
    off = compare(ours, theirs, places, groups, "the .mbs", wrong.extend)
    compare_joints(model, urdf, proof, names, wrong.extend)
    wrong += [f"not in both files: {x}" for x in sorted({*rest_of(model)} ^ {*proof["rest"]})]
    edits = [f"what moves with {name} (edited)" for name in groups if "found" in groups[name]]
    edits += [f"the frame of {x}" for x in sorted(robot.keys() - {link for link, *_ in places})]
    changed = dict.fromkeys(f"{tag} '{name}'" for (tag, name, *_), *_ in proof["changes"])
    edits += ["what was added or changed on purpose: " + ", ".join(changed)] * bool(changed)
    verdict = "NOT " * bool(wrong) + f"the same robot: {len(groups)} groups, to {off:.0e}"
    verdict += "".join(f", {kind}" for kind in proof["numbers"])
    print(*wrong, "\n  but for ".join([verdict, *edits, *predicate["warnedTests"]]), sep="\n")
    return 3 if wrong else 0


if __name__ == "__main__":
    try:
        sys.exit(replay(*sys.argv[1:]) if len(sys.argv) == 4 else __doc__)
    except Exception as error:  # a file is not what it should be
        sys.exit(f"{type(error).__name__}: {error}\n{__doc__}")
