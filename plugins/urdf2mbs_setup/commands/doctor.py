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
from importlib.metadata import entry_points, requires, version
from pathlib import Path
from textwrap import indent

from urdf2mbs import plugin
from urdf2mbs.plugin import GROUP, Plugins, add_json, add_no_plugins, print_json, version_of

#: Packages that a user installs when they are needed, and what for.
EXTRAS = {
    "distributed": "run --cluster",
    "pillow": "textures of meshes",
    "robot_descriptions": "robots by their names",
    "shtab": "completion",
    "ziglang": "pages with a robot that moves by itself",
}

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
            margin = " " * (width + 4)
            print(f"  {name:{width}}  {indent(text, margin).lstrip()}")
    return 0


def examine(*, installed_plugins: bool = True) -> dict[str, dict[str, str]]:
    """Return the titles of the tables, and the lines of each by their names."""
    needed = [line for line in requires("urdf2mbs") or [] if "extra ==" not in line]
    names = [re.split(r"[^\w.-]", line, maxsplit=1)[0] for line in needed]
    plugins = Plugins(installed=installed_plugins)
    by_plugins: list[dict[str, str]] = plugins.hook.urdf2mbs_doctor()
    packages = {name: version_of(name) or "MISSING" for name in names}
    extras = {name: version_of(name) or f"not installed, for {use}" for name, use in EXTRAS.items()}
    return {
        "urdf2mbs": {
            "urdf2mbs": f"{version('urdf2mbs')} ({Path(plugin.__file__).parent})",
            "Python": f"{platform.python_version()} ({sys.executable})",
            "system": f"{platform.system()} {platform.machine()}",
            **{name: line for lines in by_plugins for name, line in lines.items()},
            **packages,
            **extras,
        },
        "plugins": list_plugins(plugins, installed=installed_plugins),
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


def list_plugins(plugins: Plugins, *, installed: bool) -> dict[str, str]:
    """Return every plugin by its name: its package, its file, and what it brings.

    Args:
        plugins: The plugins at hand.
        installed: Whether installed packages were asked; a broken one says why it is left out.
    """
    packages = {
        entry.name: f"{entry.dist.name} {entry.dist.version}"
        for entry in (entry_points(group=GROUP) if installed else ())
        if entry.dist is not None and entry.dist.name != GROUP  # ours are in urdf2mbs itself
    }
    brought: dict[str, list[str]] = {}
    files: dict[str, str] = {}
    for name, hook in vars(plugins.hook).items():
        for impl in hook.get_hookimpls() if name.startswith(f"{GROUP}_") else ():
            hooks = brought.setdefault(impl.plugin_name, [])
            hooks.append(name.removeprefix(f"{GROUP}_").replace("_", " "))
            files[impl.plugin_name] = str(getattr(impl.plugin, "__file__", None) or "")
    lines = {}
    for name, hooks in brought.items():
        if name != GROUP:  # the core's own passes
            package = packages.get(name, "urdf2mbs")
            where = f" ({files[name]})" if name in packages else ""
            lines[name] = f"{package}{where}: {', '.join(sorted(hooks))}"
    for name, package in packages.items():
        if name not in brought:
            reasons = [broken for broken in plugins.broken if f"'{name}'" in broken.message]
            lines[name] = "\n".join([f"{package} is BROKEN", *map(str, reasons)])
    if not installed:
        lines["others"] = "left out by --no-plugins"
    elif not packages:
        lines["others"] = f"none: no installed package has an entry point '{GROUP}'"
    return lines
