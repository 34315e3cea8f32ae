"""Check: a file that is another robot does not take the place of a good one."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from support.plugin_files import write_plugin
from urdf2mbs import Result
from urdf2mbs.testing import TINY, convert_text

#: Changes the finished file, after ``emit`` and before ``check``.
REPLACE = """
    (output,) = conversion.files
    text = conversion.files[output].decode()
    assert {old!r} in text
    conversion.files[output] = text.replace({old!r}, {new!r}, 1).encode()
"""


def spoil(
    code: str, after: str, text: str = TINY, writes: tuple[str, ...] = (), **settings: Any
) -> Result:
    """Convert a robot, with a pass of this code put in."""
    with TemporaryDirectory() as folder:
        plugin = write_plugin(Path(folder), "spoil", code, writes=writes)
        return convert_text(text, plugins=[plugin], after={after: "spoil"}, **settings)


def replaced(old: str, new: str, **settings: Any) -> Result:
    """Convert the tiny robot, with one text in its file replaced by another one."""
    return spoil(REPLACE.format(old=old, new=new), "emit", **settings)


def test_a_file_of_the_same_robot_is_kept() -> None:
    for result in (convert_text(TINY), replaced("<mass>0.5</mass>", "<mass>5e-1</mass>")):
        found = result.report.proof
        assert found.same is True
        assert found.differences == []
        assert max(found.largest.values()) < 1e-14
        assert result.conversion.checked.rejected is None
        assert [*result.conversion.files_of("ours")] == [result.conversion.settings.output]


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ("<mass>0.5</mass>", "<mass>0.5000001</mass>", "mass"),
        ("<mass>0.5</mass>", "", "mass"),
        ("<z>0.15</z>", "<z>0.1500001</z>", "motion"),
        ("<Ixx>0.004</Ixx>", "<Ixx>0.0041</Ixx>", "inertia"),
        ("<q>0.5</q>", "<q>0.5001</q>", "motion"),
        ("<z>-9.81</z>", "<z>9.81</z>", "gravity"),
    ],
)
def test_another_robot_is_rejected(old: str, new: str, kind: str) -> None:
    result = replaced(old, new)
    found = result.report.proof
    assert found.same is False
    assert found.largest[kind] > 1e-9
    output = result.conversion.settings.output
    assert result.conversion.checked.rejected == output.with_suffix(".rejected.mbs")
    assert [*result.conversion.files_of("ours")] == [result.conversion.checked.rejected]


@pytest.mark.parametrize("values", [(0.0698, 3.0718), (-0.0698, -3.0718), (-3.0718, 0.0698)])
def test_limits_that_a_pass_exchanges_are_another_robot(values: tuple[float, float]) -> None:
    """An arm whose limits are not alike on both sides, as a Panda's fourth joint."""
    text = TINY.replace('lower="-1.5" upper="1.5"', 'lower="-3.0718" upper="-0.0698"')
    assert text != TINY
    code = f"""
        models = {{model.name: model for model in conversion.mbs.user_models}}
        for kind, value in zip(("q_min", "q_max"), {values}):
            (own,) = [of for of in models[kind].parameters if of.name == "shoulder"]
            own.values = (str(value),)
    """
    result = spoil(code, "joint-parameters", text)
    assert result.conversion.checked.rejected is not None
    wanted = zip((-3.0718, -0.0698), values, strict=True)
    assert [(d.kind, d.joint, d.urdf, d.mbs) for d in result.report.proof.differences] == [
        ("parameter", "shoulder", urdf, str(mbs)) for urdf, mbs in wanted if urdf != mbs
    ]


def test_the_tolerance_is_the_options() -> None:
    change = ("<mass>0.5</mass>", "<mass>0.5000001</mass>")
    loose = replaced(*change, passes={"check": {"tolerance": 1e-3}})
    assert loose.report.proof.same is True
    tight = replaced("<mass>0.5</mass>", "<mass>0.50000000001</mass>")
    assert tight.report.proof.same is True
    tight = replaced(
        "<mass>0.5</mass>", "<mass>0.50000000001</mass>", passes={"check": {"tolerance": 1e-12}}
    )
    assert tight.report.proof.same is False


def test_a_frame_that_is_elsewhere_counts_though_no_mass_is() -> None:
    found = replaced("<z>0.1</z>", "<z>0.2</z>").report.proof  # the point of the massless tool
    assert [(d.kind, d.link) for d in found.differences] == [("point", "tool")]
    assert found.same is False


def test_a_link_that_is_nowhere_is_a_difference() -> None:
    found = spoil("del conversion.frames['tool']", "assign-names").report.proof
    assert found.same is False
    assert [(d.kind, d.link) for d in found.differences] == [("frame-lost", "tool")]


def test_a_file_that_is_no_mbs_is_neither_read_nor_merged(tmp_path: Path) -> None:
    output = tmp_path / "tiny.txt"
    result = convert_text(TINY, output=output)
    assert result.conversion.checked.proof.same
    assert list(result.conversion.files) == [output]
