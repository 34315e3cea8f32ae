"""``urdf2mbs new-plugin``: write a package that already installs and runs, to start from.

Writes the folder NAME: a package with one pass and one preset, its tests, an
example robot, a README, and checks for GitHub.  Replaces no file.
"""

from __future__ import annotations

import argparse
import os
import sys
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path

from urdf2mbs.plugin import (
    ConfigError,
    Plugins,
    add_printing,
    counted,
    near,
    path,
    print_json,
    some,
)
from urdf2mbs_setup.commands.new_pass import NAME, fill_template, suggest_name

EXAMPLES = (
    "urdf2mbs new-plugin our-lab",
    "urdf2mbs new-plugin our-lab -o ~/src",
)

#: The template of each file.  NAME, PACKAGE and CLASS are placeholders, in the names of files, too.
FILES = {
    "pyproject.toml": "pyproject.toml.in",
    "README.md": "README.md.in",
    "PACKAGE/__init__.py": "plugin.py.in",
    "PACKAGE/passes/__init__.py": "passes.py.in",
    "PACKAGE/passes/PACKAGE_payload.py": "payload.py.in",
    "tests/test_PACKAGE.py": "test.py.in",
    "robots/arm.urdf": "arm.urdf.in",
    "robots/arm.yaml": "arm.yaml.in",
    ".github/workflows/robots.yml": "robots.yml.in",
    ".gitignore": "gitignore.in",
}
TEMPLATES = Path(__file__).with_name("templates") / "package"

NEXT = """\
Next: pip install -e {folder}
      urdf2mbs run {folder}/robots/arm.yaml
      pytest {folder}/tests
{folder}/README.md explains the files, and how to check your robots on GitHub"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    command.add_argument(
        "name", metavar="NAME", help="the name of the plugin: small letters, digits, hyphens"
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="DIR",
        default=".",
        help="where the folder NAME is made; default: here",
    )
    add_printing(command, writes=False)


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the package, and print how to use it."""
    folder, files = new_plugin(arguments.name, Path(arguments.output))
    if arguments.json:
        print_json({"folder": str(folder), "files": [str(file) for file in files]})
        return 0
    print(f"wrote {counted(len(files), 'file')} in {near(folder)}:")
    for file in files:
        print(f"  {file.relative_to(folder).as_posix()}")
    print(NEXT.format(folder=near(folder)))
    return 0


def new_plugin(name: str, parent: Path) -> tuple[Path, list[Path]]:
    """Write the package of a plugin.

    Args:
        name: Name of the plugin, its preset and its package.
        parent: Folder in which the folder of that name is made.

    Returns:
        The folder, and the files in it.

    Raises:
        ConfigError: ``plugin-name``, ``output-not-ours`` (nothing is written), or
            ``output-unwritable``.
    """
    _check_name(name)
    replacements = {
        "PACKAGE": name.replace("-", "_"),
        "NAME": name,
        # urdf2mbs derives the class of a pass from its name in the same manner
        "CLASS": name.title().replace("-", ""),
    }
    folder = parent / name
    file_contents = {
        folder / fill_template(file, replacements): fill_template(
            (TEMPLATES / template).read_text("utf-8"), replacements
        )
        for file, template in FILES.items()
    }
    existing = [f"'{file}'" for file in file_contents if os.path.lexists(file)]
    if existing:
        verb = "exists" if len(existing) == 1 else "exist"
        message = f"{some(existing, 3)} {verb} already: nothing is written"
        hint = "choose another name, or another folder by -o DIR"
        raise ConfigError("output-not-ours", message, hint=hint)
    for file, content in file_contents.items():
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with file.open("x", encoding="utf-8", newline="\n") as stream:
                stream.write(content)
        except OSError as error:
            message = f"cannot write '{file}': {error.strerror}"
            raise ConfigError("output-unwritable", message) from None
    return folder, list(file_contents)


def _check_name(plugin_name: str) -> None:
    """Raise ConfigError for a name that no plugin can have."""
    package = plugin_name.replace("-", "_")
    hint = f"for instance: urdf2mbs new-plugin {plugin_name}-lab"
    if not NAME.fullmatch(plugin_name):
        reason = "expected small letters, digits and hyphens, a letter first"
        hint = f"for instance: urdf2mbs new-plugin {suggest_name(plugin_name) or 'our-lab'}"
    elif package in (*sys.stdlib_module_names, "tests", "robots") or iskeyword(package):
        reason = f"Python or the folders of the package use '{package}' for something else"
    elif package.startswith("urdf2mbs") or find_spec(f"urdf2mbs_{package}") is not None:
        reason = "urdf2mbs has a plugin of this name"
        hint = "for instance: urdf2mbs new-plugin our-lab"
    elif plugin_name in Plugins(installed=False).presets:
        reason = "urdf2mbs has a preset of this name"
    elif find_spec(package) is not None:
        reason = f"a Python package '{package}' is installed here, which it would hide"
    else:
        return
    message = f"'{plugin_name}' cannot be the name of a plugin: {reason}"
    raise ConfigError("plugin-name", message, hint=hint)
