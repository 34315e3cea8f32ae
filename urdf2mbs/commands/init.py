"""`init`: a commented config for a robot."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from urdf2mbs.commands.settings import Parents, pairs


def add(commands: Any, parents: Parents) -> None:
    init = commands.add_parser(
        "init", parents=[parents.common], help="write a config for a robot, to start from"
    )
    init.add_argument(
        "robot", metavar="ROBOT", help="a .urdf or .xacro file, or robot_descriptions:NAME"
    )
    init.add_argument(
        "-o", "--output", type=Path, metavar="CONFIG.yaml", help="default: the robot's name, here"
    )
    init.add_argument("--base", choices=("auto", "floating", "fixed"), default="auto")
    init.add_argument("--package", action="append", default=[], metavar="NAME=DIR")
    init.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )
    init.set_defaults(command=_init)


def _init(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.init import init

    print(
        init(
            arguments.robot,
            arguments.output,
            base=arguments.base,
            packages=dict(pairs(arguments.package, "=", "--package", "NAME=DIR")),
            xacro_args=dict(pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        )
    )
    return 0
