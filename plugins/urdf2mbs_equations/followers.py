"""Followers: joints whose positions are linear in those of others, such as those of ``<mimic>``.

With q of all joints, T has the rows of the unit matrix for joints that lead, and the factors of
their leaders for followers.  The columns of followers are zero::

    q = T q + offset        q' = T q'        q'' = T q''

Forces do the same work along followers as along their leaders, so that the equations of the joints
that lead are T' M T, T' c, J T and T' D T; their rows and columns of followers are zero.
"""

from __future__ import annotations

from typing import NamedTuple

from urdf2mbs.plugin import Conversion, Mbs


class Follower(NamedTuple):
    """A joint whose position is ``offset``, and the sum of ``factor`` times that of a leader."""

    joint: int
    """Its number; those of its leaders are the keys of ``factors``."""
    factors: dict[int, float]
    offset: float
    """rad or m."""


def list_followers(conversion: Conversion, mbs: Mbs) -> list[Follower]:
    """Return the joints that ``<mimic>`` makes dependent, as it does in a project.

    Args:
        conversion: A finished one.
        mbs: Its model, which numbers the joints.
    """
    numbers = mbs.numbers()
    return sorted(
        Follower(
            numbers[coupling["follower"].name],
            {numbers[coupling["leader"].name]: coupling["multiplier"]},
            coupling["offset"],
        )
        for coupling in conversion.report.get("mimic", ())
        if coupling["follower"].nature == "dependent"
    )
