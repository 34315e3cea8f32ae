"""All that the author of a plugin imports: stable from version to version.

What stands in ``__all__`` keeps its name and meaning within one ``VERSION``.  Before a name goes,
it warns for one minor release (``DeprecationWarning``; a hook by pluggy's ``warn_on_impl``).
Everything else in the package may change from one day to the next.
"""

from __future__ import annotations

from urdf2mbs import spatial
from urdf2mbs_project import simulation
from urdf2mbs.conversion import (
    Conversion,
    Names,
    Segment,
    Settings,
    Step,
    choose,
)
from urdf2mbs.engine.hookspecs import Pass, hookimpl
from urdf2mbs.mbs import model as mbs
from urdf2mbs.mbs.model import LinkFrame
from urdf2mbs.messages.diagnostics import (
    ConfigError,
    ConversionError,
    Diagnostic,
    nearest,
)
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf import model as urdf

#: The version of this interface.
VERSION = 1

__all__ = [
    "VERSION",
    "ConfigError",
    "Conversion",
    "ConversionError",
    "Diagnostic",
    "Difference",
    "LinkFrame",
    "Names",
    "Pass",
    "Segment",
    "Settings",
    "Step",
    "choose",
    "hookimpl",
    "mbs",
    "nearest",
    "simulation",
    "spatial",
    "urdf",
]
