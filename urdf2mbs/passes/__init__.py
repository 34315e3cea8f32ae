"""The built-in passes, in the order of the method, registered as any plugin's are."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from urdf2mbs.engine.hookspecs import Pass, hookimpl

#: The passes of ``compact`` that ``faithful`` does without.
_COMPACT = ("lump-fixed", "merge-massless", "align-frames")


#: Each pass is the class of this name, in the file of this name.
_NAMES = (
    "expand",
    "snap",  # when given an angle
    "estimate-inertia",  # when given a density or a total mass
    "insert-base",
    "rotors",  # when given joints, or told to take those of <transmission>
    "prune-massless",
    "force-torque",  # when given joints
    "lump-fixed",
    "merge-massless",
    "align-frames",
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
    "merge",  # when people changed the .mbs that is there
    "find-singular",
    "check",
    "equations",  # when given a language
    "project",  # when the output is a project folder
    "certificate",  # when the output is a project folder, or when told to
)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    # not above: a pass imports this package
    return [
        getattr(
            import_module(f"{__name__}.{name.replace('-', '_')}"), name.title().replace("-", "")
        )
        for name in _NAMES
    ]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    return {
        # The method's conversion, frame for frame: every URDF link frame is a body frame or a
        # point.
        "faithful": {"pipeline": [name for name in _NAMES if name not in _COMPACT]},
        # The same robot with the fewest joints: a body for what moves as one, its frame along its
        # joint.
        "compact": {"pipeline": list(_NAMES)},
    }
