"""Find the spine of a robot, and the limbs that leave it to the sides, up and down."""

from __future__ import annotations

from typing import NamedTuple

import msgspec

from urdf2mbs.diagram.box_size import compute_min_box
from urdf2mbs.diagram.front_view import FrontView, LimbView
from urdf2mbs.diagram.nodes import Node, Port

MIDDLE = 0.04
"""Whatever is nearer to the plane of symmetry is in the middle (share of the robot's size)."""
MAX_LIMBS = 24
"""With more limbs than this at its spine, nobody would recognise a robot."""
SHORT_DEPTH = 2
"""A limb whose longest chain has no more bodies does not turn down, and is not a leg."""
MIN_RISING_SLOPE, MAX_LEG_SLOPE = 0.7, -0.5
"""Of limbs that are drawn upwards, and of legs, seen from the front."""
LEG_HEIGHTS = 0.15
"""Limbs down from one body whose heights differ more are arms and legs (share of the size)."""


class Limb(msgspec.Struct, eq=False):
    """A limb that leaves the spine."""

    port: Port
    side: int
    """1: to the right of the picture, -1: to the left."""
    height: float
    """Where it leaves the spine (share of the robot's size)."""
    depth: int
    """Number of bodies in its longest chain."""
    chain: list[Node]
    """The bodies from the spine to where the limb branches: these can be drawn in a horizontal
    lane."""
    lane_below: float = 0.0
    """How far this lane extends below the joints (px); set once their sizes are known."""
    lane_above: float = 0.0
    """How far this lane extends above the joints (px); set once their sizes are known."""

    @property
    def node(self) -> Node:
        """The first body."""
        return self.chain[0]


class Vertebra(msgspec.Struct, eq=False):
    """A body of the spine, and the limbs that leave it."""

    node: Node
    ahead: list[Port] = []
    """Limbs on top of it, from left to right; or the next body of the spine."""
    rows: list[list[Limb]] = []
    """Limbs to the sides, lowest first; in a row, one limb or one at each side."""
    legs: list[Limb] = []
    """Limbs straight down from the lower edge of the box, from the middle outwards."""
    lane_heights: list[float] = []
    """How high each row leaves the box (px); set once the sizes are known."""


def find_spine(nodes: list[Node], view: FrontView) -> list[Vertebra] | None:
    """Find the spine of a robot, and prepare its limbs to be drawn.

    There is a spine if the base carries one robot, of which at least one limb of two bodies or more
    has its mirror image, and if each limb has a port of its own.

    Args:
        nodes: The base, then the bodies depth first.
        view: The robot, seen from the front.

    Returns:
        The spine, lowest body first; None if the robot has no spine.
    """
    if len(nodes[0].children) != 1 or not view.pair_count:
        return None
    ports = [port for node in nodes[1:] for port in node.ports]
    if any(port.point is None or len(port.children) > 1 for port in ports):
        return None
    spine = _build_spine(nodes[0].children[0], view)
    if spine is None:
        return None
    limbs = [limb for vertebra in spine for row in (*vertebra.rows, vertebra.legs) for limb in row]
    if len(limbs) > MAX_LIMBS:
        return None
    has_long_limb = any(limb.side > 0 and limb.depth > 1 for limb in limbs)
    if not has_long_limb and len(spine[-1].ahead) < 2:
        return None  # the mirror images are farther out, such as the fingers of one arm
    _prepare_limbs(spine, limbs, view)
    return spine


def _build_spine(lowest: Node, view: FrontView) -> list[Vertebra] | None:
    """Build the spine from its lowest body up; None if a body has too many limbs."""
    spine: list[Vertebra] = []
    node: Node | None = lowest
    while node is not None:
        if len(node.ports) > MAX_LIMBS:
            return None
        vertebra, node = _build_vertebra(node, view, is_lowest=not spine)
        spine.append(vertebra)
    return spine


class MiddlePort(NamedTuple):
    """A port with a limb in the plane of symmetry."""

    port: Port
    view: LimbView


def _build_vertebra(
    node: Node, view: FrontView, *, is_lowest: bool
) -> tuple[Vertebra, Node | None]:
    """Decide for each limb of a body of the spine where it goes.

    Returns:
        The vertebra, and the next body of the spine; None if this is the last one.
    """
    vertebra = Vertebra(node)
    sideways, middle = _split_limbs(node, view)
    legs = _find_legs(sideways, view) if is_lowest else []
    next_port = _find_next_port(node, middle, view)
    next_node: Node | None = None
    if next_port is not None:
        middle.remove(next_port)
        vertebra.ahead, next_node = [next_port.port], next_port.port.children[0]
    elif not legs:
        rising = [limb for limb in sideways if _compute_slope(limb, view) > MIN_RISING_SLOPE]
        vertebra.ahead = sorted(
            (limb.port for limb in rising), key=lambda port: view.compute_offset(port.children[0])
        )
        sideways = [limb for limb in sideways if limb not in rising]
    # Two long legs leave to the sides and turn down, as arms do; all others are straight down.
    if len(legs) != 2 or any(leg.depth <= SHORT_DEPTH for leg in legs):
        vertebra.legs = sorted(legs, key=lambda leg: abs(view.compute_offset(leg.node)))
        sideways = [limb for limb in sideways if limb not in legs]
        legs = []
    # Limbs in the middle that are not on the spine go to the side with fewer limbs.
    for port, limb_view in middle:
        side = 1 if sum(limb.side for limb in sideways) < 0 else -1
        sideways.append(_create_limb(port, limb_view, side, view))
    sideways.sort(key=lambda limb: (limb not in legs, round(limb.height, 2)))
    vertebra.rows = _group_in_rows(sideways, view)
    return vertebra, next_node


