"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

# Python imports these names when they are first used, so that help needs none of them.  A type
# checker and an editor read them in ``__init__.pyi``.  Plugins add more by ``urdf2mbs_api``.

#: The names of each module.
_NAMES = {
    "api": ["Result", "convert"],
    "verification": ["Verdict", "verify"],
    "config.model": ["Config"],
    "messages.diagnostics": ["ConfigError", "ConversionError", "Diagnostic"],
}


def __getattr__(name: str) -> object:
    from importlib import import_module
    from importlib.util import find_spec

    for module, names in _NAMES.items():
        if name in names:
            value: object = getattr(import_module(f"urdf2mbs.{module}"), name)
            break
    else:
        value = None
        if not name.startswith("_") and find_spec(f"urdf2mbs.{name}") is None:
            from urdf2mbs.engine.plugins import load_plugins

            value = load_plugins().load_name(name)
        if value is None:
            raise AttributeError(f"module 'urdf2mbs' has no attribute '{name}'")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    from urdf2mbs.engine.plugins import load_plugins

    own_names = [name for names in _NAMES.values() for name in names]
    return [*globals(), *own_names, *load_plugins().api]
