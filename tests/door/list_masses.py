"""`masses`: list the mass (kg) of each body of an .mbs; 'run --masses' writes masses.csv."""

import argparse

from urdf2mbs.plugin import Command, Conversion, Pass, hookimpl, path, read_mbs_file

EXAMPLES = ("urdf2mbs masses robot.mbs",)
ROW = "{0.name},{0.mass}\n"


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    return [Command("masses", "list the mass of each body of an .mbs", __name__)]


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("model", type=path, metavar="MODEL.mbs", help="an .mbs file")


def carry_out(arguments: argparse.Namespace) -> int:
    print("".join(map(ROW.format, read_mbs_file(arguments.model).bodies)), end="")
    return 0


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    if command in ("run", "convert"):
        parser.add_argument("--masses", action="store_true", help="write masses.csv, too")


@hookimpl
def urdf2mbs_observe(arguments: argparse.Namespace) -> object | None:
    return AddMasses() if arguments.masses else None


class AddMasses:
    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Conversion) -> None:
        if pass_.name == "emit":
            conversion.add_file("masses.csv", "".join(map(ROW.format, conversion.mbs.bodies)))
