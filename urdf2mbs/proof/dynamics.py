"""An .mbs as a Pinocchio model, and the equations of motion of both sides compared there.

Needs the extra ``verify`` (Pinocchio, PyPI ``pin``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lxml import etree

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.proof.pair import POSITIONS
from urdf2mbs.proof.rigid import AXES, worst
from urdf2mbs.proof.urdf_side import SIX, in_plane
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.spatial import Vec, direction
from urdf2mbs.urdf.rewrite import rename_doubled, split_balls
from urdf2mbs.xml import lines as xml_lines


def to_pinocchio(mbs: Mbs) -> Any:
    """An .mbs as a ``pinocchio.Model``: all of Pinocchio for whoever has an .mbs.

    Joints that move keep their names, each of one degree of freedom (PX PY PZ RX RY RZ), and
    stand depth first: with any other order Pinocchio's ``crba`` is wrong without a word.  A
    driven joint is held at its initial position.  Each body is a frame of its name, and so is
    each anchor point, as ``BODY/POINT``.  Units are m, kg, rad.
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
    points = mbs.points()
    for body in mbs.depth_first():
        joint, pose = at[body.parent]
        if body.point is not None:
            at_point = np.asarray(points[body.parent, body.point].coordinates)
            pose = pose * pin.SE3(np.eye(3), at_point)
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
        xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
        inertia = pin.Inertia.Zero()  # its constructor refuses an inertia of -1e-20
        inertia.mass = body.mass or 0.0
        inertia.lever = np.asarray(body.com or (0.0,) * 3)
        inertia.inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        model.appendBodyToJoint(joint, inertia, pose)
        model.addFrame(pin.Frame(body.name, joint, 0, pose, pin.FrameType.BODY))
        for point in body.points:
            there = pose * pin.SE3(np.eye(3), np.asarray(point.coordinates))
            name = f"{body.name}/{point.name}"
            model.addFrame(pin.Frame(name, joint, 0, there, pin.FrameType.OP_FRAME))
    return model


def compare_dynamics(
    urdf: bytes,
    mbs: Mbs,
    joints: Mapping[str, tuple[str, ...]],
    *,
    orders: Mapping[str, tuple[str, ...]] | None = None,
    floating_base: tuple[str, ...] = (),
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
    tolerance: float = 1e-9,
) -> tuple[list[Difference], dict[str, float]]:
    """Compare mass matrix, gravity forces and inverse dynamics of a URDF's text (read by
    Pinocchio's own parser) and an .mbs at random positions, velocities and accelerations.

    ``joints`` and ``orders`` are as for ``verify.compare``; ``floating_base`` names the six .mbs
    joints of a base that the URDF does not have itself.  Gives the differences and the largest
    deviation of each kind: an element over the square root of the mass, or the inertia, that its
    joints move, relative to the largest such element.
    """
    pin = _pinocchio()
    import numpy as np

    text, order = _elementary_urdf(urdf, joints, orders or {}, floating_base)
    one = _from_urdf(text)
    two = to_pinocchio(mbs)
    one.gravity = pin.Motion(np.asarray(gravity), np.zeros(3))
    missing = [name for name in order if not two.existJointName(name)]
    if missing or one.nv != two.nv:
        names = ", ".join(missing) or f"{two.nv} degrees of freedom instead of {one.nv}"
        told = f"the equations of motion cannot be compared: the .mbs has other joints: {names}"
        return [Difference("joint-missing", told)], {}
    first = [one.joints[one.getJointId(name)] for name in order]
    second = [two.joints[two.getJointId(name)] for name in order]
    here = [joint.idx_v for joint in first]
    there = [joint.idx_v for joint in second]
    data_one, data_two = one.createData(), two.createData()
    local = pin.Convention.LOCAL
    # no gravity force is more than this on the scale of its joint
    weight = float(np.linalg.norm(gravity) * np.sqrt(pin.computeTotalMass(one)))
    random = np.random.default_rng(20)
    largest = {"mass matrix": 0.0, "gravity forces": 0.0, "inverse dynamics": 0.0}
    at = dict.fromkeys(largest, "")
    for _ in range(POSITIONS if order else 0):
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
            "mass matrix": (pin.crba(one, data_one, q1, local)[np.ix_(here, here)],
                            pin.crba(two, data_two, q2, local)[np.ix_(there, there)]),
            "gravity forces": (pin.computeGeneralizedGravity(one, data_one, q1)[here],
                               pin.computeGeneralizedGravity(two, data_two, q2)[there]),
            "inverse dynamics": (pin.rnea(one, data_one, q1, v1, a1)[here],
                                 pin.rnea(two, data_two, q2, v2, a2)[there]),
        }  # fmt: skip
        # on the scale of what each joint moves, so that a finger counts beside the trunk
        own = np.array([_moved(data_two.Ycrb[j.id], j.shortname()) for j in second])
        own = np.maximum(own, 1e-6 * (own.max() or 1.0))
        for kind, (ours, theirs) in pairs.items():
            unit = np.outer(own, own) if ours.ndim == 2 else own
            apart = np.abs(ours - theirs) / unit
            scale = max(np.abs(ours / unit).max(), weight if ours.ndim == 1 else 0.0)
            off = worst([float(apart.max() / (scale or 1.0))])
            if off > largest[kind]:
                largest[kind] = off
                at[kind] = order[int(np.unravel_index(apart.argmax(), apart.shape)[0])]
    found = [
        Difference(kind, f"{kind}: {off:.3g} relative, most at joint '{at[kind]}'", off)
        for kind, off in largest.items()
        if not off <= tolerance
    ]
    return found, largest


