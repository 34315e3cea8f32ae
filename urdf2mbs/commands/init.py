"""`init`: a commented config for a robot."""

from __future__ import annotations

import argparse

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import pairs
from urdf2mbs.commands.streams import STREAM
from urdf2mbs.diagnostics import ConfigError


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
        force=arguments.force,
        trust_xacro=arguments.trust_xacro,
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
