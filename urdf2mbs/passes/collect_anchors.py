"""Collect anchors: the method's step 3, "Retrieve the coordinates of the anchor points".

"The anchor points of the MBS body are the anchor points specified in the URDF joint elements whose
parent link is the corresponding URDF link."  A point has the name of the link whose origin it is.
First come the points where child bodies are attached, then the frames of links that are no bodies
of their own.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Point
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.spatial import IDENTITY, ZERO


class CollectAnchors(Pass):
    """Attach the bodies to each other, by anchor points."""

    reads = ("robot", "bodies")
    writes = ("anchors",)

    def run(self, conversion: Conversion) -> None:
        """Make the anchor points of child bodies, then those of link frames."""
        _attach_bodies(conversion)
        _add_link_frames(conversion)


def _attach_bodies(conversion: Conversion) -> None:
    """Attach each body to an anchor point of its parent, or to the origin of the base."""
    for segment in conversion.segments.values():
        if segment.parent is None:
            continue
        parent = conversion.segments[segment.parent]
        position = segment.steps[0].xyz
        if parent is conversion.ground:
            segment.body.parent = None
            if position == ZERO:
                continue  # the origin of the base needs no point
        else:
            segment.body.parent = parent.body.name
        segment.body.point = segment.link
        parent.holder.points.append(Point(segment.link, position))


def _add_link_frames(conversion: Conversion) -> None:
    """Add a point for the frame of each link that has no body of its own."""
    rotated_links: list[str] = []
    for segment in conversion.segments.values():
        for link, pose in segment.parts.items():
            # The frame of the link that names the body is the body's, unless compact shifts it.
            if link != segment.link or pose.xyz != ZERO:
                segment.holder.points.append(Point(link, pose.xyz))
                if pose.rot != IDENTITY:
                    rotated_links.append(link)
    if rotated_links:
        conversion.note(
            "point-without-rotation",
            "an anchor point cannot store a rotation; the report lists the rotation of "
            f"{counted(len(rotated_links), 'frame')}: {', '.join(rotated_links)}",
        )
