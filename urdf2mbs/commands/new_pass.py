"""`new-pass`: a plugin with one pass, and its test."""

from __future__ import annotations

import argparse

from urdf2mbs.commands.settings import add_telling, path

EXAMPLES = (
    "urdf2mbs new-pass actuate",
    "urdf2mbs new-pass actuate -o our_passes",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", metavar="NAME", help="of the pass: small letters, digits, hyphens")
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR", default=".", help="default: here"
    )
    add_telling(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.commands.printing import print_json
    from urdf2mbs.kit.new_pass import in_words, new_pass

    plugin, test = new_pass(arguments.name, arguments.output)
    if arguments.json:
        print_json({"plugin": str(plugin), "test": str(test)})
    else:
        print(in_words(arguments.name, plugin, test))
    return 0
