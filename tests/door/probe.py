"""Measure the motion at a place on a link: a sensor that neither URDF nor config can state."""

from urdf2mbs.plugin import ConfigError, Conversion, MbsSensor, Pass, hookimpl
from urdf2mbs_project import simulation


class Probe(Pass):
    """Measure the motion at a place on a link."""

    reads = ("robot", "bodies")
    writes = ("anchors",)
    after = ("sensors",)

    link: str
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """In the frame of the link (m)."""

    def run(self, conversion: Conversion) -> None:
        body, point = conversion.add_point("probe_at", self.link, self.at, "probe-link", "probe:")
        if body is None:
            raise ConfigError("probe-link", f"probe: link '{self.link}' does not move")
        point.sensor = MbsSensor("probe", (*simulation.MEASURES, "Jac"))
        axes = conversion.parts()[self.link][1].rot  # of the link, in its body
        sensor = simulation.PointSensor("probe", "accelerometer", self.link, point, axes)
        conversion.state(simulation.Simulation).sensors.append(sensor)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [Probe]
