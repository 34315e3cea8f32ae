"""The links and joints together: one root, and every other link the child of one joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.messages.diagnostics import ConversionError, nearest, some
from urdf2mbs.urdf.model import Link

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from urdf2mbs.urdf.model import Joint, Robot
    from urdf2mbs.urdf.values import Reading


def check_tree(reading: Reading, robot: Robot, line: int | None) -> None:
    """One root, and every other link the child of exactly one joint; ``line``: of <robot>."""
    if not robot.links:
        reading.fail("no-links", "the robot has no links", line)
    above: dict[str, Joint] = {}
    imply_world(reading, robot)
    links = robot.links
    for joint in robot.joints.values():
        try:
            check_ends(reading, joint, links, above)
        except ConversionError as error:
            reading.keep(error)
    if reading.last is not None:
        raise reading.last
    check_loops(reading, links, above)
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        roots = drop_unattached(reading, robot, roots)
    if len(roots) > 1:
        reading.fail(
            "several-roots",
            f"{len(roots)} links have no parent: {_list(roots)}",
            links[roots[1]].line,
            "join them by a joint, or take away what does not belong to the robot",
        )


def check_ends(
    reading: Reading, joint: Joint, links: Mapping[str, Link], above: dict[str, Joint]
) -> None:
    """A joint's links exist, and its child has no other parent."""
    for which, name in (("parent", joint.parent), ("child", joint.child)):
        if name not in links:
            what = f"joint '{joint.name}': there is no link called '{name}' ({which})"
            reading.fail("link-unknown", what, joint.line, nearest(name, links))
    other = above.setdefault(joint.child, joint)
    if other is not joint:
        reading.fail(
            "two-parents",
            f"link '{joint.child}' has two parents: '{other.parent}' by the joint"
            f" '{other.name}' (line {other.line}), and '{joint.parent}' by the joint"
            f" '{joint.name}'",
            joint.line,
            "a robot in URDF is a tree: a loop cannot be closed in it",
        )


def imply_world(reading: Reading, robot: Robot) -> None:
    """A link ``world`` that joints name as their parent need not be declared."""
    for joint in robot.joints.values():
        if joint.parent == "world" and "world" not in robot.links:
            robot.links = {"world": Link("world"), **robot.links}
            reading.warn(
                "world-implied", "there is no link called 'world': it is implied",
                joint.line, owner=("joint", joint.name),
            )  # fmt: skip


def drop_unattached(reading: Reading, robot: Robot, roots: list[str]) -> list[str]:
    """Take away links that no joint holds and that hold nothing: no mass, no shape."""
    holding = {joint.parent for joint in robot.joints.values()}
    empty = [
        link
        for name, link in robot.links.items()
        if name in roots and name not in holding
        and link.massless and not link.visuals and not link.collisions
    ]  # fmt: skip
    for link in empty if len(empty) < len(roots) else []:
        del robot.links[link.name]
        reading.warn(
            "link-unattached", "no joint leads to it, and nothing is in it: left out",
            link.line, owner=("link", link.name),
        )  # fmt: skip
    return [name for name in roots if name in robot.links]


def check_loops(reading: Reading, links: Mapping[str, Link], above: Mapping[str, Joint]) -> None:
    """Refuse links that are their own ancestors; ``above``: the joint that carries each link."""
    parents = {name: above[name].parent for name in links if name in above}
    for names in loops(parents):
        joints = [above[name] for name in reversed(names)]
        reading.fail(
            "loop",
            f"the links {_list(joint.parent for joint in joints)} form a loop"
            f" (joints {_list(joint.name for joint in joints)})",
            joints[0].line,
            "a robot in URDF is a tree: a loop cannot be closed in it",
        )


def _list(names: Iterable[str]) -> str:
    return some(f"'{name}'" for name in names)


def loops(following: Mapping[str, str]) -> Iterator[list[str]]:
    """The loops in which names lead to one another; ``following``: where each name leads."""
    seen: dict[str, str] = {}
    for start in following:
        name = start
        while name in following and name not in seen:
            seen[name] = start
            name = following[name]
        if seen.get(name) == start:
            loop = [name]
            while following[loop[-1]] != name:
                loop.append(following[loop[-1]])
            yield loop
