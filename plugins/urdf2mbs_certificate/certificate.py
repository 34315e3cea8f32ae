"""Replay a certificate of urdf2mbs: python certificate.py ROBOT.urdf MODEL.mbs MODEL.proof.json

Is the .mbs the robot of the URDF?  This file answers with Python's standard library alone, and
uses no code of urdf2mbs.  It reads both files itself.  The certificate says which joints of the
.mbs are which joint of the URDF, and what was changed on purpose, which is printed.
Exit code: 0 the same, 3 not the same, 1 a file is unreadable or has what this file does not know.
The URDF of a xacro file: urdf2mbs convert ROBOT.xacro --dump DIR --stop-after expand

What no moving joint separates is one group.  With all joints at zero, each joint must turn about
the same line of the world as in the URDF, or shift along it, behind the same joint.  The group that
it moves must have the same mass, centre and inertia.  By the product of exponentials (Brockett,
1984) all groups then move as in the URDF from there on, so the equations of motion are the same.

The replay knows these elements of a URDF and of an .mbs, with their attributes (@) and what may be
in them; of those with * there may be several.  What is in an element without a colon moves nothing.

robot: @name @version link* joint* material* gazebo* transmission* sensor* ros2_control* mujoco*
link: @name inertial visual* collision* contact*  inertial: origin mass inertia  mass: @value
inertia: @ixx @ixy @ixz @iyy @iyz @izz  origin: @xyz @rpy  axis: @xyz  parent: @link  child: @link
joint: @name @type parent child origin axis limit dynamics mimic safety_controller calibration
limit: @lower @upper @effort @velocity  dynamics: @damping @friction
mimic: @joint @multiplier @offset

mbsDescR7: mbsname mbsyspad_version base bodytree cuts links user_constraints user_models
user_variables x3D  base: gravity baseBodyName point* graphics  gravity: coordinates
bodytree: body*  body: bodyname parent joint* mass com inertia point* graphics
parent: bodyname pointname  com: coordinates  coordinates: x y z  initialvalue: q qd qdd
joint: jointname type nature initialvalue actuated symbols graphics  symbols: q qd qdd
inertia: Ixx Ixy Ixz Iyy Iyz Izz  point: pointname coordinates graphics sensor extforce
cuts: ball* rod* solid*  user_models: user_model*  user_model: name parameter*
parameter: name type value*
"""
# fmt: off

import json
import re
import sys
import xml.etree.ElementTree as ET
from functools import reduce
from math import cos, hypot, sin, sqrt
from operator import mul
from pathlib import Path

TOLERANCE = 1e-9
AXES, ZERO = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0)
MOMENTS, Q = ("xx", "xy", "xz", "yy", "yz", "zz"), ["q", "qd", "qdd"]
DECIMAL = re.compile(r"[+-]?([0-9]{1,50}\.?[0-9]{0,50}|\.[0-9]{1,50})([eE][+-]?[0-9]{1,2})?")
#: What the coordinates of a joint do: turn (R) or shift (T); and the joints of an .mbs.
WAYS = {"fixed": "", "revolute": "R", "continuous": "R", "prismatic": "T", "planar": "TTR",
        "floating": "TTTRRR"}
#: Where a URDF has the numbers of the user models: an element of the joint, and an attribute.
NUMBERS = {"damping": "dynamics damping", "friction": "dynamics friction", "effort": "limit effort",
           "velocity": "limit velocity", "q_min": "limit lower", "q_max": "limit upper"}
#: What a joint should be, and what is only told: no cut and no rule of <mimic> is read here, but
#: for a multiplier of zero.
KNOWN = {"follower": ["independent", "dependent", "driven"], "independent": ["dependent"]}


def demand(fine, said):
    """Refuse a file that has what this file does not know."""
    if not fine:
        raise ValueError(said)


# --- frames: 4 x 4 matrices of a rotation, row by row, and an origin (m), in the world ---


def frame(rotation=AXES, xyz=ZERO):
    return [[*row, x] for row, x in zip(rotation, xyz)] + [[0.0, 0.0, 0.0, 1.0]]


def product(*matrices):
    return reduce(lambda a, b: [[sum(map(mul, row, c)) for c in zip(*b)] for row in a], matrices)


def step(way, axis, q):
    """A frame after a joint: a shift, or a turn about a unit axis by Rodrigues' formula."""
    (x, y, z), turn = axis, q if way == "R" else 0.0
    k, s, c = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)), sin(turn), 1.0 - cos(turn)
    rows = [[i + s * a + c * b for i, a, b in zip(*r)] for r in zip(AXES, k, product(k, k))]
    return frame(rows, [(q - turn) * x for x in axis])


