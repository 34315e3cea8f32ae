"""``urdf2mbs doctor``: what is installed here, by names and versions; nothing is changed."""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import sys
from importlib.metadata import requires, version
from importlib.util import find_spec
from pathlib import Path

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import add_json, add_no_plugins
from urdf2mbs.engine.plugins import GROUP, Plugins, version_of

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
    return {
        "urdf2mbs": _versions(),
        "extras": {"cluster": _extra("cluster", "run --cluster")},
        "plugins": _plugins(installed_plugins),
        "ROS packages": _packages(),
        "Robotran": _robotran(),
    }


def _versions() -> dict[str, str]:
    from urdf2mbs.runtime.c_code import compiler

    needed = _requirements("")
    return {
        "urdf2mbs": f"{version('urdf2mbs')} ({Path(__file__).parents[1]})",
        "Python": f"{platform.python_version()} ({sys.executable})",
        "system": f"{platform.system()} {platform.machine()}",
        "C compiler": compiler() or "none: simulations run in Python",
        **{name: version_of(name) or "MISSING" for name in needed},
    }


def _requirements(extra: str) -> list[str]:
    """The packages that an extra brings; those that are always needed for ""."""
    found = []
    for line in requires("urdf2mbs") or []:
        name = re.split(r"[^\w.-]", line, maxsplit=1)[0]
        of = re.search(r"extra == ['\"]([\w-]+)['\"]", line)
        if (of[1] if of else "") == extra and name != "urdf2mbs":
            found.append(name)
    return found


def _extra(extra: str, use: str) -> str:
    there = {name: version_of(name) for name in _requirements(extra)}
    missing = [name for name, found in there.items() if not found]
    if missing:
        return f"not installed, for {use}: pip install {' '.join(missing)}"
    return ", ".join(f"{name} {found}" for name, found in there.items())


def _plugins(installed: bool) -> dict[str, str]:
    plugins = Plugins(installed=installed)
    lines = {
        pass_.plugin: f"{pass_.package} {pass_.version}".strip() or str(pass_.file)
        for offered in plugins.passes.values()
        for pass_ in offered
        if pass_.plugin != GROUP
    }
    broken = {f"broken {n}": str(said) for n, said in enumerate(plugins.broken, start=1)}
    return {**lines, **broken} or {"none": "no package with an entry point 'urdf2mbs'"}


def _packages() -> dict[str, str]:
    """Where ROS says that packages are; those around a robot's file are found without it."""
    names = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
    return {name: os.environ.get(name) or "not set" for name in names}


def _robotran() -> dict[str, str]:
    mbsyspy = find_spec("MBsysPy")
    editor = shutil.which("MBsysPad") or shutil.which("mbsyspad") or shutil.which("MBSysPad")
    return {
        "MBsysPy": f"{version_of('MBsysPy')} {mbsyspy.origin}".strip()
        if mbsyspy
        else "not installed: simulations in Python want it (https://www.robotran.eu)",
        "MBSysPad": editor or "not on the PATH: it shows and edits .mbs files",
        "cmake": shutil.which("cmake") or "not on the PATH: projects in C want it",
    }
