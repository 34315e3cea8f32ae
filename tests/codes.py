"""The codes of all errors, warnings and notes, as docs/diagnostics.md lists them."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "docs" / "diagnostics.md"

#: A row: the code, its level where a user can change the level, and its meaning.
ROWS = re.findall(
    r"^\| `([a-z0-9-]+)` \|(?: (error|warning|note) \|)? (.+) \|$",
    PAGE.read_text("utf-8"),
    re.MULTILINE,
)

#: The meaning of each code.
CATALOGUE = {code: meaning for code, _, meaning in ROWS}

#: The codes whose level a user can change, with their level.
DEFAULTS = {code: level for code, level, _ in ROWS if level}
