"""Simulate Robotran projects: a runtime with the names of Robotran's own, MBsysPy.

``workR/main.py`` and user functions import it as ``urdf2mbs.runtime``, in place of MBsysPy.
See ``docs/simulate.md``.
"""

from urdf2mbs.plugin import Command, hookimpl

NEEDS = ("project", "equations", "report")


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Return the commands of this plugin."""
    simulate = "simulate a robot, a project or an .mbs, and write Robotran's results"
    modes = "compute the modes of a robot: frequencies, damping, a page"
    return [
        Command("simulate", simulate, "urdf2mbs_simulate.commands.simulate"),
        Command("modes", modes, "urdf2mbs_simulate.commands.modes"),
    ]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    """Return the public names of this plugin, with the modules that define them."""
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
    """Return what ``doctor`` shows of this plugin's needs."""
    from urdf2mbs_simulate.compiler import compiler

    return {"C compiler": compiler() or "none: simulations need one (pip install ziglang)"}


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of this plugin's errors, with their meanings."""
    from urdf2mbs_simulate.codes import CODES

    return CODES