def screw(way, axis, at):
    """What a joint at a frame does: its turn, and its shift of what is at the world's origin."""
    (x, y, z), (a, b, c) = (sum(map(mul, row, axis)) for row in at[:3]), [row[3] for row in at[:3]]
    turn = (x, y, z), (b * z - c * y, c * x - a * z, a * y - b * x)
    return turn if way == "R" else (ZERO, (x, y, z))


def moments(bodies, centre):
    """The sum of m r r^T, r = (x, y, z, 1) seen from ``centre``, of bodies: a mass (kg), its
    inertia about its own centre (kg m^2), and the frame of this."""
    total = [[0.0] * 4] * 4
    for mass, (xx, xy, xz, yy, yz, zz), at in bodies:
        demand(mass >= 0.0, f"a body has a mass of {mass} kg")
        half, at = (xx + yy + zz) / 2, product(frame(AXES, [-x for x in centre]), at)
        own = [[half - xx, -xy, -xz, 0.0], [-xy, half - yy, -yz, 0.0], [-xz, -yz, half - zz, 0.0],
               [0.0, 0.0, 0.0, mass]]
        total = [[a + b for a, b in zip(*r)] for r in zip(total, product(at, own, [*zip(*at)]))]
    return total


def apart(one, two, by=(1.0, 1.0, 1.0, 1.0)):
    """How far two matrices are apart: the sum of their elements' differences, over ``by``, the
    sizes of row and column.  NaN is never small."""
    return sum(abs(a - b) / k / m for x, y, k in zip(one, two, by) for a, b, m in zip(x, y, by))


# --- reading ---


class Builder(ET.TreeBuilder):
    """Takes elements and comments, and nothing else."""

    def doctype(self, name, *_):
        demand(False, f"<!DOCTYPE or <? {name}: unknown")

    pi = doctype


def read(data, table, told, changes=()):
    """The root of a file, after a change; refuses elements that are unknown or doubled."""
    parser, parts = ET.XMLParser(target=Builder()), re.split(r"(\w+):", table)
    parser.feed(data.removeprefix(b"\xef\xbb\xbf").lstrip())
    todo, rows = [parser.close()], dict(zip(parts[1::2], map(str.split, parts[2::2])))
    change(todo[0], changes, told)
    demand(todo[0].tag == parts[1], f"<{todo[0].tag}> is unknown as the root")
    for element in todo:
        row, where = rows[element.tag], (element.tag, element.get("name", element.findtext("*")))
        told += [f"{where}: unknown {k}={v!r}" for k, v in element.items() if f"@{k}" not in row]
        unknown = [child.tag for child in element if not {child.tag, f"{child.tag}*"} & {*row}]
        once = sorted(f"<{child.tag}> {child.tag in row or child.get('name', child.findtext('*'))}"
                      for child in element if child.tag in row or child.tag in rows)
        doubled = [one for one, other in zip(once, once[1:]) if one == other]
        demand(not unknown + doubled, f"{where}: unknown {unknown}, doubled {doubled}")
        todo += [child for child in element if child.tag in rows]
    return todo[0]


def numbers(element, path, key=None, unsaid="0"):
    """The decimals in an attribute, or in the text of an element."""
    parts, where = element.findall(path), element.get("name", element.findtext("*"))
    text = (parts[0].get(key, unsaid) if key else parts[0].text or "") if parts else unsaid
    words = text.split() if text.isascii() and not parts[1:] and not any(map(len, parts)) else ()
    fine = len(words) == len(unsaid.split()) and all(map(DECIMAL.fullmatch, words))
    demand(fine, f"<{element.tag}> {where!r}: {text!r} of <{path}> is no finite decimal")
    return [*map(float, words)]


def vector(element, path, keys="xyz"):
    return [numbers(element, path + key)[0] for key in keys]


def origin(element, path):
    """The frame of an <origin>: x, y, z, roll, pitch, yaw."""
    x, y, z = (step("R", *turn) for turn in zip(AXES, numbers(element, path, "rpy", "0 0 0")))
    return product(frame(AXES, numbers(element, path, "xyz", "0 0 0")), z, y, x)


# --- the two robots, all joints at zero: groups by their coordinates (joints of the .mbs), each the
# one before it, the screw and the bodies; and other facts by their kinds and names


