"""``urdf2mbs doctor``: the versions of what is installed; nothing is changed.

Looks for Python packages, a C compiler, plugins, ROS packages and Robotran.
Changes nothing.  Add its output to a bug report.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import sys
from importlib.metadata import entry_points, requires, version
from pathlib import Path
from textwrap import indent

from urdf2mbs import plugin
from urdf2mbs.plugin import GROUP, Plugins, add_json, add_no_plugins, print_json, version_of

#: Optional packages, and their purpose.
EXTRAS = {
    "distributed": "run --cluster",
    "pillow": "textures of meshes",
    "robot_descriptions": "robots by their names",
    "ziglang": "a C compiler, if the system has none",
}

EXAMPLES = (
    "urdf2mbs doctor",
    "urdf2mbs doctor --json",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_json(command)
    add_no_plugins(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Print the tables of what is installed."""
    tables = examine(installed_plugins=not arguments.no_plugins)
    if arguments.json:
        print_json(tables)
        return 0
    for title, lines in tables.items():
        print(title)
        width = max(map(len, lines), default=0)
        for name, text in lines.items():
            print(f"  {name:{width}}  {indent(text, ' ' * (width + 4)).lstrip()}")
    return 0


def examine(*, installed_plugins: bool = True) -> dict[str, dict[str, str]]:
    """Return tables of what is installed: a text by name, by the titles of the tables."""
    requirements = [line for line in requires("urdf2mbs") or [] if "extra ==" not in line]
    names = [re.split(r"[^\w.-]", line, maxsplit=1)[0] for line in requirements]
    plugins = Plugins(installed=installed_plugins)
    lines_of_plugins: list[dict[str, str]] = plugins.hook.urdf2mbs_doctor()
    return {
        "urdf2mbs": {
            "urdf2mbs": f"{version('urdf2mbs')} ({Path(plugin.__file__).parent})",
            "Python": f"{platform.python_version()} ({sys.executable})",
            "system": f"{platform.system()} {platform.machine()}",
            **{name: line for lines in lines_of_plugins for name, line in lines.items()},
            **{name: version_of(name) or "MISSING" for name in names},
            **{
                name: version_of(name) or f"not installed, for {purpose}"
                for name, purpose in EXTRAS.items()
            },
        },
        "plugins": list_plugins(plugins, installed=installed_plugins),
        "ROS packages": {  # packages beside a robot's file are found without ROS
            name: os.environ.get(name) or "not set"
            for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
        },
        "Robotran": {
            "MBsysPy": version_of("MBsysPy")
            or "not installed (pip finds it in https://www.robotran.eu/dist/)",
            "MBSysPad": shutil.which("MBsysPad") or shutil.which("MBSysPad") or "not on the PATH",
            "cmake": shutil.which("cmake") or "not on the PATH: projects in C require it",
        },
    }


def list_plugins(plugins: Plugins, *, installed: bool) -> dict[str, str]:
    """Return the package and file of every plugin, by its name.

    Args:
        plugins: The plugins that were loaded.
        installed: Whether plugins of installed packages were loaded; a broken one has its error.
    """
    packages = {
        entry.name: f"{entry.dist.name} {entry.dist.version}"
        for entry in (entry_points(group=GROUP) if installed else ())
        if entry.dist is not None and entry.dist.name != GROUP
    }
    loaded = {
        implementation.plugin_name: implementation.plugin
        for name, hook in vars(plugins.hook).items()
        if name.startswith(f"{GROUP}_")
        for implementation in hook.get_hookimpls()
    }
    lines = {name: "urdf2mbs" for name in loaded if name not in packages and name != GROUP}
    for name, package in packages.items():
        if name in loaded:
            lines[name] = f"{package} ({getattr(loaded[name], '__file__', None)})"
        else:
            errors = [str(broken) for broken in plugins.broken if f"'{name}'" in broken.message]
            lines[name] = "\n".join([f"{package} is BROKEN", *errors])
    if not installed:
        lines["others"] = "left out by --no-plugins"
    elif not packages:
        lines["others"] = f"none: no installed package has an entry point '{GROUP}'"
    return lines
