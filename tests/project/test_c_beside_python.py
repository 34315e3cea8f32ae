"""What compares C with Python finds each thing that C does otherwise, and C reads the same data.

The first needs no compiler: what stands for C is Python, with one thing changed.
"""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from laws.rich import PASSES, convert
from project.standin import make

from urdf2mbs.passes.check_code import code_of
from urdf2mbs.runtime import MbsData, MbsDirdyn
from urdf2mbs.runtime.c_code import FLAGS, CCode, compiler
from urdf2mbs.runtime.code import prove_code
from urdf2mbs.runtime.python_code import PythonCode, loaded
from urdf2mbs.testing import TINY

needs_c = pytest.mark.skipif(compiler() is None, reason="no C compiler")


class AsC(PythonCode):
    """Python that stands for the C of a project; ``change`` makes it differ."""

    change: Callable[[Any, str], None] = lambda *_: None
    """Given the data, and what has been computed: forces, accelerations, or a sensor."""
    failed = False

    def __init__(self, data: MbsData) -> None:
        super().__init__(data)
        self.at = None
        self.library = SimpleNamespace(user_JointForces=self.forces, rich_imu=self.imu)

    def forces(self, *_: Any) -> None:
        self.data.user_JointForces(self.data, 0.0)
        self.change(self.data, "forces")

    def solve(self) -> bool:
        own = super().solve()
        self.change(self.data, "accelerations")
        return own or self.failed

    def imu(self, measured: Any, number: int, _: Any, force: Any, turn: Any) -> None:
        data, sensor = self.data, measured._obj
        names = {data.sensor_id[name]: r for name, r in sys.modules["rich_robot"].SENSORS.values()}
        rot = np.reshape(names[number], (3, 3)).T @ np.array(sensor.R).reshape(4, 4)[1:, 1:]
        data.read = np.array([*rot @ (sensor.A[1:] - data.g[1:]), *rot @ sensor.OM[1:]])
        self.change(data, f"sensor {number}")
        for k in range(3):
            force[k + 1], turn[k + 1] = data.read[k], data.read[k + 3]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Any:
    conversion = convert(
        tmp_path_factory.mktemp("rich"), {**PASSES, "equations": {"language": "python"}},
        stop_after="project",
    )  # fmt: skip
    return conversion, code_of(conversion, ".py")


def add(name: str, number: int, column: int | None = None) -> Callable[[Any], None]:
    """Adds to a number of MbsData."""

    def change(data: Any) -> None:
        at = number if column is None else (number, column)
        getattr(data, name)[at] += 1e-3 * max(1.0, np.abs(getattr(data, name)[1:]).max())

    return change


def blows(data: Any) -> bool:
    return bool(0.5 <= data.tsim < 1.5)


def touches(data: Any) -> bool:
    return bool(abs(data.qd[1:]).max() < 0.1 and abs(data.SWr[1:, 3]).max() > 0.0)


def beyond(data: Any, side: int) -> bool:
    """True if the arm is beyond its upper (1) or lower limit, or at neither (0)."""
    low, high = (data.user_model[limit]["arm"] for limit in ("q_min", "q_max"))
    q = data.q[data.joint_id["arm"]]
    return int(q > high) - int(q < low) == side


#: Which call differs, how, when, and what the message names.
CHANGES: dict[str, tuple[str, Any, Any, str]] = {
    **{f"a force {side}": ("forces", add("Qq", 7), lambda d, side=side: beyond(d, side),
                           "its force in C") for side in (-1, 0, 1)},
    "the first force": ("forces", add("Qq", 1), None, "its force in C"),
    "the rate of a bristle": ("forces", add("uxd", 1), None, "the rates of bristles in C"),
    "the last rate": ("accelerations", add("uxd", -1), None, "the rates of bristles in C"),
    "q": ("accelerations", add("q", 20), None, "its q in C"),
    "qd": ("accelerations", add("qd", 20), None, "its qd in C"),
    "qdd": ("accelerations", add("qdd", 20), None, "its qdd in C"),
    "a wrench while it acts": ("accelerations", add("SWr", 1, 1), blows, "in C: is"),
    "a wrench after its end": ("accelerations", add("SWr", 1, 1), lambda d: d.tsim >= 1.5, "in C"),
    "where the ground pushes": ("accelerations", add("SWr", 1, 9), touches, "in C: is"),
    "fast": ("accelerations", add("SWr", 1, 9), lambda d: abs(d.qd[1:]).max() > 0.5, "in C: is"),
    "a spring": ("accelerations", add("Fl", 1), None, "spring 'rope' in C"),
    **{f"sensor {k + 1}": (f"sensor {k + 1}", lambda d, k=k: d.read.__setitem__(3 * k, 9.0), None,
                       "' in C: is") for k in (0, 1)},
}  # fmt: skip


