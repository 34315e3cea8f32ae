"""Expand: from the source file to the robot that the method starts from.

The method reads "the URDF description of a robot"; in practice that is often xacro, which is
expanded here without any ROS installed: ``$(find)``, ``$(arg)``, includes, ``load_yaml``.
"""

from __future__ import annotations

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.urdf.limits import Isolate
from urdf2mbs.urdf.reader import expanded, read_text


class Options(msgspec.Struct, forbid_unknown_fields=True):
    isolate: Isolate | None = None
    """Run xacro in a process of its own, with limits: ``{seconds: 60, memory: 2GiB}``."""


def run(conversion: Conversion, options: Options) -> None:
    settings = conversion.settings
    data, expansion = expanded(
        settings.source, conversion.packages, settings.xacro_args,
        isolate=options.isolate, cache=settings.cache,
    )  # fmt: skip
    if expansion is not None:
        conversion.expanded = expansion.text
    conversion.robot, diagnostics = read_text(settings.source, data, expansion, settings.xacro_args)
    conversion.diagnostics += diagnostics


PASS = Pass("expand", run, Options, gives=("robot",))
