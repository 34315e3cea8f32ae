"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

# Python imports these names when they are first used, so that help comes at once.  A type checker
# and an editor read them here.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from urdf2mbs.api import Result, Verdict, convert, verify
    from urdf2mbs.engine.config import Config
    from urdf2mbs.many import Outcome, convert_many
    from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, Diagnostic
    from urdf2mbs.runtime.project import simulate
    from urdf2mbs.runtime.push import Push
    from urdf2mbs.runtime.results import Results
    from urdf2mbs.runtime.robot import Robot, load_equations

#: The module of each name.
_HOMES = {
    "Config": "engine.config",
    "ConfigError": "messages.diagnostics",
    "ConversionError": "messages.diagnostics",
    "Diagnostic": "messages.diagnostics",
    "Outcome": "many",
    "Push": "runtime.push",
    "Result": "api",
    "Results": "runtime.results",
    "Robot": "runtime.robot",
    "Verdict": "api",
    "convert": "api",
    "convert_many": "many",
    "load_equations": "runtime.robot",
    "simulate": "runtime.project",
    "verify": "api",
}
__all__ = [
    "Config",
    "ConfigError",
    "ConversionError",
    "Diagnostic",
    "Outcome",
    "Push",
    "Result",
    "Results",
    "Robot",
    "Verdict",
    "convert",
    "convert_many",
    "load_equations",
    "simulate",
    "verify",
]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module 'urdf2mbs' has no attribute '{name}'")
    from importlib import import_module

    value = getattr(import_module(f"urdf2mbs.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
