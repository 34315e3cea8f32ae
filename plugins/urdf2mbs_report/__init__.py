"""One HTML page to look at a robot, and the diagram of an .mbs as an SVG picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion

NEEDS = ("meshes",)


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Return the commands of this plugin."""
    package = "urdf2mbs_report.commands"
    page_help = "convert, and write one HTML page to look at instead"
    diagram_help = "draw the 2D diagram of a robot or an .mbs as an SVG picture"
    return [
        Command("report", page_help, f"{package}.report"),
        Command("diagram", diagram_help, f"{package}.diagram"),
    ]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of messages with their meanings."""
    from urdf2mbs_report.codes import CODES

    return CODES


@hookimpl
def urdf2mbs_show(conversion: Conversion) -> str:
    """Return the page of a conversion, for a notebook."""
    from urdf2mbs_report.page import frame_page, make_robot_page

    return frame_page(make_robot_page(conversion))