@pytest.mark.parametrize("change", [None, *CHANGES])
def test_each_thing_that_c_does_otherwise_is_found(
    made: Any, change: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("urdf2mbs.runtime.code.CCode", AsC)
    named = ""
    if change is not None:
        kind, function, when, named = CHANGES[change]

        def differ(_: Any, data: Any, what: str) -> None:
            if what == kind and (when is None or when(data)):
                function(data)

        monkeypatch.setattr(AsC, "change", differ)
    proof = copy.deepcopy(made[0].proof)
    prove_code(made[0], proof, made[1], in_c=True)
    messages = [difference.message for difference in proof.differences]
    assert any(named in message for message in messages) is bool(named), messages[:3]
    assert all("in C" in message for message in messages), messages[:3]


def test_c_that_finds_no_accelerations_is_found(made: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("urdf2mbs.runtime.code.CCode", AsC)
    monkeypatch.setattr(AsC, "failed", True)
    proof = copy.deepcopy(made[0].proof)
    prove_code(made[0], proof, made[1], in_c=True)
    assert [d.message for d in proof.differences] == [
        "accelerations in C: the loops cannot be closed, as Python closes them"
    ]


# --- C itself ---


@pytest.fixture
def quick_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("urdf2mbs.runtime.c_code.FLAGS", (*FLAGS, "-O0"))


@needs_c
def test_c_has_the_numbers_of_the_model(tmp_path: Path, quick_compiler: None) -> None:
    project = make(
        tmp_path, TINY, language="c", base="fixed",
        passes={"contacts": {"links": ["hand"]}, "sensors": {"links": ["tool"]}},
    )  # fmt: skip
    data = MbsData(project / "dataR" / "robot.mbs")
    n = data.njoint
    wanted = {
        "njoint": n, "nqu": data.nqu, "nqv": data.nqv, "Nux": data.Nux, "DonePart": 1,
        "g[3]": data.g[3], f"q0[{n}]": 0.25, f"qd0[{n}]": -0.5, f"m[{n}]": data.m[n],
        f"l[3][{n}]": data.l[3, n], f"In[9][{n}]": data.In[9, n], f"qu[{data.nqu}]": data.qu[-1],
        f"dpt[1][{data.npt}]": data.dpt[1, -1], f"xfidpt[{data.Nxfrc}]": data.xfidpt[-1],
    }  # fmt: skip
    file = project / "userfctR" / "user_dirdyn.c"
    lines = "".join(f'    set_output(mbs_data->{name}, "{name}");\n' for name in wanted)
    for when in ("init", "loop", "finish"):
        begin = f"void user_dirdyn_{when}(MbsData *mbs_data, MbsDirdyn *mbs_dd)\n{{\n"
        text = file.read_text()
        assert begin in text
        own = lines if when == "init" else ""
        file.write_text(text.replace(begin, f'{begin}    set_output(1.0, "{when}");\n{own}'))
    file.write_text('#include "set_output.h"\n' + file.read_text())
    data.q[n] = data.q0[n] = 0.25
    data.qd[n] = data.qd0[n] = -0.5
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(t0=0.5, tf=0.52, language="c", save2file=0)
    results = dirdyn.run()
    for name, value in wanted.items():
        assert results.outputs[name].tolist() == [[0.5, value]], name
    for when, time in (("init", 0.5), ("finish", 0.52)):
        assert results.outputs[when].tolist() == [[time, 1.0]]
    assert 0.5 < results.outputs["loop"][0, 0] < results.outputs["loop"][-1, 0] == 0.52


@needs_c
def test_what_python_raises_under_c_ends_each_call(tmp_path: Path, quick_compiler: None) -> None:
    data = MbsData(make(tmp_path, TINY, base="fixed") / "dataR" / "robot.mbs")
    with loaded(data):
        code = CCode(data, user_in_c=False)
        code.accelerate(0.0, code.state())
        y = code.state()
        code.raised = KeyError("mine")
        for call in (
            lambda: code.accelerate(0.0, y), lambda: code.slopes(0.0, y), code.solve, code.jacobian,
        ):  # fmt: skip
            with pytest.raises(KeyError, match="mine"):
                call()
        code.in_c, code.library.call_dirdyn = True, lambda *_: None
        with pytest.raises(KeyError, match="mine"):
            code.call("user_dirdyn_loop", None)
