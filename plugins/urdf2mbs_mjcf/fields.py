"""What becomes of each field of MuJoCo's model: it is read, named as lost, or says no mechanics.

A test goes over all fields of ``MjModel`` and ``MjOption``, and fails for one that is in none of
these tables: a new version of MuJoCo may add a law that nothing here reads.
"""

from __future__ import annotations

import re

from urdf2mbs_mjcf.model import KINDS, list_fields

#: Fields that the compilation reads beyond those of ``model``.
READ = ("names", "paths", "mesh_pathadr", "qpos0", "qpos_spring", "opt")
#: Fields whose elements are named if they are not zero, and the law that is lost.
LOST = {
    "jnt_stiffnesspoly": "springs with polynomial stiffness",
    "jnt_springyield": "springs that yield",
    "dof_dampingpoly": "polynomial damping",
    "body_gravcomp": "weight that is compensated (gravcomp)",
    "geom_fluid": "forces of a fluid on ellipsoids (fluidshape)",
    "geom_adhesion": "adhesion",
    "geom_surfacevel": "surfaces that move",
    "actuator_armature": "armature of actuators",
    "actuator_damping": "damping of actuators",
    "actuator_dampingpoly": "polynomial damping of actuators",
    "actuator_delay": "actuators with a delay",
    "key_qvel": "keyframes with velocities",
}
#: Fields whose elements are named if they are not -1: what another program computes.
PLUGINS = {
    "body_plugin": "bodies with a plugin",
    "geom_plugin": "geoms with a plugin",
    "actuator_plugin": "actuators with a plugin",
}
#: Options whose forces are named if they are not zero.
LOST_OPTIONS = {
    "density": "forces of a fluid (density)",
    "viscosity": "forces of a fluid (viscosity)",
    "wind": "wind",
}
#: Options that are read.
READ_OPTIONS = ("gravity", "disableflags")
#: Options of the solver and of time steps, of contacts (``o_``), and of magnetic sensors.
HARMLESS_OPTIONS = re.compile(
    r"cone|impratio|integrator|jacobian|solver|timestep|magnetic|enableflags|disableactuator|apirate"
    r"|o_\w+|(\w+_)?(iterations|tolerance|initpoints)"
)

#: Patterns of further fields, and why nothing reads them.
OTHERS = {
    # with limits, friction and equalities: a note says that they are soft there
    "softness": r"(jnt|dof|eq)_(solref|solimp)|jnt_margin",
    # the message on contacts is about all of it
    "contacts": r"geom_(condim|margin|gap|priority|sol(mix|ref|imp))|body_(margin|con\w+)|pair_\w+"
    r"|exclude_signature",
    # such elements are named as a whole
    "elements": r"tendon_\w+|wrap_prm|flex\w*_\w+|plugin\w*|key_(act|ctrl|mpos|mquat|plastic|time)"
    r"|actuator_(act\w*|dynprm|cranklength|ctrl(adr|num|spec)|out\w+|history\w*|lengthrange)"
    r"|sensor_\w+|eq_plastic\w*|(jnt|tendon|flex)_plasticadr",
    # the control of a motor that balances gravity: the body is named
    "actuation": r"jnt_(actgravcomp|actuatorid)|tendon_actuatorid",
    "shapes": r"mesh_\w+|hfield_\w+|bvh_\w+|oct_\w+|skin_\w+|site_(type|size|dataid|sameframe)"
    r"|geom_(aabb|rbound|sameframe)",
    "appearance": r"(mat|tex|light|cam)_\w+|vis|(geom|site)_(matid|rgba|group|castshadow)",
    "users": r"\w+_user|(numeric|text|tuple)_\w+|nuser\w*|signature|(jnt|actuator)_group",
    # made of other fields
    "computed": r"\w*(invweight0|length0|acc0|M0)|body_(subtreemass|rootid|weldid|treeid|simple"
    r"|sameframe|dof\w+|geom\w+|bvh\w+)|dof_(\w+id|Madr|simplenum|length)|jnt_bodyid|tree_\w+"
    r"|stat|flg_\w+",
    "layout": r"name_\w+|names_map|[BDM]_\w+|map\w+|efm\w+|\w*_J_\w+|n[A-Za-z]\w*|narena",
}
_OTHERS = {reason: re.compile(pattern) for reason, pattern in OTHERS.items()}


def classify(field: str) -> str | None:
    """Return what becomes of a field of ``MjModel``; None if nobody has decided.

    Returns:
        ``read``, ``lost``, or a key of ``OTHERS``.
    """
    read = (
        f"{prefix}_{name}" for kind, (prefix, *_) in KINDS.items() for name in list_fields(kind)
    )
    if field in READ or field in read:
        return "read"
    if field in LOST or field in PLUGINS:
        return "lost"
    reasons = (reason for reason, pattern in _OTHERS.items() if pattern.fullmatch(field))
    return next(reasons, None)


def classify_option(option: str) -> str | None:
    """Return what becomes of a field of ``MjOption``, as ``classify``."""
    if option in READ_OPTIONS:
        return "read"
    if option in LOST_OPTIONS:
        return "lost"
    return "solver" if HARMLESS_OPTIONS.fullmatch(option) else None
