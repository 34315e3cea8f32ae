"""For the pages of a CI: ``lint``, and findings as SARIF."""

from urdf2mbs.plugin import Command, PassEntry, hookimpl


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    # no preset is called so, and none gets the pass: 'lint' and configs put it in
    after = ("expand", "snap", "estimate-inertia")
    return [PassEntry("find-faults", "urdf2mbs_ci", after, presets=("lint",))]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    does = "list the faults of a robot, without converting it"
    return [Command("lint", does, "urdf2mbs_ci.commands.lint")]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    return {"findings": "urdf2mbs_ci.findings"}
