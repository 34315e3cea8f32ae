"""`doctor`: what of urdf2mbs, of ROS and of Robotran is on this machine."""

from __future__ import annotations

import argparse
from typing import Any

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import Parents


def add(commands: Any, parents: Parents) -> None:
    doctor = commands.add_parser(
        "doctor", parents=[parents.common],
        help="show versions, extras, plugins, ROS packages and Robotran as they are here",
    )  # fmt: skip
    doctor.set_defaults(command=_doctor)


def _doctor(arguments: argparse.Namespace) -> int:
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
