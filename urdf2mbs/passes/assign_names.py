"""Assign names: give each element the name and the place in the file that Robotran has for it.

Bodies come depth first, as MBSysPad numbers them when it saves: so the number of a joint never
changes.  Names become identifiers, since the code that Robotran generates uses them.  The model
takes the file's name.  The pass also records the pose of each link's frame.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import LinkFrame
from urdf2mbs.mbs.names import assign_identifiers, identifiers


class AssignNames(Pass):
    """Give each element its final name and its place in the file."""

    reads = ("bodies", "joints", "anchors", "forces")
    writes = ("names",)

    def run(self, conversion: Conversion) -> None:
        """Order the bodies, rename all elements, and record what became of links and joints."""
        mbs, names = conversion.mbs, conversion.names
        mbs.name = _choose_model_name(conversion)
        mbs.base.name = conversion.ground.link
        mbs.bodies = mbs.depth_first()
        names.bodies, _ = assign_identifiers(mbs)
        for step in conversion.steps():
            urdf_name = step.joint.name
            names.joints[urdf_name] = [joint.name for joint in step.joints]
            if step.coordinates:
                names.coordinates[urdf_name] = [joint.name for joint in step.coordinates]
        conversion.frames = _locate_link_frames(conversion)


def _choose_model_name(conversion: Conversion) -> str:
    """Return the file's name as an identifier: Robotran names the equations after the model."""
    stem = conversion.settings.output.stem
    (name,) = identifiers([stem])
    if name != stem:
        conversion.note(
            "mbs-name",
            f"the model and its equations are called '{name}' in the .mbs: the file's name "
            f"'{stem}' is not an identifier",
        )
    return name


def _locate_link_frames(conversion: Conversion) -> dict[str, LinkFrame]:
    """Return where each link's frame is: constant in a body, or in the frame after a joint."""
    frames: dict[str, LinkFrame] = {}
    for segment in conversion.segments.values():
        body = None if segment.parent is None else segment.body.name
        for link, pose in segment.parts.items():
            frames[link] = LinkFrame(body, None, pose)
        for step in segment.steps[:-1]:
            for link, pose in step.frames.items():
                frames[link] = LinkFrame(body, step.joints[-1].name, pose)
    return frames
