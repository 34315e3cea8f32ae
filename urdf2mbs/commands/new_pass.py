"""``urdf2mbs new-pass``: a plugin that runs as it is, and its test, to start from."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from urdf2mbs.commands.settings import add_telling, path
from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.engine.plugins import GROUP, Plugins
from urdf2mbs.output import write_files

EXAMPLES = (
    "urdf2mbs new-pass actuate",
    "urdf2mbs new-pass actuate -o our_passes",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", metavar="NAME", help="of the pass: small letters, digits, hyphens")
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR", default=".", help="default: here"
    )
    add_telling(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.commands.printing import print_json

    plugin, test = new_pass(arguments.name, arguments.output, force=arguments.force)
    if arguments.json:
        print_json({"plugin": str(plugin), "test": str(test)})
    else:
        print(in_words(arguments.name, plugin, test))
    return 0


PLUGIN = '''\
"""Tell which links are heavier than a limit.  (Say here what your pass does.)"""

from urdf2mbs.plugin import Conversion, Pass, hookimpl


class CLASS(Pass):
    """Tell which links are heavier than a limit."""

    name = "NAME"
    # what must be known before the pass runs; see the page on writing passes
    reads = ("robot",)

    # the options, which a config sets under ``passes: {NAME: {...}}``, with their defaults
    heavier_than: float = 1.0
    """Mass in kg."""

    def run(self, conversion: Conversion) -> None:
        for link in conversion.robot.links.values():
            mass = link.inertial.mass if link.inertial else 0.0
            if mass > self.heavier_than:
                conversion.note("heavy-link", f"link '{link.name}' has {mass:g} kg", link=link.name)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [CLASS]
'''

TEST = '''\
"""Run this with: pytest test_FILE.py"""

from pathlib import Path

from urdf2mbs.testing import assert_same_robot, convert_text, run_pass

PLUGIN = Path(__file__).with_name("FILE.py")


def test_heavy_links_are_told() -> None:
    result = run_pass("NAME", PLUGIN, after="expand", options={"heavier_than": 0.3})
    heavy = [found.link for found in result.diagnostics if found.code == "heavy-link"]
    assert heavy == ["body", "arm"]


def test_the_robot_stays_the_same() -> None:
    result = run_pass("NAME", PLUGIN, after="expand")
    assert_same_robot(result, expected=convert_text())
'''

NEXT = """\
wrote {plugin} and {test}

To use it, add to your config (paths there are relative to the config):

  plugins: [{plugin}]
  after: {{expand: {name}}}
  passes:
    {name}: {{heavier_than: 1.0}}

Then: urdf2mbs explain CONFIG.yaml   shows where it stands
      urdf2mbs run CONFIG.yaml -v    runs it
      pytest {test}"""


def new_pass(name: str, folder: Path, *, force: bool = False) -> tuple[Path, Path]:
    """Write NAME.py and test_NAME.py; gives both files.

    :raises ConfigError: ``pass-name``, ``output-not-ours``, ``output-unwritable``
    """
    stem = _stem(name)
    files = {
        folder / f"{stem}.py": PLUGIN,
        folder / f"test_{stem}.py": TEST,
    }
    write_files(
        {
            file: text.replace("NAME", name)
            .replace("CLASS", name.title().replace("-", ""))
            .replace("FILE", stem)
            .encode()
            for file, text in files.items()
        },
        force=force,
    )
    plugin, test = files
    return plugin, test


def in_words(name: str, plugin: Path, test: Path) -> str:
    """What was written, and what to do next."""
    return NEXT.format(plugin=plugin, test=test, name=name)


def _stem(name: str) -> str:
    """The name of the file for a pass; raises ConfigError where the name will not do."""
    fault = hint = ""
    stem = name.replace("-", "_")
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        words = re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).lower())
        better = re.sub(r"^[0-9-]+", "", "-".join(words))
        fault = "a pass is called by small letters, digits and hyphens, a letter first"
        hint = f"for instance: urdf2mbs new-pass {better or 'my-pass'}"
    elif name in Plugins(installed=False).passes:
        fault = "there is a built-in pass of this name"
        hint = "choose another; to replace that one, see 'swap' on the page on writing passes"
    elif stem in sys.stdlib_module_names or stem in (GROUP, "msgspec", "pytest"):
        fault = f"'{stem}.py' would hide Python's module '{stem}' from its test"
        hint = f"for instance: urdf2mbs new-pass {name}-links"
    if fault:
        raise ConfigError("pass-name", f"'{name}' cannot be the name of a pass: {fault}", hint=hint)
    return stem
