"""An .mbs as a Pinocchio model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from urdf2mbs.mbs.model import Mbs


def to_pinocchio(mbs: Mbs) -> Any:
    """An .mbs as a ``pinocchio.Model``: all of Pinocchio for whoever has an .mbs.

    Joints that move keep their names, each of one degree of freedom (PX PY PZ RX RY RZ), and
    stand depth first: with any other order Pinocchio's ``crba`` is wrong without a word.  A
    driven joint is held at its initial position.  Each body is a frame of its name, and so is
    each anchor point, as ``BODY/POINT``.  Units are m, kg, rad.
    """
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
