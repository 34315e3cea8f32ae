"""``urdf2mbs doctor``: what is installed here, by names and versions; nothing is changed.

Looks for Python packages, a C compiler, plugins, ROS packages and Robotran.
Changes nothing.  A report of a mistake should have what doctor prints.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import sys
from importlib.metadata import requires, version
from pathlib import Path

from urdf2mbs import plugin
from urdf2mbs.plugin import Plugins, add_json, add_no_plugins, print_json, version_of

#: Packages that a user installs when they are needed, and what for.
EXTRAS = {
    "distributed": "run --cluster", "pillow": "textures of meshes",
    "robot_descriptions": "robots by their names", "shtab": "completion",
}  # fmt: skip

EXAMPLES = (
    "urdf2mbs doctor",
    "urdf2mbs doctor --json",
)


def add_options(command: argparse.ArgumentParser) -> None:
    add_json(command)
    add_no_plugins(command)


def carry_out(arguments: argparse.Namespace) -> int:
    found = examine(installed_plugins=not arguments.no_plugins)
    if arguments.json:
        print_json(found)
        return 0
    for title, lines in found.items():
        print(title)
        width = max(map(len, lines), default=0)
        for name, text in lines.items():
            print(f"  {name:{width}}  {text}")
    return 0


def examine(*, installed_plugins: bool = True) -> dict[str, dict[str, str]]:
    """Titles, and below each the lines of its table."""
    needed = [line for line in requires("urdf2mbs") or [] if "extra ==" not in line]
    names = [re.split(r"[^\w.-]", line, maxsplit=1)[0] for line in needed]
    plugins = Plugins(installed=installed_plugins)
    compiler = plugins.find("compiler")
    listed = {f"broken {number}": str(said) for number, said in enumerate(plugins.broken, start=1)}
    for found in (one for offered in plugins.passes.values() for one in offered):
        if not found.is_ours:
            listed[found.plugin] = f"{found.package} {found.version}"
    return {
        "urdf2mbs": {
            "urdf2mbs": f"{version('urdf2mbs')} ({Path(plugin.__file__).parent})",
            "Python": f"{platform.python_version()} ({sys.executable})",
            "system": f"{platform.system()} {platform.machine()}",
            "C compiler": (compiler and compiler()) or "none: simulations run in Python",
            **{name: version_of(name) or "MISSING" for name in names},
            **{
                name: version_of(name) or f"not installed, for {use}"
                for name, use in EXTRAS.items()
            },
        },
        "plugins": listed or {"none": "no package has an entry point 'urdf2mbs'"},
        # packages around a robot's file are found without ROS
        "ROS packages": {
            name: os.environ.get(name) or "not set"
            for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
        },
        "Robotran": {
            "MBsysPy": version_of("MBsysPy") or "not installed (https://www.robotran.eu)",
            "MBSysPad": shutil.which("MBsysPad") or shutil.which("MBSysPad") or "not on the PATH",
            "cmake": shutil.which("cmake") or "not on the PATH: projects in C want it",
        },
    }
