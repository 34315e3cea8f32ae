"""Loops, sensors and contacts that cannot be read: what is left out of a project, with its code."""

from __future__ import annotations

from pathlib import Path

import pytest

from urdf2mbs.config.model import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.testing import TINY

LOOP = "<parent>hand</parent><child>body</child>"
#: What is added to the tiny robot, a config of its project, and what is said.
CHANGES = {
    "a zero axis": (
        f'<gazebo><joint name="l" type="revolute">{LOOP}<axis><xyz>0 0 0</xyz></axis></joint>'
        "</gazebo>", "", "loop-left-out",
    ),
    "half a pose": (
        f'<gazebo><joint name="l" type="revolute">{LOOP}<pose>1 2</pose></joint></gazebo>', "",
        "loop-left-out",
    ),
    "no number": (
        f'<gazebo><joint name="l" type="ball">{LOOP}<pose>nan 0 0</pose></joint></gazebo>', "",
        "loop-left-out",
    ),
    "a screw": (f'<gazebo><joint name="l" type="screw">{LOOP}</joint></gazebo>', "",
                "loop-left-out"),
    "a loop about z": (f'<gazebo><joint name="l" type="revolute">{LOOP}</joint></gazebo>', "",
                       "loops"),
    "a sensor on no link": ('<gazebo reference="nobody"><sensor name="s" type="imu"/></gazebo>',
                            "", "sensor-left-out"),
    "a sensor on the ground": (
        '<link name="world"/><joint name="w" type="fixed"><parent link="world"/>'
        '<child link="body"/></joint>'
        '<gazebo reference="world"><sensor name="s" type="imu"/></gazebo>',
        "base: fixed", "sensor-left-out",
    ),
    "no mesh": (
        '<link name="foot"><collision><geometry><box size="1 1 1"/></geometry></collision>'
        '<collision><geometry><mesh filename="no.obj"/></geometry></collision></link>'
        '<joint name="f" type="fixed"><parent link="hand"/><child link="foot"/></joint>',
        "passes: {contacts: {links: [foot]}}", "contacts-mesh",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_what_is_left_out_of_a_project(name: str, tmp_path: Path) -> None:
    more, config, code = CHANGES[name]
    (tmp_path / "r.urdf").write_text(TINY.replace("</robot>", f"{more}</robot>"))
    (tmp_path / "c.yaml").write_text(f"source: r.urdf\noutput: {{project: p}}\n{config}\n")
    found = Pipeline(*load(tmp_path / "c.yaml"), installed_plugins=False).run().diagnostics
    assert code in [one.code for one in found]
