"""The code of a Robotran project, in Python (``python``) and in C (``c``).

``templates`` holds the files that are written once and are the user's from then on, where they lie
in the project; most user functions are there as a title and code.  In all of them ``NAME`` stands
for the project's name.
"""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations import equations_fit

#: Stands for the name of the project, alone or in NAME_robot.
NAME = re.compile(r"(?<![A-Z])NAME(?![A-Z])")

FOLDER = Path(__file__).parent

#: The test whether equations fit the .mbs, by language; a project gets these files as they are.
EQUATIONS_FIT = {
    "python": [Path(equations_fit.__file__)],
    "c": sorted(Path(equations_fit.__file__).parent.glob("equations_fit*.[ch]")),
}

YOURS = "Yours to change: urdf2mbs wrote this file once, and will not touch it again."
#: What user functions begin with whose template is a title and code; in Python those that use the
#: robot.
INCLUDES = """\
#include <math.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "user_all_id.h"
#include "user_model.h"
#include "NAME_robot.h"
"""
IMPORTS = """\
import os
import sys

# find NAME_robot.py beside this file, whatever the folder that Python was started in
if "__file__" in globals():
    sys.path.append(os.path.dirname(os.path.abspath(__file__)))

import NAME_robot as robot

"""
#: What user_JointForces says where a controller holds the start position.
HOLD = {
    "python": """\
    #
    # The controller 'hold' pulls at the joints, too.  To end it, write in user_dirdyn_init:
    #     mbs_data.user_model["hold"]["on"] = 0.0
    # or, for one joint alone:
    #     mbs_data.user_model["hold_stiffness"]["@JOINT@"] = 0.0
    #     mbs_data.user_model["hold_damping"]["@JOINT@"] = 0.0
""",
    "c": """\
     *
     * The controller 'hold' pulls at the joints, too. To end it, write in user_dirdyn_init:
     *   mbs_data->user_model->hold.on = 0.0;
     * or, for one joint alone:
     *   mbs_data->user_model->hold_stiffness.@JOINT@ = 0.0;
     *   mbs_data->user_model->hold_damping.@JOINT@ = 0.0;
""",
}
#: What user_dirdyn_loop says where the robot has sensors.
IMU = {
    "python": """\
    # force, turn = robot.imu(mbs_data, "@SENSOR@")
    # mbs_data.set_output(force[2], "@SENSOR@_z")
""",
    "c": """\
    /* MbsSensor *sensor = mbs_dd->mbs_aux->psens;
     * double force[4], turn[4];
     * mbs_sensor(sensor, mbs_data, @SENSOR@_id);
     * @NAME@_imu(sensor, @SENSOR@_id, mbs_data, force, turn);
     * set_output(force[3], "@SENSOR@_z"); */
""",
}


def starters(language: str, mbs: Mbs) -> dict[str, bytes]:
    """The files that are written once, by their path in the project."""
    folder = FOLDER / "templates" / language
    held = next((model for model in mbs.user_models if model.name == "hold_stiffness"), None)
    moving = [parameter.name for parameter in held.parameters] if held else plotted(mbs)
    joint = next((name for name in moving if name not in dependent(mbs)), "JOINT")
    hold = HOLD[language] if held else ""
    sensor = next((p.sensor.name for p in mbs.points().values() if p.sensor is not None), "")
    imu = IMU[language].replace("@SENSOR@", sensor).replace("@NAME@", mbs.name) if sensor else ""
    return {
        file.relative_to(folder).as_posix().removesuffix(".in"): fill(file, mbs.name)
        .replace("@HOLD@\n", hold)
        .replace("@IMU@\n", imu)
        .replace("@JOINT@", joint)
        .encode()
        for file in sorted(folder.rglob("*.in"))
    }


def fill(file: Path, name: str) -> str:
    """A template with the project's name in it."""
    text = file.read_text("utf-8")
    title, _, code = text.partition("\n\n")
    if not file.name.startswith("user_") or "\n" in title:
        return NAME.sub(name, text)  # it is whole
    if ".c" in file.suffixes:
        gap = "" if code.startswith("#include") else "\n"
        text = f"/* {title}\n *\n * {YOURS} */\n{INCLUDES}{gap}{code}"
    else:
        imports = IMPORTS if "robot." in code else ""
        text = f'"""{title}\n\n{YOURS}\n"""\n\n{imports}\n{code}'
    return NAME.sub(name, text)


def dependent(mbs: Mbs) -> list[str]:
    """The joints that the partition takes for dependent ones."""
    joints = (joint for body in mbs.bodies for joint in body.joints)
    return [joint.name for joint in joints if joint.nature == "dependent"]


def plotted(mbs: Mbs) -> list[str]:
    """The joints that move, without the six of a floating base unless there are no others."""
    moving = [
        joint.name for body in mbs.bodies for joint in body.joints if joint.nature != "driven"
    ]
    base = [
        joint.name
        for body in mbs.bodies
        if body.parent is None and len(body.joints) == 6
        for joint in body.joints
        if joint.nature == "independent"
    ]
    return [name for name in moving if name not in base] or moving
