"""The links and joints together: one root, and every other link the child of one joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.messages.diagnostics import ConversionError, nearest, some
from urdf2mbs.urdf.model import Link

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from urdf2mbs.urdf.model import Joint, Robot
    from urdf2mbs.urdf.values import Reading

HINT_TREE = "a robot in URDF is a tree: a loop cannot be closed in it"


def check_tree(reading: Reading, robot: Robot, line: int | None) -> None:
    """Check that one link is the root, and every other link the child of exactly one joint.

    Args:
        reading: The file being read.
        robot: The robot, whose links may lack ``world`` or be unattached.
        line: The line of ``<robot>``.

    Raises:
        ConversionError: The links and joints are no tree.
    """
    if not robot.links:
        reading.fail("no-links", "the robot has no links", line)
    parent_joints: dict[str, Joint] = {}
    imply_world(reading, robot)
    links = robot.links
    for joint in robot.joints.values():
        try:
            check_ends(reading, joint, links, parent_joints)
        except ConversionError as error:
            reading.keep(error)
    if reading.last is not None:
        raise reading.last
    check_loops(reading, links, parent_joints)
    root_links = [link_name for link_name in links if link_name not in parent_joints]
    if len(root_links) > 1:
        root_links = drop_unattached(reading, robot, root_links)
    if len(root_links) > 1:
        message = f"{len(root_links)} links have no parent: {_quote_names(root_links)}"
        hint = "join them by a joint, or take away what does not belong to the robot"
        reading.fail("several-roots", message, links[root_links[1]].line, hint)


def check_ends(
    reading: Reading, joint: Joint, links: Mapping[str, Link], parent_joints: dict[str, Joint]
) -> None:
    """Check that a joint's links exist, and that its child has no other parent.

    Args:
        reading: The file being read.
        joint: The joint.
        links: All links, by name.
        parent_joints: The joints that were checked before, by their children; this one is added.

    Raises:
        ConversionError: ``link-unknown`` or ``two-parents``.
    """
    for end_tag, link_name in (("parent", joint.parent), ("child", joint.child)):
        if link_name not in links:
            message = f"joint '{joint.name}': there is no link called '{link_name}' ({end_tag})"
            reading.fail("link-unknown", message, joint.line, nearest(link_name, links))
    first_joint = parent_joints.setdefault(joint.child, joint)
    if first_joint is not joint:
        message = (
            f"link '{joint.child}' has two parents: '{first_joint.parent}' by the joint"
            f" '{first_joint.name}' (line {first_joint.line}), and '{joint.parent}' by the joint"
            f" '{joint.name}'"
        )
        reading.fail("two-parents", message, joint.line, HINT_TREE)


def imply_world(reading: Reading, robot: Robot) -> None:
    """Add a link ``world`` that joints name as their parent and that is not declared."""
    for joint in robot.joints.values():
        if joint.parent == "world" and "world" not in robot.links:
            robot.links = {"world": Link("world"), **robot.links}
            message = "there is no link called 'world': it is implied"
            reading.warn("world-implied", message, joint.line, owner=("joint", joint.name))


def drop_unattached(reading: Reading, robot: Robot, root_links: list[str]) -> list[str]:
    """Remove roots without joints, mass and shapes, unless all are; return those that stay."""
    parent_links = {joint.parent for joint in robot.joints.values()}
    unattached_links = []
    for link in robot.links.values():
        is_empty = link.massless and not link.visuals and not link.collisions
        if link.name in root_links and link.name not in parent_links and is_empty:
            unattached_links.append(link)
    for link in unattached_links if len(unattached_links) < len(root_links) else []:
        del robot.links[link.name]
        message = "no joint leads to it, and nothing is in it: left out"
        reading.warn("link-unattached", message, link.line, owner=("link", link.name))
    return [link_name for link_name in root_links if link_name in robot.links]


def check_loops(
    reading: Reading, links: Mapping[str, Link], parent_joints: Mapping[str, Joint]
) -> None:
    """Raise ConversionError for links that are their own ancestors."""
    parents_by_link = {
        link_name: parent_joints[link_name].parent
        for link_name in links
        if link_name in parent_joints
    }
    for loop_links in find_loops(parents_by_link):
        loop_joints = [parent_joints[link_name] for link_name in reversed(loop_links)]
        link_names = _quote_names(joint.parent for joint in loop_joints)
        joint_names = _quote_names(joint.name for joint in loop_joints)
        message = f"the links {link_names} form a loop (joints {joint_names})"
        reading.fail("loop", message, loop_joints[0].line, HINT_TREE)


def _quote_names(names: Iterable[str]) -> str:
    return some(f"'{name}'" for name in names)


def find_loops(following: Mapping[str, str]) -> Iterator[list[str]]:
    """Yield the loops in which names lead to one another.

    Args:
        following: The name that each name leads to.
    """
    first_visits: dict[str, str] = {}
    for start_name in following:
        current_name = start_name
        while current_name in following and current_name not in first_visits:
            first_visits[current_name] = start_name
            current_name = following[current_name]
        if first_visits.get(current_name) == start_name:
            loop_names = [current_name]
            while following[loop_names[-1]] != current_name:
                loop_names.append(following[loop_names[-1]])
            yield loop_names
