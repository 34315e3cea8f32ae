"""Messages: one form for all, safe on a terminal, and short enough to read."""

import pickle
from typing import Any

import pytest

from urdf2mbs.config.model import Config
from urdf2mbs.engine.levels import apply_levels, raise_errors
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import (
    ConfigError,
    ConversionError,
    Diagnostic,
    counted,
    memory_full_error,
    nearest,
    printable,
    quoted,
    some,
)


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ((None, None, None), "error[c]: m"),
        (("f", None, None), "f: error[c]: m"),
        (("f", 3, "do this"), "f:3: error[c]: m\n  do this"),
        ((None, 3, None), "error[c]: m"),
    ],
)
def test_an_error_says_where_and_what_to_do(given: Any, wanted: str) -> None:
    file, line, hint = given
    error = ConversionError("c", "m", file=file, line=line, hint=hint)
    assert str(error) == str(error.diagnostic()) == wanted
    assert error.diagnostic() == Diagnostic("error", "c", "m", file=file, line=line, hint=hint)


def test_errors_that_were_found_before_stand_first_and_warnings_do_not() -> None:
    error = ConversionError("last", "l")
    error.earlier = [Diagnostic("error", "first", "f"), Diagnostic("warning", "w", "w")]
    assert str(error) == "error[first]: f\nerror[last]: l"
    assert (error.exit_code, ConfigError("c", "m").exit_code) == (1, 2)
    raise_errors([Diagnostic("warning", "w", "w"), Diagnostic("note", "n", "n")])
    one = Diagnostic("error", "one", "1", file="f", line=2, hint="h")
    with pytest.raises(ConversionError) as caught:
        raise_errors([Diagnostic("error", "zero", "0"), Diagnostic("warning", "w", "w"), one])
    assert caught.value.diagnostic() == one
    assert [said.code for said in caught.value.earlier] == ["zero"]
    assert memory_full_error("reading").code == "memory-full"
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_a_hint_does_not_recommend_the_level_that_is_set() -> None:
    said = [
        Diagnostic("warning", code, "m", hint=hint)
        for code, hint in (("a", "--level a=error"), ("b", "mend it"), ("c", "--level"), ("d", "x"))
    ]
    plugins = Plugins(installed=False)
    config = Config(source="r", diagnostics={"a": "error", "b": "note", "d": "ignore"})
    found = [(one.level, one.code, one.hint) for one in apply_levels(said, config, plugins)]
    assert found == [("error", "a", None), ("note", "b", "mend it"), ("warning", "c", "--level")]
    strict = Config(source="r", strict=True, diagnostics={"b": "warning"})
    levels = [one.level for one in apply_levels(said, strict, plugins)]
    assert levels == ["error", "warning", "error", "error"]


def test_a_warning_without_a_hint_says_what_its_code_says_to_do() -> None:
    said = [Diagnostic("warning", "massless-leaf", "m"), Diagnostic("note", "base", "m")]
    hints = [one.hint for one in apply_levels(said, Config(source="r"), Plugins(installed=False))]
    assert hints == ["give the links mass; 'keep' keeps the joints, but not to simulate", None]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("ä b\nc", "ä b\nc"),
        ("\x1b[31m", "\\x1b[31m"),
        ("a\tb\x07", "a\tb\\x07"),
        ("a\u202eb\u2066", "a\\u202eb\\u2066"),
        ("a\u00a0b", "a\u00a0b"),
        ("\x85\r", "\\x85\\r"),
    ],
)
def test_nothing_acts_on_a_terminal(text: str, wanted: str) -> None:
    assert printable(text) == wanted


@pytest.mark.parametrize("length", [1991, 1992, 5000])
def test_a_long_line_is_cut_in_the_middle_and_a_name_begins_none(length: int) -> None:
    note = Diagnostic("note", "c", "m" * length, hint="x\n  y")
    line, *hint = str(note).split("\n")
    assert hint == ["  x", "  y"]
    whole = "note[c]: " + "m" * length
    assert line == (whole if len(whole) <= 2000 else f"{whole[:1000]} ... {whole[-1000:]}")
    assert str(Diagnostic("note", "c", "a\nerror: b")) == "note[c]: a\\nerror: b"


@pytest.mark.parametrize(
    ("text", "wanted"), [("ä", "ä"), ("a\nb", "a\\nb"), ("\\n", "\\\\n"), ("\u202e", "\\u202e")]
)
def test_a_name_in_code_stays_a_name(text: str, wanted: str) -> None:
    assert quoted(text) == wanted


def test_counts_lists_and_the_nearest_name() -> None:
    assert [counted(n, "joint") for n in (0, 1, 2)] == ["0 joints", "1 joint", "2 joints"]
    counts = [counted(n, thing) for n, thing in ((1, "body"), (2, "body"), (2, "mesh"))]
    assert counts == ["1 body", "2 bodies", "2 meshes"]
    assert (some([]), some("abcde")) == ("", "a, b, c, d, e")
    assert some("abcdef") == "a, b, c, d, e and 1 more"
    assert some(iter("abcd"), 2) == "a, b and 2 more"
    assert nearest("shuolder", ["elbow", "shoulder"]) == "did you mean 'shoulder'?"
    assert nearest("ab", ["ac"]) == "did you mean 'ac'?"
    assert nearest("abc", ["axy"]) is nearest("abc", []) is None
