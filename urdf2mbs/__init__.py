"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

from urdf2mbs.api import Result, convert

__all__ = ["Result", "convert"]
