"""A conversion from Python, and what it gives: the model, the file's bytes and the report."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from urdf2mbs.config import Config, Lines, typed
from urdf2mbs.conversion import Conversion, LinkFrame, Names
from urdf2mbs.diagnostics import Diagnostic
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.pipeline import Pipeline
from urdf2mbs.urdf.model import Robot


class Result:
    """What a conversion gives: the model, the file's bytes, and the report."""

    def __init__(self, conversion: Conversion) -> None:
        self.conversion = conversion

    @property
    def mbs(self) -> Mbs:
        return self.conversion.mbs

    @property
    def data(self) -> bytes:
        """The .mbs file."""
        conversion = self.conversion
        return conversion.files[conversion.rejected or conversion.settings.output]

    @property
    def robot(self) -> Robot:
        """The URDF's robot, with the base that was inserted."""
        return self.conversion.robot

    @property
    def names(self) -> Names:
        return self.conversion.names

    @property
    def frames(self) -> dict[str, LinkFrame]:
        """Where each URDF link's frame is in the .mbs."""
        return self.conversion.frames

    @property
    def frozen(self) -> dict[str, str]:
        """Moving URDF joints that are not in the .mbs, and why."""
        return self.conversion.frozen

    @property
    def diagnostics(self) -> list[Diagnostic]:
        return self.conversion.diagnostics

    @property
    def report(self) -> dict[str, Any]:
        return report(self.conversion)


def convert(
    source: str | os.PathLike[str],
    *,
    base: str = "auto",
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    xacro_args: Mapping[str, str] | None = None,
    pipeline: str | list[str] = "faithful",
    options: Mapping[str, Mapping[str, Any]] | None = None,
    plugins: Sequence[str | os.PathLike[str]] = (),
    after: Mapping[str, str | list[str]] | None = None,
    swap: Mapping[str, str] | None = None,
) -> Result:
    """Convert a URDF or xacro file, without writing anything.

    ``base`` is ``auto``, ``floating`` or ``fixed``; ``packages`` maps ROS packages to
    directories; ``options`` maps passes to their options; ``plugins`` are Python files,
    ``after`` maps a pass to those to put right after it, ``swap`` a pass to the plugin whose
    pass of the same name replaces it.  Paths are relative to the working folder.
    Raises ConversionError.
    """
    given = {
        "source": os.fspath(source),
        "base": base,
        "packages": {name: os.fspath(path) for name, path in (packages or {}).items()},
        "xacro_args": dict(xacro_args or {}),
        "pipeline": pipeline,
        "passes": {name: dict(values) for name, values in (options or {}).items()},
        "plugins": [os.fspath(plugin) for plugin in plugins],
        "after": dict(after or {}),
        "swap": dict(swap or {}),
    }
    lines = Lines()
    return Result(Pipeline(typed(Config, given, lines), lines).run())


def report(conversion: Conversion) -> dict[str, Any]:
    """What became of the robot, as plain data for JSON."""
    mbs, robot = conversion.mbs, conversion.robot
    joints = [joint for body in mbs.bodies for joint in body.joints]
    driven = sum(joint.nature == "driven" for joint in joints)
    inserted = 1 if conversion.inserted else 0
    return {
        "robot": robot.name,
        "source": str(conversion.settings.source),
        "output": str(conversion.settings.output),
        "base": "floating" if conversion.floating else "fixed",
        "base_reason": conversion.base_reason,
        "links": len(robot.links) - inserted,
        "bodies": len(mbs.bodies),
        "joints": {
            "urdf": len(robot.joints) - inserted,
            "mbs": len(joints),
            "independent": len(joints) - driven,
            "driven": driven,
            "per_degree_of_freedom": len(joints) / max(len(joints) - driven, 1),
        },
        "mass": sum(body.mass or 0.0 for body in mbs.bodies),
        "gravity": mbs.base.gravity,
        "names": msgspec.to_builtins(conversion.names),
        "numbers": mbs.numbers(),
        "frames": {
            link: {
                "body": frame.body,
                "joint": frame.joint,
                "xyz": frame.pose.xyz,
                "rotation": frame.pose.rot,
            }
            for link, frame in conversion.frames.items()
        },
        "frozen": conversion.frozen,
        "diagnostics": [msgspec.to_builtins(found) for found in conversion.diagnostics],
        **conversion.report,
    }
