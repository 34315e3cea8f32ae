"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

from urdf2mbs.api import Result, Verdict, convert, verify
from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic

__all__ = [
    "ConfigError",
    "ConversionError",
    "Diagnostic",
    "Result",
    "Verdict",
    "convert",
    "verify",
]
