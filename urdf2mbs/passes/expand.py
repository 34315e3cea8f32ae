"""Expand: read the robot from its source file.

The method reads "the URDF description of a robot"; in practice that is often xacro, which is
expanded here without any ROS installed: ``$(find)``, ``$(arg)``, includes, ``load_yaml``.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.urdf.reader import read_robot_file, read_text


class Expand(Pass):
    """Read the robot, which xacro expands if it has to."""

    writes = ("robot",)

    def run(self, conversion: Conversion) -> None:
        """Read the source, unless the caller has given its data, and parse it."""
        settings = conversion.settings
        if not conversion.input.data:
            _read_source(conversion)
        conversion.robot, diagnostics = read_text(
            settings.source,
            conversion.input.data,
            conversion.input.expansion,
            settings.xacro_args,
            conversion.hook.urdf2mbs_extension,
        )
        conversion.diagnostics += diagnostics
        if conversion.input.expansion is not None:
            conversion.states |= conversion.input.expansion.states


def _read_source(conversion: Conversion) -> None:
    """Read the source file, and let a plugin expand it."""
    settings = conversion.settings
    conversion.input.data = read_robot_file(settings.source)
    conversion.input.expansion = conversion.hook.urdf2mbs_read(
        source=settings.source,
        data=conversion.input.data,
        packages=conversion.packages,
        args=settings.xacro_args,
        trust=settings.config.trust_xacro,
    )
    readers = {reader.plugin_name for reader in conversion.hook.urdf2mbs_read.get_hookimpls()}
    if b"<xacro:" in conversion.input.data and "xacro" not in readers:
        message = f"'{settings.source}' is xacro, for which the plugin 'xacro' is missing"
        raise ConfigError("plugin-missing", message, hint="install urdf2mbs whole")
