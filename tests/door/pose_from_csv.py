"""Start from the pose of a table: lines of joint,position (rad or m)."""

from math import isfinite

from urdf2mbs.plugin import ConfigError, Conversion, Pass, hookimpl, nearest, read_bytes


class PoseFromCsv(Pass):
    """Start from the pose of a table: lines of joint,position (rad or m)."""

    reads = ("joints",)
    writes = ("posture",)
    after = ("decompose-joints",)

    file: str = ""
    """Relative to the config."""

    def run(self, conversion: Conversion) -> None:
        file = conversion.settings.folder / self.file
        free = [(s.joint, j) for s, j in conversion.single_coordinates() if not s.joint.mimic]
        joints = {urdf_joint.name: joint for urdf_joint, joint in free}
        try:
            lines = read_bytes(file).decode().splitlines() if self.file else []
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError("pose-file", f"pose: cannot read '{self.file}': {error}") from None
        for number, line in enumerate(lines, start=1):
            name, _, position = line.partition(",")
            try:
                joints[name].q = float(position)
                fault = "" if isfinite(float(position)) else f"'{position}' is not finite"
            except (KeyError, ValueError):
                fault = f"'{line}' is not a joint that moves freely by one coordinate, and a number"
            if fault:
                hint = nearest(name, joints)
                raise ConfigError("pose-line", fault, file=str(file), line=number, hint=hint)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [PoseFromCsv]
