"""The method's own diagram (Figure A.5): a grid of cells.

Each body has a cell (x, y) of a grid (Figure A.5), the base the upper left one (0, 0): from
parent to child (x, y + 1), from brother to brother (x + 1, y), from nephew to uncle
(x + 1, y - 1).  So the row of a body is its depth and its column the number of branches that
were finished before it.

A row begins with the first joints of its chains, all at one height; the other joints stand
straight below, the last one at the top centre of its body's box.  MBSysPad writes a joint's
name and number at the middle of the wire that leads to it.  For the first joint of a chain,
in another column than its parent, that is beside the parent's box or just below its height,
where the rule of the figure leaves the row free.
"""

from __future__ import annotations

from itertools import accumulate

from urdf2mbs.mbs.model import Body, Drawing, Mbs

# All in pixels, y down.
MARGIN = 20.0
"""Round the whole diagram."""
JOINT = 40.0
"""From joint to joint in a chain: the least that leaves room for a label."""
LABEL = 30.0
"""The size of a joint's label, both ways."""
POINT = 30.0
"""From point to point along the bottom edge of a box."""
CHARACTER = 10.0
"""The width of a character of a body's name, which MBSysPad writes in bold."""
WIDTH, HEIGHT = 100.0, 60.0
"""The least width of a body's box, and its height."""
BASE_WIDTH, BASE_HEIGHT = 120.0, 40.0
COLUMN_GAP = 40.0
ROW_GAP = 50.0
"""From the bottom of the lowest box of a row to the first joints of the next: a label."""


def arrange(mbs: Mbs) -> None:
    """Give everything its place."""
    base, bodies = mbs.base, mbs.depth_first()
    cells = _cells(bodies)
    points = {body.name: {point.name for point in body.points} for body in bodies}
    carries_at_origin = {
        body.parent
        for body in bodies
        if body.parent is not None and body.point not in points[body.parent]
    }

    base_width = max(BASE_WIDTH, 2 * POINT * (len(base.points) + 1))
    widths = [base_width]
    for body, (column, _) in zip(bodies, cells, strict=True):
        if column == len(widths):
            widths.append(0.0)
        widths[column] = max(widths[column], _width(body))
    lefts = accumulate((width + COLUMN_GAP for width in widths), initial=MARGIN)
    centres = [left + width / 2 for left, width in zip(lefts, widths, strict=False)]

    heights = [0.0] * (1 + max((row for _, row in cells), default=0))
    heights[0] = BASE_HEIGHT + ROW_GAP
    for body, (_, row) in zip(bodies, cells, strict=True):
        # From the body's own frame the wire starts at the top of its box: its middle, where
        # the label is, must come to lie below the box.
        gap = max(ROW_GAP, HEIGHT + LABEL + 10) if body.name in carries_at_origin else ROW_GAP
        height = JOINT * (len(body.joints) - 1) + HEIGHT + gap
        heights[row] = max(heights[row], height)
    tops = list(accumulate(heights, initial=MARGIN))

    x, y = base.position = (centres[0], MARGIN + BASE_HEIGHT)
    base.drawing = _box(base_width, -BASE_HEIGHT, 0.0)
    for index, point in enumerate(base.points, start=1):
        point.position = (x + POINT * index, y)  # beside the base's own frame, not on it
    for body, (column, row) in zip(bodies, cells, strict=True):
        x, y = centres[column], tops[row]
        for index, joint in enumerate(body.joints):
            joint.position = (x, y + JOINT * index)
        bottom = y + JOINT * (len(body.joints) - 1) + HEIGHT
        x -= POINT * (len(body.points) - 1) / 2
        for index, point in enumerate(body.points):
            point.position = (x + POINT * index, bottom)
        body.drawing = _box(_width(body), 0.0, HEIGHT)


def _cells(bodies: list[Body]) -> list[tuple[int, int]]:
    """Column and row of each body, the bodies standing depth first."""
    cells: list[tuple[int, int]] = []
    rows: dict[str | None, int] = {None: 0}
    column, last = 0, None
    for body in bodies:
        if body.parent != last:
            column += 1
        last = body.name
        rows[last] = rows[body.parent] + 1
        cells.append((column, rows[last]))
    return cells


def _width(body: Body) -> float:
    return max(WIDTH, CHARACTER * len(body.name) + 20, POINT * len(body.points) + 20)


def _box(width: float, top: float, bottom: float) -> Drawing:
    """A rectangle round the vertical through its joint."""
    right, left = width / 2, -width / 2
    return Drawing(
        position=(left, top),
        size=(width, bottom - top),
        control_points=((right, top), (right, bottom), (left, bottom), (left, top)),
    )
