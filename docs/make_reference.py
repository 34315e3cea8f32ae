"""Write the pages docs/codes.md and docs/config.md: python docs/make_reference.py."""

import json
import re
from importlib import import_module
from pathlib import Path
from typing import Any

from urdf2mbs.engine.plugins import Plugins
from urdf2mbs_setup.commands.schema import make_schema

ROOT = Path(__file__).resolve().parents[1]
HEAD = (
    "# All codes\n\n"
    "The codes of all messages, and what to do. [Errors, warnings, notes](diagnostics.md) explains "
    "the levels, and how to set them. `python docs/make_reference.py` writes this page.\n"
)
CONFIG_HEAD = """# Config

A config is a YAML file. `urdf2mbs init ROBOT` writes one with comments. Paths are relative to its
folder; `~` and `$VARIABLE` are filled in.
"""
CONFIG_TAIL = """Below `passes` are the options of [each pass](passes.md): `urdf2mbs explain PASS`
shows them. `urdf2mbs schema` prints all this as a JSON schema,
[for your editor](write-a-pass.md#in-your-editor).
`python docs/make_reference.py` writes this page.
"""
#: Bounds of numbers in a JSON schema, and how a table names each.
BOUNDS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}


def make_codes() -> str:
    """Return the page: a list for each room and plugin, in which names of passes are links."""
    lines = [HEAD]
    for folder, package in (("urdf2mbs", "urdf2mbs."), ("plugins", "")):
        for file in sorted((ROOT / folder).glob("*/codes.py")):
            module = import_module(f"{package}{file.parent.name}.codes")
            title = (module.__doc__ or "").replace("``", "`").strip().rstrip(".")
            lines += [f"## {title}", ""]
            for code, text in module.CODES.items():
                level, _, meaning = text.partition(": ")
                meaning = re.sub("`([a-z-]+)`", link_pass, meaning)
                lines.append(f"- **`{code}`** ({level}): {meaning}")
            lines.append("")
    return "\n".join(lines)


def link_pass(name: re.Match[str]) -> str:
    """Return a link to the page of a pass; any other name as it is."""
    page = f"passes/{name[1]}.md"
    return f"[{name[0]}]({page})" if (ROOT / "docs" / page).exists() else name[0]


def make_config() -> str:
    """Return the page of the keys of a config."""
    table = make_table("key", make_schema(Plugins(installed=False)))
    return "\n".join([CONFIG_HEAD, *table, "", CONFIG_TAIL])


def make_table(what: str, schema: dict[str, Any]) -> list[str]:
    """Return the properties of a JSON schema: default, description and range of each."""
    rows = [f"| {what} | default | |", "|---|---|---|"]
    for key, one in schema["properties"].items():
        required = key in schema.get("required", ())
        default = "must be given" if required else f"`{json.dumps(one['default'])}`"
        ranges = [
            f"{words} {kind[bound]:g}"
            for kind in (one, *one.get("anyOf", ()))
            for bound, words in BOUNDS.items()
            if bound in kind
        ]
        limits = f" ({', '.join(ranges)})" if ranges else ""
        rows.append(f"| `{key}` | {default} | {one.get('description', '')}{limits} |")
    return rows


#: The pages, and what makes each.
PAGES = {"codes.md": make_codes, "config.md": make_config}

if __name__ == "__main__":
    for name, make in PAGES.items():
        (ROOT / "docs" / name).write_text(make(), encoding="utf-8")
