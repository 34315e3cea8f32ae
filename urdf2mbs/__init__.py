"""URDF and xacro robots to Robotran ``.mbs`` multibody systems, provably the same robot."""

# Python imports these names when they are first used, so that help comes at once.  A type checker
# and an editor read them here.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from urdf2mbs.api import Result as Result
    from urdf2mbs.api import Verdict as Verdict
    from urdf2mbs.api import convert as convert
    from urdf2mbs.api import verify as verify
    from urdf2mbs.engine.config import Config as Config
    from urdf2mbs_many import Outcome as Outcome
    from urdf2mbs_many import convert_many as convert_many
    from urdf2mbs.messages.diagnostics import ConfigError as ConfigError
    from urdf2mbs.messages.diagnostics import ConversionError as ConversionError
    from urdf2mbs.messages.diagnostics import Diagnostic as Diagnostic
    from urdf2mbs_simulate.project import simulate as simulate
    from urdf2mbs_simulate.push import Push as Push
    from urdf2mbs_simulate.results import Results as Results
    from urdf2mbs_simulate.robot import Robot as Robot
    from urdf2mbs_simulate.robot import load_equations as load_equations

#: The names of each module.
_NAMES = {
    "api": ["Result", "Verdict", "convert", "verify"],
    "engine.config": ["Config"],
    "many": ["Outcome", "convert_many"],
    "messages.diagnostics": ["ConfigError", "ConversionError", "Diagnostic"],
    "runtime.project": ["simulate"],
    "runtime.push": ["Push"],
    "runtime.results": ["Results"],
    "runtime.robot": ["Robot", "load_equations"],
}
__all__ = sorted(name for names in _NAMES.values() for name in names)


def __getattr__(name: str) -> object:
    from importlib import import_module

    for module, names in _NAMES.items():
        if name in names:
            value = globals()[name] = getattr(import_module(f"urdf2mbs.{module}"), name)
            return value
    raise AttributeError(f"module 'urdf2mbs' has no attribute '{name}'")


def __dir__() -> list[str]:
    return [*globals(), *__all__]
