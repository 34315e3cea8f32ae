"""A pass made of a function, for the plugins that tests write as text; a robot of a file."""

from collections.abc import Callable, Mapping
from pathlib import Path
from textwrap import dedent, indent
from typing import Any

import msgspec

from urdf2mbs.config.lines import Lines
from urdf2mbs.engine import order
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import Diagnostic
from urdf2mbs.plugin import Pass, hookimpl
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import read_robot_file, read_text

__all__ = ["hookimpl", "make", "passes_of", "read_robot", "write_plugin"]


def read_robot(
    source: Path, packages: Packages, xacro_args: Mapping[str, str]
) -> tuple[Robot, list[Diagnostic]]:
    """Read a robot; a file with xacro in it is expanded first."""
    hook, data = Plugins(installed=False).hook, read_robot_file(source)
    expansion = hook.urdf2mbs_read(
        source=source, data=data, packages=packages, args=xacro_args, trust=False
    )
    return read_text(source, data, expansion, xacro_args, hook.urdf2mbs_extension)


def passes_of(preset: str) -> list[str]:
    """The names of the passes of a built-in preset, in their order."""
    return order.expand_preset(preset, Plugins(installed=False), Lines())[0]


def make(
    name: str,
    run: Callable[[Any, Any], None],
    *,
    reads: tuple[str, ...] = (),
    writes: tuple[str, ...] = (),
) -> type[Pass]:
    """A pass without options that calls ``run(conversion, pass)``."""
    words = {
        "name": name,
        "reads": reads,
        "writes": writes,
        "__module__": run.__module__,
        "run": lambda self, conversion: run(conversion, self),
    }
    return msgspec.defstruct("Made", [], bases=(Pass,), namespace=words)  # type: ignore[return-value]


def write_plugin(
    folder: Path, name: str, does: str, *, reads: tuple[str, ...] = (), writes: tuple[str, ...] = ()
) -> Path:
    """The file NAME.py, a plugin whose one pass, of the same name, does these lines."""
    file = folder / f"{name}.py"
    file.write_text(
        "from support.plugin_files import hookimpl, make\n"
        f"def run(conversion, options):\n{indent(dedent(does), '    ')}\n"
        "@hookimpl\ndef urdf2mbs_passes():\n"
        f"    return [make({name!r}, run, reads={reads}, writes={writes})]\n"
    )
    return file
