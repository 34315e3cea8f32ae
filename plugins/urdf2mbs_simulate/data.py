"""MbsData: the data that equations and user functions share, as Robotran's Python has it.

Arrays count from 1: index 0 is not used.  The numbers of a body are those of its last joint: a body
with two joints fills one column of m, l and In.  Units are m, kg, s, rad.  What the runtime adds to
Robotran's names is in ``_run``: all other names are the user's.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.plugin import BASE, Mbs, files, read_mbs

#: Returns a function of a project's Python files by its name, or None for any other name.
Loader = Callable[["MbsData", str], Any]


class RunState:
    """What a simulation adds to a model beside Robotran's names, which are the user's, too."""

    def __init__(self, path: str | os.PathLike[str], loader: Loader | None) -> None:
        self.file = Path(path).absolute()
        self.source: bytes = files.read_model(path)
        """The bytes of the .mbs."""
        self.mbs: Mbs = read_mbs(self.source, str(path))
        self.project = files.project_of(self.file)
        self.loader = loader
        self.notes: list[str] = []
        """Where the simulation departs from the .mbs."""
        self.natures: list[str] = []
        """Of the joints: independent, dependent or driven."""
        self.user_constraints: int | None = None
        """How many there are; None until ``set_nb_userc`` was called."""
        self.locked: list[int] = []
        """Joints at a constant position, as they move no mass."""
        self.pushes: list[Any] = []
        self.modules: dict[str, Any] = {}
        """Those of the project's user functions, while they do not run."""
        self.outputs: dict[str, list[tuple[float, ...]]] = {}
        """By name: a time and values for each frame."""
        self.new_outputs: dict[str, tuple[float, ...]] = {}
        """By name: what user code has given to set_output since the last frame."""
        self.is_recording = True
        """False in the trial states of an integrator, whose outputs are dropped."""
        self.on_compile: Callable[[int, int], None] | None = None
        """Called with the numbers of compiled files and of all files of C."""

    def store_outputs(self, time: float) -> None:
        """Store what user code has given to set_output as the values of a frame."""
        for name, values in self.new_outputs.items():
            self.outputs.setdefault(name, []).append((time, *values))
        self.new_outputs.clear()


