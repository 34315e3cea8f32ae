"""Merge the orders of an entity's children: of its joints, points, shapes, ...

Children that both sides have keep the order that a side gave them.  A child that only one side has
is placed after the child that it follows there::

    edited      a  x  b  c              x only in edited
    converted   a  c  y  b              y only in converted, which also moved c before b
    merged      a  x  c  y  b
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Literal, NamedTuple


class Orders(NamedTuple):
    """The children of an entity in each version, as far as they are in the merged model."""

    base: list[int]
    edited: list[int]
    converted: list[int]


def merge_orders(
    orders: Orders,
    find_winner: Callable[[], Literal["urdf", "edited"]],
    sort_key: Callable[[list[int]], Any] | None,
) -> list[int]:
    """Merge the orders of children.

    Args:
        orders: The order of each version.
        find_winner: Returns whose order is used where the two contradict each other.
        sort_key: Sorts two runs of children that each side added at the same place.  None: their
            order matters, and the winner's run comes first.
    """
    common = _merge_common(orders, find_winner)
    added_by_edited = _group_by_predecessor(orders.edited, set(common))
    added_by_converted = _group_by_predecessor(orders.converted, set(common))
    merged: list[int] = []
    for predecessor in [None, *common]:
        if predecessor is not None:
            merged.append(predecessor)
        runs = [
            added[predecessor]
            for added in (added_by_edited, added_by_converted)
            if predecessor in added
        ]
        if len(runs) == 2 and sort_key is not None:
            runs.sort(key=sort_key)
        elif len(runs) == 2 and find_winner() == "urdf":
            runs.reverse()
        merged += [child for run in runs for child in run]
    return merged


def _merge_common(
    orders: Orders, find_winner: Callable[[], Literal["urdf", "edited"]]
) -> list[int]:
    """Merge the order of the children that both sides have.

    If both sides moved some, each two children are in the order of the side that changed it.
    """
    both = set(orders.edited) & set(orders.converted)
    base, edited, converted = ([child for child in order if child in both] for order in orders)
    if converted in (edited, base):
        return edited
    if edited == base:
        return converted
    ranks = [
        {child: rank for rank, child in enumerate(order)} for order in (base, edited, converted)
    ]

    def is_before(first: int, second: int) -> bool:
        in_base, in_edited, in_converted = (
            rank[first] < rank[second] if first in rank and second in rank else None
            for rank in ranks
        )
        return bool(in_converted if in_edited == in_base else in_edited)

    # The order of pairs is consistent if each child has another number of predecessors.
    predecessor_counts = {
        child: sum(is_before(second, child) for second in both - {child}) for child in both
    }
    if len(set(predecessor_counts.values())) == len(both) and both == set(base):
        return sorted(both, key=predecessor_counts.__getitem__)
    return converted if find_winner() == "urdf" else edited


def _group_by_predecessor(order: list[int], common: set[int]) -> dict[int | None, list[int]]:
    """Group the children that are not common by the common child that they follow."""
    groups: dict[int | None, list[int]] = {}
    predecessor = None
    for child in order:
        if child in common:
            predecessor = child
        else:
            groups.setdefault(predecessor, []).append(child)
    return groups


def sort_parents_first(bodies: list[int], parents: dict[int, Hashable]) -> list[int]:
    """Sort bodies as a file requires it: each after its parent.

    Args:
        bodies: The bodies in the order that they keep otherwise.
        parents: The parent of each body.  The bodies of a cycle are sorted somehow.
    """
    sorted_bodies: dict[Any, None] = {}
    for body in bodies:
        chain: dict[Any, None] = {}  # from the body towards the base
        link: Hashable = body
        while link in parents and link not in sorted_bodies and link not in chain:
            chain[link] = None
            link = parents[link]
        sorted_bodies |= dict.fromkeys(reversed(chain))
    return list(sorted_bodies)
