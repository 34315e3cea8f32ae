"""Messages about one file are grouped."""

from __future__ import annotations

from urdf2mbs.urdf.messages import Messages


def test_what_is_said_of_a_link_twice_stands_there_once() -> None:
    messages = Messages("robot.urdf", ())
    for detail in ("did you mean 'b'?", "did you mean 'b'?", "or 'c'"):
        messages.warn("code", "no such link", 3, owner=("link", "a"), detail=detail)
    (said,) = messages.diagnostics()
    assert said.message == "no such link: link 'a' (did you mean 'b'?; or 'c')"
