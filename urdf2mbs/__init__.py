"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

from urdf2mbs.api import Result, Verdict, convert, verify
from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic
from urdf2mbs.many import Outcome, convert_many

__all__ = [
    "ConfigError",
    "ConversionError",
    "Diagnostic",
    "Outcome",
    "Result",
    "Verdict",
    "convert",
    "convert_many",
    "verify",
]
