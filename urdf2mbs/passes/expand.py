"""Expand: from the source file to the robot that the method starts from.

The method reads "the URDF description of a robot"; in practice that is often xacro, which is
expanded here without any ROS installed: ``$(find)``, ``$(arg)``, includes, ``load_yaml``.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.urdf.reader import expanded, read_text


class Expand(Pass):
    writes = ("robot",)

    def run(self, conversion: Conversion) -> None:
        settings = conversion.settings
        args = settings.config.xacro_args
        if not conversion.source:
            trust = settings.config.trust_xacro
            conversion.source, conversion.expansion = expanded(
                settings.source, conversion.packages, args, trust_xacro=trust
            )
        conversion.robot, diagnostics = read_text(
            settings.source, conversion.source, conversion.expansion, args
        )
        conversion.diagnostics += diagnostics
