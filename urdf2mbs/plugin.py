"""All that the author of a plugin imports: stable from version to version.

What stands in ``__all__`` keeps its name and meaning within one ``VERSION``.  Before a name goes,
it warns for one minor release (``DeprecationWarning``; a hook by pluggy's ``warn_on_impl``).
Everything else in the package may change from one day to the next.
"""

from __future__ import annotations

from urdf2mbs.hookspecs import (
    Command,
    Pass,
    PassEntry,
    always,
    asked,
    hookimpl,
    in_project,
)

# Python imports the other names when they are first used: a plugin that only names its passes and
# commands loads none of them.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from urdf2mbs import spatial as spatial
    from urdf2mbs.conversion import Conversion as Conversion
    from urdf2mbs.conversion import File as File
    from urdf2mbs.conversion import Names as Names
    from urdf2mbs.conversion import Segment as Segment
    from urdf2mbs.conversion import Settings as Settings
    from urdf2mbs.conversion import Step as Step
    from urdf2mbs.conversion import Summary as Summary
    from urdf2mbs.conversion import Use as Use
    from urdf2mbs.conversion import choose as choose
    from urdf2mbs.mbs import model as mbs
    from urdf2mbs.mbs.model import LinkFrame as LinkFrame
    from urdf2mbs.messages.diagnostics import ConfigError as ConfigError
    from urdf2mbs.messages.diagnostics import ConversionError as ConversionError
    from urdf2mbs.messages.diagnostics import Diagnostic as Diagnostic
    from urdf2mbs.messages.diagnostics import nearest as nearest
    from urdf2mbs.proof.verdict import Difference as Difference
    from urdf2mbs.urdf import model as urdf

#: The version of this interface.
VERSION = 1

#: The names of each module.
_NAMES = {
    "conversion": [
        "Conversion", "File", "Names", "Segment", "Settings", "Step", "Summary", "Use", "choose",
    ],
    "mbs.model": ["LinkFrame"],
    "messages.diagnostics": ["ConfigError", "ConversionError", "Diagnostic", "nearest"],
    "proof.verdict": ["Difference"],
}  # fmt: skip
#: Modules by the names that they have here.
_MODULES = {"mbs": "mbs.model", "spatial": "spatial", "urdf": "urdf.model"}

__all__ = [
    "VERSION",
    "Command",
    "ConfigError",
    "Conversion",
    "ConversionError",
    "Diagnostic",
    "Difference",
    "File",
    "LinkFrame",
    "Names",
    "Pass",
    "PassEntry",
    "Segment",
    "Settings",
    "Step",
    "Summary",
    "Use",
    "always",
    "asked",
    "choose",
    "hookimpl",
    "in_project",
    "mbs",
    "nearest",
    "spatial",
    "urdf",
]


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name in _MODULES:
        value: object = import_module(f"urdf2mbs.{_MODULES[name]}")
    elif name == "simulation":  # of the plugin ``project``; the module was part of the door before
        from urdf2mbs.engine.plugins import plugins_of

        value = plugins_of((), installed=False).find(name)
    else:
        module = next((module for module, names in _NAMES.items() if name in names), None)
        if module is None:
            raise AttributeError(f"module 'urdf2mbs.plugin' has no attribute '{name}'")
        value = getattr(import_module(f"urdf2mbs.{module}"), name)
    globals()[name] = value
    return value
