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
from collections import Counter
from hashlib import sha256
from math import cos, pi, sin, sqrt
from pathlib import Path
from random import Random

TOLERANCE = 1e-9
AXES, ZERO = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0)
MOMENTS = ("xx", "xy", "xz", "yy", "yz", "zz")
SYMBOLS, WORDS = ("q", "qd", "qdd"), ("link", "type", "parent", "child", "mimic")
#: What the coordinates of a joint do: turn (R), or shift (T).
COORDINATES = {
    "revolute": "R", "continuous": "R", "prismatic": "T", "planar": "TTR", "floating": "TTTRRR",
    "fixed": "",
}  # fmt: skip
LIMIT, SAFETY, CALIBRATION = "limit", "safety_controller", "calibration"
#: User models that hold numbers of the URDF's joints: the element, and its attribute.
NUMBERS = {
    "damping": ("dynamics", "damping"), "friction": ("dynamics", "friction"),
    "effort": (LIMIT, "effort"), "velocity": (LIMIT, "velocity"),
    "q_min": (LIMIT, "lower"), "q_max": (LIMIT, "upper"),
    "k_velocity": (SAFETY, "k_velocity"), "k_position": (SAFETY, "k_position"),
    "soft_q_min": (SAFETY, "soft_lower_limit"), "soft_q_max": (SAFETY, "soft_upper_limit"),
    "calibration_rising": (CALIBRATION, "rising"), "calibration_falling": (CALIBRATION, "falling"),
}  # fmt: skip
SPRINGS = {
    "spring_stiffness": ("springStiffness", "value"),
    "spring_reference": ("springReference", "value"),
}  # fmt: skip
#: What is read of the URDF: kinds of values, each with its element and attributes.
KINDS = {
    "link": {
        "link": (".", "name"), "mass": ("inertial/mass", "value"),
        "centre": ("inertial[mass]/origin", "xyz", "rpy"),
        "inertia": ("inertial[mass]/inertia", "ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    },
    "joint": {
        "type": (".", "type"), "parent": ("parent", "link"), "child": ("child", "link"),
        "origin": ("origin", "xyz", "rpy"), "axis": ("axis", "xyz"), "mimic": ("mimic", "joint"),
        **NUMBERS,
    },
    "gazebo": SPRINGS,
}  # fmt: skip
#: What the URDF means where it says nothing.
UNSAID = {
    "mass": [0.0], "centre": [0.0] * 6, "inertia": [0.0] * 6,
    "origin": [0.0] * 6, "axis": [1.0, 0.0, 0.0],
    "spring_reference": [0.0],
}  # fmt: skip


# --- frames: 4 x 4 matrices of a rotation, row by row, and an origin (m) ---


def frame(rotation=AXES, xyz=ZERO):
    return [[*row, x] for row, x in zip(rotation, xyz)] + [[0.0, 0.0, 0.0, 1.0]]


def unpacked(numbers):
    return frame([numbers[k : k + 3] for k in (0, 3, 6)], numbers[9:])


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
    terms = zip(AXES, k, product(k, k))
    return frame([[i + s * a + c * b for i, a, b in zip(*rows)] for rows in terms])


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
    """Where each part and each name of a way is, and the coordinate that moves it last."""
    at, mover = {"": frame()}, {"": ""}
    for part, (before, way, _) in robot.items():
        here, last = at[before], mover[before]
        for name, motion in (*way, (part, frame())):
            if len(motion) == 2:
                motion, last = step(*motion, position[name]), name
            at[name] = here = product(here, motion)
            mover[name] = last
    return at, mover


def carried(robot, at, mover, coordinate, back):
    """The moments of what a coordinate moves last, in the frame whose inverse is ``back``."""
    total = [[0.0] * 4] * 4
    for part, (_, _, own) in robot.items():
        if own and mover[part] == coordinate:
            there = product(back, at[part])
            seen = product(there, own, [*zip(*there)])
            total = [[a + b for a, b in zip(*rows)] for rows in zip(total, seen)]
    return total


def apart(one, two, sizes):
    """How far two matrices are apart: the sum of their elements' differences, over the sizes of
    row and column.  NaN is never small."""
    rows = zip(one, two, sizes)
    return sum(abs(a - b) / (k * m) for x, y, k in rows for a, b, m in zip(x, y, sizes))


def compare(one, two, places, coordinates, what, wrong):
    """Compare two robots at random positions; gives the largest deviation, relative.

    ``places``: for each thing of the first robot, that of the second one, and the frame in it.
    """
    chance, worst = Random(what), Counter()
    for reach in (0.0, pi, pi, pi):
        position = {name: chance.uniform(-reach, reach) for name in coordinates}
        (at, mover), (there, their_mover) = poses(one, position), poses(two, position)
        size = max((abs(row[3]) for pose in at.values() for row in pose[:3]), default=0.0) or 1.0
        for name, (other, place) in places.items():
            off = apart(at[name], product(there[other], place), (1.0, 1.0, 1.0, size))
            worst[name] += off + (mover[name] != their_mover[other])
    for name in coordinates:
        back = inverse(at[name])
        ours = carried(one, at, mover, name, back)
        theirs = carried(two, there, their_mover, name, back)
        size = sqrt(max(abs(value) for row in ours[:3] for value in row[:3])) or 1.0
        mass = sqrt(abs(ours[3][3])) or 1.0
        worst["mass behind", name] = apart(ours, theirs, (size, size, size, mass))
    for thing, off in worst.items():
        if not off <= TOLERANCE:
            wrong(f"{what}: {thing} is {off:.1e} off")
    return max(worst.values(), default=0.0)


def urdf_values(robot: ET.Element) -> dict[tuple[str, str], list]:
    """What the URDF says of links and joints, by kind and name, as lists of numbers or words."""
    values = {}
    elements = [(e, kinds) for tag, kinds in KINDS.items() for e in robot.iterfind(tag)]
    for element, kinds in elements:
        for kind, (path, *keys) in kinds.items():
            part, at = element.find(path), (kind, element.get("name") or element.get("reference"))
            if part is None:
                values.setdefault(at, UNSAID.get(kind))
            elif kind in WORDS:
                values[at] = [part.get(keys[0])]
            else:
                zeros = "0 0 0" if kind in ("centre", "origin", "axis") else "0"
                text = (part.text or "").strip() or zeros
                values[at] = [float(n) for key in keys for n in part.get(key, text).split()]
    return values


def change(values, changes, wrong):
    """What passes changed on purpose: each value must be as it was, and then is as it became."""
    for kind, name, before, after in changes:
        if values.get((kind, name)) != before:
            wrong(f"{kind} of '{name}' is {values.get((kind, name))}, and was {before}")
        values[kind, name] = after


def motions(joint, values, proof, wrong):
    """The coordinates of a URDF joint, each with T or R, and its axis."""
    own = [group for group in proof["groups"] if group["joint"] == joint]
    (kind,), axis = values["type", joint], values["axis", joint]
    if len(own) != len(COORDINATES[kind]) and (own or joint not in proof["held"]):
        wrong(f"joint '{joint}' ({kind}) has {len(own)} coordinates")
    if not own:
        return []
    length = sqrt(sum(c * c for c in axis))
    # which two axes of its plane a planar joint has, the URDF leaves open
    axes = [*(group["axis"] for group in own[:-1]), [c / length for c in axis]]
    axes = [*AXES, *AXES] if len(own) == 6 else axes
    if not apart(product(axes[-3:], [*zip(*axes[-3:])]), AXES, (1.0, 1.0, 1.0)) < TOLERANCE:
        wrong(f"the axes of joint '{joint}' are not square to each other")
    return [(group["coordinate"], motion) for group, *motion in zip(own, COORDINATES[kind], axes)]


def urdf_robot(values, proof, wrong):
    """The robot of the URDF: each link is a part."""
    joints = {name: said[0] for (kind, name), said in values.items() if kind == "child"}
    links = [name for kind, name in values if kind == "link"]
    robot, todo = {}, [(link, "", []) for link in links if link not in joints.values()]
    for link, before, way in todo:
        (mass,), tensor, centre = (values[kind, link] for kind in ("mass", "inertia", "centre"))
        robot["link", link] = before, way, moments(mass, tensor, origin(centre))
        for name, child in joints.items():
            if values["parent", name] == [link]:
                way = [(None, origin(values["origin", name]))]
                todo.append((child, ("link", link), way + motions(name, values, proof, wrong)))
    return robot


def certified_robot(groups, urdf):
    """The robot of the certificate: each group is a part.  Links are where the URDF has them."""
    robot = {}
    for name, g in groups.items():
        way = [(None, unpacked(g["place"])), (name, ("TR"[g["turns"]], g["axis"]))]
        own = moments(g["mass"], g["inertia"], frame(AXES, g["centre"]))
        robot["group", name] = g["parent"], way, own
    at, mover = poses(urdf, dict.fromkeys(groups, 0.0))
    for link in urdf:
        place = product(inverse(at[mover[link]]), at[link])
        robot[link] = mover[link], [(None, place)], None
    return robot


def vector(element):
    return ZERO if element is None else [float(element.findtext(k, "0")) for k in "xyz"]


def mbs_robot(model, names):
    """The robot of the .mbs: each body is a part, and each point.

    ``names``: the coordinates of the joints that move.
    """
    robot = {}
    for body in (model.find("base"), *model.iterfind("bodytree/body")):
        name, way = body.findtext("bodyname", "base"), []
        for joint in body.iterfind("joint"):
            own, (kind, axis) = joint.findtext("jointname"), joint.findtext("type")
            motion = kind, AXES[int(axis) - 1]
            if own not in names:
                held = joint.findtext("nature") == "driven"
                motion = step(*motion, float(joint.findtext("initialvalue/q", "0")) * held)
            way.append((names.get(own, ("joint", own)), motion))
        mass, centre = float(body.findtext("mass", "0")), vector(body.find("com/coordinates"))
        tensor = [float(body.findtext(f"inertia/I{k}", "0")) for k in MOMENTS]
        parent = "point", body.findtext("parent/bodyname"), body.findtext("parent/pointname")
        own = moments(mass, tensor, frame(AXES, centre))
        robot["body", name] = "" if name == "base" else parent, way, own
        robot["point", name, "origin"] = ("body", name), [], None
        for point in body.iterfind("point"):
            way = [(None, frame(AXES, vector(point.find("coordinates"))))]
            robot["point", name, point.findtext("pointname")] = ("body", name), way, None
    return robot


# --- what else is in the .mbs ---


def rest_of(model: ET.Element) -> list[list[str]]:
    """All that the .mbs says beside its bodies: each thing as a list of words."""
    parts = [part for part in model if part.tag not in ("base", "bodytree")]
    rest = [[thing.tag, *words_of(thing)] for part in parts for thing in part]
    rest.append(["gravity", *words_of(model.find("base/gravity"))])
    for body in model.iterfind("bodytree/body"):
        name = body.findtext("bodyname")
        keys = "jointname", "type", "nature", *(f"initialvalue/{q}" for q in SYMBOLS)
        rest += [[joint.findtext(key, "") for key in keys] for joint in body.iterfind("joint")]
        for point in body.iterfind("point"):
            things = (*point.iterfind("extforce"), *point.iterfind("sensor"))
            at = words_of(point.find("coordinates"))
            rest += [[thing.tag, thing.get("name"), name, *at] for thing in things]
    return rest


def words_of(element):
    return [text.strip() for text in element.itertext() if text.strip()]


def compare_joints(model, values, proof, names, wrong):
    """Compare natures, <symbols>, and the numbers of the URDF's joints."""
    for joint in model.iterfind("bodytree/body/joint"):
        name, nature = joint.findtext("jointname"), joint.findtext("nature")
        symbols, own = joint.find("symbols"), names.get(name)
        lost = set() if symbols is None else {*SYMBOLS} - {one.tag for one in symbols}
        moved = {value.tag for value in joint.iterfind("initialvalue/*") if float(value.text)}
        # what is held may have a position, if its symbols have it, and no speed
        fine = not lost if own else not (moved & {"q"} & lost or moved - {"q"} - lost)
        follows = values.get(("mimic", own))  # in what way, the certificate says
        if not fine or ((own is None) != (nature == "driven") and not follows):
            wrong(f"joint '{name}' ({nature}, without {sorted(lost)}) does not move as it should")
        for kind in (*NUMBERS, *SPRINGS):
            place = f"user_models/user_model[name='{kind}']/parameter[name='{name}']/value"
            text, should = model.findtext(place), values.get((kind, own))
            known = [f"joint '{own}': {kind} is {text}, " in edit for edit in proof["but_for"]]
            if text is not None and [float(text)] != should and not any(known):
                wrong(f"joint '{name}': {kind} is {text}, and in the URDF {should}")


class Refuse(ET.TreeBuilder):
    def doctype(self, *_):
        raise ValueError("a <!DOCTYPE>, whose entities could hide what is read")


def replay(*files):
    """Print what does not hold, and the verdict; gives the exit code."""
    data, wrong = [Path(file).read_bytes() for file in files], []
    robot, model = (ET.fromstring(text, ET.XMLParser(target=Refuse())) for text in data[:2])
    statement, canonical = json.loads(data[2]), ET.canonicalize(data[0]).encode()
    predicate = statement["predicate"]
    proof, known = predicate["urdf2mbs"], (*predicate["configuration"], *statement["subject"])
    digests = {one["digest"]["sha256"] for one in known}
    for file, texts in zip(files, ((data[0], canonical), data[1:2])):
        if digests.isdisjoint(sha256(text).hexdigest() for text in texts):
            wrong.append(f"{file} is not the file that was certified")
    for element in model.iter():
        element.text = (element.text or "").strip()
    listed = {group["coordinate"]: group for group in proof["groups"]}
    edited = {name: group | group.get("found", {}) for name, group in listed.items()}
    names = {group["mbs"]: name for name, group in listed.items()}
    values = urdf_values(robot)
    change(values, proof["changes"], wrong.append)
    urdf = urdf_robot(values, proof, wrong.append)
    groups = {name: (name, frame()) for name in listed}
    certified = certified_robot(listed, urdf)
    compare(urdf, certified, groups, listed, "the certificate", wrong.append)
    certified, places = certified_robot(edited, urdf), {}
    for link in urdf:
        kind, name, place = proof["frames"][link[1]]
        there = names.get(name, ("joint", name)) if kind == "joint" else (kind, name)
        if not any(f"link '{link[1]}': its frame is " in edit for edit in proof["but_for"]):
            places[link] = there, unpacked(place)
    for cut, link, place, body, point in proof["ends"]:
        end = "end of a cut", cut, body, point
        certified[end] = ("link", link), [(None, unpacked(place))], None
        places[end] = ("point", body, point), frame()
    off = compare(certified, mbs_robot(model, names), places, listed, "the .mbs", wrong.append)
    compare_joints(model, values, proof, names, wrong.append)
    rest, should = rest_of(model), proof["rest"]
    odd = [thing for thing in rest + should if (thing in rest) != (thing in should)]
    if rest != should:
        wrong.append(f"only in the .mbs, or only in the certificate: {odd}")
    verdict = "NOT " * bool(wrong) + f"the same robot: {len(listed)} groups, to {off:.0e}"
    edits = [f"what moves with '{name}' (edited)" for name in listed if "found" in listed[name]]
    known = (proof["but_for"] | proof["not_compared"]).items()
    known = [*edits, *proof["changed"], *(f"{thing} ({why})" for thing, why in known)]
    print(*wrong, verdict, *(f"  but for {thing}" for thing in known), sep="\n")
    return 3 if wrong else 0


if __name__ == "__main__":
    try:
        sys.exit(replay(*sys.argv[1:]) if len(sys.argv) == 4 else __doc__)
    except Exception as error:  # a file is not what it should be
        sys.exit(f"{type(error).__name__}: {error}\n{__doc__}")
