"""`masses`: list the mass of each body of an .mbs.

Prints the bodies, the heaviest first, and their sum (kg).
"""

import argparse

from urdf2mbs.plugin import Command, add_json, hookimpl, path, print_json, read_mbs_file

EXAMPLES = ("urdf2mbs masses robot.mbs", "urdf2mbs masses robot.mbs --json")


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    return [Command("masses", "list the mass of each body of an .mbs", __name__)]


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("model", type=path, metavar="MODEL.mbs", help="an .mbs file")
    add_json(command)


def carry_out(arguments: argparse.Namespace) -> int:
    masses = {body.name: body.mass or 0.0 for body in read_mbs_file(arguments.model).bodies}
    heaviest_first = dict(sorted(masses.items(), key=lambda item: -item[1]))
    if arguments.json:
        print_json(heaviest_first)
        return 0
    for name, mass in heaviest_first.items():
        print(f"{mass:10.4g} kg  {name}")
    print(f"{sum(masses.values()):10.4g} kg  in all")
    return 0
