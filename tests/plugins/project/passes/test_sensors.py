"""Sensors: where they are, and how they are called; the oracle proves what they read."""

from pathlib import Path

import pytest

from support.plugin_files import write_plugin
from support.standin import MbsData, make
from urdf2mbs.testing import TINY, convert_text

#: The anchor point of the link ``tool`` gets a force, as a plugin may give it.
FORCED = """
from urdf2mbs.plugin import mbs
for body in conversion.mbs.bodies:
    for point in body.points:
        if point.name == "tool":
            point.extforce = mbs.Sensor("push", ("Pos",))
"""


def test_a_sensor_is_not_on_the_point_of_a_force(tmp_path: Path) -> None:
    forced = write_plugin(tmp_path, "forced", FORCED, writes=("anchors",))
    result = convert_text(
        TINY,
        plugins=[forced],
        after={"collect-anchors": "forced"},
        passes={"sensors": {"links": ["tool"]}},
    )
    points = {point.name: point for body in result.mbs.bodies for point in body.points}
    assert points["tool"].extforce is not None
    assert points["tool"].sensor is None
    assert points["tool_at"].sensor is not None
    assert points["tool_at"].coordinates == points["tool"].coordinates


def test_the_config_puts_sensors_on_links(tmp_path: Path) -> None:
    project = make(tmp_path, TINY, passes={"sensors": {"links": ["tool", "arm"]}})
    data = MbsData(project / "dataR" / "robot.mbs")
    assert data.sensor_id == {"arm_sensor": 1, "tool_sensor": 2}
    points = {b.name: [p.name for p in b.points] for b in data._run.mbs.bodies}
    assert points["hand"] == ["tool"], "the frame's own point has the sensor"
    (tool,) = [p for b in data._run.mbs.bodies for p in b.points if p.name == "tool"]
    assert set(tool.sensor.measures) == {"Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac"}


def test_sensors_of_the_urdf_have_places_and_links() -> None:
    """In SDF's words and in URDF's; a sensor without a place is where its link is; a sensor whose
    place or link cannot be read is left out, and that is said."""
    more = (
        '<gazebo reference="arm"><sensor name="sdf" type="imu"><pose>1 2 3 0 0 0</pose></sensor>'
        '<sensor name="bare" type="imu"/><sensor name="bad" type="imu"><pose>1 2 x 0 0 0</pose>'
        "</sensor></gazebo>"
        '<sensor name="urdf" type="imu"><parent link="hand"/><origin xyz="0 0 4"/></sensor>'
        '<sensor name="lost" type="imu"><parent link="nowhere"/></sensor></robot>'
    )
    result = convert_text(TINY.replace("</robot>", more))
    points = {p.sensor.name: p for b in result.mbs.bodies for p in b.points if p.sensor is not None}
    assert set(points) == {"sdf", "bare", "urdf"}
    assert points["sdf"].coordinates == (1.0, 2.0, 3.0)
    assert points["bare"].coordinates == (0.0, 0.0, 0.0)
    assert points["urdf"].coordinates == (0.0, 0.0, 4.0)
    bad, lost = [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code == "sensor-left-out"
    ]
    assert "the text of <pose> is '1 2 x 0 0 0': 'x' is not a number: sensor 'bad'" in bad.message
    assert "left out: it is on link 'nowhere', which does not exist: sensor 'lost'" in lost.message


@pytest.mark.parametrize(("apart", "count"), [(0.0, 1), (1e-9, 1), (1e-3, 2)])
def test_a_sensor_that_is_there_twice_is_one(apart: float, count: int) -> None:
    sensors = "".join(
        f'<gazebo reference="hand"><sensor name="imu" type="imu"><pose>0 0 {z} 0.5 0 0</pose>'
        "</sensor></gazebo>"
        for z in (1.0, 1.0 + apart)
    )
    result = convert_text(TINY.replace("</robot>", f"{sensors}</robot>"))
    names = [sensor["name"] for sensor in result.report.passes["sensors"]]
    assert names == ["imu", "hand_imu"][:count]


def test_a_sensor_on_what_does_not_move_is_left_out() -> None:
    sensors = {"sensors": {"links": ["body", "hand"]}}
    result = convert_text(TINY, base="fixed", pipeline="compact", passes=sensors)
    (warning,) = [
        diagnostic for diagnostic in result.diagnostics if diagnostic.code == "sensor-left-out"
    ]
    assert warning.message.endswith("no part of a moving body: body (link 'body')")
    assert [sensor["link"] for sensor in result.report.passes["sensors"]] == ["hand"]
