"""Let a robot move: a runtime for Robotran projects, with the names of Robotran's own, MBsysPy.

``workR/main.py`` and user functions use it, by the name ``urdf2mbs.runtime``, as they use MBsysPy.
See ``docs/simulate.md``.
"""

from urdf2mbs.plugin import Command, hookimpl

NEEDS = ("project", "equations", "report")


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    does = "let a robot, a project or an .mbs move, and write Robotran's results"
    swings = "compute the modes of a robot: frequencies, damping, a page"
    return [
        Command("simulate", does, "urdf2mbs_simulate.commands.simulate"),
        Command("modes", swings, "urdf2mbs_simulate.commands.modes"),
    ]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    package = "urdf2mbs_simulate"
    return {
        "Push": f"{package}.push:Push",
        "Results": f"{package}.results:Results",
        "Robot": f"{package}.robot:Robot",
        "load_equations": f"{package}.robot:load_equations",
        "modes": f"{package}.project:modes",
        "runtime": f"{package}.runtime",
        "simulate": f"{package}.project:simulate",
    }


@hookimpl
def urdf2mbs_doctor() -> dict[str, str]:
    from urdf2mbs_simulate.compiler import compiler

    return {"C compiler": compiler() or "none: simulations need one (pip install ziglang)"}


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_simulate.codes import CODES

    return CODES
