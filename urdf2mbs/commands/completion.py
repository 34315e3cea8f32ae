"""`completion`: a script that completes commands and options in a shell."""

from __future__ import annotations

import argparse

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.options import parser


def carry_out(arguments: argparse.Namespace) -> int:
    try:
        import shtab
    except ImportError:
        raise ConfigError(
            "extra-missing",
            "completion needs the package 'shtab', which is not installed",
            hint="pip install 'urdf2mbs[completion]'",
        ) from None
    print(shtab.complete(parser(), shell=arguments.shell))
    return 0
