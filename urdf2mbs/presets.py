"""The pipelines that have a name, as a plugin gives its own (``urdf2mbs_presets``)."""

from __future__ import annotations

from typing import Any

#: What comes before the robot is taken apart into bodies, in both.
_FIRST = [
    "expand",
    "estimate-inertia",  # when given a density or a total mass
    "insert-base",
    "prune-massless",
    "force-torque",  # when given joints
]

#: What comes when its bodies are known, in both.
_THEN = [
    "reframe-inertia",
    "decompose-joints",
    "mimic",  # when joints follow others, and the output is a project folder
    "actuators",  # of <transmission> and <ros2_control>
    "collect-anchors",
    "posture",  # when given one
    "joint-parameters",  # limits, damping, friction, as user models
    "loops",  # when given cuts, or where <gazebo> closes a loop
    "contacts",  # when given links
    "sensors",  # of <gazebo> and <sensor>
    "forces",  # when given some
    "time-step",  # when the output is a project folder; and the gains of hold
    "convert-visuals",
    "convert-meshes",  # when the output is a project folder
    "assign-names",
    "layout",
    "fit-view",
    "left-out",
    "emit",
    "find-singular",
    "check",
    "equations",  # when given a language
    "project",  # when the output is a project folder
]

#: Each with its passes, in their order.
PRESETS: dict[str, dict[str, Any]] = {
    # The method's conversion, frame for frame: every URDF link frame is a body frame or a point.
    "faithful": {"pipeline": [*_FIRST, *_THEN]},
    # The same robot with the fewest joints: a body for what moves as one, its frame along its
    # joint.
    "compact": {"pipeline": [*_FIRST, "lump-fixed", "merge-massless", "align-frames", *_THEN]},
}
