"""For the pages of a CI: ``lint``, and findings as SARIF."""

from urdf2mbs.plugin import Command, hookimpl


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    does = "list the faults of a robot, without converting it"
    return [Command("lint", does, "urdf2mbs_ci.commands.lint")]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    return {"findings": "urdf2mbs_ci.findings"}
