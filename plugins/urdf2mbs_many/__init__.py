"""Many robots: several configs, a folder of robots, or a sweep, on all cores or on a cluster."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import hookimpl

if TYPE_CHECKING:
    import argparse

    from urdf2mbs.plugin import Config, Lines

#: File name of the report of many robots.
REPORT = "urdf2mbs-report.json"


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    """Add options to ``run`` and ``convert``."""
    if command not in ("run", "convert"):
        return
    from urdf2mbs.plugin import path

    group = parser.add_argument_group("many robots")
    group.add_argument("--workers", type=int, metavar="N", help="processes (default: every core)")
    group.add_argument(
        "--cluster", metavar="ADDRESS", help="the address of a Dask scheduler to use instead"
    )
    group.add_argument(
        "--report",
        type=path,
        metavar="FILE.json",
        help=f"default: {REPORT} in the folder of all outputs",
    )


@hookimpl
def urdf2mbs_observe(arguments: argparse.Namespace) -> None:
    """Refuse these options for one robot."""
    from urdf2mbs.plugin import refuse

    refuse(arguments, ("workers", "cluster", "report"), "many robots, and this is one")


@hookimpl
def urdf2mbs_carry_out(
    command: str, configs: list[tuple[Config, Lines]], arguments: argparse.Namespace
) -> int:
    """Carry out ``run`` or ``convert`` for many robots."""
    from urdf2mbs_many.commands.many import convert_configs, convert_folder

    if command == "convert":
        return convert_folder(arguments)
    return convert_configs(configs, arguments)


@hookimpl
def urdf2mbs_expand_sweep(config: Config, lines: Lines) -> list[tuple[Config, str]]:
    """Return the config of each robot of a sweep, and its values in words."""
    from urdf2mbs_many.sweep import format_values, list_members

    return [
        (robot_config, format_values(values))
        for robot_config, values in list_members(config, lines)
    ]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    """Return where the functions for Python are."""
    package = "urdf2mbs_many"
    return {
        "Outcome": f"{package}.job:Outcome",
        "convert_many": f"{package}.convert:convert_many",
    }


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of messages and their meanings."""
    from urdf2mbs_many.codes import CODES

    return CODES
