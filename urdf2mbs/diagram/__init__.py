"""Draw the 2D diagram of MBSysPad: where boxes, joints and points are, and how large they are.

A diagram is made in three steps, each in a file or two:

1. ``nodes`` makes a tree of the bodies, and ``front_view`` says what the robot looks like.
2. ``robot`` (which needs a ``spine``) or ``tree``, the two styles, decide where each limb goes.
   ``box_layout`` lays out one body with its children, whose layouts are known; ``box_size`` says
   how large its box must be.
3. ``sheet`` moves all that to its place on the sheet, and writes it into the model.
"""

from __future__ import annotations

from urdf2mbs.diagram.front_view import compute_front_view
from urdf2mbs.diagram.nodes import build_nodes
from urdf2mbs.diagram.robot import arrange_robot
from urdf2mbs.diagram.spine import find_spine
from urdf2mbs.diagram.tree import arrange_tree
from urdf2mbs.mbs.model import Mbs


def arrange(mbs: Mbs, style: str = "robot") -> str:
    """Place the base, the bodies, their joints and their points in the diagram (px, y down).

    Args:
        mbs: The model; its bodies, joints and points get their positions.
        style: ``robot`` or ``tree``.

    Returns:
        The style that was used: ``tree`` also if the robot has no shape that could be drawn.
    """
    nodes = build_nodes(mbs)
    view = compute_front_view(mbs, nodes)
    spine = find_spine(nodes, view) if style == "robot" else None
    if spine is not None:
        arrange_robot(mbs, nodes, spine)
        return "robot"
    arrange_tree(mbs, nodes, view)
    return "tree"
