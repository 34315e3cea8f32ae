"""Draw a model as a tidy tree: every parent at the middle above its children, all wires straight.

Children are side by side, each below its own port on the edge of the parent's box, which is as long
as that takes.  If many children are attached to a body, they may be at its two sides instead, one
below the other, which takes less room.  That is a *comb*::

        tree                        comb
       +------ parent ------+       +------+
       +--o----o----o----o--+    ---o      o---
          |    |    |    |          |parent|
                                 ---o      o---
                                    +------+
"""

from __future__ import annotations

from collections.abc import Container

from urdf2mbs.diagram.box_layout import Layout, PortSides, lay_out_box
from urdf2mbs.diagram.front_view import FrontView
from urdf2mbs.diagram.nodes import Node, Port
from urdf2mbs.diagram.sheet import GROWS_DOWN, GROWS_UP, place_on_sheet
from urdf2mbs.mbs.model import Mbs

MIN_COMB_PORTS = 4
"""A comb is tried for a body with at least this number of ports."""
COMB_COST = 0.75
"""A comb is used if its width and height together are at most this share of the tree's."""
NARROW_COMB_COST = 0.9
"""The same, if width counts twice."""
MIN_RISE = 0.25
"""A tree grows up if its bodies are on average higher than the first one by more than this share of
the robot's size."""

VERTICAL, BOTH = (True,), (True, False)
"""The orientations in which a limb is laid out: values of ``vertical``."""


def arrange_tree(mbs: Mbs, nodes: list[Node], view: FrontView) -> None:
    """Place a model in the diagram as a tree.

    Args:
        mbs: The model.
        nodes: The base, then the bodies depth first.
        view: The robot, seen from the front; limbs are drawn in its order from left to right.
    """
    rises = [
        view.limbs[node.name].frame[2] - view.limbs[nodes[1].name].start[2] for node in nodes[1:]
    ]
    grows_up = bool(rises) and sum(rises) / len(rises) > MIN_RISE * view.size
    for node in nodes:
        node.sort_ports(view.compute_offset)
    orientations = find_orientations(nodes, MIN_COMB_PORTS)
    for node in reversed(nodes):
        lay_out_tree(node, orientations.get(node.name, VERTICAL))
    base = nodes[0]
    place_on_sheet(mbs, base, base.layouts[True], GROWS_UP if grows_up else GROWS_DOWN)


def find_orientations(
    nodes: list[Node], min_ports: int, excluded: Container[str] = ()
) -> dict[str, tuple[bool, ...]]:
    """Find in which orientations each body may have to be drawn.

    The limbs of a comb run across, and so may all that is attached to them.

    Args:
        nodes: The base, then the bodies depth first.
        min_ports: A body with at least this number of ports may become a comb.
        excluded: Names of bodies that are laid out otherwise.

    Returns:
        The orientations of each body, by name.
    """
    orientations: dict[str, tuple[bool, ...]] = {}
    for node in nodes:
        child_orientations = orientations.get(node.name, VERTICAL)
        port_count = sum(port.point is not None for port in node.ports)
        if node.name not in excluded and port_count >= min_ports:
            child_orientations = BOTH
        orientations |= {
            child.name: child_orientations for child in node.children if child.name not in excluded
        }
    return orientations


def lay_out_tree(
    node: Node, orientations: tuple[bool, ...] = BOTH, *, narrow: bool = False
) -> None:
    """Lay out a body whose children are laid out, as a tree or as a comb.

    Args:
        node: The body; its layouts are set.
        orientations: The orientations that are needed.
        narrow: True if width counts more than height.
    """
    has_only_ports = all(port.point is not None for port in node.ports)
    max_cost = NARROW_COMB_COST if narrow else COMB_COST
    for vertical in orientations:
        best = lay_out_box(node, PortSides(ahead=node.ports), vertical=vertical)
        combs = []
        if has_only_ports and len(node.ports) >= MIN_COMB_PORTS:
            minus, plus = split_ports(node.ports, vertical=not vertical)
            combs.append(lay_out_box(node, PortSides(minus=minus, plus=plus), vertical=vertical))
        if has_only_ports and narrow and len(node.ports) > vertical:
            combs.append(lay_out_box(node, PortSides(plus=node.ports), vertical=vertical))
        for comb in combs:
            if _compute_cost(comb, narrow=narrow) < max_cost * _compute_cost(best, narrow=narrow):
                best = comb
        node.layouts[vertical] = best


def _compute_cost(layout: Layout, *, narrow: bool) -> float:
    """Compute the width and height of a layout together (px); width may count twice."""
    along_min, along_max, across_min, across_max = layout.extent
    width, height = across_max - across_min, along_max - along_min
    if not layout.vertical:
        width, height = height, width
    return (2 if narrow else 1) * width + height


def split_ports(ports: list[Port], *, vertical: bool) -> tuple[list[Port], list[Port]]:
    """Split ports, in order, into two parts whose limbs take about the same room.

    Args:
        ports: The ports.
        vertical: True if the limbs grow up or down.
    """
    widths = []
    for port in ports:
        extents = [child.layouts[vertical].extent for child in port.children]
        widths.append(sum(extent.across_max - extent.across_min for extent in extents))
    half, sum_before = sum(widths) / 2, 0.0
    for index, width in enumerate(widths):
        if sum_before + width / 2 >= half:
            return ports[:index], ports[index:]
        sum_before += width
    return ports, []
