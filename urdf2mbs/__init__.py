"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

# Nothing is imported before ``cli`` has taken the working folder out of ``sys.path``.
# A type checker and an editor read these imports; Python imports a name when it is first used.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from urdf2mbs.api import Result, Verdict, convert, verify
    from urdf2mbs.engine.config import Config
    from urdf2mbs.many import Outcome, convert_many
    from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, Diagnostic
    from urdf2mbs.runtime.project import simulate
    from urdf2mbs.runtime.push import Push
    from urdf2mbs.runtime.results import Results

__all__ = [
    "Config",
    "ConfigError",
    "ConversionError",
    "Diagnostic",
    "Outcome",
    "Push",
    "Result",
    "Results",
    "Verdict",
    "convert",
    "convert_many",
    "simulate",
    "verify",
]

_HOMES = {
    "Config": "urdf2mbs.engine.config",
    "ConfigError": "urdf2mbs.messages.diagnostics",
    "ConversionError": "urdf2mbs.messages.diagnostics",
    "Diagnostic": "urdf2mbs.messages.diagnostics",
    "Outcome": "urdf2mbs.many",
    "Push": "urdf2mbs.runtime.push",
    "Result": "urdf2mbs.api",
    "Results": "urdf2mbs.runtime.results",
    "Verdict": "urdf2mbs.api",
    "convert": "urdf2mbs.api",
    "convert_many": "urdf2mbs.many",
    "simulate": "urdf2mbs.runtime.project",
    "verify": "urdf2mbs.api",
}


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'urdf2mbs' has no attribute '{name}'")
    globals()[name] = found = getattr(import_module(_HOMES[name]), name)
    return found


def __dir__() -> list[str]:
    return [*globals(), *__all__]