def urdf_robot(urdf, said, told):
    groups, facts = {"": ("", None, [])}, {("gravity", "base"): (0.0, 0.0, -9.81)}
    ends = urdf.iterfind("joint/parent[@link='world']")
    links = {end.get("link"): ET.Element("link") for end in ends}
    links |= {link.get("name"): link for link in urdf.iterfind("link")}  # which may declare it
    joints = urdf.findall("joint[parent][child]")
    below = {joint.find("child").get("link"): joint for joint in joints}
    todo = [(link, "", frame()) for link in links if link not in below]
    for name, group, here in todo:
        link = links.get(name, urdf)
        tensor = [numbers(link, "inertial/inertia", f"i{key}")[0] for key in MOMENTS]
        centre = product(here, origin(link, "inertial/origin"))
        groups[group][2].append((*numbers(link, "inertial/mass", "value"), tensor, centre))
        for joint in [joint for joint in joints if joint.find("parent").get("link") == name]:
            before, at = group, product(here, origin(joint, "origin"))
            for own, way, axis in motions(joint, said, told):
                demand(own not in groups, f"the certificate has joint {own!r} twice")
                groups[own], before = (before, screw(way, axis, at), []), own
                facts["nature", own] = "independent" if joint.find("mimic") is None else "follower"
                # a follower stays at its offset if its multiplier is zero; + 0.0 makes 0 of -0
                q, m = numbers(joint, "mimic", "offset"), numbers(joint, "mimic", "multiplier", "1")
                facts["motion", own] = m == [0.0] and f"driven, {[q[0] + 0.0, 0.0, 0.0]} with ['q']"
                for kind, place in NUMBERS.items():
                    facts[kind, own] = numbers(joint, *place.split())[0]
            todo.append((joint.find("child").get("link"), before, at))
    fine = len(todo) == len(links) == len(below) + 1 == len(urdf.findall("joint")) + 1
    demand(fine, "the links are no tree with one root")
    return groups, facts


def motions(joint, said, told):
    """Of each coordinate of a URDF joint: its joint in the .mbs, T or R, and its axis."""
    name, kind, axis = joint.get("name"), joint.get("type"), numbers(joint, "axis", "xyz", "1 0 0")
    own, axis = said["joints"].get(name, ()), [c / (hypot(*axis) or 1.0) for c in axis]
    # a URDF leaves open which two directions in its plane a planar joint has
    axes = [*AXES, *AXES] if kind == "floating" else [*said["planes"].get(name, ()), axis]
    square = len(axes) == 1 or apart(product(axes[-3:], [*zip(*axes[-3:])]), AXES) < TOLERANCE
    fine = kind in WAYS and (not own or (len(own) == len(WAYS[kind]) == len(axes) and square))
    demand(fine, f"joint {name!r} of type {kind!r} cannot be {own} along {axes}")
    if WAYS[kind] and not own:
        told.append(f"joint {name!r} is held at zero: {said['held'].get(name)!r}")
    return zip(own, WAYS[kind], axes)


def mbs_robot(model, coordinates):
    """``coordinates``: the joints that are the URDF's.  The others are held where they start."""
    facts = {("gravity", "base"): tuple(vector(model, "base/gravity/coordinates/"))}
    groups, places = {"": ("", None, [])}, {(None, None): ("", frame())}
    for body in (*model.iterfind("base"), *model.iterfind("bodytree/body")):
        name = body.findtext("bodyname", "base")
        on = body.findtext("parent/bodyname"), body.findtext("parent/pointname")
        demand(on in places and (name, "origin") not in places, f"body {name!r} cannot be on {on}")
        group, at = places[on]
        for joint in body.iterfind("joint"):
            own, kind, symbols = joint[0].text, joint.findtext("type", ""), joint.find("symbols")
            demand(own not in groups and re.fullmatch("[TR][123]", kind), f"{own!r} of {kind!r}")
            way, axis = kind[0], AXES[int(kind[1]) - 1]
            q, *speeds = vector(joint, "initialvalue/", Q)
            kept = Q if symbols is None else [one.tag for one in symbols]
            nature = joint.findtext("nature", "unknown")
            if own in coordinates:
                groups[own], group = (group, screw(way, axis, at), []), own
                fine, facts["nature", own] = len(kept) == 3, nature
            else:  # what is held may have a position, if its symbols have it
                at = product(at, step(way, axis, q))
                fine = nature == "driven" and not any(speeds) and (not q or "q" in kept)
            facts["motion", own] = not fine and f"{nature}, {[q, *speeds]} with {kept}"
        places[name, "origin"] = group, at
        for point in body.iterfind("point"):
            xyz, key = vector(point, "coordinates/"), (name, point.findtext("pointname"))
            demand(key not in places or not any(xyz), f"point {key} is elsewhere")
            places[key] = group, product(at, frame(AXES, xyz))
        xyz, tensor = vector(body, "com/coordinates/"), vector(body, "inertia/I", MOMENTS)
        groups[group][2].append((*numbers(body, "mass"), tensor, product(at, frame(AXES, xyz))))
    for one in model.iterfind("user_models/user_model"):
        for parameter in one.iterfind("parameter") if one[0].text in NUMBERS else ():
            facts[one[0].text, parameter[0].text] = numbers(parameter, "value")[0]
    ends = [{own for kind, own in facts if kind == end} for end in ("q_min", "q_max")]
    demand(ends[0] == ends[1], f"limits at one end alone: {ends[0] ^ ends[1]}")
    for cut in model.iterfind("cuts/*"):
        facts[cut.tag, " ".join(cut.itertext())] = "not compared"
    return groups, facts


