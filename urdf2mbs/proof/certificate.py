"""Replay a certificate of urdf2mbs: python certificate.py ROBOT.urdf MODEL.mbs MODEL.proof.json

Is the .mbs the robot of the URDF?  This file answers with Python's standard library alone, and
uses no code of urdf2mbs.  It computes the mass matrix and the moments of all mass at random
positions: of the URDF, of the .mbs, and of the numbers in the certificate.  If they agree, the
equations of motion are the same.  Exit code: 0 the same, 3 not the same, 1 a file is unreadable.
The URDF of a xacro file: urdf2mbs convert ROBOT.xacro --dump DIR --stop-after expand
"""

import json
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from hashlib import sha256
from math import cos, isfinite, pi, sin, sqrt
from pathlib import Path
from random import Random

TOLERANCE = 1e-9
AXES, ZERO = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0)
MOMENTS, SYMBOLS = ("xx", "xy", "xz", "yy", "yz", "zz"), {"q", "qd", "qdd"}
#: User models: those called as their attribute in URDF is, and those of the ends of a range.
SPRING = {"spring_stiffness": "<springStiffness>", "spring_reference": "<springReference>"}
PLAIN = ["damping", "friction", "effort", "velocity", "k_position", "k_velocity", *SPRING]
ENDS = "q_min q_max soft_q_min soft_q_max calibration_rising calibration_falling".split()
ENDS = dict(zip(ENDS, "lower upper soft_lower_limit soft_upper_limit rising falling".split()))
ZEROS = {"limit": ("lower", "upper")}
ZEROS["safety_controller"] = ("k_position", "soft_lower_limit", "soft_upper_limit")


def frame(rotation, xyz):
    """A 4 x 4 matrix: a rotation, row by row, and an origin (m)."""
    return [[*row, x] for row, x in zip(rotation, xyz)] + [[0.0, 0.0, 0.0, 1.0]]


def product(first, *others):
    for other in others:
        columns = list(zip(*other))
        first = [[sum(map(float.__mul__, row, column)) for column in columns] for row in first]
    return first


def seen(at, moments):
    return product(at, moments, list(zip(*at)))


def twist(kind, axis):
    """The velocity of a joint at the speed 1: a turn (R) about a unit axis, or a shift (T)."""
    x, y, z = axis
    turn = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))
    rows = frame(turn, ZERO) if kind == "R" else frame([ZERO] * 3, axis)
    return [*rows[:3], [0.0] * 4]


def step(kind, axis, q):
    """A frame after a joint: I + sin(q) K + (1 - cos(q)) K^2 by Rodrigues, or I + q K."""
    k, first = twist(kind, axis), sin(q) if kind == "R" else q  # K^2 of a shift is 0
    terms = zip(frame(AXES, ZERO), k, product(k, k))
    return [[i + first * a + (1.0 - cos(q)) * b for i, a, b in zip(*rows)] for rows in terms]


def pseudo(mass, tensor):
    """A mass (kg) at the origin and the inertia about it (kg m^2) as the 4 x 4 sum of m r r^T,
    r = (x, y, z, 1).  Parts add up, and J seen from a frame T is T J T^T."""
    xx, xy, xz, yy, yz, zz = tensor
    a, b, c = (yy + zz - xx) / 2, (xx + zz - yy) / 2, (xx + yy - zz) / 2
    return [[a, -xy, -xz, 0.0], [-xy, b, -yz, 0.0], [-xz, -yz, c, 0.0], [0.0, 0.0, 0.0, mass]]


def dynamics(groups, position):
    """The mass matrix, and how each coordinate's speed moves the moments of all mass."""
    at = {name: product(g[1], step(g[2], g[3], position[name])) for name, g in groups.items()}
    parts, matrix = {name: list(g[4]) for name, g in groups.items()} | {"": []}, {}
    for name in reversed(groups):
        whole = [[*map(sum, zip(*rows))] for rows in zip(pseudo(0.0, [0.0] * 6), *parts[name])]
        parts[groups[name][0]].append(seen(at[name], whole))
        flow, own = product(whole, list(zip(*twist(*groups[name][2:4])))), name
        while own:
            speed = twist(*groups[own][2:4])
            matrix[name, own] = [sum(speed[i][k] * flow[k][i] for i in range(3) for k in range(4))]
            flow, own = seen(at[own], flow), groups[own][0]
        matrix[name, ""] = [value for row in flow for value in row]
    matrix["", ""] = [sum(m[i][k] for m in parts[""]) for i in range(4) for k in range(4)]
    return matrix


