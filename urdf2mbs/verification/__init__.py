"""Are two robots the same?  Each of them is a URDF, an .mbs, or what a config makes."""

from urdf2mbs.verification.compare import verify, verify_sides
from urdf2mbs.verification.joint_map import read_joint_map, write_joint_map
from urdf2mbs.verification.sides import is_config, read_source
from urdf2mbs.verification.verdict import Verdict

__all__ = [
    "Verdict",
    "is_config",
    "read_joint_map",
    "read_source",
    "verify",
    "verify_sides",
    "write_joint_map",
]
