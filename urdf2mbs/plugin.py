"""All that the author of a plugin imports: stable from version to version.

What stands in ``__all__`` keeps its name and meaning within one ``VERSION``.  Before a name goes,
it warns for one minor release (``DeprecationWarning``; a hook by pluggy's ``warn_on_impl``).
Everything else in the package may change from one day to the next.
"""

# A plugin that only names its passes and commands imports no more than the hooks: the other names
# are imported when they are first used.  A type checker and an editor read them in ``plugin.pyi``.

#: The version of this interface.
VERSION = 1

#: The names of each module.
_NAMES = {
    "conversion": [
        "Conversion", "File", "Names", "Segment", "Settings", "Step", "Summary", "Use", "choose",
        "fits",
    ],
    "hookspecs": ["Command", "Pass", "PassEntry", "always", "asked", "hookimpl", "in_project"],
    "mbs.model": ["LinkFrame"],
    "messages.diagnostics": ["ConfigError", "ConversionError", "Diagnostic", "nearest"],
    "proof.verdict": ["Difference"],
    "urdf.mimic": ["follow"],
    "states": ["Estimates", "JointModels", "OnPurpose", "Placed"],
}  # fmt: skip
#: Modules by the names that they have here.
_MODULES = {"mbs": "mbs.model", "spatial": "spatial", "urdf": "urdf.model"}

__all__ = ["VERSION", *_MODULES, *(name for names in _NAMES.values() for name in names)]


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name in _MODULES:
        value: object = import_module(f"urdf2mbs.{_MODULES[name]}")
    else:
        module = next((module for module, names in _NAMES.items() if name in names), None)
        if module is None:
            raise AttributeError(f"module 'urdf2mbs.plugin' has no attribute '{name}'")
        value = getattr(import_module(f"urdf2mbs.{module}"), name)
    globals()[name] = value
    return value
