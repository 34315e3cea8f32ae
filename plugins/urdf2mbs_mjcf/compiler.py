"""Compile an MJCF by MuJoCo: a script that runs in a process of its own.

It reads a job from its standard input, as JSON, and writes the file ``job["result"]``.  What it
hands back is plain data: ``model.Compiled``, or ``{"error": TEXT}``.  It imports nothing of
urdf2mbs, so that it starts fast.
"""

from __future__ import annotations

import json
import os
import random
import sys
from typing import Any

#: The types of MuJoCo's fields that are numbers of an enumeration, and the prefix of its names.
ENUMERATIONS = {
    "jnt_type": ("mjtJoint", "mjJNT_"),
    "geom_type": ("mjtGeom", "mjGEOM_"),
    "sensor_type": ("mjtSensor", "mjSENS_"),
    "sensor_objtype": ("mjtObj", "mjOBJ_"),
    "eq_type": ("mjtEq", "mjEQ_"),
    "eq_objtype": ("mjtObj", "mjOBJ_"),
    "actuator_trntype": ("mjtTrn", "mjTRN_"),
    "actuator_gaintype": ("mjtGain", "mjGAIN_"),
    "actuator_biastype": ("mjtBias", "mjBIAS_"),
    "actuator_dyntype": ("mjtDyn", "mjDYN_"),
    "wrap_type": ("mjtWrap", "mjWRAP_"),
}
N_STATES = 3


def main() -> None:
    """Carry out the job of the standard input."""
    job = json.load(sys.stdin)
    sys.path[:] = job["path"]
    _limit_resources(job)
    import mujoco

    mujoco.set_mju_user_warning(lambda text: None)  # otherwise it writes a log file
    try:
        spec = _read_spec(mujoco, job["source"])
        model = spec.compile()
        result = _list_content(mujoco, spec, model, job)
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        result = {"error": str(error)}
    with open(job["result"], "w", encoding="utf-8") as file:  # noqa: PTH123
        json.dump(result, file)


def _read_spec(mujoco: Any, source: str) -> Any:
    """Return the spec of an MJCF; MuJoCo itself reads only files whose names end in .xml."""
    if source.endswith(".xml"):
        return mujoco.MjSpec.from_file(source)
    folder = os.path.dirname(source)  # noqa: PTH120
    os.chdir(folder)  # what it includes is looked for here
    with open(source, encoding="utf-8-sig") as file:  # noqa: PTH123
        spec = mujoco.MjSpec.from_string(file.read())
    spec.modelfiledir = folder
    return spec


def _limit_resources(job: dict[str, Any]) -> None:
    """Limit the time and memory of this process, where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    limits = {"RLIMIT_CPU": job["seconds"], "RLIMIT_CORE": 0, "RLIMIT_FSIZE": job["file_size"]}
    if sys.platform == "linux":
        limits["RLIMIT_AS"] = job["memory"]
    for name, limit in limits.items():
        _, hard = resource.getrlimit(getattr(resource, name))
        allowed = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        resource.setrlimit(getattr(resource, name), (allowed, hard))


def _list_content(mujoco: Any, spec: Any, model: Any, job: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a compiled model."""
    content: dict[str, Any] = {
        kind: _list_elements(mujoco, model, prefix, object_type, fields)
        for kind, (prefix, object_type, fields) in job["kinds"].items()
    }
    assets = {asset.name: asset for asset in spec.meshes}
    for number, mesh in enumerate(content["meshes"]):
        asset = assets.get(mesh["name"], spec.meshes[number])
        begin = int(model.mesh_pathadr[number])
        end = model.paths.find(b"\0", begin)
        mesh["file"] = "" if begin < 0 else model.paths[begin:end].decode("utf-8", "replace")
        mesh |= {"refpos": asset.refpos.tolist(), "refquat": asset.refquat.tolist()}
    flags = mujoco.mjtDisableBit.__members__.items()
    disabled = [
        name.removeprefix("mjDSBL_").lower()
        for name, bit in flags
        if name.startswith("mjDSBL_") and model.opt.disableflags & int(bit)
    ]
    gravity = [0.0, 0.0, 0.0] if "gravity" in disabled else model.opt.gravity.tolist()
    content |= {
        "name": spec.modelname,
        "version": mujoco.__version__,
        "qpos0": model.qpos0.tolist(),
        "qpos_spring": model.qpos_spring.tolist(),
        "gravity": gravity,
        "disabled": disabled,
        "lost": _find_lost(mujoco, model, job),
    }
    content["states"] = _compute_states(mujoco, model, content["joints"], content["bodies"])
    return content


