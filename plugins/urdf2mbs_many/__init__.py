"""Many robots: several configs, a folder of robots, or a sweep, on all cores or on a cluster."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import hookimpl

if TYPE_CHECKING:
    import argparse

    from urdf2mbs.plugin import Config, Lines

#: The name of the report of many robots.
REPORT = "urdf2mbs-report.json"


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    if command not in ("run", "convert"):
        return
    from urdf2mbs.plugin import path

    many = parser.add_argument_group("many robots")
    many.add_argument("--workers", type=int, metavar="N", help="processes (default: every core)")
    does = "the address of a Dask scheduler to use instead"
    many.add_argument("--cluster", metavar="ADDRESS", help=does)
    does = f"default: {REPORT} in the folder of all outputs"
    many.add_argument("--report", type=path, metavar="FILE.json", help=does)


@hookimpl
def urdf2mbs_observe(arguments: argparse.Namespace) -> None:
    from urdf2mbs.plugin import refuse

    refuse(arguments, ("workers", "cluster", "report"), "many robots, and this is one")


@hookimpl
def urdf2mbs_carry_out(
    command: str, configs: list[tuple[Config, Lines]], arguments: argparse.Namespace
) -> int:
    from urdf2mbs_many.commands.many import carry_out_folder, carry_out_many

    if command == "convert":
        return carry_out_folder(arguments)
    return carry_out_many(configs, arguments)


@hookimpl
def urdf2mbs_expand_sweep(config: Config, lines: Lines) -> list[tuple[Config, str]]:
    from urdf2mbs_many import sweep

    members = sweep.members(config, lines)
    return [(member.config, sweep.in_words(member.values)) for member in members]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    package = "urdf2mbs_many"
    return {
        "Outcome": f"{package}.job:Outcome",
        "convert_many": f"{package}.convert:convert_many",
    }


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_many.codes import CODES

    return CODES
