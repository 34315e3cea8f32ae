"""`completion`: a script that completes commands and options in a shell.

Prints the script; a line of your shell's setup reads it, as in the examples.
"""

from __future__ import annotations

import argparse
import re

from urdf2mbs.plugin import not_installed, parser

EXAMPLES = (
    "urdf2mbs completion bash > ~/.local/share/bash-completion/completions/urdf2mbs",
    "urdf2mbs completion zsh > ~/.zfunc/_urdf2mbs     # with: fpath+=~/.zfunc; compinit",
    "urdf2mbs completion fish > ~/.config/fish/completions/urdf2mbs.fish",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("shell", choices=("bash", "zsh", "fish"), help="the shell that you use")


def carry_out(arguments: argparse.Namespace) -> int:
    try:
        import shtab
    except ImportError:
        raise not_installed("completion", "shtab") from None
    words = parser()
    for command in _commands(words):
        for action in command._actions:
            if action.metavar == "DIR":
                action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
            elif re.fullmatch(r"ROBOT|[A-Z]+\.[a-z]+", str(action.metavar)):
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(words, shell=arguments.shell))
    return 0


def _commands(words: argparse.ArgumentParser) -> list[argparse.ArgumentParser]:
    return [
        command
        for action in words._actions
        if isinstance(action, argparse._SubParsersAction)
        for command in action.choices.values()
    ]
