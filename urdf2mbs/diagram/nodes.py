"""The bodies of a model as a tree of nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.diagram.sizes import measure_name
from urdf2mbs.mbs.model import Body, Joint, Mbs, Point

if TYPE_CHECKING:
    from urdf2mbs.diagram.box_layout import Layout


class Port(msgspec.Struct, eq=False):
    """A point of a body to which children are attached."""

    point: Point | None
    """None: the body's own frame."""
    children: list[Node] = []


class Node(msgspec.Struct, eq=False):
    """A body of the diagram, or the base."""

    body: Body | None
    """None: the base."""
    name: str = ""
    name_width: float = 0.0
    """px."""
    joints: list[Joint] = []
    """The chain of joints from the parent."""
    ports: list[Port] = []
    children: list[Node] = []
    """The children of all ports."""
    free_points: list[Point] = []
    """Points without children; they are drawn inside the box."""
    twin: Node | None = None
    """Its mirror image in the robot; both are drawn alike."""
    layouts: dict[bool, Layout] = {}
    """Its layout with all its descendants, if its limb grows vertically (True) or horizontally."""

    @property
    def half_name_width(self) -> float:
        """Half of the width (px) of its name, or of its twin's, if that is longer."""
        return max(self.name_width, (self.twin or self).name_width) / 2

    def sort_ports(self, position: Callable[[Node], float]) -> None:
        """Sort the ports by the positions of their first children."""
        if len(self.ports) > 1:
            self.ports.sort(key=lambda port: round(position(port.children[0]), 2))
            self.children = [child for port in self.ports for child in port.children]


def build_nodes(mbs: Mbs) -> list[Node]:
    """Build the tree of a model: the base, then the bodies depth first."""
    base = Node(None, name_width=measure_name("Base"))
    nodes = [base]
    node_of_body: dict[str | None, Node] = {None: base}
    points = mbs.points()
    ports: dict[tuple[str | None, str | None], Port] = {}
    for body in mbs.depth_first():
        parent = node_of_body[body.parent]
        node = Node(body, body.name, measure_name(body.name), body.joints)
        node_of_body[body.name] = node
        nodes.append(node)
        point = points.get((body.parent, body.point))
        key = (body.parent, None if point is None else body.point)
        if key not in ports:
            ports[key] = Port(point)
            parent.ports.append(ports[key])
        ports[key].children.append(node)
        parent.children.append(node)
    for node in nodes:
        points_of_ports = {id(port.point) for port in node.ports}
        all_points = mbs.base.points if node.body is None else node.body.points
        node.free_points = [point for point in all_points if id(point) not in points_of_ports]
    return nodes
