"""Random edits of an .mbs, as people make them in MBSysPad, and random changes of a URDF."""

import re
from collections.abc import Callable, Iterable
from copy import deepcopy
from random import Random
from typing import Any

from lxml import etree

from urdf2mbs.mbs import model as m
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.diff.table import list_entities

MEASURES = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
Edit = Callable[[m.Mbs], Any]


# --- edits by the path of what they change, such as ``bodies.0.mass`` ---


def get(mbs: m.Mbs, path: str) -> Any:
    """Return what is at a path."""
    value: Any = mbs
    for step in path.split("."):
        value = value[int(step)] if step.isdigit() else getattr(value, step)
    return value


def put(path: str, value: Any) -> Edit:
    owner, _, field = path.rpartition(".")
    return lambda mbs: setattr(get(mbs, owner) if owner else mbs, field, value)


def add(path: str, part: Any, index: int = 99) -> Edit:
    return lambda mbs: get(mbs, path).insert(index, deepcopy(part))


def drop(path: str, index: int = 0) -> Edit:
    return lambda mbs: get(mbs, path).pop(index)


def move(source: str, target: str, index: int = 0) -> Edit:
    return lambda mbs: get(mbs, target).append(get(mbs, source).pop(index))


def call(path: str, name: str) -> Edit:
    """Rename a body, joint or point wherever it is named."""
    return lambda mbs: rename_part(mbs, get(mbs, path), name)


def all_of(*edits: Edit) -> Edit:
    return lambda mbs: [edit(mbs) for edit in edits]


def rename_part(mbs: m.Mbs, part: Any, name: str) -> None:
    """Rename a part of a model, and all references to it."""
    entities = list_entities(mbs)
    (renamed,) = (entity for entity in entities if entity.part is part)
    for entity in entities:
        for field, targets in entity.references.items():
            if renamed not in targets or any(isinstance(target, str) for target in targets):
                continue
            names: list[str | None] = []
            for target in targets:
                if target is renamed:
                    names.append(name)
                elif target is None or isinstance(target, str) or target.kind == "base":
                    names.append(None)
                else:
                    names.append(target.name)
            is_single = field in ("joint", "name")
            setattr(entity.part, field, names[0] if is_single else tuple(names))
    part.name = name


def as_saved(data: bytes) -> bytes:
    """Return a file as MBSysPad saves it: its spelling of numbers, no zeros, no frames, CRLF."""
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


# --- edits with names and numbers of their own ---


def sensor(mbs: m.Mbs, random: Random) -> None:
    point = m.Point("eye", (0.0, 0.125, random.random()), sensor=m.Sensor("my_sensor", MEASURES))
    random.choice(mbs.bodies).points.append(point)


def link(mbs: m.Mbs, random: Random) -> None:
    first, second = random.sample(mbs.bodies, 2)
    mbs.links.append(m.Connection("link", "my_link", (first.name, None), (second.name, None)))


def mass(mbs: m.Mbs, random: Random) -> None:
    random.choice([body for body in mbs.bodies if body.mass]).mass = 33.25 + random.random()


def renamed_joint(mbs: m.Mbs, random: Random) -> None:
    rename_part(mbs, random.choice(mbs.bodies).joints[0], "my_joint")


def renamed_body(mbs: m.Mbs, random: Random) -> None:
    rename_part(mbs, random.choice(mbs.bodies), "my_body")


def no_leaf(mbs: m.Mbs, random: Random) -> None:
    """Remove a body that carries nothing."""
    free = [body for body in mbs.bodies if is_free(mbs, body)]
    if len(free) > 0 and len(mbs.bodies) > 2:
        mbs.bodies.remove(random.choice(free))


def concerned(mbs: m.Mbs) -> set[str | None]:
    """Return the joints that something else names."""
    constrained = {name for constraint in mbs.user_constraints for name in constraint.joints}
    return constrained | {
        part.joint for part in ([*mbs.view.lights, *mbs.view.viewpoints] if mbs.view else [])
    }


def places(mbs: m.Mbs) -> set[tuple[str | None, str | None]]:
    """Return where bodies are attached, and where cuts and links end."""
    ends = [end for c in (*mbs.cuts, *mbs.links) for end in (c.endpoint1, c.endpoint2)]
    return {body.place for body in mbs.bodies} | {*ends}


def is_free(mbs: m.Mbs, body: m.Body) -> bool:
    """Return whether nothing needs the body."""
    carries = body.name in {name for name, _ in places(mbs)}
    return not carries and concerned(mbs).isdisjoint(joint.name for joint in body.joints)


