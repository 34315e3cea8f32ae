"""Converts a robot from Python."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from urdf2mbs.config.load import config_of
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion, Names
from urdf2mbs.engine.output import write
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.model import LinkFrame, Mbs
from urdf2mbs.messages.diagnostics import Diagnostic
from urdf2mbs.summary import Report, report
from urdf2mbs.urdf.model import Robot


class Result:
    """The result of a conversion: the model, the file's bytes, and the report."""

    def __init__(self, conversion: Conversion) -> None:
        self.conversion = conversion

    def write(self, *, force: bool = False) -> Path:
        """Write the file, or the project.

        Args:
            force: Whether to replace files that were edited, or that urdf2mbs has not written.

        Returns:
            The path of the .mbs; ``NAME.rejected.mbs`` if it is not the same robot.

        Raises:
            ConfigError: A file cannot be written, or is not ours to replace.
        """
        write(self.conversion, force=force)
        return self.conversion.written

    def _repr_html_(self) -> str | None:
        """Return how a notebook shows the conversion; None without a plugin that can show it."""
        html: str | None = self.conversion.hook.urdf2mbs_show(conversion=self.conversion)
        return html

    @property
    def mbs(self) -> Mbs:
        """The model."""
        return self.conversion.mbs

    @property
    def data(self) -> bytes:
        """The bytes of the .mbs file."""
        conversion = self.conversion
        return conversion.files[conversion.written]

    @property
    def robot(self) -> Robot:
        """The URDF's robot, with the base that was inserted."""
        return self.conversion.robot

    @property
    def names(self) -> Names:
        """The map from URDF to .mbs names."""
        return self.conversion.names

    @property
    def frames(self) -> dict[str, LinkFrame]:
        """The place of each URDF link's frame in the .mbs."""
        return self.conversion.frames

    @property
    def frozen(self) -> dict[str, str]:
        """The URDF joints that are locked at zero, and why; they are not in the .mbs."""
        return self.conversion.frozen

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """The warnings and notes."""
        return self.conversion.diagnostics

    @property
    def report(self) -> Report:
        """The report, which ``--json`` prints."""
        return report(self.conversion)


def convert(source: Config | str | os.PathLike[str], **fields: Any) -> Result:
    """Convert a URDF or xacro file; nothing is written until ``Result.write()``.

    Args:
        source: The robot's file, a config file, or a ``Config``.
        fields: Fields of ``Config``, the keys of a config file, such as ``pipeline="compact"``,
            ``output={"project": "robot"}``, ``passes={"contacts": {"links": ["foot"]}}``.  Paths
            are relative to the working folder.

    Raises:
        ConversionError: The robot cannot be converted, or a field is wrong.
    """
    return Result(Pipeline(*config_of(source, **fields)).run())
