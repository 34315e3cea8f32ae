"""Messages about one file are grouped."""

import pytest

from urdf2mbs.commands.printing import print_diagnostics
from urdf2mbs.messages.diagnostics import Diagnostic
from urdf2mbs.urdf.messages import Messages


def test_what_is_said_of_a_link_twice_stands_there_once() -> None:
    messages = Messages("robot.urdf", ())
    for detail in ("did you mean 'b'?", "did you mean 'b'?", "or 'c'"):
        messages.warn("code", "no such link", 3, owner=("link", "a"), detail=detail)
    (said,) = messages.diagnostics()
    assert said.message == "no such link: link 'a' (did you mean 'b'?; or 'c')"


def test_warnings_of_one_code_are_told_as_one_each_with_its_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    said = [
        Diagnostic("warning", code, text, file="r.urdf", line=line)
        for code, text, line in (("a", "one", 3), ("a", "two", 9), ("b", "three", 5))
    ]
    print_diagnostics(said, verbose=False)
    told = capsys.readouterr()
    assert told.out == "  3 warnings of 2 kinds, 0 notes\n"
    assert told.err == "r.urdf:3: warning[a]: one; line 9: two\nr.urdf:5: warning[b]: three\n"
    print_diagnostics(said, verbose=True)
    assert capsys.readouterr().out == "  3 warnings, 0 notes\n"
