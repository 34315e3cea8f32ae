"""`init`: a commented config for a robot."""

from __future__ import annotations

import argparse

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import add_base, add_isolate, add_robot, add_telling, pairs, path
from urdf2mbs.commands.streams import STREAM
from urdf2mbs.diagnostics import ConfigError

EXAMPLES = (
    "urdf2mbs init robot.urdf.xacro",
    "urdf2mbs init robot_descriptions:atlas_v4_description",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "robot", metavar="ROBOT", help="a .urdf or .xacro file, or robot_descriptions:NAME"
    )
    command.add_argument(
        "-o", "--output", type=path, metavar="CONFIG.yaml", help="default: the robot's name, here"
    )
    add_telling(command)
    add_base(command)
    add_robot(command)
    add_isolate(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.init import in_words, init

    if arguments.robot == STREAM:
        raise ConfigError("usage", "a config names the robot's file, and standard input has none")
    config, found = init(
        arguments.robot,
        arguments.output,
        base=arguments.base or "auto",
        packages=dict(pairs(arguments.package, "=", "--package", "NAME=DIR")),
        xacro_args=dict(pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        isolate=arguments.isolate,
    )
    if arguments.json:
        more = {key: value for key, value in found._asdict().items() if key != "robot"}
        declared = [one._asdict() for one in found.arguments]
        packages = {name: str(folder) for name, folder in found.packages.items()}
        print_json(
            {"config": str(config), "robot": found.robot.name, "links": len(found.robot.links),
             **more, "packages": packages, "arguments": declared}
        )  # fmt: skip
    else:
        print(in_words(config, found))
    return 0
