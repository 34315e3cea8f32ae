"""Expand: from the source file to the robot that the method starts from.

The method reads "the URDF description of a robot"; in practice that is often xacro, which is
expanded here without any ROS installed: ``$(find)``, ``$(arg)``, includes, ``load_yaml``.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.urdf.reader import read_robot_file, read_text


class Expand(Pass):
    writes = ("robot",)

    def run(self, conversion: Conversion) -> None:
        settings, given = conversion.settings, conversion.input
        args = settings.config.xacro_args
        if not given.data:
            trust = settings.config.trust_xacro
            given.data = read_robot_file(settings.source)
            given.expansion = conversion.hook.urdf2mbs_read(
                source=settings.source, data=given.data, packages=conversion.packages,
                args=args, trust=trust,
            )  # fmt: skip
            if b"<xacro:" in given.data and not conversion.hook.urdf2mbs_read.get_hookimpls():
                what = f"'{settings.source}' is xacro, for which the plugin 'xacro' is missing"
                raise ConfigError("plugin-missing", what, hint="install urdf2mbs whole")
        conversion.robot, diagnostics = read_text(
            settings.source, given.data, given.expansion, args, conversion.hook.urdf2mbs_extension,
        )  # fmt: skip
        conversion.diagnostics += diagnostics
