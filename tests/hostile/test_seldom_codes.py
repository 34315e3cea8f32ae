"""Codes that only odd robots and broken surroundings bring about."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from urdf2mbs.api import convert
from urdf2mbs.engine.config import Lines
from urdf2mbs.many.convert import jobs_of
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic
from urdf2mbs.testing import TINY


def told(found: list[Diagnostic], code: str) -> list[Diagnostic]:
    return [one for one in found if one.code == code]


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    (tmp_path / "tiny.urdf").write_text(TINY)
    return tmp_path / "tiny.urdf"


def with_collision(tiny: Path, mesh: bytes | None) -> Path:
    """The tiny robot, whose hand collides by a mesh."""
    text = TINY.replace(
        '<link name="hand">',
        '<link name="hand"><collision><geometry><mesh filename="hand.obj"/></geometry></collision>',
    )
    assert text != TINY
    tiny.write_text(text)
    if mesh is not None:
        (tiny.parent / "hand.obj").write_bytes(mesh)
    return tiny


@pytest.mark.parametrize("mesh", [None, b"", b"v 0 0 0\nf 1 2 3\n"])
def test_contacts_of_a_mesh_that_cannot_be_used(tiny: Path, mesh: bytes | None) -> None:
    given = {"contacts": {"links": ["hand"], "points": {"hand": [[0, 0, 1]]}}}
    with_collision(tiny, mesh)
    assert not told(convert(tiny, passes=given).diagnostics, "contacts-mesh")
    result = convert(tiny, passes={"contacts": {"links": ["hand"]}})
    found = told(result.diagnostics, "contacts-mesh")
    assert [one.link for one in found] == ["hand"]
    assert "'hand.obj' cannot be used" in found[0].message


def test_a_sensor_on_no_link_and_one_on_the_base(tiny: Path) -> None:
    def sensor(link: str, name: str) -> str:
        return f'<gazebo reference="{link}"><sensor name="{name}" type="imu"/></gazebo>'

    more = sensor("nobody", "lost") + sensor("world", "still") + sensor("hand", "good")
    more += (
        '<link name="world"/><joint name="w" type="fixed"><parent link="world"/>'
        '<child link="body"/></joint>'
    )
    tiny.write_text(TINY.replace("</robot>", f"{more}</robot>"))
    result = convert(tiny, base="fixed", output={"project": tiny.parent / "p"})
    found = [one.message for one in told(result.diagnostics, "sensor-left-out")]
    assert any("'lost' is left out: it is on link 'nobody'" in one for one in found), found
    assert any("still (link 'world')" in one for one in found), found
    assert [one["name"] for one in result.report.passes["sensors"]] == ["good"]


def test_a_part_of_a_mesh(tiny: Path) -> None:
    visual = '<visual><geometry><mesh filename="hand.obj"/></geometry></visual>'
    tiny.write_text(TINY.replace('<link name="hand">', f'<link name="hand">{visual}'))
    (tiny.parent / "hand.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 nan\nf 1 2 3\nf 1 2 4")
    found = told(convert(tiny, output={"project": tiny.parent / "p"}).diagnostics, "mesh-part")
    assert len(found) == 1
    assert "a coordinate of 1 triangle" in found[0].message
    assert found[0].message.endswith("mesh hand.obj")


def test_a_cluster_whose_workers_cannot_convert(
    tiny: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stand-in for Dask, whose workers have no urdf2mbs, or are killed."""

    class KilledWorkerError(Exception):
        pass

    failures = [ModuleNotFoundError("No module named 'urdf2mbs'"), KilledWorkerError("worker")]

    class Client:
        loop = None

        def __init__(self, address: str, **_: Any) -> None:
            assert address == "tcp://here:1"

        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def map(self, work: Any, jobs: list[Any], pure: bool) -> list[Any]:
            return [
                SimpleNamespace(key=n, exception=lambda n=n: failures[n]) for n in range(len(jobs))
            ]

    module = SimpleNamespace(
        Client=Client, KilledWorker=KilledWorkerError,
        as_completed=lambda futures, loop: iter(list(futures)),
    )  # fmt: skip
    monkeypatch.setitem(sys.modules, "distributed", module)  # type: ignore[arg-type]
    from urdf2mbs.engine.config import Config, typed
    from urdf2mbs.many.cluster import on_cluster

    config = typed(Config, {"source": str(tiny)}, Lines())
    other = typed(Config, {"source": str(tiny), "output": "b.mbs"}, Lines())
    jobs = list(jobs_of([(config, Lines()), (other, Lines())]))
    found = [outcome.error for outcome in on_cluster(jobs, "tcp://here:1")]
    assert [error.code for error in found if error] == ["cluster-failed", "worker-died"]
    assert found[0] is not None
    assert "No module named 'urdf2mbs'" in found[0].message


def test_errors_of_several_kinds_are_told_together(tmp_path: Path) -> None:
    """In the order of the file, each with its line; the tree is judged when these are mended."""
    file = tmp_path / "r.urdf"
    inertial = '<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0"'
    lines = [
        '<robot name="r">',
        f'<link name="a">{inertial.format("1")} izz="one"/></inertial></link>',
        f'<link name="b">{inertial.format("")} izz="1"/></inertial></link>',
        '<link name="c"/><link name="c"><visual/></link>',
        "<link/>",
        '<joint name="j" type="hinge"><parent link="a"/><child link="b"/></joint>',
        '<joint name="k" type="revolute"><parent link="a"/><child link="nobody"/></joint>',
        '<joint name="l" type="revolute"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 0"/><limit effort="1" velocity="1"/></joint>',
        '<joint name="m" type="fixed"><child link="b"/></joint>',
        '<joint name="n" type="fixed"><parent link="a"/><child link="b"/>'
        '<origin xyz="1 2"/></joint>',
        "</robot>",
    ]
    file.write_text("\n".join(lines))
    with pytest.raises(ConversionError) as caught:
        convert(file)
    error = caught.value
    found = [*(one for one in error.said if one.level == "error"), error.diagnostic()]
    assert [(one.line, one.code) for one in found] == [
        (2, "number-invalid"), (3, "number-missing"), (4, "name-doubled"), (5, "name-missing"),
        (6, "joint-type-unknown"), (8, "axis-zero"),
        (9, "joint-link-missing"), (10, "number-count"),
    ]  # fmt: skip
    assert str(error).count("error[") == len(found)
