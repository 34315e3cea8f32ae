"""Writes an .mbs with its loops as MJCF, so that MuJoCo can compute the same motion.

A body of an .mbs has joints one after the other, each about or along an axis of the frame after
the joint before it.  MuJoCo has them in one body, too, but states their axes and points in the
frame of the body, as it is at zero::

    parent's point --[driven]--[joint a]--[driven]--[joint b]--> frame of the body
                               at T_a               at T_b       at T

Driven joints are locked at their initial position.  All others are at zero here, so the motion
between two frames is constant, and joint a is at ``inv(T) T_a``.

Cuts are equalities: a ball is a ``connect``, a solid a ``weld``, a rod a tendon between two sites
that keeps its length.  Force elements, user constraints and shapes are left out.
"""

from __future__ import annotations

import numpy as np
from lxml import etree

from support.oracle.mbs import GROUND, Body, Evaluator
from support.oracle.multibody import Array, rotation, translation

#: s
TIME_STEP = 1e-5
#: MuJoCo's equalities are soft.  These are as stiff as it allows: a time constant (s) of two time
#: steps, and the largest impedance.  They stay closed to about 1e-8 m.
STIFF = {"solref": f"{2 * TIME_STEP} 1", "solimp": "0.9999 0.9999 0.001 0.5 2"}
EQUALITIES = {"ball": "connect", "solid": "weld"}


def write_mjcf(data: bytes) -> str:
    """Return the MJCF of an .mbs, whose moving bodies all have mass and inertia.

    Its joints and bodies have the same names, and the same zero.
    """
    mbs = Evaluator(data)
    root = etree.Element("mujoco")
    _add(root, "compiler", angle="radian")
    _add(
        root,
        "option",
        gravity=mbs.gravity,
        integrator="RK4",
        timestep=TIME_STEP,
        iterations="10",
        tolerance=0,
    )
    elements = {GROUND: _add(root, "worldbody")}
    for body in mbs.bodies.values():
        if body.name != GROUND:
            elements[body.name] = _add_body(elements[str(body.parent)], mbs, body)
        for point, position in {"origin": np.zeros(3), **body.points}.items():
            _add(elements[body.name], "site", name=f"{body.name}/{point}", pos=position)
    _add_cuts(root, mbs, etree.fromstring(data))
    return etree.tostring(root, encoding="unicode")


def _add_body(parent: etree._Element, mbs: Evaluator, body: Body) -> etree._Element:
    """Add a body with its joints and its inertia."""
    attachment = mbs.bodies[str(body.parent)].points.get(str(body.point), np.zeros(3))
    pose, frames = translation(attachment), {}
    for name in body.joints:
        joint = mbs.joints[name]
        axis = np.eye(3)[int(joint.type[1]) - 1]
        if joint.nature != "driven":
            frames[name] = pose
        elif joint.type[0] == "T":
            pose = pose @ translation(joint.q * axis)
        else:
            turn = np.eye(4)
            turn[:3, :3] = rotation(axis, joint.q)
            pose = pose @ turn
    element = _add(parent, "body", name=body.name, pos=pose[:3, 3], xyaxes=pose[:3, :2].T.ravel())
    for name, frame in frames.items():
        relative, kind = np.linalg.inv(pose) @ frame, mbs.joints[name].type
        _add(
            element,
            "joint",
            name=name,
            type="slide" if kind[0] == "T" else "hinge",
            axis=relative[:3, int(kind[1]) - 1],
            pos=relative[:3, 3],
        )
    inertia = body.inertia
    if inertia.mass:
        tensor = inertia.tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        _add(element, "inertial", pos=inertia.com, mass=inertia.mass, fullinertia=tensor)
    return element


def _add_cuts(root: etree._Element, mbs: Evaluator, source: etree._Element) -> None:
    """Add the equalities of all cuts."""
    tendons, equalities = _add(root, "tendon"), _add(root, "equality")
    poses = mbs.positions({})
    for cut in source.iterfind("cuts/*"):
        ends = [
            (str(cut.findtext(f"{end}/bodyname")), str(cut.findtext(f"{end}/pointname")))
            for end in ("endpoint1", "endpoint2")
        ]
        sites = [f"{body}/{point}" for body, point in ends]
        name = str(cut.findtext("name"))
        if cut.tag in EQUALITIES:
            equality = EQUALITIES[cut.tag]
            _add(equalities, equality, name=name, site1=sites[0], site2=sites[1], **STIFF)
            continue
        tendon = _add(tendons, "spatial", name=name)
        for site in sites:
            _add(tendon, "site", site=site)
        # MuJoCo counts the length of a tendon from that at zero
        first, second = (
            poses.body(body) @ [*mbs.bodies[body].points.get(point, np.zeros(3)), 1.0]
            for body, point in ends
        )
        change = float(str(cut.findtext("length"))) - float(np.linalg.norm(second - first))
        _add(equalities, "tendon", name=name, tendon1=name, polycoef=[change, 0, 0, 0, 0], **STIFF)


def _add(
    parent: etree._Element, tag: str, **attributes: str | float | list[float] | Array
) -> etree._Element:
    """Add an element; numbers are written with all their digits."""
    element = etree.SubElement(parent, tag)
    for key, value in attributes.items():
        if not isinstance(value, str):
            value = " ".join(repr(float(number)) for number in np.atleast_1d(value))
        element.set(key, value)
    return element
