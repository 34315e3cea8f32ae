"""Every number of every option has its range in its type."""

from collections.abc import Iterator
from math import inf, nan
from typing import Annotated, Any

import msgspec
import pytest
from msgspec.inspect import FloatType, IntType, StructType, type_info

from urdf2mbs.config.model import Config
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.ranges import LARGEST_TOLERANCE

PASSES = {name: found[0].load() for name, found in Plugins(installed=False).passes.items()}


def numbers(kind: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the types of all numbers in a type, each with the names that lead to it."""
    if isinstance(kind, (FloatType, IntType)):
        yield path, kind
    if isinstance(kind, StructType):
        for field in kind.fields:
            yield from numbers(field.type, (*path, field.encode_name))
    for name in ("type", "item_type", "value_type"):
        if hasattr(kind, name):
            yield from numbers(getattr(kind, name), path)
    for name in ("item_types", "types"):
        for inner in getattr(kind, name, ()):
            yield from numbers(inner, path)


ALL = [
    (name, path, number)
    for name, pass_ in PASSES.items()
    for path, number in numbers(type_info(pass_))
] + [
    ("config", path, number)
    for path, number in numbers(type_info(Config))
    # a xacro argument is the word that stands there, whatever it looks like
    if path != ("sweep", "xacro_args")
]


def test_the_walk_reaches_what_is_nested() -> None:
    paths = {(name, *path) for name, path, _ in ALL}
    nested = {
        ("forces", "wrenches", "force"),
        ("forces", "springs", "ends", "at"),
        ("posture", "hold", "stiffness"),
        ("contacts", "points"),
        ("loops", "cuts", "length"),
        ("config", "gravity"),
        ("check", "tolerance"),
    }
    assert {path for path in nested if path[0] in (*PASSES, "config")} <= paths


def test_every_number_has_two_finite_ends() -> None:
    for name, path, number in ALL:
        low = number.ge if number.gt is None else number.gt
        high = number.le if number.lt is None else number.lt
        assert low is not None, f"{name}: {path} is a bare number"
        assert high is not None, f"{name}: {path} is a bare number"
        assert -1e16 < low < high < 1e16, (name, path)
        kind: Any = float if isinstance(number, FloatType) else int
        meta = msgspec.Meta(gt=number.gt, ge=number.ge, lt=number.lt, le=number.le)
        for value in (nan, inf, -inf, 1e300, -1e300):
            with pytest.raises(msgspec.ValidationError):
                msgspec.convert(value, Annotated[kind, meta])
        if path[-1] == "tolerance":
            assert high <= LARGEST_TOLERANCE
