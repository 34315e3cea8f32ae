"""``urdf2mbs doctor``: the versions of the installed packages and tools.

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
    """Print the tables of the installation."""
    tables = examine(installed_plugins=not arguments.no_plugins)
    if arguments.json:
        print_json(tables)
        return 0
    for title, table in tables.items():
        print(title)
        name_width = max(map(len, table), default=0)
        for entry_name, entry_text in table.items():
            indented_text = indent(entry_text, " " * (name_width + 4)).lstrip()
            print(f"  {entry_name:{name_width}}  {indented_text}")
    return 0


def examine(*, installed_plugins: bool = True) -> dict[str, dict[str, str]]:
    """Return the tables of the installation by title: versions and paths by name."""
    requirements = [
        requirement for requirement in requires("urdf2mbs") or [] if "extra ==" not in requirement
    ]
    package_names = [
        re.split(r"[^\w.-]", requirement, maxsplit=1)[0] for requirement in requirements
    ]
    plugins = Plugins(installed=installed_plugins)
    entries_of_plugins: list[dict[str, str]] = plugins.hook.urdf2mbs_doctor()
    return {
        "urdf2mbs": {
            "urdf2mbs": f"{version('urdf2mbs')} ({Path(plugin.__file__).parent})",
            "Python": f"{platform.python_version()} ({sys.executable})",
            "system": f"{platform.system()} {platform.machine()}",
            **{
                entry_name: entry_text
                for plugin_entries in entries_of_plugins
                for entry_name, entry_text in plugin_entries.items()
            },
            **{
                package_name: version_of(package_name) or "MISSING"
                for package_name in package_names
            },
            **{
                package_name: version_of(package_name) or f"not installed, for {purpose}"
                for package_name, purpose in EXTRAS.items()
            },
        },
        "plugins": list_plugins(plugins, installed=installed_plugins),
        "ROS packages": {  # packages beside a robot's file are found without ROS
            variable_name: os.environ.get(variable_name) or "not set"
            for variable_name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
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
    loaded_plugins = {
        implementation.plugin_name: implementation.plugin
        for hook_name, hook in vars(plugins.hook).items()
        if hook_name.startswith(f"{GROUP}_")
        for implementation in hook.get_hookimpls()
    }
    descriptions = {
        plugin_name: "urdf2mbs"
        for plugin_name in loaded_plugins
        if plugin_name not in packages and plugin_name != GROUP
    }
    for plugin_name, package in packages.items():
        if plugin_name in loaded_plugins:
            descriptions[plugin_name] = (
                f"{package} ({getattr(loaded_plugins[plugin_name], '__file__', None)})"
            )
        else:
            error_texts = [
                str(plugin_error)
                for plugin_error in plugins.broken
                if f"'{plugin_name}'" in plugin_error.message
            ]
            descriptions[plugin_name] = "\n".join([f"{package} is BROKEN", *error_texts])
    if not installed:
        descriptions["others"] = "left out by --no-plugins"
    elif not packages:
        descriptions["others"] = f"none: no installed package has an entry point '{GROUP}'"
    return descriptions
