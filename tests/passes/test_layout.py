"""Layout: the options, and the grid of the method's Figure A.5."""

from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from diagram.faults import Rectangle, square
from diagram.trees import trees
from hypothesis import given, settings

from urdf2mbs.conversion import Conversion, Settings
from urdf2mbs.engine.config import Config
from urdf2mbs.mbs.model import XY, Body, Drawing, Joint, Mbs, Point
from urdf2mbs.passes.layout import Layout

if TYPE_CHECKING:
    from collections.abc import Iterator

#: How large MBSysPad draws a joint or point and its label (px).
DOT, LABEL = 10.0, 30.0


reproducible = settings(max_examples=200, deadline=None, derandomize=True, database=None)


def tree(*parents: int | None, joints: int = 1) -> Mbs:
    """Bodies b0, b1, ..., each with an anchor point of its own on the parent of that index."""
    mbs = Mbs("m")
    for index, parent in enumerate(parents):
        carrier = mbs.base if parent is None else mbs.bodies[parent]
        carrier.points.append(Point(f"to_b{index}"))
        mbs.bodies.append(
            Body(
                f"b{index}", None if parent is None else carrier.name, f"to_b{index}",
                [Joint(f"j{index}_{k}", "R1") for k in range(joints)],
            )
        )  # fmt: skip
    return mbs


def laid_out(mbs: Mbs) -> Mbs:
    conversion = Conversion(Settings(Path("robot.urdf"), Path("robot.mbs"), Config(source="")))
    conversion.mbs = mbs
    Layout(style="method").run(conversion)
    return mbs


def box(what: str, drawing: Drawing | None, at: XY | None) -> Rectangle:
    assert drawing is not None
    assert at is not None
    x, y = at[0] + drawing.position[0], at[1] + drawing.position[1]
    width, height = drawing.size
    assert drawing.shape == "rectangle"
    corners = [(at[0] + u, at[1] + v) for u, v in drawing.control_points]
    assert corners == [(x + width, y), (x + width, y + height), (x, y + height), (x, y)]
    return Rectangle(what, x, y, x + width, y + height)


def position(of: Joint | Point) -> XY:
    assert of.position is not None
    return of.position


def middle(a: XY, b: XY) -> XY:
    return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)


def boxes(mbs: Mbs) -> list[Rectangle]:
    """The base's, then the bodies' in their order."""
    bodies = [box(b.name, b.drawing, b.joints[-1].position) for b in mbs.bodies]
    return [box("base", mbs.base.drawing, mbs.base.position), *bodies]


def dots(mbs: Mbs) -> Iterator[Rectangle]:
    assert mbs.base.position is not None
    yield square("base", mbs.base.position, DOT)
    for point in mbs.base.points:
        yield square(f"base.{point.name}", position(point), DOT)
    for body in mbs.bodies:
        for joint in body.joints:
            yield square(joint.name, position(joint), DOT)
        for point in body.points:
            yield square(f"{body.name}.{point.name}", position(point), DOT)


def labels(mbs: Mbs) -> Iterator[Rectangle]:
    """The name and number of each joint stand at the middle of the wire that leads to it."""
    starts: dict[tuple[str | None, str | None], XY] = {}
    assert mbs.base.position is not None
    starts[None, None] = mbs.base.position
    starts |= {(None, point.name): position(point) for point in mbs.base.points}
    for body in mbs.bodies:
        starts[body.name, None] = position(body.joints[-1])
        starts |= {(body.name, point.name): position(point) for point in body.points}
    for body in mbs.bodies:
        start = starts[body.parent, body.point]
        for joint in body.joints:
            yield square(f"label of {joint.name}", middle(start, position(joint)), LABEL)
            start = position(joint)


def check(mbs: Mbs) -> None:
    """Nothing is negative; boxes, joints, points and labels keep off one another."""
    solid = boxes(mbs)
    drawn, written = list(dots(mbs)), list(labels(mbs))
    for thing in (*solid, *drawn, *written):
        assert thing.left >= 0.0, thing
        assert thing.top >= 0.0, thing
    for kind in (solid, drawn, written):
        for a, b in combinations(kind, 2):
            assert not a.overlaps(b), (a, b)
    for label in written:
        for thing in (*solid, *drawn):
            assert not label.overlaps(thing), (label, thing)
    on_edge = edges(mbs)
    for dot in drawn:
        for thing in solid:
            assert not dot.overlaps(thing) or on_edge[dot.what] == thing.what, (dot, thing)


def edges(mbs: Mbs) -> dict[str, str | None]:
    """On whose box's edge each joint and point stands."""
    edge: dict[str, str | None] = {"base": "base"}
    edge |= {f"base.{point.name}": "base" for point in mbs.base.points}
    for body in mbs.bodies:
        edge |= {joint.name: None for joint in body.joints}
        edge[body.joints[-1].name] = body.name
        edge |= {f"{body.name}.{point.name}": body.name for point in body.points}
    return edge


