"""The page of tolerances has every one, with its value."""

from __future__ import annotations

import re
from pathlib import Path

import urdf2mbs

PACKAGE = Path(urdf2mbs.__file__).parent
PAGE = Path(__file__).resolve().parents[2] / "docs" / "tolerances.md"


def test_the_page_has_every_tolerance() -> None:
    stated = dict(re.findall(r"^\| `([\w.]+)` \| (\S+) \|", PAGE.read_text("utf-8"), re.M))
    defined = {}
    for file in PACKAGE.rglob("*.py"):
        module = ".".join(file.relative_to(PACKAGE).with_suffix("").parts)
        for name, value in re.findall(r"^([A-Z_]+) = (1e-\d+)$", file.read_text("utf-8"), re.M):
            defined[f"{module}.{name}"] = value
    assert {name: float(value) for name, value in stated.items()} == {
        name: float(value) for name, value in defined.items()
    }
