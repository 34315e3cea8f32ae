"""Random robots stay the same robots: all joint types, any axis, any angle, any names."""

from itertools import cycle, product
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.build import SOLID, joint, link, robot
from support.compare import beside_its_urdf, lost_shapes, structure_faults
from support.examples import reproducible
from support.oracle.urdf import Urdf
from support.presets import PRESETS
from support.strategies import robots, snapped
from urdf2mbs import convert

TOLERANCE = 1e-11
KEEP_ALL = {"prune-massless": {"keep": ["*"]}}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robots") / "robot.urdf"


def check(file: Path, text: str | bytes, base: str, keep: bool, snapped: float = 0.0) -> None:
    """Converts the robot; everything that can be compared must be the same, but for what comes
    of axes having been moved by up to ``snapped`` (rad) in all."""
    data = text.encode() if isinstance(text, str) else text
    file.write_bytes(data)
    urdf = Urdf.parse(data)
    result = convert(file, base=base, passes=KEEP_ALL if keep else {})
    comparison, errors = beside_its_urdf(result, urdf, data, base, positions=2)
    # forces are relative to levers that may be 3e-3 of the robot's size
    limit = {kind: TOLERANCE + (10 if kind == "pose" else 1000) * snapped for kind in errors}
    assert not {kind: error for kind, error in errors.items() if not error <= limit[kind]}
    assert structure_faults(comparison) == []
    assert lost_shapes(comparison) == []
    assert set(result.frozen) == (set() if keep else urdf.moving_nothing())


def check_any_robot(file: Path, text: bytes, base: str, keep: bool) -> None:
    """An axis within 1e-9 rad of a coordinate axis or plane is taken to lie on it; beyond that,
    and everywhere else, nothing is rounded."""
    check(file, text, base, keep, snapped(text))


ANY_ROBOT = {
    "text": robots(),
    "base": st.sampled_from(("auto", "floating", "fixed")),
    "keep": st.booleans(),
}


@settings(reproducible, max_examples=40)
@given(**ANY_ROBOT)
def test_any_robot_is_the_same_robot(file: Path, text: bytes, base: str, keep: bool) -> None:
    """By the preset faithful; tests/plugins/compact/test_compact.py has the other."""
    check_any_robot(file, text, base, keep)


@pytest.mark.slow
@settings(reproducible, max_examples=250)
@given(**ANY_ROBOT)
def test_any_of_many_robots_is_the_same_robot(
    file: Path, text: bytes, base: str, keep: bool
) -> None:
    check_any_robot(file, text, base, keep)


AXES = {
    "aligned": ("1 0 0", "0 1 0", "0 0 1", "-1 0 0", "0 -1 0", "0 0 -1"),
    "in a plane": ("0 1 1", "0 1 -2", "1 0 1", "-1 0 2", "1 1 0", "-1 1 0", "-2 -1 0"),
    "oblique": ("1 1 1", "-1 -2 3", "1 2 -3"),
    "of any length": ("5 0 0", "0 0 -1e-3", "1e-200 2e-200 0", "1e200 1e200 1e200"),
    "almost aligned": ("1 2e-9 0", "1 1e-8 -1e-8"),
}


@pytest.mark.parametrize("axes", AXES)
def test_every_axis_is_kept_by_every_joint_that_has_one(file: Path, axes: str) -> None:
    elements = [link("root", SOLID)]
    for number, axis in enumerate(AXES[axes]):
        for kind in ("revolute", "prismatic", "planar"):
            near, far = f"{kind}_{number}", f"{kind}_{number}_behind"
            elements += [
                link(near, SOLID),
                link(far, SOLID),
                joint("root", near, kind, axis=axis, xyz="1 2 3", rpy="1 2 3"),
                joint(near, far, kind, axis=axis),
            ]
    check(file, robot(*elements), "floating", False)


@pytest.mark.parametrize("axis", ["1 {} 0", "0 -1 {}", "{} {} 1", "1 {} 1"])
def test_a_nearly_aligned_axis_is_off_by_no_more_than_it_was(file: Path, axis: str) -> None:
    off = 9.9e-10
    turning = joint("a", "b", "revolute", axis=axis.format(off, off))
    text = robot(link("a", SOLID), link("b", SOLID), turning)
    check(file, text, "fixed", False, off)


@pytest.mark.parametrize(
    "rpy",
    [
        "1.5708 0 0",
        "0 1.5708 0",
        "0 0 1.5708",
        "1.57079632679 1.57079632679 1.57079632679",
        "0 -1.5707963267948966 0.3",
        "3.141592653589793 0 -3.141592653589793",
        "0.5 1.5707963267948966 -0.5",
        "-3.14159 1e-9 0",
        "1e-300 0 0",
    ],
)
def test_every_turn_of_an_origin_is_kept(file: Path, rpy: str) -> None:
    turned = f'<origin xyz="0.1 0.2 0.3" rpy="{rpy}"/>'
    shapes = "".join(
        f"<visual>{turned}<geometry>{shape}</geometry></visual>"
        for shape in (
            '<box size="1 2 3"/>',
            '<cylinder radius="1" length="2"/>',
            '<mesh filename="m.stl" scale="1 2 3"/>',
        )
    )
    text = robot(
        link("a", SOLID, shapes),
        link("b", SOLID.replace('rpy="0.3 -0.2 0.1"', f'rpy="{rpy}"'), shapes),
        link("frame", shapes),
        joint("a", "b", xyz="0.1 0.2 0.3", rpy=rpy),
        joint("b", "frame", "fixed", xyz="0.1 0.2 0.3", rpy=rpy),
    )
    check(file, text, "floating", False)
    check(file, text, "fixed", True)