def rigid(parts):
    """Rigid groups: the one before, where its joint is, T or R, its axis, and its moments; of
    parts: a name, the part before it, the way to it, and its inertias."""
    groups, where = {}, {"": ("", frame(AXES, ZERO))}
    for name, before, way, weighs in parts:
        group, at = where[before]
        for joint in way:
            if isinstance(joint, list):
                at = product(at, joint)
            else:
                groups[joint[0]] = group, at, *joint[1:], []
                group, at = joint[0], frame(AXES, ZERO)
        where[name] = group, at
        for centre, *inertia in weighs if group else ():
            groups[group][4].append(seen(product(at, centre), pseudo(*inertia)))
    return groups


def compare(one, other, what, wrong):
    """Compare two robots at random positions; gives the largest deviation, relative."""
    chance, worst = Random(what), {"": 0.0}
    if {name: g[0] for name, g in one.items()} != {name: g[0] for name, g in other.items()}:
        wrong(f"{what}: other coordinates move, or stand on each other")
        return 1.0
    for _ in range(3):
        position = {name: chance.uniform(-pi, pi) for name in one}
        ours, theirs = dynamics(one, position), dynamics(other, position)
        for (name, to), mine in ours.items():
            own = sqrt(abs(ours[name, name][0] * ours[to, to][0])) if to else max(map(abs, mine))
            off = [abs(a - b) / (own or 1.0) for a, b in zip(mine, theirs[name, to])]
            worst[name] = max(worst.get(name, 0.0), max(off) if isfinite(sum(off)) else 1e300)
    for name in sorted(worst, key=worst.get, reverse=True):
        if worst[name] > TOLERANCE:
            wrong(f"{what}: what {name or 'the ground'} carries is {worst[name]:.1e} off")
    return max(worst.values())


def numbers(element, path, key, default=ZERO):
    """The numbers of an attribute; ``path`` leads to its element."""
    text = None if (found := element.find(path)) is None else found.get(key)
    return default if text is None else [*map(float, text.split())]


def vector(element):
    return ZERO if element is None else [float(element.findtext(k, "0")) for k in "xyz"]


def origin(element):
    x, y, z = (step("R", axis, q) for axis, q in zip(AXES, numbers(element, "origin", "rpy")))
    return product(frame(AXES, numbers(element, "origin", "xyz")), z, y, x)


def coordinates(joint, proof, listed):
    """A URDF joint's coordinates: the name of each, T or R, and its axis."""
    name, kind = joint.get("name"), joint.get("type")
    if kind == "fixed" or name in proof["held"]:
        return []
    if kind == "floating":
        return [(f"{name}[{t}{k}]", t, AXES[k - 1]) for t in "TR" for k in (1, 2, 3)]
    axis = numbers(joint, "axis", "xyz", AXES[0])
    length = sqrt(sum(c * c for c in axis)) * (-1.0 if name in proof["flipped"] else 1.0)
    axis = [c / length for c in axis]
    if kind != "planar":
        return [(name, "T" if kind == "prismatic" else "R", axis)]
    axes = [*(listed[f"{name}[{k}]"]["axis"] for k in (0, 1)), axis]  # which two, URDF leaves open
    square = product(axes, list(zip(*axes)))
    if any(abs(square[i][k] - AXES[i][k]) > TOLERANCE for i in range(3) for k in range(3)):
        raise ValueError(f"the axes of the planar joint '{name}' are not square to each other")
    return [(f"{name}[{k}]", "TTR"[k], axis) for k, axis in enumerate(axes)]


def urdf_parts(robot, proof, listed):
    """Each link, parents first."""
    ends = {joint: joint.find("parent").get("link") for joint in robot.iterfind("joint")}
    links = {link.get("name"): link for link in robot.iterfind("link")}
    (root,) = links.keys() - {joint.find("child").get("link") for joint in ends}
    base = ET.Element("joint", name=proof["base_joint"] or "", type="floating")
    todo = [(root, "", coordinates(base, proof, listed) if proof["base_joint"] else [])]
    for name, before, way in todo:
        weighs = []
        for e in links[name].iterfind("inertial[mass]"):
            tensor = [numbers(e, "inertia", f"i{k}")[0] for k in MOMENTS]
            weighs.append((origin(e), *numbers(e, "mass", "value"), tensor))
        yield name, before, way, weighs
        for joint in (joint for joint, parent in ends.items() if parent == name):
            way = [origin(joint), *coordinates(joint, proof, listed)]
            todo.append((joint.find("child").get("link"), name, way))