# --- edits of any model; one that finds nothing to change does nothing ---


def new(random: Random, word: str) -> str:
    return f"{word}_{random.randrange(10**6)}"


def vector(random: Random) -> Any:
    return tuple(random.randrange(-40, 40) / 8 for _ in range(3))


def some(random: Random, parts: Iterable[Any]) -> Any:
    parts = list(parts)
    return random.choice(parts) if parts else None


def joints(mbs: m.Mbs) -> list[m.Joint]:
    return [joint for body in mbs.bodies for joint in body.joints]


def a_value(mbs: m.Mbs, random: Random) -> None:
    """Change a number."""
    owners: list[Any] = [*mbs.bodies, mbs.base]
    choices = [(body, field) for body in mbs.bodies for field in ("mass", "com")]
    choices += [(p, "coordinates") for o in owners for p in o.points if p.name != "origin"]
    choices += [
        (shape, field) for o in owners for shape in o.shapes for field in ("rotation", "scale")
    ]
    choices += [(joint, field) for joint in joints(mbs) for field in ("q", "qd")]
    choices += [(mbs.base, "gravity")]
    part, field = random.choice(choices)
    value = vector(random)
    setattr(part, field, value if field not in ("mass", "q", "qd") else value[0])


def a_word(mbs: m.Mbs, random: Random) -> None:
    joint = some(random, joints(mbs))
    if joint:
        joint.type = random.choice(["R1", "R2", "R3", "T1", "T2", "T3"])
        joint.nature = random.choice(["independent", "dependent", "driven"])


def a_place(mbs: m.Mbs, random: Random) -> None:
    for joint in joints(mbs)[: random.randrange(3)]:
        joint.position = (float(random.randrange(900)), float(random.randrange(900)))


def body_on_a_new_point(mbs: m.Mbs, random: Random) -> None:
    on = some(random, mbs.bodies) or mbs.base
    point = m.Point(new(random, "hook"), vector(random))
    on.points.append(point)
    parent = on.name if isinstance(on, m.Body) else None
    joint, body = (new(random, word) for word in ("turn", "load"))
    mbs.bodies.append(m.Body(body, parent, point.name, [m.Joint(joint, "R2")], 1.5))
    mbs.links.append(m.Connection("link", new(random, "rope"), (body, None), (parent, point.name)))


def a_point(mbs: m.Mbs, random: Random) -> None:
    body = some(random, mbs.bodies)
    if body:
        point = m.Point(new(random, "eye"), vector(random))
        setattr(
            point, random.choice(["sensor", "extforce"]), m.Sensor(new(random, "feel"), ("Pos",))
        )
        body.points.insert(random.randrange(len(body.points) + 1), point)


def a_joint(mbs: m.Mbs, random: Random) -> None:
    body = some(random, mbs.bodies)
    if body:
        place = random.randrange(len(body.joints) + 1)
        body.joints.insert(place, m.Joint(new(random, "slide"), "T2"))


def a_shape(mbs: m.Mbs, random: Random) -> None:
    shape = m.Shape("box", "New_Shape", size=vector(random))
    (some(random, mbs.bodies) or mbs.base).shapes.append(shape)


def a_model(mbs: m.Mbs, random: Random) -> None:
    parameter = m.Parameter(new(random, "gain"), "scalar", ("0.5",))
    model = some(random, mbs.user_models)
    if model and random.random() < 0.5:
        model.parameters.append(parameter)
    else:
        mbs.user_models.append(m.UserModel(new(random, "Mine"), [parameter]))
    mbs.user_variables.append(m.UserVariable(new(random, "mine"), "in", "3"))
    if mbs.view is not None:
        light = m.Light(new(random, "lamp"), vector(random))
        mbs.view.lights.append(light)


def a_cut(mbs: m.Mbs, random: Random) -> None:
    first, second = (some(random, [None, *mbs.bodies]) for _ in range(2))
    ends = [(body.name, None) if body else (None, None) for body in (first, second)]
    mbs.cuts.append(m.Connection("rod", new(random, "rod"), *ends, 1.5))