#: How links without mass are attached: the first and the third joint, and the second; with each
#: pair of them another choice of the rest.
ROWS = [
    (inner, outer, *choice)
    for (inner, outer), choice in zip(
        product(("fixed", "prismatic", "floating"), ("fixed", "revolute", "planar", "floating")),
        cycle(product(("0 0 0", "0.1 0 0"), ("fixed", "floating"), (False, True))),
        strict=False,
    )
]


@pytest.mark.parametrize(("inner", "outer", "shift", "base", "keep"), ROWS)
def test_massless_links_in_a_row_keep_their_frames(
    file: Path, inner: str, outer: str, shift: str, base: str, keep: bool
) -> None:
    """Root, two frames in a row, a body behind them, and frames that lead nowhere."""
    turned = {"xyz": shift, "rpy": "0.1 0.2 0.3", "axis": "1 2 3"}
    text = robot(
        *(link(name) for name in ("root", "one", "two", "side", "tip")),
        link("body", SOLID),
        joint("root", "one", inner, xyz="1 2 3", rpy="1 2 3", axis="1 2 3"),
        joint("one", "two", outer, **turned),
        joint("two", "body", inner, **turned),
        joint("one", "side", outer, **turned),
        joint("body", "tip", inner, **turned),
    )
    check(file, text, base, keep)
    alone = text.replace('<link name="side">', f'<link name="side">{SOLID}')
    check(file, alone, base, keep)


@pytest.mark.parametrize(
    ("first", "second", "kind"),
    [
        ("hip", "hip_origin_R3", "revolute"),
        ("hip", "hip_axis_R3", "planar"),
        ("hip_back_R2", "hip", "revolute"),
        ("a-b", "a_b", "planar"),
        ("a/b", "a b", "floating"),
        ("floating_base", "floating_base_T1", "revolute"),
        ("floating_base_2", "floating_base", "floating"),
        ("third", "third_T1", "planar"),
    ],
)
def test_joint_names_that_clash_with_those_of_driven_joints_stay_apart(
    file: Path, first: str, second: str, kind: str
) -> None:
    turned = {"xyz": "0 0 1", "rpy": "0.1 0.2 0.3", "axis": "1 2 3"}
    text = robot(
        link(second, SOLID),
        link(first, SOLID),
        link("last", SOLID),
        joint(second, first, kind, name=first, **turned),
        joint(first, "last", kind, name=second, **turned),
    )
    check(file, text, "floating", False)


def test_mass_without_inertia_and_inertia_without_mass_are_kept(file: Path) -> None:
    point = '<inertial><mass value="3"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    flywheel = (
        '<inertial><mass value="0"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="2"/>'
    )
    links = link("a", point, "</inertial>"), link("b", flywheel, "</inertial>")
    text = robot(*links, joint("a", "b"))
    check(file, text, "fixed", False)
    check(file, text, "floating", False)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_a_robot_of_any_size_is_the_same_robot(file: Path, scale: float) -> None:
    small = f"{0.1 * scale!r} {-0.3 * scale!r} {0.2 * scale!r}"
    inertia = 1e-2 * scale**2
    text = robot(
        *(
            link(
                name,
                f'<inertial><origin xyz="{small}"/><mass value="1e-9"/><inertia '
                f'ixx="{1e-9 * inertia!r}" ixy="0" ixz="0" iyy="{2e-9 * inertia!r}" iyz="0" '
                f'izz="{2.5e-9 * inertia!r}"/></inertial>',
            )
            for name in "abc"
        ),
        joint("a", "b", "revolute", xyz=small, rpy="1 2 3", axis="1 0 0"),
        joint("b", "c", "prismatic", xyz=small, axis="1 1 1"),
    )
    check(file, text, "fixed", False)
    check(file, text, "floating", False)


@pytest.mark.parametrize("pipeline", PRESETS)
def test_a_robot_of_frames_alone_has_bodies_without_mass(file: Path, pipeline: str) -> None:
    """All stay, as bodies without mass, and that is said."""
    for links, base in product(("a", "ab"), ("fixed", "floating")):
        text = robot(*map(link, links), *([joint("a", "b")] * (links == "ab")))
        file.write_text(text)
        result = convert(file, base=base, pipeline=pipeline)
        proof = result.report.proof
        assert proof is not None
        assert proof.same
        assert result.mbs.bodies
        assert sum(body.mass or 0.0 for body in result.mbs.bodies) == 0.0
        (said,) = [found for found in result.diagnostics if found.level == "warning"]
        assert said.code == "no-mass"
        assert "estimate-inertia" not in (said.hint or "")
