"""`new-pass`: a plugin with one pass, and its test."""

from __future__ import annotations

import argparse


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.commands.printing import print_json
    from urdf2mbs.kit.new_pass import in_words, new_pass

    plugin, test = new_pass(arguments.name, arguments.output, force=arguments.force)
    if arguments.json:
        print_json({"plugin": str(plugin), "test": str(test)})
    else:
        print(in_words(arguments.name, plugin, test))
    return 0
