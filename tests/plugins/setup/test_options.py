"""The options of a pass in words: what a person writes into a config."""

from typing import Annotated, Any, Literal

import msgspec
import pytest

from urdf2mbs.plugin import Pass
from urdf2mbs_setup.options import describe_type, list_inner_structs, list_options


class Inner(msgspec.Struct):
    at: tuple[float, float] = (0.0, 1.0)


class Outer(msgspec.Struct):
    inner: Inner


class Sample(Pass):
    """A pass with options of all kinds."""

    given: dict[str, Outer]
    """Must be given."""
    at: tuple[float, ...] = (0.5, 1.0)
    on: bool = True
    word: str = ""
    most: Annotated[float, msgspec.Meta(gt=0)] | None = None
    names: list[str] = []


def test_options_are_described_in_words() -> None:
    options = list_options(Sample)
    assert [(option.name, option.type) for option in options] == [
        ("given", "dict[str, Outer]"),
        ("at", "tuple[float, ...]"),
        ("on", "bool"),
        ("word", "str"),
        ("most", "float | none"),
        ("names", "list[str]"),
    ]
    given, *optional = options
    assert given.required
    assert given.help == "Must be given."
    assert [option.default_in_words for option in optional] == [
        "[0.5, 1.0]",
        "true",
        "''",
        "none",
        "[]",
    ]
    assert not any(option.required for option in optional)


def test_structs_within_options_are_listed() -> None:
    assert list_inner_structs(Sample) == [Outer, Inner]


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (Literal["python", "c"], "python | c"),
        (list[Literal["a", "b"]] | Literal["a"], "list[a | b] | a"),
        (int | float, "int | float"),
        (Any, "Any"),
    ],
)
def test_a_type_is_described_in_words(kind: Any, words: str) -> None:
    assert describe_type(kind) == words
