"""The built-in passes, in the order of the method, registered as any plugin's are."""

from __future__ import annotations

from urdf2mbs.engine.hookspecs import Pass, hookimpl


@hookimpl
def urdf2mbs_passes() -> list[Pass]:
    # not above: whoever looks for hooks would look at every module
    from urdf2mbs.passes import (
        actuators,
        align_frames,
        assign_names,
        check,
        collect_anchors,
        contacts,
        convert_meshes,
        convert_visuals,
        decompose_joints,
        emit,
        equations,
        estimate_inertia,
        expand,
        find_singular,
        fit_view,
        force_torque,
        forces,
        insert_base,
        joint_parameters,
        layout,
        left_out,
        loops,
        lump_fixed,
        merge_massless,
        mimic,
        posture,
        project,
        prune_massless,
        reframe_inertia,
        sensors,
        time_step,
    )

    return [
        expand.PASS,
        estimate_inertia.PASS,
        insert_base.PASS,
        prune_massless.PASS,
        force_torque.PASS,
        reframe_inertia.PASS,
        lump_fixed.PASS,
        merge_massless.PASS,
        align_frames.PASS,
        decompose_joints.PASS,
        mimic.PASS,
        actuators.PASS,
        collect_anchors.PASS,
        posture.PASS,
        joint_parameters.PASS,
        loops.PASS,
        contacts.PASS,
        sensors.PASS,
        forces.PASS,
        time_step.PASS,
        convert_visuals.PASS,
        convert_meshes.PASS,
        assign_names.PASS,
        layout.PASS,
        fit_view.PASS,
        left_out.PASS,
        emit.PASS,
        find_singular.PASS,
        check.PASS,
        equations.PASS,
        project.PASS,
    ]