def mbs_parts(model, names):
    """The base, and each body; ``names`` gives the URDF's coordinate of each joint that moves."""
    points = {("", "base"): ZERO}
    for body in (model.find("base"), *model.iterfind("bodytree/body")):
        name = body.findtext("bodyname", "base")
        points[name, "origin"] = ZERO
        for point in body.iterfind("point"):
            points[name, point.findtext("pointname")] = vector(point.find("coordinates"))
        before = body.findtext("parent/bodyname", "")
        way = [frame(AXES, points[before, body.findtext("parent/pointname", "base")])]
        for joint in body.iterfind("joint"):
            own, (kind, axis) = joint.findtext("jointname"), joint.findtext("type")
            if own in names:
                way.append((names[own], kind, AXES[int(axis) - 1]))
            elif joint.findtext("nature") == "driven":
                q = float(joint.findtext("initialvalue/q", "0"))
                way.append(step(kind, AXES[int(axis) - 1], q))
        mass, centre = float(body.findtext("mass", "0")), vector(body.find("com/coordinates"))
        tensor = [float(body.findtext(f"inertia/I{k}", "0")) for k in MOMENTS]
        yield name, before, way, [(frame(AXES, centre), mass, tensor)]


def stated(joint, kind, flipped):
    """A URDF joint's number for a user model; None: the URDF has none."""
    said = {key: "0" for part in joint for key in ZEROS.get(part.tag, ())}
    said |= {key: text for part in joint for key, text in part.items()}
    said |= {key: joint.get(tag, "0") for key, tag in SPRING.items()}
    other = [end for end in ENDS if end.rpartition("_")[0] == kind.rpartition("_")[0] != kind]
    kind, sign = (other[kind == other[0]], -1.0) if flipped and kind in ENDS else (kind, 1.0)
    number, *ends = (float(said.get(ENDS.get(one, one), "nan")) for one in (kind, *other))
    no_room = kind in ENDS and "calibration" not in kind and not ends[0] < ends[1]
    endless = kind in ("q_min", "q_max") and joint.get("type") == "continuous"
    nothing = kind in ("damping", "friction") and number == 0.0
    nothing |= kind in SPRING and float(said["spring_stiffness"]) == 0.0
    sign = -1.0 if flipped and kind == "spring_reference" else sign
    return sign * number if isfinite(number) and not (no_room or endless or nothing) else None


def compare_rest(robot, model, proof, names, wrong):
    """Natures, <symbols> and user models; all that the URDF does not have must be named."""
    named = proof["but_for"] | proof["by_code"] | proof["not_compared"]
    things, counts = [], Counter()
    urdf = {joint.get("name"): joint for joint in robot.iterfind("joint")}
    for gazebo in robot.iterfind("gazebo"):
        for part in gazebo if gazebo.get("reference") in urdf else ():
            urdf[gazebo.get("reference")].set(f"<{part.tag}>", part.get("value") or part.text)
    tied = {tie.text for tie in model.iterfind("user_constraints//jointname")}
    for joint in model.iterfind("bodytree/body/joint"):
        name, nature = joint.findtext("jointname"), joint.findtext("nature")
        symbols, own = joint.find("symbols"), urdf.get(names.get(name))
        lost = set() if symbols is None else SYMBOLS - {symbol.tag for symbol in symbols}
        values = {value.tag for value in joint.iterfind("initialvalue/*") if float(value.text)}
        counts["start"] += nature != "driven" and bool(values)
        fine = not lost if name in names else not (values & {"q"} & lost or values - {"q"} - lost)
        if own is not None and own.find("mimic") is not None:
            thing = "<mimic> of " * (nature == "dependent") + f"joint '{own.get('name')}'"
            why = {"independent": "free", "dependent": "held", "driven": "driven"}[nature]
            fine &= named.get(thing, "").startswith(why)
        else:
            fine &= (name in names) != (nature == "driven")
        if not fine or (nature == "dependent" and name not in tied and not model.findall("cuts/*")):
            wrong(f"joint '{name}' ({nature}, without {sorted(lost)}) does not move as it should")
    for kind in (*PLAIN, *ENDS):
        place = f"user_models/user_model[name='{kind}']/parameter[name='%s']/value"
        for name, own in ((name, own) for name, own in names.items() if own in urdf):
            number = stated(urdf[own], kind, own in proof["flipped"])
            text = model.findtext(place % name)
            counts[kind] += text is None and number is not None
            edited = any(thing.startswith(f"joint '{own}': {kind} is {text}, ") for thing in named)
            if text is not None and (number is None or float(text) != number) and not edited:
                wrong(f"joint '{name}': {kind} is {text}, and in the URDF {number}")
    for element in model.iterfind("*/*"):  # cuts, links, user constraints, models and variables
        name = element.findtext("name") or element.findtext("varname")
        things += [f"'{name}'"] * (name not in (*PLAIN, *ENDS, *proof["declared"], None))
    things += [f"force '{force.get('name')}'" for force in model.iterfind("bodytree//extforce")]
    things += [f"{what} of {count} joint" for what, count in counts.items() if count]
    for thing in things:
        if not any(thing in known for known in named):
            wrong(f"{thing}: the certificate does not name it")


