"""URDF files: reading a text, words that a fuzzer mixes."""

from pathlib import Path

from support.plugin_files import read_robot
from urdf2mbs.messages.diagnostics import Diagnostic
from urdf2mbs.urdf.model import (
    Robot,
)
from urdf2mbs.urdf.packages import Packages


def read(tmp_path: Path, text: str | bytes) -> tuple[Robot, list[Diagnostic]]:
    source = tmp_path / "robot.urdf"
    source.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_robot(source, Packages({}, source), {})


XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


WORDS = [
    *(
        b"\" ' < > /> </robot> <!-- --> & &x; &#0; <? <![ \0 \xff \xc3 nan - e ${ $( } xmlns="
        b" xacro: 1 9e999 { : = a <a:b/> <link/>"
    ).split(b" "),
    b" ",
    b"\n",
    b"<!DOCTYPE robot [<!ENTITY a 'b'>]>",
]
