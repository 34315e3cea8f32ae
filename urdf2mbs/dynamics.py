"""An .mbs as a Pinocchio model, and the equations of motion of both sides compared there.

Needs the extra ``verify`` (Pinocchio, PyPI ``pin``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lxml import etree

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.spatial import direction
from urdf2mbs.verify import POSITIONS, Difference, in_plane


def to_pinocchio(mbs: Mbs) -> Any:
    """An .mbs as a ``pinocchio.Model``: all of Pinocchio for whoever has an .mbs.

    Joints that move keep their names, in the order of the file, each of one degree of freedom
    (PX PY PZ RX RY RZ); a driven joint is held at its initial position.  Each body is a frame of
    its name, and so is each anchor point, as ``BODY/POINT``.  Units are m, kg, rad.
    """
    pin = _pinocchio()
    import numpy as np

    kinds = {
        "T1": pin.JointModelPX, "T2": pin.JointModelPY, "T3": pin.JointModelPZ,
        "R1": pin.JointModelRX, "R2": pin.JointModelRY, "R3": pin.JointModelRZ,
    }  # fmt: skip
    axes = np.eye(3)
    model = pin.Model()
    model.name = mbs.name
    model.gravity = pin.Motion(np.asarray(mbs.base.gravity), np.zeros(3))
    # each body: the Pinocchio joint that it moves with, and its pose in that joint's frame
    at: dict[str | None, tuple[int, Any]] = {None: (0, pin.SE3.Identity())}
    points: dict[tuple[str | None, str], Any] = {
        (None, point.name): np.asarray(point.coordinates) for point in mbs.base.points
    }
    for body in mbs.bodies:
        joint, pose = at[body.parent]
        if body.point is not None:
            pose = pose * pin.SE3(np.eye(3), points[body.parent, body.point])
        for own in body.joints:
            axis = axes[int(own.type[1]) - 1]
            if own.nature != "driven":
                joint = model.addJoint(joint, kinds[own.type](), pose, own.name)
                pose = pin.SE3.Identity()
            elif own.type[0] == "T":
                pose = pose * pin.SE3(np.eye(3), (own.q or 0.0) * axis)
            else:
                turn = pin.AngleAxis(own.q or 0.0, axis).toRotationMatrix()
                pose = pose * pin.SE3(turn, np.zeros(3))
        at[body.name] = (joint, pose)
        if body.mass or body.inertia:
            xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            inertia = pin.Inertia(body.mass or 0.0, np.asarray(body.com or (0.0,) * 3), tensor)
            model.appendBodyToJoint(joint, inertia, pose)
        model.addFrame(pin.Frame(body.name, joint, 0, pose, pin.FrameType.BODY))
        for point in body.points:
            points[body.name, point.name] = np.asarray(point.coordinates)
            there = pose * pin.SE3(np.eye(3), points[body.name, point.name])
            name = f"{body.name}/{point.name}"
            model.addFrame(pin.Frame(name, joint, 0, there, pin.FrameType.OP_FRAME))
    return model


def compare_dynamics(
    urdf: bytes,
    mbs: Mbs,
    joints: Mapping[str, tuple[str, ...]],
    frozen: Mapping[str, str],
    *,
    floating_base: tuple[str, ...] = (),
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
    tolerance: float = 1e-9,
) -> tuple[list[Difference], dict[str, float]]:
    """Compare mass matrix, gravity forces and inverse dynamics of a URDF's text (read by
    Pinocchio's own parser) and an .mbs at random positions, velocities and accelerations.

    ``joints`` and ``frozen`` are as for ``verify.compare``; ``floating_base`` names the six .mbs
    joints of a base that the URDF does not have itself.  Gives the differences and the largest
    deviation of each kind, relative to the largest element.
    """
    pin = _pinocchio()
    import numpy as np

    text, order = _elementary_urdf(urdf, joints, frozen, floating_base)
    one = pin.buildModelFromXML(text)
    two = to_pinocchio(mbs)
    one.gravity = pin.Motion(np.asarray(gravity), np.zeros(3))
    missing = [name for name in order if not two.existJointName(name)]
    if missing or one.nv != two.nv:
        names = ", ".join(missing) or f"{two.nv} degrees of freedom instead of {one.nv}"
        return [Difference("joint-missing", f"the .mbs has other joints: {names}")], {}
    first = [one.joints[one.getJointId(name)] for name in order]
    second = [two.joints[two.getJointId(name)] for name in order]
    here = [joint.idx_v for joint in first]
    there = [joint.idx_v for joint in second]
    data_one, data_two = one.createData(), two.createData()
    random = np.random.default_rng(20)
    largest = {"mass matrix": 0.0, "gravity forces": 0.0, "inverse dynamics": 0.0}
    worst = dict.fromkeys(largest, "")
    for _ in range(POSITIONS):
        q, v, a = random.uniform(-np.pi, np.pi, (3, len(order)))
        q1, q2 = np.zeros(one.nq), np.zeros(two.nq)
        for value, joint in zip(q, first, strict=True):
            if joint.nq == 2:  # Pinocchio keeps a continuous joint as cosine and sine
                q1[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                q1[joint.idx_q] = value
        q2[[joint.idx_q for joint in second]] = q
        v1, v2, a1, a2 = np.zeros(one.nv), np.zeros(two.nv), np.zeros(one.nv), np.zeros(two.nv)
        v1[here], v2[there], a1[here], a2[there] = v, v, a, a
        pairs = {
            "mass matrix": (_full(pin.crba(one, data_one, q1))[np.ix_(here, here)],
                            _full(pin.crba(two, data_two, q2))[np.ix_(there, there)]),
            "gravity forces": (pin.computeGeneralizedGravity(one, data_one, q1)[here],
                               pin.computeGeneralizedGravity(two, data_two, q2)[there]),
            "inverse dynamics": (pin.rnea(one, data_one, q1, v1, a1)[here],
                                 pin.rnea(two, data_two, q2, v2, a2)[there]),
        }  # fmt: skip
        for kind, (ours, theirs) in pairs.items():
            apart = np.abs(ours - theirs)
            off = float(apart.max(initial=0.0) / (np.abs(ours).max(initial=0.0) or 1.0))
            if off > largest[kind]:
                largest[kind] = off
                worst[kind] = order[int(np.unravel_index(apart.argmax(), apart.shape)[0])]
    found = [
        Difference(kind, f"{kind}: {off:.3g} relative, most at joint '{worst[kind]}'", off)
        for kind, off in largest.items()
        if off > tolerance
    ]
    return found, largest


def _full(matrix: Any) -> Any:
    """Pinocchio fills the upper triangle only."""
    import numpy as np

    return np.triu(matrix) + np.triu(matrix, 1).T


def _elementary_urdf(
    urdf: bytes,
    joints: Mapping[str, tuple[str, ...]],
    frozen: Mapping[str, str],
    floating_base: tuple[str, ...],
) -> tuple[str, list[str]]:
    """The URDF with only one-axis joints, under the names that they have in the .mbs.

    Floating and planar joints become chains over massless links, since Pinocchio has other
    coordinates for them and ignores a planar joint's axis.  Numbers are stripped, since
    urdfdom drops an inertial whose number has a trailing newline.
    """
    root = etree.fromstring(urdf, etree.XMLParser(remove_comments=True, resolve_entities=False))
    for element in root.iter():
        for name, value in element.attrib.items():
            element.set(name, value.strip())
    for tag in ("visual", "collision"):
        for element in root.findall(f"link/{tag}"):
            element.getparent().remove(element)  # type: ignore[union-attr]
    found = [e for e in root.findall("joint") if e.get("type") is not None]
    order: list[str] = []
    x, y, z = "1 0 0", "0 1 0", "0 0 1"
    six = [("prismatic", x), ("prismatic", y), ("prismatic", z),
           ("revolute", x), ("revolute", y), ("revolute", z)]  # fmt: skip
    for element in found:
        name, kind = element.get("name", ""), element.get("type")
        for mimic in element.findall("mimic"):
            element.remove(mimic)
        if name in frozen:
            element.set("type", "fixed")
        elif kind == "floating":
            order += _chain(root, element, joints[name], six)
        elif kind == "planar":
            axis = element.find("axis")
            words = (axis.get("xyz", x) if axis is not None else x).split()
            order += _chain(root, element, joints[name], _in_plane([float(w) for w in words]))
        elif kind != "fixed":
            order += joints[name]
            element.set("name", joints[name][0])
    if floating_base:
        children = {e.get("link") for e in root.findall("joint/child")}
        old = next(e.get("name") for e in root.findall("link") if e.get("name") not in children)
        etree.SubElement(root, "link", name="_ground")
        above = etree.SubElement(root, "joint", name="_floating", type="floating")
        etree.SubElement(above, "parent", link="_ground")
        etree.SubElement(above, "child", link=old or "")
        order += _chain(root, above, floating_base, six)
    return etree.tostring(root, encoding="unicode"), order


def _in_plane(axis: list[float]) -> list[tuple[str, str]]:
    """A planar joint's shifts and turn, as ``verify`` has them."""
    n = direction((axis[0], axis[1], axis[2]))
    u, v = in_plane(n)
    words = [" ".join(repr(c) for c in w) for w in (u, v, n)]
    return [("prismatic", words[0]), ("prismatic", words[1]), ("revolute", words[2])]


def _chain(
    root: Any, joint: Any, names: tuple[str, ...], kinds: list[tuple[str, str]]
) -> tuple[str, ...]:
    """Put one-axis joints over massless links in the place of a joint."""
    before, after = joint.find("parent").get("link"), joint.find("child").get("link")
    origin = joint.find("origin")
    root.remove(joint)
    for number, (name, (kind, axis)) in enumerate(zip(names, kinds, strict=True)):
        last = number == len(names) - 1
        onto = after if last else f"_{name}"
        if not last:
            etree.SubElement(root, "link", name=onto)
        element = etree.SubElement(root, "joint", name=name, type=kind)
        if number == 0 and origin is not None:
            element.append(origin)
        etree.SubElement(element, "parent", link=before)
        etree.SubElement(element, "child", link=onto)
        etree.SubElement(element, "axis", xyz=axis)
        etree.SubElement(element, "limit", lower="-9", upper="9", effort="1", velocity="1")
        before = onto
    return names


def _pinocchio() -> Any:
    try:
        import pinocchio
    except ImportError:
        raise ConfigError(
            "extra-missing", "this needs Pinocchio", hint="pip install 'urdf2mbs[verify]'"
        ) from None
    return pinocchio