def snap(robot, most):
    """Put exact angles and axes in place of those that are at most so far off (rad)."""
    for joint in robot.iterfind("joint") if most else ():
        rpy, axis = numbers(joint, "origin", "rpy"), numbers(joint, "axis", "xyz")
        right = [round(angle / (pi / 4)) * pi / 4 for angle in rpy]
        near = [b if abs(a - b) <= most else a for a, b in zip(rpy, right)]
        if near != [*rpy]:
            joint.find("origin").set("rpy", " ".join(map(repr, near)))
        near = [round(c / max(map(abs, axis))) for c in axis] if any(axis) else axis
        sizes = [sqrt(sum(c * c for c in vector)) or 1.0 for vector in (axis, near)]
        off = [a / sizes[0] - b / sizes[1] for a, b in zip(axis, near)]
        if any(off) and sqrt(sum(c * c for c in off)) <= most:
            joint.find("axis").set("xyz", " ".join(map(repr, near)))


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
    snap(robot, proof.get("snap"))
    for element in model.iter():
        element.text = (element.text or "").strip()
    listed = {group["coordinate"]: group for group in proof["groups"]}
    names = {group["mbs"]: name for name, group in listed.items()}
    urdf, last = rigid(urdf_parts(robot, proof, listed)), [0.0, 0.0, 0.0, 1.0]
    edited = {name: g | g.get("found", {}) for name, g in listed.items()}
    notes = [f"what moves with '{name}' (edited)" for name, g in listed.items() if "found" in g]
    claimed, found = (
        rigid(
            (name, g["parent"], [[*g["place"], last], (name, "TR"[g["turns"]], g["axis"])],
             [(frame(AXES, g["centre"]), g["mass"], g["inertia"])])
            for name, g in groups.items()
        )
        for groups in (listed, edited)
    )  # fmt: skip
    compare(urdf, claimed, "the certificate", wrong.append)
    off = compare(urdf if edited == listed else found, rigid(mbs_parts(model, names)),
                  "the .mbs", wrong.append)  # fmt: skip
    compare_rest(robot, model, proof, names, wrong.append)
    gravity = vector(model.find("base/gravity/coordinates"))
    if not all(abs(a - b) < TOLERANCE for a, b in zip(gravity, proof["gravity"])):
        wrong.append(f"gravity is {gravity}, and should be {proof['gravity']} m/s^2")
    print(
        *wrong, "NOT " * bool(wrong) + f"the same robot: {len(urdf)} groups, to {off:.0e}", sep="\n"
    )
    known = *proof["but_for"].items(), *proof["not_compared"].items()
    for note in (*notes, *proof["changed"], *known):
        print("  but for", note if isinstance(note, str) else "{} ({})".format(*note))
    return 3 if wrong else 0


if __name__ == "__main__":
    try:
        sys.exit(replay(*sys.argv[1:]) if len(sys.argv) == 4 else __doc__)
    except (OSError, ET.ParseError, ValueError, LookupError, TypeError, AttributeError) as error:
        sys.exit(f"{type(error).__name__}: {error}\n{__doc__}")
