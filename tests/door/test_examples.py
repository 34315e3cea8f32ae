"""Each task of a lab is solved by the door alone, in few lines, and stands so in the docs."""

import ast
import re
from pathlib import Path

import pytest

from urdf2mbs import plugin

FOLDER = Path(__file__).resolve().parent
PAGES = [FOLDER.parents[1] / "docs" / name for name in ("write-a-pass.md", "hooks.md")]
PLUGINS = sorted(file for file in FOLDER.glob("*.py") if not file.name.startswith("test_"))
BLOCKS = {
    file: text
    for page in PAGES
    for file, text in re.findall(r"(?sm)^```python file=([\w.]+)\n(.*?)^```", page.read_text())
}


def test_the_eleven_tasks_are_there() -> None:
    assert len(PLUGINS) == 11


@pytest.mark.parametrize("file", PLUGINS, ids=lambda file: file.stem)
def test_a_plugin_is_short_and_imports_the_door_alone(file: Path) -> None:
    text = file.read_text()
    assert len(text.splitlines()) <= 40
    imports = [
        (node.module, alias.name)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if (node.module or "").startswith("urdf2mbs")
    ]
    assert "import urdf2mbs" not in text
    for module, name in imports:
        assert module == "urdf2mbs.plugin" or (module, name) == ("urdf2mbs_project", "simulation")
        assert module != "urdf2mbs.plugin" or name in plugin.__all__


@pytest.mark.parametrize("file", PLUGINS, ids=lambda file: file.stem)
def test_a_page_shows_the_plugin_or_links_it(file: Path) -> None:
    """``python docs/make_examples.py`` writes what is shown."""
    links = [page for page in PAGES if f"(../tests/door/{file.name})" in page.read_text()]
    assert links or BLOCKS.get(file.name) == file.read_text()
    assert BLOCKS.get(file.name, file.read_text()) == file.read_text()


@pytest.mark.parametrize("file", PLUGINS, ids=lambda file: file.stem)
def test_a_plugin_has_a_test(file: Path) -> None:
    assert file.with_name(f"test_{file.name}").is_file()
