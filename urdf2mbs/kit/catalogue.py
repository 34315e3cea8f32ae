"""``python -m urdf2mbs.kit.catalogue`` prints docs/diagnostics.md: errors, warnings, notes.

It is made from the table in urdf2mbs/catalogue.py, and from nothing else.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from urdf2mbs.catalogue import SECTIONS, Section

HEAD = """\
# Errors, warnings, notes

<!-- Made by `python -m urdf2mbs.kit.catalogue > docs/diagnostics.md`: do not edit. -->

An **error** ends a conversion, and nothing is written. A **warning** says that something of the robot is not in the `.mbs` as one would expect. A **note** says what was decided (`-v` shows notes; `--json` has all). Each reads `file:line: level[code]: message`, with what to do below it. The codes are stable.

The errors in a URDF's links and joints are told all at once, up to 20 of them. An error in xacro names the macros and files that led to it, the innermost first.

## Levels are yours

Every warning and note below can be made an `error`, a `warning`, a `note` or nothing (`ignore`), and so can the errors in the first table. In the config:

```yaml
diagnostics: {inertia-indefinite: error, mesh-missing: ignore}
strict: true   # all other warnings are errors
```

On the command line, of `run`, `convert`, `report` and `explain`, `--level CODE=LEVEL` (as often as wanted) goes before the config, and `--strict` is the same as `strict: true`. A level that is given by its code goes before `strict`. All errors of a run are told at once.

All errors but those of the first table leave nothing to convert, and cannot be changed.

Exit codes: 0 done; 1 this robot cannot be converted; 2 the command line, the config or a plugin is wrong; 3 converted, but not the same robot.
"""  # noqa: E501


def page() -> str:
    """The text of docs/diagnostics.md."""
    return "".join([HEAD, *(part for section in SECTIONS for part in _section(section))])


def _section(section: Section) -> Iterator[str]:
    yield f"\n## {section.title}\n\n"
    if section.intro:
        yield f"{section.intro}\n\n"
    level = section.changeable
    yield "| code |" + " |" * level + " meaning | what to do |\n" + "|---" * (3 + level) + "|\n"
    for code, one in section.codes.items():
        yield f"| `{code}` |" + f" {one.level} |" * level + f" {one.meaning} | {one.todo} |\n"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")  # type: ignore[union-attr]
    sys.stdout.write(page())