class MbsData:
    """The model of an .mbs file, and the state of its simulation."""

    math: Any = math
    """The module with sin, cos and sqrt for equations in Python."""
    user_JointForces: Any  # noqa: N815  Robotran's name; loaded when it is first used

    def __init__(
        self,
        path: str | os.PathLike[str],
        user_path: str = "userfctR",
        symbolic_path: str = "symbolicR",
        *,
        loader: Loader | None = None,
    ) -> None:
        self._run = run = RunState(path, loader)
        for cut in [cut for cut in run.mbs.cuts if cut.is_draft]:
            run.mbs.cuts.remove(cut)
            note = f"{cut.kind} '{cut.name}' is left out: an end of it is on no body or no point"
            run.notes.append(note)
        self.mbs_name = run.mbs.name
        self.user_path = run.project / user_path
        self.symbolic_path = run.project / symbolic_path
        self._init_joints()
        self._init_bodies()
        self._init_points()
        self._init_connections()
        self._init_user_models()
        self.process, self.flag_stop, self.DonePart, self.tsim = 0, 0, 0, 0.0

    def _init_joints(self) -> None:
        joints = self._run.mbs.joints().values()
        self.joint_id = self._run.mbs.numbers()
        n = self.njoint = len(joints)
        self.q, self.qd, self.qdd, self.Qq, self.Qc, self.Qa = np.zeros((6, n + 1))
        for number, joint in enumerate(joints, start=1):
            self.q[number], self.qd[number] = joint.q or 0.0, joint.qd or 0.0
            self.qdd[number] = joint.qdd or 0.0
        self.q0, self.qd0, self.qdd0 = self.q.copy(), self.qd.copy(), self.qdd.copy()
        actuated = [k for k, joint in enumerate(joints, start=1) if joint.actuated]
        self.qa = np.array([0, *actuated])
        self._run.natures = [joint.nature for joint in joints]
        self.set_natures({})

    def set_natures(self, changes: Mapping[int, str]) -> None:
        """Set joints independent, dependent or driven, by their numbers."""
        for number, nature in changes.items():
            self._run.natures[number - 1] = nature
        self.qu, self.qv, self.qc = (
            np.array(
                [0, *(k for k, nature in enumerate(self._run.natures, start=1) if nature == kind)]
            )
            for kind in ("independent", "dependent", "driven")
        )
        self.nqu, self.nqv, self.nqc = (len(kind) - 1 for kind in (self.qu, self.qv, self.qc))
        self.Lambda = np.zeros(self.nqv + 1)

    def _init_bodies(self) -> None:
        mbs, n = self._run.mbs, self.njoint
        self.nbody = len(mbs.bodies)
        self.body_id = {body.name: self.joint_id[body.joints[-1].name] for body in mbs.bodies}
        self.m = np.zeros(n + 1)
        self.l, self.In = np.zeros((4, n + 1)), np.zeros((10, n + 1))
        self.frc, self.trq = np.zeros((2, 4, n + 1))
        self.g = np.array([0.0, *mbs.base.gravity])
        for body in mbs.bodies:
            number = self.body_id[body.name]
            self.m[number] = body.mass or 0.0
            self.l[1:, number] = body.com or (0.0, 0.0, 0.0)
            xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
            self.In[1:, number] = [xx, xy, xz, xy, yy, yz, xz, yz, zz]

    def _init_points(self) -> None:
        points = self._run.mbs.points()
        self.npt = len(points)
        self.dpt = np.zeros((4, self.npt + 1))
        self.points_id: dict[str, dict[str, int]] = {}
        self.extforce_id: dict[str, int] = {}
        self.sensor_id: dict[str, int] = {}
        force_points = [0]
        for number, ((body, _), point) in enumerate(points.items(), start=1):
            self.dpt[1:, number] = point.coordinates
            self.points_id.setdefault(body or BASE, {})[point.name] = number
            if point.extforce is not None:
                self.extforce_id[point.extforce.name] = len(force_points)
                force_points.append(number)
            if point.sensor is not None:
                self.sensor_id[point.sensor.name] = len(self.sensor_id) + 1
        self.xfidpt, self.Nxfrc = np.array(force_points, dtype=np.int32), len(force_points) - 1
        self.SWr = np.zeros((self.Nxfrc + 1, 10))
        self.Nsensor = len(self.sensor_id)
        self.sensors = [MbsSensor(self)]
        """User code appends one for each sensor, and uses them by their numbers, from 1."""

    def _init_connections(self) -> None:
        mbs = self._run.mbs
        self.lrod = np.array([0.0, *(cut.length or 0.0 for cut in mbs.cuts if cut.kind == "rod")])
        links, links_3d = (
            [link.name for link in mbs.links if link.kind == kind] for kind in ("link", "link3D")
        )
        self.link_id = {name: number for number, name in enumerate(links, start=1)}
        self.Nlink, self.Nlink3D = len(links), len(links_3d)
        self.Z, self.Zd, self.Fl = np.zeros((3, self.Nlink + 1))
        self.l3DWr = np.zeros((self.Nlink3D + 1, 10))

    def _init_user_models(self) -> None:
        """Set ``user_model[MODEL][PARAMETER]``, and the user states.

        A parameter is a float, or a list where it has several values; a state is the index of its
        ``ux``.
        """
        self.user_model: dict[str, dict[str, Any]] = {}
        states = [0.0]
        for model in self._run.mbs.user_models:
            parameters: dict[str, Any] = {}
            for parameter in model.parameters:
                try:
                    numbers = [float(value) for value in parameter.values]
                except ValueError:  # a structure of C: a type, and its header
                    continue
                values: list[Any] = list(numbers)
                if parameter.type == "state":
                    values = [len(states) + k for k in range(len(numbers))]
                    states += numbers
                parameters[parameter.name] = values[0] if len(values) == 1 else values
            self.user_model[model.name] = parameters
        self.ux, self.Nux = np.array(states), len(states) - 1
        self.ux0, self.uxd = self.ux.copy(), np.zeros(self.Nux + 1)

    def __getattr__(self, name: str) -> Any:
        """Return a function of the project, which is loaded when it is first used."""
        loader = self._run.loader if name.startswith(("mbs_", "user_")) else None
        function = loader(self, name) if loader else None
        if function is None:
            raise AttributeError(f"MbsData has no attribute '{name}'")
        setattr(self, name, function)
        return function

    def set_nb_userc(self, count: int) -> None:
        """Set how many constraints ``user_cons_hJ`` fills."""
        self._run.user_constraints = count

    set_Nuserc = set_nb_userc  # noqa: N815

    def set_qu(self, joint: int) -> None:
        """Set a joint, or several, independent."""
        self.set_natures(dict.fromkeys(np.atleast_1d(joint), "independent"))

    def set_qv(self, joint: int) -> None:
        """Set a joint, or several, dependent."""
        self.set_natures(dict.fromkeys(np.atleast_1d(joint), "dependent"))

    def set_qdriven(self, joint: int) -> None:
        """Set a joint, or several, driven: constant unless ``user_DrivenJoints`` moves it."""
        self.set_natures(dict.fromkeys(np.atleast_1d(joint), "driven"))

    set_qc = set_qlocked = set_qdriven

    def set_qa(self, joint: int) -> None:
        """Set a joint, or several, actuated: inverse dynamics computes its force."""
        self.qa = np.array(sorted({*self.qa, *np.atleast_1d(joint).tolist()}))

    @property
    def nqa(self) -> int:
        """The number of actuated joints."""
        return len(self.qa) - 1

    def set_output(self, value: float, name: str) -> None:
        """Record a number of the present time for the results."""
        self.set_output_vector([value], name)

    def set_output_vector(self, values: Any, name: str) -> None:
        """Record several numbers for the results; the last ones of each frame are kept."""
        if self._run.is_recording:
            self._run.new_outputs[name] = tuple(map(float, values))

    def define_output_vector(self, name: str, size: int) -> None:
        """Do nothing: outputs need no announcement here."""


class MbsSensor:
    """The motion of a point, in the axes of the base.

    P, V, A: position, velocity, acceleration (m, s); R: its rows are the axes of the body; OM, OMP:
    angular velocity and acceleration; J: the Jacobian (7, joints + 1), translation first.
    """

    def __init__(self, mbs_data: MbsData, number: int | None = None) -> None:
        self._data, self._number = mbs_data, number
        self.P, self.V, self.OM, self.A, self.OMP = np.zeros((5, 4))
        self.R, self.J = np.zeros((4, 4)), np.zeros((7, mbs_data.njoint + 1))

    def comp_s_sensor(self, number: int | None = None) -> None:
        """Compute a sensor for the present state.

        Args:
            number: Of the sensor; by default, the one given at construction.
        """
        self._data.mbs_sensor(self, self._data, self._number if number is None else number)

    def comp_gen_sensor(self, number: int) -> None:
        """Compute the frame after a joint for the present state."""
        self._data.mbs_gensensor(self, self._data, number)