def no_part(mbs: m.Mbs, random: Random) -> None:
    """Remove a part that nothing needs."""
    used, named = places(mbs), concerned(mbs)
    lists: list[tuple[list[Any], Any]] = []
    for body in mbs.bodies:
        lists += [(body.points, p) for p in body.points if (body.name, p.name) not in used]
        lists += [(body.shapes, shape) for shape in body.shapes]
        if len(body.joints) > 1:
            lists += [(body.joints, joint) for joint in body.joints if joint.name not in named]
        if is_free(mbs, body):
            lists.append((mbs.bodies, body))
    for parts in (mbs.cuts, mbs.links, mbs.user_models, mbs.user_variables):
        lists += [(parts, part) for part in parts]
    if lists:
        parts, part = random.choice(lists)
        parts[:] = [kept for kept in parts if kept is not part]


def sensors_change_places(mbs: m.Mbs, random: Random) -> None:
    points = [point for body in mbs.bodies for point in body.points]
    if len(points) > 1:
        points = random.sample(points, 2)
        field = random.choice(["sensor", "extforce"])
        first, second = (getattr(point, field) for point in points)
        if first and second and random.random() < 0.5:  # only their names change places
            first.name, second.name = second.name, first.name
        else:
            setattr(points[0], field, second)
            setattr(points[1], field, first)


def joint_moves(mbs: m.Mbs, random: Random) -> None:
    body = some(random, [body for body in mbs.bodies if len(body.joints) > 1])
    if body:
        joint = body.joints.pop(random.randrange(len(body.joints)))
        body = random.choice(mbs.bodies)
        body.joints.insert(random.randrange(len(body.joints) + 1), joint)


def body_moves(mbs: m.Mbs, random: Random) -> None:
    body = some(random, mbs.bodies)
    if body is None:
        return
    below = {body.name}
    for descendant in mbs.bodies:
        below |= {descendant.name} if descendant.parent in below else set()
    on = random.choice([mbs.base, *[b for b in mbs.bodies if b.name not in below]])
    body.parent = on.name if isinstance(on, m.Body) else None
    body.point = random.choice([None, *[p.name for p in on.points if p.name != "origin"]])
    mbs.bodies = mbs.depth_first()


def order(mbs: m.Mbs, random: Random) -> None:
    lists = [mbs.cuts, mbs.links, mbs.user_models]
    lists += [parts for b in mbs.bodies for parts in (b.joints, b.points, b.shapes)]
    parts: Any = some(random, [parts for parts in lists if len(parts) > 1])
    if parts:
        parts.insert(random.randrange(len(parts)), parts.pop(random.randrange(len(parts))))


def rename(mbs: m.Mbs, random: Random) -> None:
    kinds = ("body", "joint", "sensor", "point")
    entity = some(random, [entity for entity in list_entities(mbs) if entity.kind in kinds])
    if entity is None or entity.name == "origin":
        return
    rename_part(mbs, entity.part, new(random, "other"))


EDITS: list[Callable[[m.Mbs, Random], None]] = [
    a_value,
    a_word,
    a_place,
    body_on_a_new_point,
    a_point,
    a_joint,
    a_shape,
    a_model,
    a_cut,
    no_part,
    sensors_change_places,
    joint_moves,
    body_moves,
    order,
    rename,
]


def edited(data: bytes, random: Random, count: int) -> bytes:
    """Return a file with some edits, and with elements that the model does not know."""
    mbs = read_mbs(data, "base")
    for edit in random.choices(EDITS, k=count):
        edit(mbs, random)
    made = write(mbs)
    if random.random() < 0.3:
        places = [match.end() for match in re.finditer(rb"</jointname>|</bodyname>", made)]
        if places:
            place = random.choice(places)
            brake = b"<brake><force>%d</force></brake>" % random.randrange(9)
            made = made[:place] + brake + made[place:]
    return made


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
    root.append(
        etree.fromstring(
            '<link name="extra"><inertial><mass value="0.75"/><inertia ixx="1" iyy="1" izz="1" '
            'ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    )
    root.append(
        etree.fromstring(
            f'<joint name="to_extra" type="revolute"><parent link="{parent}"/><child link="extra"/>'
            '<origin xyz="0.1 0.2 0.3"/><axis xyz="0 1 0"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    )


def link_removed(root: Any, random: Random) -> None:
    parents = {joint.find("parent").get("link") for joint in root.findall("joint")}
    tied = re.findall(r"<(?:parent|child)>([^<]*)<", etree.tostring(root).decode())
    joints = [
        joint
        for joint in root.findall("joint")
        if joint.find("child").get("link") not in {*parents, *tied}
    ]
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
    heavier,
    elsewhere,
    other_limit,
    larger,
    link_added,
    link_removed,
    link_renamed,
    joint_renamed,
    other_type,
]
