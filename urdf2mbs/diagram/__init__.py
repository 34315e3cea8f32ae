"""Where everything stands in MBSysPad's 2D diagram: two styles, and how large things are."""

from __future__ import annotations

from urdf2mbs.diagram import robot, tree
from urdf2mbs.diagram.boxes import nodes
from urdf2mbs.diagram.shape import look
from urdf2mbs.mbs.model import Mbs


def arrange(mbs: Mbs, style: str = "robot") -> str:
    """Give the base, the bodies, their joints and points their places (px, y down).

    Returns the style that was used: ``robot`` falls back to ``tree`` where there is no shape
    worth following.
    """
    order = nodes(mbs)
    shape = look(mbs, order)
    bones = robot.spine(order, shape) if style == "robot" else None
    if bones is not None:
        robot.arrange(mbs, order, bones)
        return "robot"
    tree.arrange(mbs, order, shape)
    return "tree"
