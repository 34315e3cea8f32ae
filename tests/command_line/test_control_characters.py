"""What a name holds is shown as letters: no terminal acts on it, and JSON has it whole."""

import json
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.api import convert
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConversionError, printable
from urdf2mbs.testing import TINY

#: Clears the screen, and what else a terminal acts on; XML 1.0 refuses the first, and an .mbs,
#: a config and a file's name do not.
NASTY = "a\x1b[2J\x9b2J\x07\x7f\u202eb\rc"
ACTS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e]")


@pytest.fixture
def nasty(here: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Add files in which names have control characters."""
    monkeypatch.setenv("NO_COLOR", "1")
    # what XML permits: C1 controls, as references also a carriage return and a new line
    name = "shoulder&#x9b;2J&#x85;&#x202e;&#13;&#10;error[fake]: all is lost"
    odd = TINY.replace('"shoulder"', f'"{name}"')
    (here / "odd.urdf").write_text(odd.replace('type="revolute"', 'type="hinge"', 1))
    (here / "kept.urdf").write_text(odd)
    (here / "odd.yaml").write_text(f"source: tiny.urdf\npipeline: {json.dumps(NASTY)}\n")
    (here / "plugin.yaml").write_text(f"source: {json.dumps(NASTY)}\n")
    return here


@pytest.mark.parametrize(
    "words",
    [
        ["convert", "odd.urdf"],
        ["convert", "kept.urdf", "-v"],
        ["report", "kept.urdf", "-v"],
        ["run", "odd.yaml"],
        ["explain", "plugin.yaml"],
        ["convert", NASTY],
        ["convert", "tiny.urdf", "-o", NASTY],
        ["verify", "tiny.urdf", NASTY],
        ["init", "kept.urdf", "-o", "k.yaml"],
        ["convert", "tiny.urdf", "--set", f"{NASTY}.a=1"],
        ["convert", "tiny.urdf", "--arg", f"{NASTY}:=1"],
        ["diagram", NASTY],
        ["new-pass", NASTY],
        ["explain", "--plugin", NASTY],
        ["doctor", NASTY],
    ],
    ids=lambda words: " ".join(words)[:40].encode("unicode_escape").decode(),
)
def test_no_control_character_is_printed(words: list[str], nasty: Path, capsys: Any) -> None:
    for more in ([], ["--json"]):
        with suppress(SystemExit):  # of argparse
            main([*words, *more])
        said = capsys.readouterr()
        assert said.out + said.err
        assert not ACTS.search(said.out + said.err)
        assert not re.search("^error.fake", said.out + said.err, re.MULTILINE)
        if more and said.out and words[0] not in ("init", "new-pass"):
            json.loads(said.out)


def test_json_gives_the_name_back(nasty: Path, capsys: Any) -> None:
    assert main(["convert", "kept.urdf", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert any("\x9b2J\x85\u202e\r\nerror[fake]" in name for name in str_of(found))


def str_of(data: Any) -> list[str]:
    if isinstance(data, dict):
        return [*data, *(text for value in data.values() for text in str_of(value))]
    if isinstance(data, list):
        return [text for value in data for text in str_of(value)]
    return [data] if isinstance(data, str) else []


def test_an_error_as_text_from_python(nasty: Path) -> None:
    with pytest.raises(ConversionError) as caught:
        convert(nasty / "odd.urdf")
    assert not ACTS.search(str(caught.value))
    assert r"\x9b2J\x85\u202e\r\nerror[fake]" in str(caught.value)


def test_what_is_no_control_character_stays() -> None:
    text = "腕 é 🦾 \t a\n  b\\n"
    assert printable(text) == text
