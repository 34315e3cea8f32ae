"""The robots that a sweep stands for."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import parse
from urdf2mbs.engine.settings import make_settings
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs_many.convert import list_jobs
from urdf2mbs_many.job import Job


def swept(text: str, output: str = "'{height}.mbs'", more: str = "") -> list[Job]:
    text = f"source: biped.urdf.xacro\noutput: {output}\n{more}\nsweep:\n  {text}\n"
    return list_jobs([parse(text, Path("sweep.yaml"))])


def test_every_combination_in_its_order() -> None:
    jobs = swept(
        "{xacro_args: {height: [0.70, 0.8], arms: [true, no]}, "
        "passes: {decompose-joints: {snap: [0, 1.5]}}}",
        "'{height}-{arms}-{decompose-joints.snap}.mbs'",
    )
    assert [job.config.output for job in jobs] == [
        "0.70-true-0.mbs",
        "0.70-true-1.5.mbs",
        "0.70-no-0.mbs",
        "0.70-no-1.5.mbs",
        "0.8-true-0.mbs",
        "0.8-true-1.5.mbs",
        "0.8-no-0.mbs",
        "0.8-no-1.5.mbs",
    ]
    assert jobs[1].values == {"height": "0.70", "arms": "true", "decompose-joints.snap": 1.5}
    assert jobs[1].config.xacro_args == {"height": "0.70", "arms": "true"}
    assert jobs[1].config.passes == {"decompose-joints": {"snap": 1.5}}
    assert all(job.config.sweep is None for job in jobs)


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ("{from: 0.7, to: 0.9, step: 0.1}", ["0.7", "0.8", "0.9"]),
        ("{from: 0.7, to: 0.84, step: 0.07}", ["0.7", "0.77", "0.84"]),
        (
            "{from: 0, to: 1, step: 0.3333333333333333}",
            ["0.0", "0.3333333333333333", "0.6666666666666666", "1.0"],
        ),
        (
            "{from: 0, to: 0.2, step: 0.06666666666666667}",
            ["0.0", "0.06666666666666667", "0.13333333333333333", "0.2"],
        ),
        ("{from: 1, to: 1, step: 5}", ["1"]),
        ("{from: 1, to: 3, step: 1}", ["1", "2", "3"]),
        ("{from: 3, to: 1, step: -1}", ["3", "2", "1"]),
        ("{from: 0, to: 1, count: 4}", ["0.0", "0.3333333333333333", "0.6666666666666666", "1.0"]),
    ],
)
def test_a_range_lists_its_values(given: str, values: list[str]) -> None:
    jobs = swept(f"{{xacro_args: {{height: {given}}}}}")
    assert [job.values["height"] for job in jobs] == values


@pytest.mark.parametrize(
    ("heights", "code"),
    [
        ("[]", "sweep-empty"),
        ("{from: 1, to: 2}", "sweep-range"),
        ("{from: 1, to: 2, step: 0}", "sweep-range"),
        ("{from: 1, to: 2, step: -1}", "sweep-range"),
        ("{from: 1, to: 2, count: 1}", "sweep-range"),
        ("{from: 1, to: 2, count: 3, step: 0.5}", "sweep-range"),
        ("{from: 0.7, to: 0.9, step: 0.07}", "sweep-range"),
        ("{from: 1, to: 4, step: 2}", "sweep-range"),
        ("{from: 1, to: 1.5, step: 2}", "sweep-range"),
        ("{from: 1, to: .nan, step: 1}", "config-type"),
        ("{from: 1, to: .inf, step: 1}", "value-range"),
        ("{from: 0, to: 1, step: 1.0e-9}", "sweep-long"),
        ("3", "config-type"),
        # two robots of one name, on some system
        ("[a/b, a_b]", "output-doubled"),
        ("[left, LEFT]", "output-doubled"),
        ('["\\u00e9", "e\\u0301"]', "output-doubled"),
        ("[1, 1]", "output-doubled"),
    ],
)
def test_values_that_are_no_sweep(heights: str, code: str) -> None:
    assert refused(f"{{xacro_args: {{height: {heights}}}}}") == code


def test_steps_that_miss_the_end_are_named() -> None:
    given = "{xacro_args: {height: {from: 0.7, to: 0.9, step: 0.07}}}"
    with pytest.raises(ConfigError) as caught:
        swept(given)
    assert "the steps of 0.07 from 0.7 do not end at 0.9, but at 0.84" in caught.value.message
    assert "'to: 0.84'" in str(caught.value.hint)
    assert "'count: 4'" in str(caught.value.hint)
    again = swept(given.replace("step: 0.07", "count: 4"))
    assert [job.values["height"] for job in again][::3] == ["0.7", "0.9"]


@pytest.mark.parametrize(
    ("given", "output", "more", "code"),
    [
        ("{}", "x.mbs", "", "sweep-empty"),
        ("{args: {}}", "x.mbs", "", "unknown-key"),
        ("{xacro_args: {height: [1, 2]}}", "'{hight}.mbs'", "", "sweep-output"),
        ("{xacro_args: {height: [1, 2]}}", "null", "", "sweep-output"),
        ("{xacro_args: {height: [1, 2]}}", "x.mbs", "", "output-doubled"),
        ("{xacro_args: {height: [1]}}", "'{height}.mbs'", "xacro_args: {height: 1}", "sweep-twice"),
        ("{passes: {a: {b: [1]}}}", "'{a.b}.mbs'", "passes: {a: {b: 1}}", "sweep-twice"),
        ("{xacro_args: {height: [1]}}", "'${height}.mbs'", "", "variable-unset"),
    ],
)
def test_a_wrong_sweep_is_refused(given: str, output: str, more: str, code: str) -> None:
    assert refused(given, output, more) == code


def refused(given: str, output: str = "'{height}.mbs'", more: str = "") -> str:
    with pytest.raises(ConfigError) as caught:
        swept(given, output, more)
    assert caught.value.line is not None
    return caught.value.code


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
    settings = make_settings(robot.config, Lines(Path("c.yaml"), folder=Path("/there")))
    assert settings.project == Path("/there/out") / name / "p"


def test_a_project_and_its_model_have_one_name() -> None:
    for job in swept("{xacro_args: {height: [0.7, 0.8]}}", "{project: 'out/biped_{height}'}"):
        settings = make_settings(job.config, Lines(Path("c.yaml"), folder=Path("/there")))
        name = f"biped_{job.values['height']}".replace(".", "_")
        assert settings.output == Path(f"/there/out/{name}/dataR/{name}.mbs")


def test_a_value_is_no_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLACE", "models")
    (robot,) = swept("{xacro_args: {height: [PLACE]}}", "'$PLACE/{height}.mbs'")
    assert robot.config.output == "models/PLACE.mbs"
    (robot,) = swept("{xacro_args: {height: [root]}}", "'~{height}/a.mbs'")
    assert robot.config.output == "./~root/a.mbs"
