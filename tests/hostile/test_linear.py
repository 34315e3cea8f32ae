"""What reads a file takes a time that grows as the file, whatever is in it.

Each reader gets a hostile text, and the same four times as long.  The time of the process alone is
compared, as a ratio: quadratic is 16.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from urdf2mbs.engine import config, yaml_text
from urdf2mbs.many import folder
from urdf2mbs.mbs import reader as mbs
from urdf2mbs.messages.diagnostics import ConversionError, render
from urdf2mbs.urdf import packages, reader, shapes, values, written, xacro, xml
from urdf2mbs.urdf.packages import Packages

#: What each pattern begins with, or gets lost in.
TEXTS = {
    "xacro": "xacro",
    "xacro:": "xacro:=",
    "xmlns": "xmlns",
    "xmlns=": "xmlns=",
    "xmlns ='": "xmlns= '",
    "two quotes": "xmlns='xmlns=\"",
    "declarations": "<?xml ",
    "closed declarations": "<?xml ?>\n",
    "version": "<?xml version='1",
    "versions": "version=",
    "comments": "<!--",
    "dashes": "<!---",
    "closed comments": "<!----><?xml ?>",
    "bad comments": "<!-- -- -->\n",
    "conflict": "=======\n",
    "conflict and blanks": "=======    \n",
    "name": "<name",
    "name>": "<name>",
    "names": "name ",
    "name=": "name=",
    "name='": "name='",
    "blanks": " ",
    "lines": "\n",
    "slashes": "/",
    "quotes": "'",
    "double quotes": '"',
    "letters": "a",
    "words": "a b",
    "dots": "a.",
    "arg": "<xacro:arg ",
    "macro": "<xacro:macro ",
    "link": "<link ",
    "robot": "<robot ",
    "expected": "Expected ",
    "got": ", got ",
    "digits": "1",
    "zeros": "0.",
    "signs": "+",
    "exponents": "1e",
    "braces": "{",
    "dollars": "${",
    "package": "package:/",
    "find": "$(find ",
    "brackets": "[",
    "colons": "a: ",
    "anchors": "&a ",
    "#": "#",
    "controls": "\x1b",
    "backquotes": "`a`",
    "arguments": "xacro.arg('",
    "evaluating": "when evaluating '",
}


def _package(text: str, here: Path) -> None:
    (here / "package.xml").write_text(text)
    packages._package_name(here)


def _written(text: str, here: Path) -> None:
    file = str(here / "a.xacro")
    Path(file).write_text(text)
    written.element("link", "a", [file])
    written.arguments([file])
    written.locate(["a", "b"], [file])


def _message(text: str, here: Path) -> None:
    xacro._find_words(text)
    render("error", "a", text, "a", 1, None)


def _names(text: str, here: Path) -> None:
    places = Packages({}, here / "r.urdf")
    for before in ("", "file:", "package://", "file:///"):
        places.resolve(before + text)
    re.sub(shapes._UNRESOLVED, "", f"file:{text}")
    values._BLANKS.sub(" ", text)


def _yaml(text: str, here: Path) -> None:
    yaml_text.tree(text, None)


def _config(text: str, here: Path) -> None:
    config.typed(config.Config, {"source": "a", "base": text}, config.Lines())


def _mbs(text: str, here: Path) -> None:
    number = text.replace("<", "").replace("&", "").replace("\x1b", "").encode()
    mbs._NUMBER(number.decode())
    mbs.read(b"<mbs_xml_format><bodytree><base><x>" + number + b"</x></base></bodytree>", "a")


READERS: dict[str, Callable[[str, Path], object]] = {
    "has xacro": lambda text, here: reader.has_xacro(text.encode(), "a"),
    "mend": lambda text, here: xml.mend(text.encode()),
    "mend latin": lambda text, here: xml.mend(text.encode() + b"\xff"),
    "urdf": lambda text, here: reader.parse(text.encode(), "a"),
    "urdf, begun": lambda text, here: reader.parse(b"<robot>" + text.encode(), "a"),
    "package": _package,
    "written": _written,
    "message": _message,
    "names": _names,
    "yaml": _yaml,
    "config": _config,
    "mbs": _mbs,
    "folder": lambda text, here: folder._ROBOT.search(text.encode()),
}


def _time(work: Callable[[str, Path], object], text: str, here: Path) -> float:
    start = time.process_time()
    with suppress(ConversionError):
        work(text, here)
    return time.process_time() - start


@pytest.mark.parametrize("name", READERS)
def test_time_grows_as_the_text(name: str, tmp_path: Path) -> None:
    for kind, piece in TEXTS.items():
        large = (piece * (200_000 // len(piece)))[:200_000]
        whole = part = 1e9
        for _ in range(4):
            whole = min(whole, _time(READERS[name], large, tmp_path))
            if whole < 0.1:  # too short to compare, and short enough
                break
            part = min(part, _time(READERS[name], large[:50_000], tmp_path))
            if whole < 9 * part:
                break
        else:
            pytest.fail(f"{kind}: {part:.3f} s, and {whole:.3f} s for four times the text")
