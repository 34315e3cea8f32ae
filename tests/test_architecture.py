"""docs/architecture.md names every module; no file or function is long."""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "urdf2mbs"


def test_every_module_has_its_place_on_the_page() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    told = set(re.findall(r"`([a-z_/]+)`", "\n".join(rows)))
    rooms = {word.partition("/")[0] for word in told if "/" in word}
    for file in PACKAGE.rglob("*.py"):
        path = file.relative_to(PACKAGE).with_suffix("")
        if path.name == "__init__":
            assert str(path.parent) in rooms | {"."}, path
        elif path.parts[0] in ("passes", "commands"):
            continue  # a file each: the page names the room
        elif len(path.parts) > 1 and path.parts[0] in rooms:
            row = next(row for row in rows if f"`{path.parts[0]}/" in row)
            room = "".join(one for one in rows if f"`{path.parts[0]}/" in one)
            assert f"`{path.name}`" in room or f"`{path.as_posix()}`" in room, (path, row)
        else:
            assert path.as_posix() in told, path


def test_no_file_and_no_function_is_long() -> None:
    """A file of any language, and a function of Python."""
    long = []
    for file in sorted(PACKAGE.rglob("*.*")):
        if file.suffix not in (".py", ".js", ".css", ".html", ".c", ".h", ".in"):
            continue
        text = file.read_text("utf-8")
        if len(text.splitlines()) > 450:
            long.append(file.name)
        functions = ast.walk(ast.parse(text if file.suffix == ".py" else ""))
        long += [
            node.name
            for node in functions
            if isinstance(node, ast.FunctionDef) and node.end_lineno - node.lineno >= 70
        ]
    assert not long


def test_every_pass_has_its_tests() -> None:
    for file in (PACKAGE / "passes").glob("[a-z]*.py"):
        assert (ROOT / "tests" / "passes" / f"test_{file.name}").is_file(), file.name