# --- the comparison


def compare(ours, theirs, wrong):
    """Compare how groups move, and what they weigh."""
    for name, (before, axis, bodies) in [*ours.items()][1:]:
        their_before, their_axis, their_bodies = theirs[name]
        turn, shift = (apart([a], [b]) for a, b in zip(axis, their_axis))
        # the size of the parts counts, but as at least 1 mm, and as at most 1 m for a length
        motion = turn + shift / min(max(hypot(*axis[1]), 1e-3), 1.0) + (before != their_before)
        mass = sum(mass for mass, *_ in bodies)
        centre = [sum(m * at[k][3] for m, _, at in bodies) / (mass or 1.0) for k in range(3)]
        sums = moments(bodies, centre), moments(their_bodies, centre)
        most = max(abs(x) for total in sums for row in total[:3] for x in row[:3])
        k = sqrt(max(most, mass * 1e-6)) or 1.0
        weight = apart(*sums, (k, k, k, sqrt(max(total[3][3] for total in sums)) or 1.0))
        offs = {f"motion of {name!r}": motion, f"mass or inertia of {name!r}": weight}
        wrong |= {what: f"{off:.1e} off" for what, off in offs.items() if not off <= TOLERANCE}


def compare_facts(ours, theirs, gravity, wrong, told):
    """Compare gravity, natures and numbers: zero is none.  Cuts and <mimic> are only told."""
    for kind, name in ours | theirs:
        should, found = (facts.get((kind, name)) or None for facts in (ours, theirs))
        how = f"{found!r}, and {should!r} in the URDF"
        if found is None or found in KNOWN.get(should, [gravity, "not compared"]):
            told += [f"{kind} of {name!r}: {how}"] * (found != should)
        elif found != should:
            wrong[f"{kind} of {name!r}"] = how


def change(urdf, changes, told):
    """What passes changed on purpose: elements that are replaced, or added to the robot."""
    owners = {(one.tag, one.get("name")): one for one in urdf} | {("robot", None): urdf}
    for (tag, name), text in changes:
        owner, new = owners[tag, name], ET.fromstring(text)
        old = [] if owner is urdf else owner.findall(new.tag)
        was = "".join(ET.canonicalize(ET.tostring(one), strip_text=True) for one in old)
        told.append(f"<{tag}> {name!r} has {text!r} on purpose, and {was!r} in the URDF")
        owner[:] = [*(one for one in owner if one not in old), new]


def replay(urdf: bytes, mbs: bytes, certificate: bytes) -> tuple[dict[str, str], list[str]]:
    """Compare two files: what is not the same, by its name, and what is known."""
    wrong, told, tables, said = {}, [], __doc__.split("\n\n")[-2:], json.loads(certificate)
    ours, our_facts = urdf_robot(read(urdf, tables[0], told, said["changes"]), said, told)
    theirs, their_facts = mbs_robot(read(mbs, tables[1], told), ours)
    demand(ours.keys() == theirs.keys(), f"not in the .mbs: {sorted(ours.keys() - theirs.keys())}")
    compare(ours, theirs, wrong)
    compare_facts(our_facts, their_facts, tuple(said["gravity"]), wrong, told)
    told += [f"{one}: {wrong.pop(one)}, as edited" for one in [*wrong] if one in said["edited"]]
    return wrong, told


def main(files: list[str]) -> int:
    """Print the verdict; gives the exit code."""
    try:
        wrong, told = replay(*(Path(file).read_bytes() for file in files))
        same = "the same robot" + ", but for:" * bool(told)
        wrong = [f"{what}: {how}" for what, how in wrong.items()]
        print("NOT the same robot" if wrong else same, *wrong, *told, sep="\n  ")
        return 3 if wrong else 0
    except Exception as error:  # a file is not what it should be
        print(f"{type(error).__name__}: {str(error)!r}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) if len(sys.argv) == 4 else __doc__)
