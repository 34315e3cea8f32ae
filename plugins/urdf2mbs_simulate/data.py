"""MbsData: the memory that equations and user functions share, as Robotran's Python has it.

Arrays count from 1: index 0 is not used.  A body's numbers stand at its last joint.  Units are m,
kg, s, rad.  What is no attribute yet is looked for in the project's Python files: ``mbs_dirdyna``
in symbolicR, ``user_JointForces`` in userfctR.
"""

from __future__ import annotations

import math
import os
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.disk import files
from urdf2mbs.mbs.model import BASE
from urdf2mbs.mbs.reader import read


class MbsData:
    """The model of an .mbs file, and the state of its simulation."""

    math: Any = math
    """What equations in Python take sin, cos and sqrt from."""
    user_JointForces: Any  # noqa: N815  loaded when it is asked for, like all of its kind

    def __init__(
        self,
        path: str | os.PathLike[str],
        user_path: str = "userfctR",
        symbolic_path: str = "symbolicR",
    ) -> None:
        self.mbs_file = Path(path).absolute()
        self.model = files.read_model(path)
        self.said: list[str] = []
        """What a simulation takes otherwise than the .mbs has it."""
        self.mbs = mbs = read(self.model, str(path))
        for cut in [cut for cut in mbs.cuts if cut.is_draft]:
            mbs.cuts.remove(cut)
            text = f"{cut.kind} '{cut.name}' is left out: an end of it is on no body or no point"
            self.said.append(text)
        self.mbs_name = mbs.name
        self.project = files.project_of(self.mbs_file)
        self.user_path = self.project / user_path
        self.symbolic_path = self.project / symbolic_path
        self._joints()
        self._bodies_and_points()
        self._connections()
        self._user_models()
        self.outputs: dict[str, list[tuple[float, ...]]] = defaultdict(list)
        self.modules: dict[str, Any] = {}
        """Those of the project's user functions, while they do not run."""
        self.pushes: list[Any] = []
        self.push: Any = None
        """Adds their joint forces to Qq, at a time."""
        self.user_constraints: int | None = None
        """How many there are, once somebody has said it."""
        self.held: list[int] = []
        """Joints that move nothing that has mass."""
        self.can_turn, self.turned, self.own_angles = False, False, np.zeros(3)
        """Whether the base may be, and is in turned axes (``turn``), and its own angles (rad)."""
        self.process, self.flag_stop, self.DonePart, self.tsim = 0, 0, 0, 0.0

    def _joints(self) -> None:
        joints = self.mbs.joints().values()
        self.joint_id = self.mbs.numbers()
        n = self.njoint = len(joints)
        self.q, self.qd, self.qdd, self.Qq, self.Qc, self.Qa = np.zeros((6, n + 1))
        for number, joint in enumerate(joints, start=1):
            self.q[number], self.qd[number] = joint.q or 0.0, joint.qd or 0.0
            self.qdd[number] = joint.qdd or 0.0
        self.q0, self.qd0, self.qdd0 = self.q.copy(), self.qd.copy(), self.qdd.copy()
        actuated = [k for k, joint in enumerate(joints, start=1) if joint.actuated]
        self.qa = np.array([0, *actuated])
        self.natures = [joint.nature for joint in joints]
        self.divide({})

    def divide(self, changes: Mapping[int, str]) -> None:
        """Let joints be independent, dependent or driven."""
        for number, nature in changes.items():
            self.natures[number - 1] = nature
        self.qu, self.qv, self.qc = (
            np.array([0, *(k for k, nature in enumerate(self.natures, start=1) if nature == kind)])
            for kind in ("independent", "dependent", "driven")
        )
        self.nqu, self.nqv, self.nqc = (len(kind) - 1 for kind in (self.qu, self.qv, self.qc))
        self.Lambda = np.zeros(self.nqv + 1)

    def _bodies_and_points(self) -> None:
        mbs, n = self.mbs, self.njoint
        self.nbody = len(mbs.bodies)
        self.body_id = {body.name: self.joint_id[body.joints[-1].name] for body in mbs.bodies}
        self.m = np.zeros(n + 1)
        self.l, self.In = np.zeros((4, n + 1)), np.zeros((10, n + 1))
        self.frc, self.trq = np.zeros((2, 4, n + 1))
        self.g = np.array([0.0, *mbs.base.gravity])
        for body in mbs.bodies:
            last = self.body_id[body.name]
            self.m[last] = body.mass or 0.0
            self.l[1:, last] = body.com or (0.0, 0.0, 0.0)
            xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
            self.In[1:, last] = [xx, xy, xz, xy, yy, yz, xz, yz, zz]
        points = mbs.points()
        self.npt = len(points)
        self.dpt = np.zeros((4, self.npt + 1))
        self.points_id: dict[str, dict[str, int]] = {}
        self.extforce_id: dict[str, int] = {}
        self.sensor_id: dict[str, int] = {}
        forces = [0]
        for number, ((owner, _), point) in enumerate(points.items(), start=1):
            self.dpt[1:, number] = point.coordinates
            self.points_id.setdefault(owner or BASE, {})[point.name] = number
            if point.extforce is not None:
                self.extforce_id[point.extforce.name] = len(forces)
                forces.append(number)
            if point.sensor is not None:
                self.sensor_id[point.sensor.name] = len(self.sensor_id) + 1
        self.xfidpt, self.Nxfrc = np.array(forces, dtype=np.int32), len(forces) - 1
        self.SWr = np.zeros((self.Nxfrc + 1, 10))
        self.Nsensor = len(self.sensor_id)
        self.sensors = [MbsSensor(self)]
        """People append one for each sensor, and find them by their numbers, from 1."""

    def _connections(self) -> None:
        mbs = self.mbs
        self.lrod = np.array([0.0, *(cut.length or 0.0 for cut in mbs.cuts if cut.kind == "rod")])
        links, links_3d = (
            [link.name for link in mbs.links if link.kind == kind] for kind in ("link", "link3D")
        )
        self.link_id = {name: number for number, name in enumerate(links, start=1)}
        self.Nlink, self.Nlink3D = len(links), len(links_3d)
        self.Z, self.Zd, self.Fl = np.zeros((3, self.Nlink + 1))
        self.l3DWr = np.zeros((self.Nlink3D + 1, 10))

    def _user_models(self) -> None:
        """``user_model[MODEL][PARAMETER]`` is a float; a list where there are several values; of
        a state, the index of its ``ux``."""
        self.user_model: dict[str, dict[str, Any]] = {}
        states = [0.0]
        for model in self.mbs.user_models:
            values: dict[str, Any] = {}
            for parameter in model.parameters:
                try:
                    numbers = [float(value) for value in parameter.values]
                except ValueError:  # a structure of C: a type, and its header
                    continue
                found: list[Any] = list(numbers)
                if parameter.type == "state":
                    found = [len(states) + k for k in range(len(numbers))]
                    states += numbers
                values[parameter.name] = found[0] if len(found) == 1 else found
            self.user_model[model.name] = values
        self.ux, self.Nux = np.array(states), len(states) - 1
        self.ux0, self.uxd = self.ux.copy(), np.zeros(self.Nux + 1)

    def __getattr__(self, name: str) -> Any:
        """A function of the project's, loaded when it is first asked for."""
        from urdf2mbs_simulate.python_code import KNOWN, function

        if name not in KNOWN:
            raise AttributeError(f"MbsData has no attribute '{name}'")
        found = function(self, name)
        setattr(self, name, found)
        return found

    def set_nb_userc(self, count: int) -> None:
        """Say how many constraints ``user_cons_hJ`` fills."""
        self.user_constraints = count

    set_Nuserc = set_nb_userc  # noqa: N815

    def set_qu(self, joint: int) -> None:
        """Let a joint, or several, be independent."""
        self.divide(dict.fromkeys(np.atleast_1d(joint), "independent"))

    def set_qv(self, joint: int) -> None:
        """Let a joint, or several, be dependent."""
        self.divide(dict.fromkeys(np.atleast_1d(joint), "dependent"))

    def set_qdriven(self, joint: int) -> None:
        """Let a joint, or several, be driven: it stays unless ``user_DrivenJoints`` moves it."""
        self.divide(dict.fromkeys(np.atleast_1d(joint), "driven"))

    set_qc = set_qlocked = set_qdriven

    def set_qa(self, joint: int) -> None:
        """Let a joint, or several, be actuated: inverse dynamics computes its force."""
        self.qa = np.array(sorted({*self.qa, *np.atleast_1d(joint).tolist()}))

    @property
    def nqa(self) -> int:
        return len(self.qa) - 1

    def set_output(self, value: float, name: str) -> None:
        """Keep a number of the present time for the results."""
        self.outputs[name].append((self.tsim, float(value)))

    def set_output_vector(self, values: Any, name: str) -> None:
        """Keep several numbers of the present time for the results."""
        self.outputs[name].append((self.tsim, *map(float, values)))

    def define_output_vector(self, name: str, size: int) -> None:
        """Outputs need no announcement here."""


class MbsSensor:
    """The motion of a point, in the axes of the base; the rows of R are the axes of the body."""

    def __init__(self, mbs_data: MbsData, number: int | None = None) -> None:
        self._data, self._number = mbs_data, number
        self.P, self.V, self.OM, self.A, self.OMP = np.zeros((5, 4))
        self.R, self.J = np.zeros((4, 4)), np.zeros((7, mbs_data.njoint + 1))

    def comp_s_sensor(self, number: int | None = None) -> None:
        """Compute a sensor for the present state: by itself that which it was made for."""
        self._data.mbs_sensor(self, self._data, self._number if number is None else number)

    def comp_gen_sensor(self, number: int) -> None:
        """Compute the frame behind a joint for the present state."""
        self._data.mbs_gensensor(self, self._data, number)
