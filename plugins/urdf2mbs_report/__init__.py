"""One HTML page to look at a robot, and the diagram of an .mbs as an SVG picture."""

from urdf2mbs.plugin import Command, hookimpl

NEEDS = ("meshes",)


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    package = "urdf2mbs_report.commands"
    return [
        Command(
            "report", "convert, and write one HTML page to look at instead", f"{package}.report"
        ),
        Command(
            "diagram", "draw the 2D diagram of an .mbs file as an SVG picture",
            f"{package}.diagram",
        ),
    ]  # fmt: skip


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_report.codes import CODES

    return CODES
