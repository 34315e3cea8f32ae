"""A project in C: its memory, and what Python raises under it."""

from __future__ import annotations

from pathlib import Path

import pytest
from project.standin import make

from urdf2mbs.runtime import MbsData, MbsDirdyn
from urdf2mbs.runtime.c_code import FLAGS, CCode, compiler
from urdf2mbs.runtime.python_code import loaded
from urdf2mbs.testing import TINY

needs_c = pytest.mark.skipif(compiler() is None, reason="no C compiler")


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
