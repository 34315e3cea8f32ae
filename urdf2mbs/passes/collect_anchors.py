"""Collect anchors: the method's step 3, "Retrieve the coordinates of the anchor points".

"The anchor points of the MBS body are the anchor points specified in the URDF joint
elements whose parent link is the corresponding URDF link."  A point is named after the
link whose origin it is: first the bodies it carries, then the frames of links that are no
bodies of their own.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Point
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.spatial import IDENTITY, ZERO


class CollectAnchors(Pass):
    reads = ("robot", "bodies")
    writes = ("anchors",)

    def run(self, conversion: Conversion) -> None:
        ground = conversion.ground
        for segment in conversion.segments.values():
            if segment.parent is None:
                continue
            parent = conversion.segments[segment.parent]
            at = segment.steps[0].xyz
            if parent is ground:
                segment.body.parent = None
                if at == ZERO:
                    continue  # the base's own origin: no point needed
            else:
                segment.body.parent = parent.body.name
            segment.body.point = segment.link
            parent.holder.points.append(Point(segment.link, at))

        turned: list[str] = []
        for segment in conversion.segments.values():
            for link, pose in segment.parts.items():
                # the link that names the body needs a point only where compact moved its frame
                if link != segment.link or pose.xyz != ZERO:
                    segment.holder.points.append(Point(link, pose.xyz))
                    if pose.rot != IDENTITY:
                        turned.append(link)
        if turned:
            conversion.note(
                "point-without-rotation",
                "an anchor point cannot store a rotation; the report lists the rotation of "
                f"{counted(len(turned), 'frame')}: {', '.join(turned)}",
            )
