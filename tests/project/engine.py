"""Direct dynamics as Robotran does it, with Pinocchio in the place of the generated equations.

Mass matrix, bias forces and the motion of points are Pinocchio's; everything else (constraints,
joint forces, external forces) is what the generated user functions say.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin
from project.standin import BOUND, MbsData

from urdf2mbs.proof.dynamics import to_pinocchio


class Engine:
    """Of a project's data and user functions; states are numpy arrays by joint number - 1."""

    def __init__(self, data: MbsData, user: dict[str, ModuleType]) -> None:
        self.data, self.user = data, user
        self.model = to_pinocchio(data.mbs)
        self.pin = self.model.createData()
        joints = [joint for body in data.mbs.bodies for joint in body.joints]
        names = [joint.name for joint in joints]
        #: Joint numbers - 1 in Pinocchio's order.
        self.moving = [names.index(name) for name in list(self.model.names)[1:]]
        assert [j.idx_v for j in self.model.joints[1:]] == list(range(len(self.moving)))
        kinds = [joints[k].nature for k in self.moving]
        self.free = [k for k, kind in enumerate(kinds) if kind == "independent"]
        self.bound = [k for k, kind in enumerate(kinds) if kind == "dependent"]
        self.frames = [
            self.model.getFrameId(f"{owner}/{point.name}") for _, owner, point in data.forces
        ]
        self.bodies = [self.model.getFrameId(owner) for _, owner, _ in data.forces]
        #: The views that user functions fill.
        n = data.constraints or 0
        self.h, self.jac, self.jdqd = (
            np.zeros(n + 1),
            np.zeros((n + 1, data.njoint + 1)),
            np.zeros(n + 1),
        )
        # the checks of the stand-in's arrays would take most of the time
        for name in BOUND:
            object.__setattr__(data, name, np.asarray(getattr(data, name)))
        self.q, self.v = data.q[1:], data.qd[1:]
        self.P, self.V, self.OM, self.none = (np.zeros(4) for _ in range(4))
        self.R = np.zeros((4, 4))

    def start(self) -> tuple[Any, Any]:
        """Position and velocity of the moving joints at the start."""
        return (
            self.data.q0[1:][self.moving].copy(),
            self.data.qd[1:][self.moving].copy(),
        )

    def put(self, q: Any, v: Any) -> None:
        """Hand a state to the data, as Robotran does before it calls user functions."""
        self.q[self.moving] = q
        self.v[self.moving] = v

    def constrain(self) -> tuple[Any, Any]:
        """h and its Jacobian by the moving joints."""
        self.user["user_cons_hJ"].user_cons_hJ(self.h, self.jac, self.data, 0.0)
        return self.h[1:].copy(), self.jac[1:, 1:][:, self.moving].copy()

    def close(self, q: Any, v: Any) -> tuple[Any, Any]:
        """The state with its dependent joints solved for."""
        q, v = q.copy(), v.copy()
        if not self.bound:
            return q, v
        for _ in range(100):
            self.put(q, v)
            h, jac = self.constrain()
            if np.abs(h).max() <= 1e-12:
                break
            q[self.bound] -= np.linalg.solve(jac[:, self.bound], h)
        v[self.bound] = -np.linalg.solve(jac[:, self.bound], jac[:, self.free] @ v[self.free])
        return q, v

    def forces(self, q: Any, v: Any, t: float) -> Any:
        """External and joint forces, on the moving joints."""
        data, model = self.data, self.model
        force = np.zeros(model.nv)
        if self.frames:
            pin.forwardKinematics(model, self.pin, q, v, np.zeros(model.nv))
            pin.computeJointJacobians(model, self.pin, q)
            pin.updateFramePlacements(model, self.pin)
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        for number, (frame, body) in enumerate(zip(self.frames, self.bodies, strict=True), 1):
            at, moves = self.pin.oMf[frame], pin.getFrameVelocity(model, self.pin, frame, world)
            self.P[1:], self.V[1:], self.OM[1:] = at.translation, moves.linear, moves.angular
            self.R[1:, 1:] = at.rotation.T
            row = self.user["user_ExtForces"].user_ExtForces(
                self.P, self.R, self.V, self.OM, self.none, self.none, data, t, number
            )
            F, M, d = (row[k : k + 3] for k in (1, 4, 7))
            if F.any() or M.any():
                # the point of application is in the axes of the body, from the body frame
                origin = self.pin.oMf[body]
                arm = origin.translation + origin.rotation @ d - at.translation
                jacobian = pin.getFrameJacobian(model, self.pin, frame, world)
                force += jacobian[:3].T @ F + jacobian[3:].T @ (M + np.cross(arm, F))
        data.Qq[1:] = 99.0  # what was there before counts for nothing
        self.user["user_JointForces"].user_JointForces(data, t)
        return force + data.Qq[1:][self.moving]

    def accelerate(self, q: Any, v: Any, t: float) -> Any:
        """qdd of all moving joints, the dependent ones by the constraints."""
        self.put(q, v)
        bias = pin.nonLinearEffects(self.model, self.pin, q, v)
        mass = pin.crba(self.model, self.pin, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        right = self.forces(q, v, t) - bias
        if not self.bound:
            return np.linalg.solve(mass, right)
        _, jac = self.constrain()
        self.user["user_cons_jdqd"].user_cons_jdqd(self.jdqd, self.data)
        solve = np.linalg.solve
        reduced = np.zeros((self.model.nv, len(self.free)))
        reduced[self.free] = np.eye(len(self.free))
        reduced[self.bound] = -solve(jac[:, self.bound], jac[:, self.free])
        rest = np.zeros(self.model.nv)
        rest[self.bound] = -solve(jac[:, self.bound], self.jdqd[1:])
        free = solve(reduced.T @ mass @ reduced, reduced.T @ (right - mass @ rest))
        return reduced @ free + rest

    def run(self, seconds: float, step: float) -> tuple[Any, Any]:
        """Runge-Kutta 4 from the start; returns position and velocity at the end."""
        q, v = self.close(*self.start())
        for k in range(round(seconds / step)):
            t = k * step
            a1 = self.accelerate(q, v, t)
            q2, v2 = self.close(q + step / 2 * v, v + step / 2 * a1)
            a2 = self.accelerate(q2, v2, t + step / 2)
            q3, v3 = self.close(q + step / 2 * v2, v + step / 2 * a2)
            a3 = self.accelerate(q3, v3, t + step / 2)
            q4, v4 = self.close(q + step * v3, v + step * a3)
            a4 = self.accelerate(q4, v4, t + step)
            q, v = self.close(
                q + step / 6 * (v + 2 * v2 + 2 * v3 + v4),
                v + step / 6 * (a1 + 2 * a2 + 2 * a3 + a4),
            )
            assert np.isfinite(q).all(), f"it exploded at {t} s"
        return q, v