def _moved(carried: Any, joint: str) -> float:
    """The square root of the mass, or the inertia about the joint, that a joint moves."""
    import numpy as np

    if joint.startswith("JointModelP"):
        return float(np.sqrt(carried.mass))
    arm = float(carried.mass * carried.lever @ carried.lever)
    return float(np.sqrt(abs(float(np.trace(carried.inertia))) + arm))


def _elementary_urdf(
    urdf: bytes,
    joints: Mapping[str, tuple[str, ...]],
    orders: Mapping[str, tuple[str, ...]],
    floating_base: tuple[str, ...],
) -> tuple[str, list[str]]:
    """The URDF with only one-axis joints, under the names that they have in the .mbs; also
    these names.

    Floating and planar joints become chains over massless links, since Pinocchio has other
    coordinates for them and ignores a planar joint's axis.  Joints that the .mbs does not have
    are held at zero.  Numbers are parted by single blanks, since urdfdom drops an
    inertial whose numbers are parted by newlines, and refuses commas.
    """
    root = etree.fromstring(urdf, xml_lines.parser(remove_comments=True))
    for element in root.iter():
        for name, value in element.attrib.items():
            if name not in ("name", "link"):
                element.set(name, " ".join(str(value).replace(",", " ").split()))
    rename_doubled(root)
    split_balls(root)
    for tag in ("visual", "collision"):
        for element in root.findall(f"link/{tag}"):
            element.getparent().remove(element)  # type: ignore[union-attr]
    own = "_"
    while any(e.get("name", "").startswith(own) for e in root):
        own += "_"
    if floating_base:
        children = {e.get("link") for e in root.findall("joint/child")}
        old = next(e.get("name") for e in root.findall("link") if e.get("name") not in children)
        etree.SubElement(root, "link", name=own)
        above = etree.SubElement(root, "joint", name=own, type="floating")
        etree.SubElement(above, "parent", link=own)
        etree.SubElement(above, "child", link=old or "")
        joints = {**joints, own: floating_base}
    order: list[str] = []
    for number, element in enumerate(root.findall("joint")):
        name, kind = element.get("name", ""), element.get("type")
        if kind == "fixed" or name not in joints:
            element.set("type", "fixed")
            element.set("name", f"{own}{number}")
            continue
        axis = element.find("axis")
        xyz = axis.get("xyz", "1 0 0") if axis is not None else "1 0 0"
        u = direction(tuple(float(word) for word in xyz.split()))  # type: ignore[arg-type]
        if kind == "floating":
            moves = [(k[0], AXES[int(k[1]) - 1]) for k in orders.get(name, SIX)]
        elif kind == "planar":
            moves = list(zip("TTR", (*in_plane(u), u), strict=True))
        else:
            moves = [("T" if kind == "prismatic" else "R", u)]
        _chain(root, element, joints[name], moves, own)
        order += joints[name]
    return etree.tostring(root, encoding="unicode"), order


def _chain(
    root: Any, joint: Any, names: tuple[str, ...], moves: list[tuple[str, Vec]], own: str
) -> None:
    """Put one-axis joints over massless links in the place of a joint."""
    before, after = joint.find("parent").get("link"), joint.find("child").get("link")
    origin = joint.find("origin")
    root.remove(joint)
    for name, (kind, axis) in zip(names, moves, strict=True):
        last = name == names[-1]
        onto = after if last else f"{own}{name}"
        if not last:
            etree.SubElement(root, "link", name=onto)
        kind = "prismatic" if kind == "T" else "continuous"
        element = etree.SubElement(root, "joint", name=name, type=kind)
        if name == names[0] and origin is not None:
            element.append(origin)
        etree.SubElement(element, "parent", link=before)
        etree.SubElement(element, "child", link=onto)
        etree.SubElement(element, "axis", xyz=" ".join(map(repr, axis)))
        if kind == "prismatic":
            etree.SubElement(element, "limit", lower="-9", upper="9", effort="1", velocity="1")
        before = onto


def _from_urdf(text: str) -> Any:
    try:
        return _pinocchio().buildModelFromXML(text)
    except (ValueError, RuntimeError) as error:
        raise ConversionError(
            "pinocchio-refused", f"Pinocchio cannot read this robot: {error}",
            hint="compare without '--engine pinocchio'",
        ) from None  # fmt: skip


def _pinocchio() -> Any:
    try:
        import pinocchio
    except ImportError:
        raise ConfigError("extra-missing", "this needs Pinocchio", hint="pip install pin") from None
    return pinocchio
