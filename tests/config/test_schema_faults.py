"""All faults of a config's data are found, as the schema of its class says."""

from typing import Annotated, Any, Literal

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from msgspec import Meta

from urdf2mbs.config.faults import take_faults
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config, Preset, Range, Sweep
from urdf2mbs.config.schema_faults import find_schema_faults


class Options(msgspec.Struct, forbid_unknown_fields=True):
    """Options of a pass, with each keyword that msgspec writes into a schema."""

    word: Annotated[str, Meta(pattern="^[a-z]*$", min_length=1, max_length=4)]
    count: Annotated[int, Meta(multiple_of=3)] = 3
    ratio: Annotated[float, Meta(gt=0, lt=1)] = 0.5
    level: Annotated[float, Meta(ge=-1, le=1)] = 0.0
    choice: Literal["left", "right"] | bool = True
    digit: Literal[1, 2] = 1
    pair: tuple[int, str] = (1, "")
    some: Annotated[list[int], Meta(min_length=1, max_length=2)] | None = None
    table: dict[Annotated[str, Meta(min_length=1)], Range | list[str]] = {}
    few: Annotated[dict[str, int], Meta(min_length=1, max_length=1)] | None = None


CLASSES = [Options, Config, Preset, Sweep, Range]
KEYS = sorted({"", "x", *(key for kind in CLASSES for key in kind.__struct_encode_fields__)})
ATOMS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-4, 4),
    st.sampled_from([0.5, 2.0, -2.5, 1e20, "", "left", "auto", "Ab", "abcde", "error"]),
)
VALUES = st.recursive(
    ATOMS,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=3)
    ),
    max_leaves=5,
)


@given(data=st.data(), kind=st.sampled_from(CLASSES))
def test_a_fault_is_found_where_jsonschema_finds_one(data: Any, kind: type) -> None:
    keys = st.sampled_from([*kind.__struct_encode_fields__, "x"])  # type: ignore[attr-defined]
    value = data.draw(st.dictionaries(keys, VALUES, max_size=5) | VALUES)
    schema = msgspec.json.schema(kind)
    faults = list(find_schema_faults(value, schema, schema["$defs"]))
    errors = list(Draft202012Validator(schema).iter_errors(value))
    # an item too many is a fault of "maxItems", too
    assert {(fault.keyword, fault.key) for fault in faults} == {
        (str(error.validator), tuple(error.path)) for error in errors if error.validator != "items"
    }


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"word": "A"}, "'pass.word': 'A' does not match '^[a-z]*$'"),
        ({"word": "abcde"}, "'pass.word': expected at most 4 letters, got 'abcde'"),
        ({"word": ""}, "'pass.word': the value is empty; expected a name or a path"),
        ({"count": 4}, "'pass.count': expected a multiple of 3, got 4"),
        ({"count": 1.5}, "'pass.count': expected a whole number, got 1.5"),
        ({"ratio": 1}, "'pass.ratio': expected a number above 0, below 1, got 1"),
        ({"ratio": float("nan")}, "'pass.ratio': expected a number, got nan"),
        ({"level": True}, "'pass.level': expected a number, got True"),
        ({"digit": True}, "'pass.digit': True is not one of its values"),
        ({"pair": (1,)}, "'pass.pair': expected a list of 2, got one of 1"),
        ({"pair": (1, 2)}, "'pass.pair.1': expected a word, got 2"),
        ({"some": []}, "'pass.some': expected a list of 1, got one of 0"),
        ({"table": {"": ["a"]}}, "'pass.table': a key is empty; expected a name or a path"),
        ({"table": {"a": {"from": 1}}}, "'pass.table.a.to' must be given"),
        ({"few": {}}, "'pass.few': expected 1 key or more, got 0"),
        ({"few": {"a": 1, "b": 2}}, "'pass.few': expected 1 key or less, got 2"),
    ],
)
def test_a_fault_says_what_was_expected(option: dict[str, Any], message: str) -> None:
    schema = msgspec.json.schema(Options)
    block = {"word": "a", **option}
    faults = take_faults(schema, block, Lines(), ("pass",))
    if isinstance(option.get("count"), float):
        faults = faults[:1]  # it is no multiple, either
    assert [fault.message for fault in faults] == [message]
    assert not option.keys() & block.keys(), "a wrong value is taken out"
