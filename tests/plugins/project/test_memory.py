"""The memory of a model, in Python and C."""

from pathlib import Path

import pytest

from support.standin import make
from urdf2mbs import ConversionError
from urdf2mbs.mbs.model import (
    BASE,
    Base,
    Body,
    Connection,
    Joint,
    Mbs,
    Parameter,
    Point,
    Sensor,
    UserModel,
)
from urdf2mbs.mbs.writer import write as write_mbs
from urdf2mbs.testing import TINY
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

needs_c = pytest.mark.skipif(compiler() is None, reason="no C compiler")


@needs_c
def test_c_has_the_numbers_of_the_model(tmp_path: Path) -> None:
    project = make(
        tmp_path,
        TINY,
        language="c",
        base="fixed",
        passes={"contacts": {"links": ["hand"]}, "sensors": {"links": ["tool"]}},
    )
    data = MbsData(project / "dataR" / "robot.mbs")
    n = data.njoint
    wanted = {
        "njoint": n,
        "nqu": data.nqu,
        "nqv": data.nqv,
        "Nux": data.Nux,
        "DonePart": 1,
        "g[3]": data.g[3],
        f"q0[{n}]": 0.25,
        f"qd0[{n}]": -0.5,
        f"m[{n}]": data.m[n],
        f"l[3][{n}]": data.l[3, n],
        f"In[9][{n}]": data.In[9, n],
        f"qu[{data.nqu}]": data.qu[-1],
        f"dpt[1][{data.npt}]": data.dpt[1, -1],
        f"xfidpt[{data.Nxfrc}]": data.xfidpt[-1],
    }
    file = project / "userfctR" / "user_dirdyn.c"
    lines = "".join(f'    set_output(mbs_data->{name}, "{name}");\n' for name in wanted)
    for when in ("init", "loop", "finish"):
        begin = f"void user_dirdyn_{when}(MbsData *mbs_data, MbsDirdyn *mbs_dd)\n{{\n"
        text = file.read_text()
        assert begin in text
        own_lines = lines if when == "init" else ""
        file.write_text(text.replace(begin, f'{begin}    set_output(1.0, "{when}");\n{own_lines}'))
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
    assert 0.5 == results.outputs["loop"][0, 0] < results.outputs["loop"][-1, 0] == 0.52


def test_the_arrays_of_a_model(tmp_path: Path) -> None:
    """Each number stands where Robotran has it: bodies at their last joint, points in order."""
    kinds = (("R1", "independent"), ("T2", "driven"), ("R3", "dependent"))
    joints = [
        Joint(f"j{k}", kind, nature, q=k / 10, qd=rate, qdd=0.7 if k == 1 else None)
        for (kind, nature), k, rate in zip(kinds, (1, 2, 3), (0.4, None, 0.6), strict=True)
    ]
    points = [Point(name, (float(k), 0.0, 0.0)) for k, name in enumerate("abcd", start=1)]
    points[2].extforce, points[3].extforce = Sensor("push"), Sensor("pull")
    points[1].sensor, points[3].sensor = Sensor("eye"), Sensor("ear")
    base = Base(gravity=(0.1, 0.2, -9.7), points=points[:1])
    body = Body(
        "one",
        BASE,
        None,
        joints=joints[:2],
        mass=2.0,
        com=(0.1, 0.2, 0.3),
        inertia=(1.0, 0.1, 0.2, 1.1, 0.3, 1.2),
        points=points[1:3],
    )
    two = Body(
        "two", "one", None, joints=joints[2:], mass=3.0, com=(0.4, 0.5, 0.6), points=points[3:]
    )
    models = [
        UserModel(
            "states",
            [Parameter("x", "state", ("0.5", "0.6")), Parameter("k", "vector", ("5", "6"))],
        ),
        UserModel(
            "more",
            [
                Parameter("y", "state", ("0.7",)),
                Parameter("s", "scalar", ("7",)),
                Parameter("c", "struct", ("Type", "type.h")),
            ],
        ),
    ]
    ends = ("one", "b"), ("two", "d")
    file = tmp_path / "arrays.mbs"
    file.write_bytes(
        write_mbs(
            Mbs(
                "arrays",
                base=base,
                bodies=[body, two],
                user_models=models,
                cuts=[Connection("ball", "x", *ends), Connection("rod", "y", *ends, 0.8)],
                links=[
                    Connection("link3D", "far", *ends),
                    Connection("link", "first", *ends),
                    Connection("link", "second", *ends),
                ],
            )
        )
    )
    data = MbsData(file)
    assert (data.link_id, data.Nlink, data.Nlink3D) == ({"first": 1, "second": 2}, 2, 1)
    assert [data.Z.shape, data.l3DWr.shape, data.lrod.tolist()] == [(3,), (2, 10), [0.0, 0.8]]
    assert (data.njoint, data.nbody, data.npt, data.Nxfrc, data.Nux) == (3, 2, 4, 2, 3)
    assert data.body_id == {"one": 2, "two": 3}
    assert data.m.tolist() == [0.0, 0.0, 2.0, 3.0]
    assert data.l[1:].T.tolist() == [[0.0] * 3, [0.0] * 3, [0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]
    assert data.In[1:, 2].tolist() == [1.0, 0.1, 0.2, 0.1, 1.1, 0.3, 0.2, 0.3, 1.2]
    assert data.points_id == {"base": {"a": 1}, "one": {"b": 2, "c": 3}, "two": {"d": 4}}
    assert data.dpt[1].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert (data.extforce_id, data.sensor_id) == ({"push": 1, "pull": 2}, {"eye": 1, "ear": 2})
    assert data.xfidpt.tolist() == [0, 3, 4]
    assert data.SWr.shape == (3, 10)
    states = data.user_model["states"]
    assert (states, data.user_model["more"]) == ({"x": [1, 2], "k": [5.0, 6.0]}, {"y": 3, "s": 7.0})
    assert data.ux.tolist() == data.ux0.tolist() == [0.0, 0.5, 0.6, 0.7]
    assert (data.q[1:].tolist(), data.qd[1:].tolist()) == ([0.1, 0.2, 0.3], [0.4, 0.0, 0.6])
    assert (data.qdd[1:].tolist(), data.qdd0[1:].tolist()) == ([0.7, 0.0, 0.0],) * 2
    assert [x.tolist() for x in (data.qu, data.qv, data.qc)] == [[0, 1], [0, 3], [0, 2]]
    assert data.g.tolist() == [0.0, 0.1, 0.2, -9.7]
    with pytest.raises(ConversionError, match="cannot read"):
        MbsData(tmp_path / "nowhere.mbs")
