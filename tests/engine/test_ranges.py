"""Every number of every option has its range: in its type, the schema, the pages, the errors."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from math import inf, nan
from pathlib import Path
from typing import Any

import msgspec
import pytest
from msgspec.inspect import FloatType, IntType, StructType, type_info

from urdf2mbs.cli import main
from urdf2mbs.commands.schema import schema
from urdf2mbs.engine.config import Config
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.ranges import LARGEST_TOLERANCE, in_words
from urdf2mbs.testing import TINY, convert_text

PASSES = {name: found[0].kind for name, found in Plugins(installed=False).passes.items()}
PAGES = Path(__file__).parents[2] / "docs" / "passes"


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


def bounds(number: Any) -> tuple[Any, Any]:
    return (
        number.ge if number.gt is None else number.gt,
        number.le if number.lt is None else number.lt,
    )


def test_the_walk_reaches_what_is_nested() -> None:
    paths = {(name, *path) for name, path, _ in ALL}
    assert {
        ("forces", "wrenches", "force"), ("forces", "springs", "ends", "at"),
        ("posture", "hold", "stiffness"), ("contacts", "points"), ("loops", "cuts", "length"),
        ("config", "gravity"), ("check", "tolerance"),
    } <= paths  # fmt: skip


@pytest.mark.parametrize(("name", "path", "number"), ALL, ids=lambda value: str(value)[:40])
def test_every_number_has_two_finite_ends(name: str, path: tuple[str, ...], number: Any) -> None:
    low, high = bounds(number)
    assert low is not None, f"{name}: {path} is a bare number"
    assert high is not None, f"{name}: {path} is a bare number"
    assert -1e16 < low < high < 1e16
    for value in (nan, inf, -inf, 1e300, -1e300):
        with pytest.raises(msgspec.ValidationError):
            msgspec.convert({"x": value}, msgspec.defstruct("One", [("x", _annotated(number))]))
    if path[-1] == "tolerance":
        assert high <= LARGEST_TOLERANCE


def _schema(number: Any) -> dict[str, Any]:
    found: dict[str, Any] = msgspec.json.schema(_annotated(number))
    return found


def _annotated(number: Any) -> Any:
    from typing import Annotated

    kind = float if isinstance(number, FloatType) else int
    return Annotated[
        kind, msgspec.Meta(gt=number.gt, ge=number.ge, lt=number.lt, le=number.le)
    ]  # fmt: skip


@pytest.mark.parametrize(("name", "path", "number"), ALL, ids=lambda value: str(value)[:40])
def test_the_page_of_a_pass_shows_each_range(name: str, path: tuple[str, ...], number: Any) -> None:
    if name == "config":
        return
    shown = re.sub("^a (whole )?number ", "", in_words(_schema(number)))
    lines = (PAGES / f"{name}.md").read_text().splitlines()
    assert any(f"`{path[-1]}`" in line and shown in line for line in lines), (path, shown)


def test_the_schema_shows_the_ranges() -> None:
    text = json.dumps(schema(Plugins(installed=False)))
    assert f'"maximum": {LARGEST_TOLERANCE}' in text

    def bare(part: Any) -> Iterator[Any]:
        if isinstance(part, dict):
            if part.get("type") in ("number", "integer") and "maximum" not in part:
                yield part
            for key, inner in part.items():
                if key != "xacro_args":
                    yield from bare(inner)
        elif isinstance(part, list):
            for inner in part:
                yield from bare(inner)

    assert list(bare(json.loads(text))) == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("check:\n    tolerance: 1.0e+300",
         "c.yaml:4: error[value-range]: 'passes.check.tolerance' is 1e+300: a number above 0, "
         "at most 0.001 is wanted"),
        ("forces: {wrenches: {w: {link: hand, force: [.nan, 0, 0]}}}",
         "c.yaml:3: error[value-range]: 'passes.forces.wrenches.w.force.0' is nan: a number from"),
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


@pytest.mark.parametrize("tolerance", [1.0, 0.8, nan, inf, 0.0, -1.0, 2e-3])
@pytest.mark.parametrize("name", ["check", "align-frames"])
def test_no_tolerance_is_beyond_1e_3(name: str, tolerance: float) -> None:
    with pytest.raises(ConfigError) as refused:
        convert_text(pipeline="compact", passes={name: {"tolerance": tolerance}})
    assert refused.value.code == "value-range"
