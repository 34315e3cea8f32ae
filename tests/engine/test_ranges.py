"""Every number of every option has its range, in its type and in the errors."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any

import msgspec
import pytest
from msgspec.inspect import FloatType, IntType, StructType, type_info

from urdf2mbs.cli import main
from urdf2mbs.engine.config import Config
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.ranges import LARGEST_TOLERANCE
from urdf2mbs.testing import TINY

PASSES = {name: found[0].kind for name, found in Plugins(installed=False).passes.items()}


def numbers(kind: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The types of all numbers in a type, each with the names that lead to it."""
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


def annotated(number: Any) -> Any:
    kind = float if isinstance(number, FloatType) else int
    return Annotated[kind, msgspec.Meta(gt=number.gt, ge=number.ge, lt=number.lt, le=number.le)]


def test_the_walk_reaches_what_is_nested() -> None:
    paths = {(name, *path) for name, path, _ in ALL}
    assert {
        ("forces", "wrenches", "force"), ("forces", "springs", "ends", "at"),
        ("posture", "hold", "stiffness"), ("contacts", "points"), ("loops", "cuts", "length"),
        ("config", "gravity"), ("check", "tolerance"),
    } <= paths  # fmt: skip


@pytest.mark.parametrize(("name", "path", "number"), ALL, ids=lambda value: str(value)[:40])
def test_every_number_has_two_finite_ends(name: str, path: tuple[str, ...], number: Any) -> None:
    low = number.ge if number.gt is None else number.gt
    high = number.le if number.lt is None else number.lt
    assert low is not None, f"{name}: {path} is a bare number"
    assert high is not None, f"{name}: {path} is a bare number"
    assert -1e16 < low < high < 1e16
    for value in (nan, inf, -inf, 1e300, -1e300):
        with pytest.raises(msgspec.ValidationError):
            msgspec.convert({"x": value}, msgspec.defstruct("One", [("x", annotated(number))]))
    if path[-1] == "tolerance":
        assert high <= LARGEST_TOLERANCE


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("check:\n    tolerance: 1.0e+300",
         "c.yaml:4: error[value-range]: 'passes.check.tolerance' is 1e+300: a number above 0, "
         "at most 0.001 is wanted"),
        ("forces: {wrenches: {w: {link: hand, force: [.nan, 0, 0]}}}",
         "c.yaml:3: error[config-type]: 'passes.forces.wrenches.w.force.0': a number is wanted, "
         "and this is nan"),
        ("posture: {hold: {stiffness: -1, damping: 1}}",
         "c.yaml:3: error[value-range]: 'passes.posture.hold.stiffness' is -1: a number from 0 to"),
    ],
)  # fmt: skip
def test_the_error_names_key_line_value_and_range(
    text: str, said: str, tmp_path: Path, capsys: Any
) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "c.yaml").write_text(f"source: tiny.urdf\npasses:\n  {text}\n")
    assert main(["explain", str(tmp_path / "c.yaml")]) == 2
    assert said in capsys.readouterr().err
