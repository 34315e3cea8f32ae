"""`doctor`: what of urdf2mbs, of ROS and of Robotran is on this machine."""

from __future__ import annotations

import argparse

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import add_json, add_no_plugins

EXAMPLES = (
    "urdf2mbs doctor",
    "urdf2mbs doctor --json",
)


def add_options(command: argparse.ArgumentParser) -> None:
    add_json(command)
    add_no_plugins(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.doctor import examine

    found = examine(installed_plugins=not arguments.no_plugins)
    if arguments.json:
        print_json(found)
        return 0
    for title, lines in found.items():
        print(title)
        width = max(map(len, lines), default=0)
        for name, text in lines.items():
            print(f"  {name:{width}}  {text}")
    return 0
