"""Write the page of all codes, docs/codes.md: python docs/make_codes.py."""

import re
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "codes.md"
HEAD = (
    "# All codes\n\n"
    "The codes of all messages, and what to do. [Errors, warnings, notes](diagnostics.md) explains "
    "the levels, and how to set them. `python docs/make_codes.py` writes this page.\n"
)


def make_codes() -> str:
    """Return the page: a table for each room and plugin, in which names of passes are links."""
    lines = [HEAD]
    for folder, package in (("urdf2mbs", "urdf2mbs."), ("plugins", "")):
        for file in sorted((ROOT / folder).glob("*/codes.py")):
            module = import_module(f"{package}{file.parent.name}.codes")
            title = (module.__doc__ or "").replace("``", "`").strip().rstrip(".")
            lines += [
                f"## {title}",
                "",
                "| code | level | meaning, and what to do |",
                "|---|---|---|",
            ]
            for code, text in module.CODES.items():
                level, _, meaning = text.partition(": ")
                meaning = re.sub("`([a-z-]+)`", link_pass, meaning)
                lines.append(f"| `{code}` | {level} | {meaning} |")
            lines.append("")
    return "\n".join(lines)


def link_pass(name: re.Match[str]) -> str:
    """Return a link to the page of a pass; any other name as it is."""
    page = f"passes/{name[1]}.md"
    return f"[{name[0]}]({page})" if (ROOT / "docs" / page).exists() else name[0]


if __name__ == "__main__":
    PAGE.write_text(make_codes(), encoding="utf-8")
