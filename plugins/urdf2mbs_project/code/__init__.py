"""The code of a Robotran project, in Python (``python``) and in C (``c``).

``templates`` has the starter files, which are written once and belong to the user from then on, at
their paths in the project.  Most user functions are there as a title and code only; the head that
they share is added here.  ``NAME`` is replaced by the name of the project, ``@WORD@`` by the
data of the robot.
"""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations import equations_fit

#: The word for the name of the project, alone or in NAME_robot.
NAME = re.compile(r"(?<![A-Z])NAME(?![A-Z])")

FOLDER = Path(__file__).parent

#: The files that check if equations fit the .mbs, by language; a project gets them unchanged.
EQUATIONS_FIT = {
    "python": [Path(equations_fit.__file__)],
    "c": sorted(Path(equations_fit.__file__).parent.glob("equations_fit*.[ch]")),
}

OWNERSHIP_NOTE = "Yours to change: urdf2mbs wrote this file once, and will not touch it again."
#: The head of a user function whose template is a title and code.
INCLUDES = """\
#include <math.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "user_all_id.h"
#include "user_model.h"
#include "NAME_robot.h"
"""
#: The head of a user function in Python that uses the robot.
IMPORTS = """\
import os
import sys

# find NAME_robot.py beside this file, whatever the folder that Python was started in
if "__file__" in globals():
    sys.path.append(os.path.dirname(os.path.abspath(__file__)))

import NAME_robot as robot

"""
#: The comment in user_JointForces if a controller holds the start position, by language.
HOLD_COMMENT = {
    "python": """\
    #
    # The controller 'hold' acts on the joints, too.  To end it, write in user_dirdyn_init:
    #     mbs_data.user_model["hold"]["on"] = 0.0
    # or, for one joint alone:
    #     mbs_data.user_model["hold_stiffness"]["@JOINT@"] = 0.0
    #     mbs_data.user_model["hold_damping"]["@JOINT@"] = 0.0
""",
    "c": """\
     *
     * The controller 'hold' acts on the joints, too. To end it, write in user_dirdyn_init:
     *   mbs_data->user_model->hold.on = 0.0;
     * or, for one joint alone:
     *   mbs_data->user_model->hold_stiffness.@JOINT@ = 0.0;
     *   mbs_data->user_model->hold_damping.@JOINT@ = 0.0;
""",
}
#: The comment in user_dirdyn_loop if the robot has sensors, by language.
IMU_COMMENT = {
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


def generate_starter_files(language: str, mbs: Mbs) -> dict[str, bytes]:
    """Return the files that are written once, by their paths in the project.

    Args:
        language: ``python`` or ``c``.
        mbs: The model; its first joint and sensor are the examples in comments.
    """
    hold_model = next((model for model in mbs.user_models if model.name == "hold_stiffness"), None)
    if hold_model is None:
        joints, hold_comment = list_plotted_joints(mbs), ""
    else:
        joints = [parameter.name for parameter in hold_model.parameters]
        hold_comment = HOLD_COMMENT[language]
    dependent_joints = list_dependent_joints(mbs)
    joint = next((name for name in joints if name not in dependent_joints), "JOINT")
    sensors = [point.sensor.name for point in mbs.points().values() if point.sensor is not None]
    imu_comment = ""
    if sensors:
        imu_comment = IMU_COMMENT[language].replace("@SENSOR@", sensors[0])
        imu_comment = imu_comment.replace("@NAME@", mbs.name)

    folder = FOLDER / "templates" / language
    starters: dict[str, bytes] = {}
    for file in sorted(folder.rglob("*.in")):
        text = fill_template(file, mbs.name)
        text = text.replace("@HOLD@\n", hold_comment).replace("@IMU@\n", imu_comment)
        text = text.replace("@JOINT@", joint)
        starters[file.relative_to(folder).as_posix().removesuffix(".in")] = text.encode()
    return starters


def fill_template(file: Path, name: str) -> str:
    """Return a template with the name of the project in it, and the head of user functions."""
    text = file.read_text("utf-8")
    title, _, code = text.partition("\n\n")
    has_head = not file.name.startswith("user_") or "\n" in title
    if has_head:
        return NAME.sub(name, text)
    if ".c" in file.suffixes:
        gap = "" if code.startswith("#include") else "\n"
        text = f"/* {title}\n *\n * {OWNERSHIP_NOTE} */\n{INCLUDES}{gap}{code}"
    else:
        imports = IMPORTS if "robot." in code else ""
        text = f'"""{title}\n\n{OWNERSHIP_NOTE}\n"""\n\n{imports}\n{code}'
    return NAME.sub(name, text)


def list_dependent_joints(mbs: Mbs) -> list[str]:
    """List the joints that the partition takes for dependent ones."""
    joints = (joint for body in mbs.bodies for joint in body.joints)
    return [joint.name for joint in joints if joint.nature == "dependent"]


def list_plotted_joints(mbs: Mbs) -> list[str]:
    """List the joints that move, without the six of a floating base unless it has no others."""
    moving = [
        joint.name for body in mbs.bodies for joint in body.joints if joint.nature != "driven"
    ]
    base_joints = [
        joint.name
        for body in mbs.bodies
        if body.parent is None and len(body.joints) == 6
        for joint in body.joints
        if joint.nature == "independent"
    ]
    return [name for name in moving if name not in base_joints] or moving