def _list_elements(
    mujoco: Any, model: Any, prefix: str, object_type: str, fields: list[str]
) -> list[dict[str, Any]]:
    """Return the elements of a kind, with the fields that are asked for."""
    columns = {}
    for field in fields:
        values = getattr(model, f"{prefix}_{field}").tolist()
        enumeration, beginning = ENUMERATIONS.get(f"{prefix}_{field}", ("", ""))
        if enumeration:
            kind = getattr(mujoco, enumeration)
            words = {int(value): name for name, value in kind.__members__.items()}
            names = (words.get(value, "unknown") for value in values)
            values = [name.removeprefix(beginning).lower() for name in names]
        columns[field] = values
    count = len(next(iter(columns.values())))
    elements = [
        {field: column[number] for field, column in columns.items()} for number in range(count)
    ]
    for number, element in enumerate(elements):
        element["name"] = _get_name(mujoco, model, object_type, number)
    return elements


def _get_name(mujoco: Any, model: Any, object_type: str, number: int) -> str:
    """Return the name of an element; empty if it has none."""
    if not object_type:
        return ""
    kind = getattr(mujoco.mjtObj, f"mjOBJ_{object_type}")
    return mujoco.mj_id2name(model, kind, number) or ""


def _find_lost(mujoco: Any, model: Any, job: dict[str, Any]) -> dict[str, list[str]]:
    """Return the elements of each field that nothing reads, and that is not at its default."""
    object_types = {prefix: object_type for prefix, object_type, _ in job["kinds"].values()}
    lost = {}
    for field, default in job["lost"].items():
        values = getattr(model, field, None)  # an older MuJoCo does not have all of them
        if values is not None and len(values):
            prefix = field.partition("_")[0]
            names = [
                _get_name(mujoco, model, object_types.get(prefix, ""), number)
                for number, value in enumerate(values.reshape(len(values), -1))
                if (value != default).any()
            ]
            if names:
                lost[field] = names
    import numpy as np

    lost |= {
        f"opt.{option}": [""]
        for option in job["lost_options"]
        if np.any(getattr(model.opt, option, 0.0))
    }
    counts = ("nflex", "nskin", "npair", "nplugin")
    return lost | {count: [""] * getattr(model, count) for count in counts if getattr(model, count)}


def _compute_states(
    mujoco: Any, model: Any, joints: list[dict[str, Any]], bodies: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    """Return MuJoCo's mass matrix, bias and poses at random states, the same each time."""
    import numpy as np

    for name in ("dof_armature", "actuator_armature", "tendon_armature"):
        if hasattr(model, name):
            getattr(model, name)[:] = 0.0
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    choice = random.Random(1)
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)  # MuJoCo keeps the inertia of simple bodies with armature
    states = []
    for _ in range(N_STATES):
        angles = []
        data.qpos[:] = model.qpos0
        for joint in joints:
            coordinates = [
                choice.uniform(-1.0, 1.0)
                for _ in range({"free": 6, "ball": 3}.get(joint["type"], 1))
            ]
            angles.append(coordinates)
            _set_position(mujoco, data.qpos, joint, coordinates)
        data.qvel[:] = [choice.uniform(-1.0, 1.0) for _ in range(model.nv)]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        bias = np.zeros(model.nv)
        mujoco.mj_rne(model, data, 0, bias)
        mass_matrix = np.zeros((model.nv, model.nv))
        try:
            mujoco.mj_fullM(model, data, mass_matrix)
        except TypeError:  # before MuJoCo 4
            mujoco.mj_fullM(model, mass_matrix, data.qM)
        states.append(
            {
                "angles": angles,
                "velocity": data.qvel.tolist(),
                "mass_matrix": mass_matrix.tolist(),
                "bias": bias.tolist(),
                "body_pos": data.xpos.tolist(),
                "body_quat": data.xquat.tolist(),
            }
        )
    return states


def _set_position(mujoco: Any, qpos: Any, joint: dict[str, Any], coordinates: list[float]) -> None:
    """Move a joint from its zero by some coordinates: ``qpos0``, or of a free joint the world."""
    import numpy as np

    address = joint["qposadr"]
    if joint["type"] in ("hinge", "slide"):
        qpos[address] += coordinates[0]
        return
    *position, x, y, z = coordinates
    qpos[address : address + len(position)] = position
    rotation_address = address + len(position)
    start = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in enumerate((x, y, z)):
        turned, turn = np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, np.eye(3)[axis], angle)
        mujoco.mju_mulQuat(turned, start, turn)
        start = turned
    qpos[rotation_address : rotation_address + 4] = start


if __name__ == "__main__":
    main()