def _split_limbs(node: Node, view: FrontView) -> tuple[list[Limb], list[MiddlePort]]:
    """Split the limbs of a body into those at the sides and those in the middle."""
    sideways: list[Limb] = []
    middle: list[MiddlePort] = []
    for port in node.ports:
        limb_view = view.limbs[port.children[0].name]
        centre = limb_view.centre[0] / view.size
        start = max(abs(limb_view.start[0]), abs(limb_view.frame[0])) / view.size
        if limb_view.partner is None and start <= MIDDLE and abs(centre) <= 4 * MIDDLE:
            middle.append(MiddlePort(port, limb_view))
        else:
            sideways.append(_create_limb(port, limb_view, 1 if centre > 0 else -1, view))
    return sideways, middle


def _create_limb(port: Port, limb_view: LimbView, side: int, view: FrontView) -> Limb:
    """Create a limb that leaves the spine to a side (1 or -1)."""
    chain = [port.children[0]]
    while len(chain[-1].children) == 1:
        chain += chain[-1].children
    return Limb(port, side, limb_view.start[2] / view.size, limb_view.depth, chain)


def _find_next_port(node: Node, middle: list[MiddlePort], view: FrontView) -> MiddlePort | None:
    """Find the limb in the middle with which the spine goes on: of those up, the largest."""
    height = view.limbs[node.name].frame[2] - MIDDLE * view.size
    upwards = [port for port in middle if max(port.view.frame[2], port.view.centre[2]) >= height]
    return max(upwards, key=lambda port: port.view.body_count, default=None)


def _find_legs(limbs: list[Limb], view: FrontView) -> list[Limb]:
    """Find the limbs that lead down; of arms and legs at the same body, the lower ones."""
    downwards = [limb for limb in limbs if _compute_slope(limb, view) < MAX_LEG_SLOPE]
    heights = [limb.height for limb in downwards]
    if downwards and max(heights) - min(heights) > LEG_HEIGHTS:
        middle = (min(heights) + max(heights)) / 2
        downwards = [limb for limb in downwards if limb.height < middle]
    return downwards


def _compute_slope(limb: Limb, view: FrontView) -> float:
    """Compute how steeply a limb rises, seen from the front."""
    limb_view = view.limbs[limb.node.name]
    run = abs(limb_view.centre[0] - limb_view.start[0])
    rise = limb_view.centre[2] - limb_view.start[2]
    return rise / max(run, 1e-9 * view.size)


def _group_in_rows(limbs: list[Limb], view: FrontView) -> list[list[Limb]]:
    """Group limbs in rows: partners, or two limbs at different sides that follow each other."""
    rows: list[list[Limb]] = []
    remaining = {limb.node.name: limb for limb in limbs}
    while remaining:
        limb = remaining.pop(next(iter(remaining)))
        partner_node = view.limbs[limb.node.name].partner
        partner = remaining.pop(partner_node.name, None) if partner_node is not None else None
        last_row = rows[-1] if rows else []
        if partner is not None:
            partner.side = -limb.side  # also if both are a little to the same side
            rows.append([limb, partner])
        elif len(last_row) == 1 and last_row[0].side != limb.side:
            last_row.append(limb)
        else:
            rows.append([limb])
    return rows


# --- limbs ---


def _prepare_limbs(spine: list[Vertebra], limbs: list[Limb], view: FrontView) -> None:
    """Sort the bodies of limbs outwards, link twins, and compute how high their lanes are."""
    for limb in limbs:
        _sort_outwards(limb, view)
    for child in (child for vertebra in spine for child in vertebra.node.children):
        partner = view.limbs[child.name].partner
        if partner is not None and child.twin is not partner:
            _link_twins(child, partner)
    for limb in limbs:
        boxes = [compute_min_box(node, None, vertical=False) for node in limb.chain]
        limb.lane_below = max(box.margin for box in boxes)
        limb.lane_above = max(box.margin + 2 * box.offset for box in boxes)


def _sort_outwards(limb: Limb, view: FrontView) -> None:
    """Sort the children of each body of a limb from the middle of the robot outwards."""
    stack = [limb.node]
    while stack:
        node = stack.pop()
        node.sort_ports(lambda child: limb.side * view.compute_offset(child))
        stack.extend(node.children)


def _link_twins(limb: Node, partner: Node) -> None:
    """Link the bodies of two limbs that are mirror images, as long as both have the same form."""
    stack = [(limb, partner)]
    while stack:
        node, twin = stack.pop()
        if node.body is None or twin.body is None or len(node.children) != len(twin.children):
            continue
        node.twin, twin.twin = twin, node
        stack.extend(zip(node.children, twin.children, strict=True))
