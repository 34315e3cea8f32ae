"""The robots that a sweep stands for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.engine.config import Lines, parse
from urdf2mbs.engine.settings import settings_of
from urdf2mbs.many.sweep import Member, members
from urdf2mbs.messages.diagnostics import ConfigError


def swept(text: str, output: str = "'{height}.mbs'") -> list[Member]:
    text = f"source: biped.urdf.xacro\noutput: {output}\nsweep:\n  {text}\n"
    return members(*parse(text, Path("sweep.yaml")))


def test_every_combination_in_its_order() -> None:
    found = swept(
        "{xacro_args: {height: [0.70, 0.8], arms: [true, no]}, "
        "passes: {decompose-joints: {snap: [0, 1.5]}}}",
        "'{height}-{arms}-{decompose-joints.snap}.mbs'",
    )
    assert [one.config.output for one in found] == [
        "0.70-true-0.mbs", "0.70-true-1.5.mbs", "0.70-no-0.mbs", "0.70-no-1.5.mbs",
        "0.8-true-0.mbs", "0.8-true-1.5.mbs", "0.8-no-0.mbs", "0.8-no-1.5.mbs",
    ]  # fmt: skip
    assert found[1].values == {"height": "0.70", "arms": "true", "decompose-joints.snap": 1.5}
    assert found[1].config.xacro_args == {"height": "0.70", "arms": "true"}
    assert found[1].config.passes == {"decompose-joints": {"snap": 1.5}}
    assert all(one.config.sweep is None for one in found)


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ("{from: 0.7, to: 0.9, step: 0.1}", ["0.7", "0.8", "0.9"]),
        ("{from: 0.7, to: 0.89, step: 0.1}", ["0.7", "0.8"]),
        ("{from: 1, to: 3, step: 1}", ["1", "2", "3"]),
        ("{from: 3, to: 1, step: -1}", ["3", "2", "1"]),
        ("{from: 0, to: 1, count: 4}", ["0.0", "0.3333333333333333", "0.6666666666666666", "1.0"]),
    ],
)
def test_ranges(given: str, values: list[str]) -> None:
    found = swept(f"{{xacro_args: {{height: {given}}}}}")
    assert [one.values["height"] for one in found] == values


@pytest.mark.parametrize(
    ("given", "output", "code"),
    [
        ("{}", "x.mbs", "sweep-empty"),
        ("{xacro_args: {height: []}}", "x.mbs", "sweep-empty"),
        ("{xacro_args: {height: [1, 2]}}", "x.mbs", "sweep-output"),
        ("{xacro_args: {height: [1, 1]}}", "'{height}.mbs'", "sweep-output"),
        ("{xacro_args: {height: [1, 2]}}", "'{hight}.mbs'", "sweep-output"),
        ("{xacro_args: {height: [1, 2]}}", "null", "sweep-output"),
        ("{xacro_args: {height: {from: 1, to: 2}}}", "'{height}.mbs'", "sweep-range"),
        ("{xacro_args: {height: {from: 1, to: 2, step: 0}}}", "'{height}.mbs'", "sweep-range"),
        ("{xacro_args: {height: {from: 1, to: 2, step: -1}}}", "'{height}.mbs'", "sweep-range"),
        ("{xacro_args: {height: {from: 1, to: .nan, step: 1}}}", "'{height}.mbs'", "config-type"),
        ("{xacro_args: {height: {from: 1, to: .inf, step: 1}}}", "'{height}.mbs'", "value-range"),
        ("{xacro_args: {height: {from: 1, to: 2, step: .nan}}}", "'{height}.mbs'", "config-type"),
        ("{xacro_args: {height: {from: 1, to: 2, count: 1}}}", "'{height}.mbs'", "sweep-range"),
        ("{xacro_args: {height: {from: 0, to: 1, step: 1.0e-9}}}", "'{height}.mbs'", "sweep-long"),
        ("{xacro_args: {hight: 3}}", "x.mbs", "config-type"),
        ("{args: {}}", "x.mbs", "unknown-key"),
    ],
)  # fmt: skip
def test_what_is_no_sweep(given: str, output: str, code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        swept(given, output)
    assert caught.value.code == code
    assert caught.value.line is not None


def test_a_value_that_is_given_and_swept() -> None:
    text = (
        "source: a.xacro\noutput: '{height}.mbs'\nxacro_args: {height: 1}\n"
        "sweep: {xacro_args: {height: [1, 2]}}"
    )
    with pytest.raises(ConfigError) as caught:
        members(*parse(text, None))
    assert caught.value.code == "sweep-twice"


@pytest.mark.parametrize(
    ("value", "name"),
    [
        ("../../etc", ".._.._etc"),
        ("..", "__"),
        (".", "_"),
        ("''", "_"),
        ("a.", "a_"),
        ("a ", "a"),  # YAML's own
        ("'a '", "a_"),
        ("$HOME", "_HOME"),
        ("~root", "_root"),
        ("'%APPDATA%'", "_APPDATA_"),
        ("'a\\b'", "a_b"),
        ('"a\\0b\\n"', "a_b_"),
        ("'c:d'", "c_d"),
        ("aux", "_aux"),
        ("NUL.x", "_NUL.x"),
        ("'{0}'", "{0}"),
    ],
)
def test_a_value_is_one_name_on_every_system(value: str, name: str) -> None:
    """It leads to no other folder, and no variable in it is filled in."""
    (robot,) = swept(f"{{xacro_args: {{height: [{value}]}}}}", "{project: 'out/{height}/p'}")
    output: Any = robot.config.output
    assert output.project == f"out/{name}/p"
    settings = settings_of(robot.config, Lines(file=Path("c.yaml")), Path("/there"))
    assert settings.project == Path("/there/out") / name / "p"


def test_a_project_and_its_model_have_one_name() -> None:
    (robot,) = swept("{xacro_args: {height: [0.7]}}", "{project: 'out/biped_{height}'}")
    settings = settings_of(robot.config, Lines(file=Path("c.yaml")), Path("/there"))
    assert settings.output == Path("/there/out/biped_0_7/dataR/biped_0_7.mbs")


def test_a_value_makes_no_variable_of_what_stands_before_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PLACE", "models")
    (robot,) = swept("{xacro_args: {height: [PLACE]}}", "'$PLACE/~{height}.mbs'")
    assert robot.config.output == "models/_PLACE.mbs"
    with pytest.raises(ConfigError, match="wants the variable height"):
        swept("{xacro_args: {height: [PLACE]}}", "'${height}.mbs'")


@pytest.mark.parametrize("values", ["a/b, a_b", "left, LEFT", '"\\u00e9", "e\\u0301"', "a, a"])
def test_two_values_of_one_name(values: str) -> None:
    with pytest.raises(ConfigError, match="two robots of the sweep would be written") as caught:
        swept(f"{{xacro_args: {{height: [{values}]}}}}", "'{height}.mbs'")
    assert caught.value.code == "sweep-output"


def test_a_project_each() -> None:
    found = swept("{xacro_args: {height: [1, 2]}}", "{project: 'biped_{height}'}")
    outputs: list[Any] = [one.config.output for one in found]
    assert [one.project for one in outputs] == ["biped_1", "biped_2"]
