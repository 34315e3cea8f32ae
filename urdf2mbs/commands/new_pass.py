"""`new-pass`: a plugin with one pass, and its test."""

from __future__ import annotations

import argparse


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.new_pass import new_pass

    print(new_pass(arguments.name, arguments.output))
    return 0