@reproducible
@given(trees())
def test_nothing_overlaps_and_nothing_is_negative(mbs: Mbs) -> None:
    check(laid_out(mbs))


@reproducible
@given(trees())
def test_chains_stand_straight_above_their_box_and_points_on_its_lower_edge(mbs: Mbs) -> None:
    laid_out(mbs)
    for body, rectangle in zip(mbs.bodies, boxes(mbs)[1:], strict=True):
        x, y = position(body.joints[-1])
        assert (x, y) == ((rectangle.left + rectangle.right) / 2, rectangle.top)
        for k, joint in enumerate(reversed(body.joints)):
            assert position(joint) == (x, y - 40 * k)
        across = [position(point)[0] for point in body.points]
        assert all(b - a == 30.0 for a, b in pairwise(across))
        assert sum(across) == pytest.approx(x * len(across))
        for point in body.points:
            assert position(point)[1] == rectangle.bottom
            assert rectangle.left < position(point)[0] < rectangle.right
        assert rectangle.right - rectangle.left >= 9 * len(body.name)  # as MBSysPad writes it
    base, assigned = boxes(mbs)[0], mbs.base.position
    assert assigned == ((base.left + base.right) / 2, base.bottom)
    for point in mbs.base.points:
        assert position(point)[1] == base.bottom
        assert base.left < position(point)[0] < base.right


@reproducible
@given(trees())
def test_the_rule_of_figure_a5(mbs: Mbs) -> None:
    """The row is the depth, the column the number of branches finished before."""
    laid_out(mbs)
    order = mbs.depth_first()
    depth: dict[str | None, int] = {None: 0}
    column, cells = 0, []
    stack: list[str | None] = [None]  # the branch that is being drawn
    for body in order:
        if stack[-1] != body.parent:
            column += 1  # from the end of a branch to a brother of one of its bodies
            while stack[-1] != body.parent:
                stack.pop()
        stack.append(body.name)
        depth[body.name] = depth[body.parent] + 1
        cells.append((column, depth[body.name]))
    placed = [position(body.joints[0]) for body in order]
    assert len(set(cells)) == len(cells)
    columns, rows = {c: x for (c, _), (x, _) in zip(cells, placed, strict=True)}, {
        r: y for (_, r), (_, y) in zip(cells, placed, strict=True)
    }  # fmt: skip
    assert placed == [(columns[c], rows[r]) for c, r in cells]
    assert sorted(columns.values()) == [columns[c] for c in sorted(columns)]
    assert sorted(rows.values()) == [rows[r] for r in sorted(rows)]
    assert len({*columns.values()}) == len(columns)
    assert len({*rows.values()}) == len(rows)
    assert mbs.base.position is not None
    assert all(y > mbs.base.position[1] for _, y in placed)
    assert all(x >= mbs.base.position[0] for x, _ in placed)


def test_the_tree_of_the_figure() -> None:
    """Parent to child: one down; brother to brother: one right; nephew to uncle: right and up."""
    mbs = laid_out(tree(None, 0, 1, 1, 0))
    cells = [position(body.joints[0]) for body in mbs.bodies]
    (x0, y1), (x0_, y2), (x0__, y3), (x1, y3_), (x2, y2_) = cells
    assert x0 == x0_ == x0__ < x1 < x2
    assert y1 < y2 == y2_ < y3 == y3_
    assert mbs.base.position is not None
    assert mbs.base.position[0] == x0


def test_brothers_that_share_a_point_or_the_parents_own_frame() -> None:
    for point in ("to_b1", None):
        mbs = tree(None, 0, 0, 0, 0)
        for body in mbs.bodies[1:]:
            body.point = point
        check(laid_out(mbs))
    mbs = tree(None, None, None, joints=6)
    for body in mbs.bodies:
        body.point = None
    check(laid_out(mbs))


def test_children_of_the_frame_and_of_points_side_by_side() -> None:
    mbs = tree(None, *[0] * 20)
    mbs.bodies[5].point = mbs.bodies[9].point = mbs.bodies[12].point = None
    check(laid_out(mbs))


def test_a_short_chain_beside_a_long_one() -> None:
    mbs = tree(None, 0, 0, 1, 2, 2)
    mbs.bodies[1].joints += [Joint(f"k{k}", "R1") for k in range(9)]
    check(laid_out(mbs))


def test_a_robot_that_is_only_a_base() -> None:
    mbs = laid_out(Mbs("m"))
    check(mbs)
    assert mbs.base.drawing is not None


def test_the_order_of_the_bodies_does_not_matter() -> None:
    one, other = tree(None, 0, 0, 1, 2), tree(None, 0, 0, 1, 2)
    other.bodies = [other.bodies[k] for k in (0, 2, 1, 4, 3)]
    laid_out(one)
    laid_out(other)
    assert {b.name: b.joints[0].position for b in one.bodies} == {
        b.name: b.joints[0].position for b in other.bodies
    }
