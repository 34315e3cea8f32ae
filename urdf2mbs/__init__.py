"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

# Python imports these names when they are first used, so that help comes at once.  A type checker
# and an editor read them in ``__init__.pyi``.

#: The names of each module.
_NAMES = {
    "api": ["Result", "Verdict", "convert", "verify"],
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
        is_module = name.startswith("_") or find_spec(f"urdf2mbs.{name}") is not None
        value = None if is_module else _of_plugins().find(name)
        if value is None:
            raise AttributeError(f"module 'urdf2mbs' has no attribute '{name}'")
    globals()[name] = value
    return value


def _of_plugins():  # type: ignore[no-untyped-def]
    from urdf2mbs.engine.plugins import plugins_of

    return plugins_of((), installed=False)


def __dir__() -> list[str]:
    own = [name for names in _NAMES.values() for name in names]
    return [*globals(), *own, *_of_plugins().api]
