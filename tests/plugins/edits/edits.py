"""Random edits of an .mbs, as people make them in MBSysPad, and random changes of a URDF."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random
from typing import Any

from lxml import etree

from urdf2mbs.mbs import model as m

MEASURES = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")


def as_saved(data: bytes) -> bytes:
    """A file as MBSysPad saves it: its own spelling of numbers, no zeros, no frames, CRLF."""
    root = etree.fromstring(data, etree.XMLParser(remove_comments=True))
    for element in root.iter("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz", "mass", "q"):
        if float(element.text or "1") == 0.0:
            element.set("gone", "1")
    for element in [e for e in root.iter() if e.get("gone") or e.tag == "x3D_frame"]:
        parent: Any = element.getparent()
        parent.remove(element)
    for element in root.iter("x", "y", "z", "mass", "Ixx", "Iyy", "Izz"):
        if element.text and 0.0 < abs(float(element.text)) < 1e-3:
            element.text = f"{float(element.text)!r}".upper().replace("E-0", "E-")
    version: Any = root.find("mbsyspad_version")
    version.text = "1.30.0"
    text = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return text.replace(b"\n", b"\r\n").replace(b"/>", b" />")


def places(mbs: m.Mbs, random: Random) -> None:
    for body in mbs.bodies:
        for joint in body.joints:
            if joint.position:
                joint.position = (joint.position[0] + 40.0, joint.position[1] + 7.0)


def colour(mbs: m.Mbs, random: Random) -> None:
    for body in mbs.bodies:
        if body.shapes:
            random.choice(body.shapes).color = (1, 2, random.randrange(200))
            return


def a_shape(mbs: m.Mbs, random: Random) -> None:
    one = m.Shape("box", "New_Shape", size=(0.5, 0.25, random.random()))
    random.choice(mbs.bodies).shapes.append(one)


def own_point(mbs: m.Mbs, random: Random) -> None:
    random.choice(mbs.bodies).points.append(m.Point("mine", (random.random(), 0.0, 0.5)))


def sensor(mbs: m.Mbs, random: Random) -> None:
    point = m.Point("eye", (0.0, 0.125, random.random()), sensor=m.Sensor("my_sensor", MEASURES))
    random.choice(mbs.bodies).points.append(point)


def force_at_origin(mbs: m.Mbs, random: Random) -> None:
    body = random.choice([b for b in mbs.bodies if not any(p.name == "origin" for p in b.points)])
    body.points.insert(0, m.Point("origin", extforce=m.Sensor("my_force", MEASURES)))


def link(mbs: m.Mbs, random: Random) -> None:
    one, two = random.sample(mbs.bodies, 2)
    mbs.links.append(m.Connection("link", "my_link", (one.name, None), (two.name, None)))


def cut(mbs: m.Mbs, random: Random) -> None:
    one = random.choice(mbs.bodies)
    mbs.cuts.append(m.Connection("rod", "my_rod", (one.name, None), (None, None), 1.5))


def user_model(mbs: m.Mbs, random: Random) -> None:
    mbs.user_models.append(m.UserModel("Mine", [m.Parameter("gain", "scalar", ("0.5",))]))


def variable(mbs: m.Mbs, random: Random) -> None:
    mbs.user_variables.append(m.UserVariable("mine", "in", "3"))


def start(mbs: m.Mbs, random: Random) -> None:
    free = [j for b in mbs.bodies for j in b.joints if j.nature == "independent"]
    random.choice(free).q = 0.125 + random.random() / 8


def nature(mbs: m.Mbs, random: Random) -> None:
    joint = random.choice([j for b in mbs.bodies for j in b.joints])
    joint.nature = "driven" if joint.nature == "independent" else "independent"
    joint.symbols = ("q", "qd", "qdd")


def camera(mbs: m.Mbs, random: Random) -> None:
    assert mbs.view is not None
    mbs.view.viewpoints.append(m.Viewpoint("mine", (1.0, random.random(), 0.0), (0.0, 0.0, 0.0)))
    joint = random.choice(mbs.bodies).joints[-1].name
    mbs.view.lights.append(m.Light("lamp_of_mine", (0.0, 0.0, -1.0), joint))
    mbs.view.background = (9, 9, 9)


def mass(mbs: m.Mbs, random: Random) -> None:
    random.choice([body for body in mbs.bodies if body.mass]).mass = 33.25 + random.random()


def centre(mbs: m.Mbs, random: Random) -> None:
    random.choice([body for body in mbs.bodies if body.mass]).com = (0.0, random.random(), 0.25)


def point_moved(mbs: m.Mbs, random: Random) -> None:
    points = [p for b in mbs.bodies for p in b.points if p.name != "origin"]
    if points:
        random.choice(points).coordinates = (3.0, random.random(), 0.5)


def renamed_joint(mbs: m.Mbs, random: Random) -> None:
    joint = random.choice(mbs.bodies).joints[0]
    for part in (
        *mbs.user_constraints,
        *([*mbs.view.viewpoints, *mbs.view.lights] if mbs.view else []),
    ):
        if isinstance(part, m.Viewpoint | m.Light):
            part.joint = "my_joint" if part.joint == joint.name else part.joint
        else:
            part.joints = tuple("my_joint" if n == joint.name else n for n in part.joints)
    joint.name = "my_joint"


def renamed_body(mbs: m.Mbs, random: Random) -> None:
    body = random.choice(mbs.bodies)
    for child in mbs.bodies:
        child.parent = "my_body" if child.parent == body.name else child.parent
    for part in (*mbs.cuts, *mbs.links):
        for end in ("endpoint1", "endpoint2"):
            on, at = getattr(part, end)
            setattr(part, end, ("my_body" if on == body.name else on, at))
    body.name = "my_body"


def a_body(mbs: m.Mbs, random: Random) -> None:
    on = random.choice(mbs.bodies)
    mbs.bodies.append(
        m.Body("payload", on.name, None, [m.Joint("swing", "R2", position=(50.0, 60.0))], 1.25,
             points=[m.Point("hook", (0.0, 0.0, -0.5), (55.0, 66.0))],
             drawing=m.Drawing((0.0, 0.0), (20.0, 20.0), ((20.0, 0.0),) * 4))
    )  # fmt: skip
    mbs.links.append(m.Connection("link", "rope", ("payload", "hook"), (None, None)))
    mbs.bodies = mbs.depth_first()


def a_joint(mbs: m.Mbs, random: Random) -> None:
    body = random.choice(mbs.bodies)
    place = random.randrange(len(body.joints) + 1)
    body.joints.insert(place, m.Joint("my_slide", "T3", position=(70.0, 80.0)))


def no_shape(mbs: m.Mbs, random: Random) -> None:
    bodies = [body for body in mbs.bodies if body.shapes]
    if bodies:
        random.choice(bodies).shapes.pop()


def no_leaf(mbs: m.Mbs, random: Random) -> None:
    """Remove a body that carries nothing."""
    used = {body.parent for body in mbs.bodies}
    used |= {end[0] for c in (*mbs.cuts, *mbs.links) for end in (c.endpoint1, c.endpoint2)}
    free = [body for body in mbs.bodies if body.name not in used]
    names = {n for c in mbs.user_constraints for n in c.joints}
    names |= {light.joint for light in (mbs.view.lights if mbs.view else [])}
    free = [body for body in free if names.isdisjoint(j.name for j in body.joints)]
    if len(free) > 0 and len(mbs.bodies) > 2:
        mbs.bodies.remove(random.choice(free))


#: Of them, the edits that make it another robot.
MECHANICS: list[Callable[[m.Mbs, Random], None]] = [
    cut, nature, mass, centre, point_moved, a_body, a_joint, no_leaf,
]  # fmt: skip
BESIDE: list[Callable[[m.Mbs, Random], None]] = [
    places, colour, a_shape, own_point, sensor, force_at_origin, link, user_model, variable,
    start, camera, renamed_joint, renamed_body, no_shape,
]  # fmt: skip


# --- the URDF ---


def heavier(root: Any, random: Random) -> None:
    mass = random.choice(root.findall("link/inertial/mass"))
    mass.set("value", repr(float(mass.get("value")) * 1.5))


def elsewhere(root: Any, random: Random) -> None:
    joint = random.choice(root.findall("joint"))
    if joint.find("origin") is None:
        etree.SubElement(joint, "origin")
    joint.find("origin").set("xyz", f"0.5 {random.random()} 0.25")


def other_limit(root: Any, random: Random) -> None:
    limits = root.findall("joint/limit")
    if limits:
        random.choice(limits).set("effort", "77.5")


def larger(root: Any, random: Random) -> None:
    for box in root.findall("link/visual/geometry/box")[:1]:
        box.set("size", f"1 2 {1 + random.random()}")


def link_added(root: Any, random: Random) -> None:
    parent = random.choice(root.findall("link")).get("name")
    root.append(etree.fromstring(
        '<link name="extra"><inertial><mass value="0.75"/><inertia ixx="1" iyy="1" izz="1" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
    ))  # fmt: skip
    root.append(etree.fromstring(
        f'<joint name="to_extra" type="revolute"><parent link="{parent}"/><child link="extra"/>'
        '<origin xyz="0.1 0.2 0.3"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    ))  # fmt: skip


def link_removed(root: Any, random: Random) -> None:
    parents = {joint.find("parent").get("link") for joint in root.findall("joint")}
    tied = re.findall(r"<(?:parent|child)>([^<]*)<", etree.tostring(root).decode())
    joints = [
        joint for joint in root.findall("joint")
        if joint.find("child").get("link") not in {*parents, *tied}
    ]  # fmt: skip
    followed = {mimic.get("joint") for mimic in root.findall("joint/mimic")}
    joints = [joint for joint in joints if joint.get("name") not in followed]
    if joints:
        joint = random.choice(joints)
        for link in root.findall("link"):
            if link.get("name") == joint.find("child").get("link"):
                root.remove(link)
        for user in [*root.findall("gazebo"), *root.findall("transmission")]:
            root.remove(user)
        root.remove(joint)


def link_renamed(root: Any, random: Random) -> None:
    link = random.choice(root.findall("link"))
    name = link.get("name")
    if name == "world":
        return
    link.set("name", "new_name_of_link")
    for end in [*root.findall("joint/parent"), *root.findall("joint/child")]:
        if end.get("link") == name:
            end.set("link", "new_name_of_link")
    for gazebo in root.findall("gazebo"):
        root.remove(gazebo)


def joint_renamed(root: Any, random: Random) -> None:
    joint = random.choice(root.findall("joint"))
    name = joint.get("name")
    joint.set("name", "new_name_of_joint")
    for mimic in root.findall("joint/mimic"):
        if mimic.get("joint") == name:
            mimic.set("joint", "new_name_of_joint")
    for transmission in root.findall("transmission"):
        root.remove(transmission)


def other_type(root: Any, random: Random) -> None:
    joints = [j for j in root.findall("joint") if j.get("type") in ("revolute", "continuous")]
    if joints:
        random.choice(joints).set("type", "prismatic")


CHANGES: list[Callable[[Any, Random], None]] = [
    heavier, elsewhere, other_limit, larger, link_added, link_removed, link_renamed, joint_renamed,
    other_type,
]  # fmt: skip
