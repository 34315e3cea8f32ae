"""A robot that has all that a project's code does, and its project."""

from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.load import config_of
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.pipeline import Pipeline


class Asked(Conversion):
    """A conversion, and the options of its passes, which the oracle compares with."""

    asked: dict[str, Any] = {}


def link(name: str, mass: float = 0.8, more: str = "") -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.02 0.05 -0.1" rpy="0.1 0.2 0.3"/>'
        f'<mass value="{mass}"/><inertia ixx="0.04" ixy="0.001" ixz="0" iyy="0.05" iyz="0.002" '
        f'izz="0.03"/></inertial>{more}</link>'
    )


def joint(
    name: str,
    parent: str,
    axis: str,
    more: str = "",
    kind: str = "revolute",
    at: str = "0.1 0 -0.2",
    rpy: str = "0.2 0.1 -0.3",
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{at}" rpy="{rpy}"/>'
        f'<parent link="{parent}"/><child link="of_{name}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def limit(low: float, high: float) -> str:
    return f'<limit lower="{low}" upper="{high}" effort="3" velocity="2"/>'


SHAPES = (
    '<collision><origin xyz="0.02 0 -0.2" rpy="0 0.3 0"/><geometry><box size="0.2 0.1 0.02"/>'
    "</geometry></collision>"
)
RICH = (
    '<robot name="rich">'
    + link("trunk", 3.0)
    + joint(
        "leg",
        "trunk",
        "0 0 -1",
        limit(-0.5, 0.7) + '<dynamics damping="0.2" friction="0.3"/>',
        rpy="0 0 0",
    )
    + link("of_leg")
    + joint("ankle", "of_leg", "1 0 0", limit(-1, 1) + '<dynamics damping="0.1"/>')
    + link("of_ankle", 0.5, SHAPES)
    + joint("left", "trunk", "0 -1 0", limit(0.3, 0.7), at="0 0.3 0.1", rpy="0 0 0")
    + link("of_left")
    + joint(
        "right",
        "trunk",
        "-1 0 0",
        limit(-9, 9) + '<mimic joint="left" multiplier="-1.5" offset="0.1"/>',
        at="0 -0.3 0.1",
    )
    + link("of_right")
    + joint(
        "slide",
        "of_left",
        "0 0 -1",
        limit(-9, 9) + '<mimic joint="right" multiplier="0.5" offset="0.2"/>',
        "prismatic",
    )
    + link("of_slide")
    + joint(
        "tail",
        "trunk",
        "0 1 0",
        limit(-9, 9) + '<mimic joint="left" multiplier="0.7" offset="0.3"/>',
        at="-0.3 0 0",
    )
    + link("of_tail")
    + joint("arm", "trunk", "0 0 1", limit(-2, 2) + '<dynamics friction="0.05"/>', at="0.2 0.1 0.3")
    + link("of_arm", 0.4)
    + joint(
        "swing",
        "of_left",
        "-1 0 0",
        limit(-0.05, 0.4) + '<dynamics damping="0.02"/>',
        at="0.1 0.2 0.3",
        rpy="0 0 0",
    )
    + link("of_swing", 0.3)
    + '<gazebo reference="swing"><springStiffness>6</springStiffness></gazebo>'
    + '<gazebo reference="swing"><springReference value="0.15"/></gazebo>'
    + joint("roller", "trunk", "0 1 0", kind="continuous", at="-0.2 0.3 -0.8")
    + link(
        "of_roller",
        0.4,
        '<collision><origin xyz="0.01 0.02 0.03" rpy="1.5 0.1 0"/><geometry>'
        '<cylinder radius="0.1" length="0.05"/></geometry></collision>'
        '<collision><geometry><sphere radius="0.05"/></geometry></collision>',
    )
    + joint("hand", "of_arm", "0 1 0", kind="fixed", at="0.1 0 0")
    + link("of_hand", 0.3)
    + '<gazebo reference="of_hand"><sensor name="imu" type="imu"><pose>0.01 0.02 0.03 0.4 0.5 0.6'
    "</pose></sensor></gazebo>"
    + joint("eye", "of_arm", "0 1 0", kind="fixed", at="0.2 0 0.1")
    + '<link name="of_eye"/><gazebo reference="of_eye"><sensor name="gyro" type="imu">'
    "<pose>0.1 0.2 0.3 0.1 0 0.2</pose></sensor></gazebo>"
    + "".join(
        joint(f"bar{k}", parent, "0 1 0", kind="continuous", at=at) + link(f"of_bar{k}")
        for k, parent, at in (
            (1, "trunk", "0 0.5 0"),
            (2, "of_bar1", "0 0 0.3"),
            (3, "of_bar2", "0.4 0 0"),
            (4, "of_bar3", "0 0 -0.2"),
        )
    ).replace(
        'rpy="0.2 0.1 -0.3"/><parent link="trunk"/><child link="of_bar1"/>',
        '/><parent link="trunk"/><child link="of_bar1"/>',
    )
    + "</robot>"
)
PASSES: dict[str, Any] = {
    "mimic": {"joints": {"tail": "driven"}},
    "posture": {
        "joints": {"left": 0.6, "arm": 0.3, "swing": 0.2, "leg": 0.2, "ankle": 1.5},
        "hold": {
            "joints": ["leg", "arm", "ankle", "swing"],
            "frequency": 4.0,
            "gains": {"arm": {"stiffness": 30.0, "damping": 0.5}},
        },
    },
    "contacts": {
        "links": ["of_ankle"],
        "roll": ["of_roller"],
        "points": {"of_swing": [[0.1, 0.0, 0.2]]},
        "friction": 0.7,
    },
    "forces": {
        "wrenches": {
            "wind": {
                "link": "of_slide",
                "at": [0.1, 0.2, 0.3],
                "force": [1.0, 2.0, 3.0],
                "torque": [0.1, 0.2, 0.3],
                "start": 0.5,
                "stop": 1.5,
            }
        },
        "springs": {
            "rope": {
                "ends": [
                    {"link": "trunk", "at": [0.0, 0.1, 0.4]},
                    {"link": "of_left", "at": [0.1, 0.0, 0.0]},
                ],
                "stiffness": 50.0,
                "damping": 2.0,
            }
        },
    },
    "sensors": {"links": ["of_right"]},
    "force-torque": {"joints": ["hand"]},
    "loops": {
        "cuts": {
            "tie": {
                "ends": [
                    {"link": "of_bar4", "at": [0.0, 0.0, 0.0]},
                    {"link": "of_bar1", "at": [0.3, 0.0, 0.2]},
                ],
                "kind": "rod",
            }
        }
    },
}


def convert(
    folder: Path,
    passes: dict[str, Any] = PASSES,
    text: str = RICH,
    *,
    stop_after: str | None = None,
    **settings: Any,
) -> Any:
    """Make the project of a robot in a folder, in memory."""
    source = folder / "rich.urdf"
    source.write_text(text)
    values = {
        "source": str(source),
        "output": {"project": str(folder / "rich"), "language": "python"},
        "pipeline": "compact",
        "base": "floating",
        "passes": passes,
        "gravity": [0.5, -0.3, -9.7],
        "diagnostics": {"mimic-driven": "ignore", "posture-limit": "ignore"},
        **settings,
    }
    pipeline = Pipeline(*config_of(values), installed_plugins=False)
    made = msgspec.structs.asdict(pipeline.run(stop_after=stop_after))
    return Asked(**made, asked={one.pass_.name: one.pass_ for one in pipeline.passes})
