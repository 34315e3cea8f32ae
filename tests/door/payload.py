"""Fix a payload to a link: a box of even density."""

from typing import Annotated

from msgspec import Meta

from urdf2mbs.plugin import ConfigError, Conversion, Pass, PositiveLength, free_name, hookimpl, urdf


class Payload(Pass):
    """Fix a payload to a link: a box of even density."""

    writes = ("robot",)

    link: str
    mass: Annotated[float, Meta(gt=0.0, le=1e6)]
    """kg"""
    size: tuple[PositiveLength, PositiveLength, PositiveLength] = (0.1, 0.1, 0.1)
    """Full lengths along the axes of the link (m)."""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The centre in the frame of the link (m)."""

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        if self.link not in robot.links:
            raise ConfigError("payload-link", f"payload: there is no link '{self.link}'")
        x, y, z = (self.mass * length**2 / 12 for length in self.size)
        inertial = urdf.Inertial(self.mass, (y + z, 0.0, 0.0, x + z, 0.0, x + y))
        visual = urdf.Visual(urdf.Box(self.size))
        name, mount = free_name("payload", robot.links), free_name("payload_mount", robot.joints)
        robot.links[name] = urdf.Link(name, inertial, [visual])
        origin = urdf.Origin(self.at)
        robot.joints[mount] = urdf.Joint(mount, "fixed", self.link, name, origin)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [Payload]
