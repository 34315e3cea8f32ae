"""Assign names: everything gets the name and the place in the file that Robotran will know it by.

Bodies stand depth first, as MBSysPad numbers them when it saves: so the number of a joint never
changes.  Names become identifiers, since the code that Robotran generates uses them.  The model
takes the file's name.  The pass also records the place of each link's frame.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import LinkFrame
from urdf2mbs.mbs.names import assign_identifiers, identifiers


class AssignNames(Pass):
    reads = ("bodies", "joints", "anchors", "forces")
    writes = ("names",)

    def run(self, conversion: Conversion) -> None:
        mbs, names = conversion.mbs, conversion.names
        mbs.name = _name(conversion)
        mbs.base.name = conversion.ground.link
        mbs.bodies = mbs.depth_first()
        names.bodies, _ = assign_identifiers(mbs)
        for segment in conversion.segments.values():
            for step in segment.steps:
                name = step.joint.name
                names.joints[name] = [joint.name for joint in step.joints]
                if step.coordinates:
                    names.coordinates[name] = [joint.name for joint in step.coordinates]
        conversion.frames = _frames(conversion)


def _name(conversion: Conversion) -> str:
    """The file's own name: Robotran names the equations after it."""
    stem = conversion.settings.output.stem
    (name,) = identifiers([stem])
    if name != stem:
        conversion.note(
            "mbs-name",
            f"the model is called '{name}' in the .mbs, and so are its equations: the file's "
            f"name '{stem}' cannot be one in a program",
        )
    return name


def _frames(conversion: Conversion) -> dict[str, LinkFrame]:
    frames: dict[str, LinkFrame] = {}
    for segment in conversion.segments.values():
        body = None if segment.parent is None else segment.body.name
        for link, pose in segment.parts.items():
            frames[link] = LinkFrame(body, None, pose)
        for step in segment.steps[:-1]:
            for link, pose in step.frames.items():
                frames[link] = LinkFrame(body, step.joints[-1].name, pose)
    return frames
