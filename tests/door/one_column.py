"""Draw one body below the other, its joints in a row before it: a layout of our own."""

from urdf2mbs.plugin import Base, Body, Conversion, Drawing, Pass, hookimpl

#: The size of a box, and the distances from row to row and from joint to joint (px).
WIDTH, HEIGHT, ROW, COLUMN = 90.0, 60.0, 100.0, 70.0
#: Left, right, top and bottom of a box, from the last joint before it (px).
LEFT, RIGHT, TOP, BOTTOM = 20.0, 20.0 + WIDTH, -HEIGHT / 2, HEIGHT / 2


class Layout(Pass):
    """Draw one body below the other, its joints in a row before it."""

    reads = ("bodies", "joints", "anchors", "names")
    writes = ("layout",)

    def run(self, conversion: Conversion) -> None:
        mbs = conversion.mbs
        mbs.base.position = (COLUMN, ROW)
        holders: list[Base | Body] = [mbs.base, *mbs.bodies]
        for row, holder in enumerate(holders, start=1):
            corners = ((RIGHT, TOP), (RIGHT, BOTTOM), (LEFT, BOTTOM), (LEFT, TOP))
            holder.drawing = Drawing((LEFT, TOP), (WIDTH, HEIGHT), corners)
            joints = holder.joints if isinstance(holder, Body) else []
            for column, joint in enumerate(joints, start=1):
                joint.position = (COLUMN * column, row * ROW)
            right = COLUMN * max(1, len(joints)) + RIGHT
            gap = HEIGHT / (len(holder.points) + 1)
            for number, point in enumerate(holder.points, start=1):
                point.position = (right, row * ROW + TOP + number * gap)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [Layout]
