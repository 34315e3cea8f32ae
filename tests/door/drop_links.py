"""Take links away, with all that is attached to them: a sensor that is not mounted."""

from urdf2mbs.plugin import Conversion, ConversionError, Pass, choose, hookimpl


class DropLinks(Pass):
    """Take links away, with all that is attached to them."""

    writes = ("robot",)

    links: list[str]
    """Patterns: '*_camera'."""

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        gone = set(choose(self.links, robot.links, "drop-links", "drop-links: no link"))
        if robot.root() in gone:
            raise ConversionError("drop-root", f"'{robot.root()}' is the root: nothing is left")
        for joint in robot.depth_first():  # parents first
            if joint.parent in gone:
                gone.add(joint.child)
        robot.links = {name: link for name, link in robot.links.items() if name not in gone}
        robot.joints = {
            name: joint for name, joint in robot.joints.items() if joint.child not in gone
        }
        conversion.warn("dropped", f"{len(gone)} links are left out: {', '.join(sorted(gone))}")


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [DropLinks]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    return {"dropped": "warning: links are left out. Leave 'drop-links' out to keep them."}
