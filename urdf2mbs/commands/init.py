"""`init`: a commented config for a robot."""

from __future__ import annotations

import argparse

from urdf2mbs.commands.settings import pairs


def carry_out(arguments: argparse.Namespace) -> int:
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
