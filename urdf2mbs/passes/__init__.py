"""The built-in passes, in the order of the method, registered as any plugin's are."""

from __future__ import annotations

from typing import Any

from urdf2mbs.engine.hookspecs import Pass, hookimpl

#: The passes of ``compact`` that ``faithful`` does without.
_COMPACT = ("lump-fixed", "merge-massless", "align-frames")


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    # not above: whoever looks for hooks would look at every class
    from urdf2mbs.passes.actuators import Actuators
    from urdf2mbs.passes.align_frames import AlignFrames
    from urdf2mbs.passes.apply_edits import ApplyEdits
    from urdf2mbs.passes.assign_names import AssignNames
    from urdf2mbs.passes.certificate import Certificate
    from urdf2mbs.passes.check import Check
    from urdf2mbs.passes.collect_anchors import CollectAnchors
    from urdf2mbs.passes.contacts import Contacts
    from urdf2mbs.passes.convert_meshes import ConvertMeshes
    from urdf2mbs.passes.convert_visuals import ConvertVisuals
    from urdf2mbs.passes.decompose_joints import DecomposeJoints
    from urdf2mbs.passes.emit import Emit
    from urdf2mbs.passes.equations import Equations
    from urdf2mbs.passes.estimate_inertia import EstimateInertia
    from urdf2mbs.passes.expand import Expand
    from urdf2mbs.passes.find_singular import FindSingular
    from urdf2mbs.passes.fit_view import FitView
    from urdf2mbs.passes.force_torque import ForceTorque
    from urdf2mbs.passes.forces import Forces
    from urdf2mbs.passes.insert_base import InsertBase
    from urdf2mbs.passes.joint_parameters import JointParameters
    from urdf2mbs.passes.layout import Layout
    from urdf2mbs.passes.left_out import LeftOut
    from urdf2mbs.passes.loops import Loops
    from urdf2mbs.passes.lump_fixed import LumpFixed
    from urdf2mbs.passes.merge import Merge
    from urdf2mbs.passes.merge_massless import MergeMassless
    from urdf2mbs.passes.mimic import Mimic
    from urdf2mbs.passes.posture import Posture
    from urdf2mbs.passes.project import Project
    from urdf2mbs.passes.prune_massless import PruneMassless
    from urdf2mbs.passes.reframe_inertia import ReframeInertia
    from urdf2mbs.passes.rotors import Rotors
    from urdf2mbs.passes.sensors import Sensors
    from urdf2mbs.passes.snap import Snap
    from urdf2mbs.passes.time_step import TimeStep

    return [
        Expand,
        Snap,  # when given an angle
        EstimateInertia,  # when given a density or a total mass
        InsertBase,
        Rotors,  # when given joints, or told to take those of <transmission>
        PruneMassless,
        ForceTorque,  # when given joints
        LumpFixed,
        MergeMassless,
        AlignFrames,
        ReframeInertia,
        DecomposeJoints,
        Mimic,  # when joints follow others, and the output is a project folder
        Actuators,  # of <transmission> and <ros2_control>
        CollectAnchors,
        Posture,  # when given one
        JointParameters,  # limits, damping, friction, as user models
        Loops,  # when given cuts, or where <gazebo> closes a loop
        Contacts,  # when given links
        Sensors,  # of <gazebo> and <sensor>
        Forces,  # when given some
        TimeStep,  # when the output is a project folder; and the gains of hold
        ConvertVisuals,
        ConvertMeshes,  # when the output is a project folder
        AssignNames,
        Layout,
        FitView,
        LeftOut,
        Emit,
        ApplyEdits,  # when given a file
        Merge,  # when people changed the .mbs that is there
        FindSingular,
        Check,
        Equations,  # when given a language
        Project,  # when the output is a project folder
        Certificate,  # when the output is a project folder, or when told to
    ]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    names = [kind.name for kind in urdf2mbs_passes()]
    return {
        # The method's conversion, frame for frame: every URDF link frame is a body frame or a
        # point.
        "faithful": {"pipeline": [name for name in names if name not in _COMPACT]},
        # The same robot with the fewest joints: a body for what moves as one, its frame along its
        # joint.
        "compact": {"pipeline": names},
    }
