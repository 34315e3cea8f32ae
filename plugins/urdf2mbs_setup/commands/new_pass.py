"""``urdf2mbs new-pass``: write a plugin that already runs, and its test, to start from.

Writes NAME.py, a pass that already runs, and test_NAME.py, which tests it.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from urdf2mbs.plugin import GROUP, ConfigError, Plugins, add_printing, path, print_json, write_files

EXAMPLES = (
    "urdf2mbs new-pass actuate",
    "urdf2mbs new-pass actuate -o our_passes",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    command.add_argument(
        "name", metavar="NAME", help="the name of the pass: small letters, digits, hyphens"
    )
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR", default=".", help="default: here"
    )
    add_printing(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the plugin, and print how to use it."""
    plugin_file, test_file = new_pass(arguments.name, arguments.output, force=arguments.force)
    if arguments.json:
        print_json({"plugin": str(plugin_file), "test": str(test_file)})
    else:
        print(NEXT.format(plugin=plugin_file, test=test_file, name=arguments.name))
    return 0


#: Names of passes and plugins.
NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
#: NAME, CLASS and FILE are the placeholders of the templates.
TEMPLATES = Path(__file__).with_name("templates")

NEXT = """\
wrote {plugin} and {test}

To use it, add to your config (paths there are relative to the config):

  plugins: [{plugin}]
  passes:
    {name}: {{heavier_than: 1.0}}

Then: urdf2mbs explain CONFIG.yaml   shows its place
      urdf2mbs run CONFIG.yaml -v    runs it
      pytest {test}"""


def new_pass(name: str, folder: Path, *, force: bool = False) -> tuple[Path, Path]:
    """Write NAME.py and test_NAME.py.

    Args:
        name: Name of the pass.
        folder: Folder of both files.
        force: Replace files that urdf2mbs did not write.

    Returns:
        Both files.

    Raises:
        ConfigError: ``pass-name``, ``output-not-ours`` or ``output-unwritable``.
    """
    file_stem = _get_file_stem(name)
    plugin_file, test_file = folder / f"{file_stem}.py", folder / f"test_{file_stem}.py"
    replacements = {"NAME": name, "CLASS": name.title().replace("-", ""), "FILE": file_stem}
    files = {}
    for output_file, template in ((plugin_file, "plugin.py.in"), (test_file, "test_plugin.py.in")):
        content = fill_template((TEMPLATES / template).read_text("utf-8"), replacements)
        files[output_file] = content.encode()
    write_files(files, force=force)
    return plugin_file, test_file


def fill_template(template: str, replacements: Mapping[str, str]) -> str:
    """Return a template with its placeholders replaced."""
    for placeholder, replacement in replacements.items():
        template = template.replace(placeholder, replacement)
    return template


def suggest_name(name: str) -> str:
    """Return the name with small letters, digits and hyphens only; may be empty."""
    words = re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).lower())
    return re.sub(r"^[0-9-]+", "", "-".join(words))


def _get_file_stem(pass_name: str) -> str:
    """Return the stem of the file for a pass; raise ConfigError if no pass can have the name."""
    file_stem = pass_name.replace("-", "_")
    builtin_passes = Plugins(installed=False).passes
    if not NAME.fullmatch(pass_name):
        suggestion = suggest_name(pass_name) or "my-pass"
        suggestion += "-links" if suggestion in builtin_passes else ""
        reason = "expected small letters, digits and hyphens, a letter first"
        hint = f"for instance: urdf2mbs new-pass {suggestion}"
    elif pass_name in builtin_passes:
        reason = "a built-in pass has this name"
        hint = "choose another; to replace that pass, see 'swap' on the page on writing passes"
    elif file_stem in sys.stdlib_module_names or file_stem in (GROUP, "msgspec", "pytest"):
        reason = f"'{file_stem}.py' would hide Python's module '{file_stem}' from its test"
        hint = f"for instance: urdf2mbs new-pass {pass_name}-links"
    else:
        return file_stem
    raise ConfigError(
        "pass-name", f"'{pass_name}' cannot be the name of a pass: {reason}", hint=hint
    )
