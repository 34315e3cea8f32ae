"""A loop in a plane is the same robot wherever it is cut, but not if it closes elsewhere."""

import re
import shutil
from pathlib import Path

import pytest

from support.build import joint, link, robot
from urdf2mbs import convert, verify
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Point
from urdf2mbs.mbs.writer import write

PIN = "-2 {} 0"


def solid(mass: float, x: float) -> str:
    """An inertia whose centre is at x (m)."""
    return (
        f'<inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>'
        '<inertia ixx="0.01" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def close(name: str, parent: str, child: str, xyz: str) -> str:
    """A rotation that closes a loop, as Gazebo states it."""
    return (
        f'<gazebo><joint name="{name}" type="revolute"><parent>{parent}</parent>'
        f"<child>{child}</child><pose>{xyz} 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint>"
        "</gazebo>"
    )


CRANKS = (
    link("world"),
    link("a", solid(1, 0.1)),
    link("c", solid(3, 0.2)),
    joint("world", "a", name="A"),
    joint("world", "c", xyz="2 0 0", name="D"),
)


def cut_at_c() -> str:
    """A parallelogram of 2 m by 1 m: ground, a, b, c; cut between b and c."""
    coupler = joint("a", "b", xyz="0 1 0", name="B")
    return robot(*CRANKS, link("b", solid(2, 0.7)), coupler, close("C", "b", "c", "0 1 0"))


def cut_at_b(y: float = 0.0) -> str:
    """The same one, cut between a and b; y moves the cut (m)."""
    coupler = joint("c", "b", xyz="0 1 0", name="C")
    pin = close("B", "a", "b", PIN.format(y))
    return robot(*CRANKS, link("b", solid(2, 0.7 - 2)), coupler, pin)


def cut_at_a() -> str:
    """The same one, cut between the ground and a, so that two joints carry the other way round."""
    crank = link("a", solid(1, 0.1).replace('xyz="0.1 0 0"', 'xyz="0.1 -1 0"'))
    elements = (
        link("world"),
        link("c", solid(3, 0.2)),
        link("b", solid(2, 0.7 - 2)),
        crank,
        joint("world", "c", xyz="2 0 0", name="D"),
        joint("c", "b", xyz="0 1 0", name="C"),
        joint("b", "a", xyz="-2 0 0", name="B", axis="0 0 -1"),
    )
    return robot(*elements, close("A", "world", "a", "0 -1 0"))


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of four parallelograms and their models."""
    folder = tmp_path_factory.mktemp("loops")
    texts = {"c": cut_at_c(), "b": cut_at_b(), "a": cut_at_a(), "off": cut_at_b(0.05)}
    for name, text in texts.items():
        source = folder / f"{name}.urdf"
        source.write_text(re.sub("<limit[^>]*>", "", text))  # a cut has none
        source.with_suffix(".mbs").write_bytes(convert(source).data)
    return folder


@pytest.fixture
def loops(converted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Change to a copy of that folder."""
    shutil.copytree(converted, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("loops")
@pytest.mark.parametrize("second", ["b.urdf", "b.mbs", "a.urdf", "a.mbs"])
@pytest.mark.parametrize("first", ["c.urdf", "c.mbs"])
def test_a_loop_may_be_cut_at_another_joint(first: str, second: str) -> None:
    verdict = verify(first, second)
    assert verdict.same, [difference.message for difference in verdict.differences]
    (item, reason), *_ = verdict.but_for.items()
    joints = {first[0].upper(), second[0].upper()}
    assert {item.split("'")[1].removesuffix("_1"), reason.split("'")[1]} == joints


@pytest.mark.usefixtures("loops")
@pytest.mark.parametrize(
    ("first", "second"), [("c.urdf", "off.urdf"), ("c.mbs", "off.mbs"), ("b.mbs", "off.mbs")]
)
def test_a_loop_that_is_closed_elsewhere_is_another_one(first: str, second: str) -> None:
    verdict = verify(first, second)
    assert not verdict.same
    (difference,) = verdict.differences
    assert difference.kind == "cut"
    assert "is 0.05 m off" in difference.message


@pytest.mark.usefixtures("loops")
def test_a_loop_is_itself() -> None:
    verdict = verify("c.mbs", "c.mbs")
    assert verdict.verdict == "the same robot"


@pytest.mark.usefixtures("loops")
def test_a_loop_in_space_is_not_cut_elsewhere() -> None:
    """A ball in place of a rotation lets it move in other ways."""
    for name in ("c", "b"):
        text = Path(f"{name}.urdf").read_text()
        tilted = text.replace('xyz="2 0 0" rpy="0 0 0"', 'xyz="2 0 0" rpy="0.2 0 0"')
        Path(f"{name}.urdf").write_text(tilted)
    assert not verify("c.urdf", "b.urdf").same


def hang_on_a_rod(length: float = 0.5, x: float = 0.2) -> Mbs:
    """A pendulum that a rod holds to the ground."""
    mbs = Mbs("rod")
    mbs.base.points = [Point("hook", (0.0, 0.0, 1.0))]
    inertia = (0.1, 0.0, 0.0, 0.2, 0.0, 0.3)
    tip = Point("tip", (x, 0.0, 0.5))
    joints = [Joint("swing", "R2"), Joint("turn", "R3", "dependent")]
    mbs.bodies = [Body("arm", None, None, joints, 2.0, (0.1, 0.0, 0.2), inertia, [tip])]
    mbs.cuts = [Connection("rod", "rope", (None, "hook"), ("arm", "tip"), length=length)]
    return mbs


@pytest.mark.parametrize(
    ("changes", "is_same"), [({}, True), ({"length": 0.6}, False), ({"x": 0.25}, False)]
)
def test_rods_are_compared(changes: dict[str, float], is_same: bool, tmp_path: Path) -> None:
    (tmp_path / "a.mbs").write_bytes(write(hang_on_a_rod()))
    (tmp_path / "b.mbs").write_bytes(write(hang_on_a_rod(**changes)))
    verdict = verify(tmp_path / "a.mbs", tmp_path / "b.mbs")
    assert verdict.same is is_same
    assert [difference.kind for difference in verdict.differences] == ["cut"] * (not is_same)
    assert not any(item.startswith("cut ") for item in verdict.but_for) or not is_same


def test_a_fault_of_the_first_model_is_no_difference(tmp_path: Path) -> None:
    """A joint that is dependent, and that nothing moves."""
    mbs = hang_on_a_rod()
    mbs.cuts = []
    (tmp_path / "a.mbs").write_bytes(write(mbs))
    assert verify(tmp_path / "a.mbs", tmp_path / "a.mbs").same
    mbs.bodies[0].joints[1].nature = "driven"
    (tmp_path / "b.mbs").write_bytes(write(mbs))
    assert not verify(tmp_path / "a.mbs", tmp_path / "b.mbs").same


@pytest.mark.usefixtures("loops")
def test_numbers_of_a_joint_that_is_a_cut_are_a_difference() -> None:
    text = Path("c.urdf").read_text()
    damped = text.replace(
        '<joint name="B" type="continuous">',
        '<joint name="B" type="continuous"><dynamics damping="3"/>',
    )
    Path("damped.urdf").write_text(damped)
    verdict = verify("damped.urdf", "b.mbs")
    (difference,) = verdict.differences
    assert "joint 'B' is a cut in the .mbs, without its damping" in difference.message
