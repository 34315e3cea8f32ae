"""Is this file the same robot as that one: what ``urdf2mbs verify`` says of a pair of files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec

from urdf2mbs.config import Config, Lines, typed
from urdf2mbs.conversion import Settings
from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.mbs.reader import read, validate
from urdf2mbs.pipeline import Pipeline
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.xacro import expand
from urdf2mbs.verify import TOLERANCE, Difference, compare, floating_joints, match


class Verdict(msgspec.Struct):
    """What was compared and what differs."""

    robot: str
    base: str
    joints: dict[str, tuple[str, ...]]
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    urdf_mass: float
    mbs_mass: float
    groups: int
    positions: int
    largest: dict[str, float]
    """The largest relative deviation of each kind."""
    differences: list[Difference]
    """Where the two are not the same robot, the largest first."""
    frames: list[Difference]
    """Frames that are elsewhere in the .mbs: by itself a matter of convention."""
    not_compared: dict[str, str]
    schema: list[str]
    """Where the file departs from the format."""

    @property
    def same(self) -> bool:
        return not self.differences


def verify(
    source: str,
    model: Path,
    *,
    packages: Mapping[str, str] | None = None,
    xacro_args: Mapping[str, str] | None = None,
    engine: str = "own",
    tolerance: float = TOLERANCE,
) -> Verdict:
    """Compare a URDF or xacro file with an .mbs, which may have been edited by hand.

    Whether the base floats is read off the .mbs; joints are matched by name.  ``engine`` is
    ``own`` or ``pinocchio``, which compares the equations of motion too.  Raises
    ConversionError.
    """
    try:
        data = model.read_bytes()
    except OSError as error:
        raise ConfigError("file-unreadable", f"cannot read '{model}': {error.strerror}") from None
    mbs = read(data, str(model))
    base = "floating" if floating_joints(mbs) else "fixed"
    given = {
        "source": source,
        "output": f"{source}.mbs",  # never written
        "base": base,
        "packages": dict(packages or {}),
        "xacro_args": dict(xacro_args or {}),
        "pipeline": ["expand", "insert-base"],
    }
    lines = Lines()
    conversion = Pipeline(typed(Config, given, lines), lines, installed_plugins=False).run()
    robot = conversion.robot
    found = match(robot, mbs)
    comparison = compare(
        robot, mbs, found.joints, frames=found.frames, frozen=found.frozen, tolerance=tolerance
    )
    differences, largest = comparison.differences, comparison.largest
    if engine == "pinocchio":
        from urdf2mbs.dynamics import compare_dynamics

        inserted = next(iter(robot.joints)) if conversion.floating else ""
        more, deviations = compare_dynamics(
            _text(conversion.settings),
            mbs,
            found.joints,
            found.frozen,
            floating_base=found.joints.get(inserted, ()),
            tolerance=tolerance,
        )
        differences = sorted(differences + more, key=lambda difference: -difference.size)
        largest = {**largest, **deviations}
    return Verdict(
        robot.name,
        base,
        found.joints,
        comparison.urdf_mass,
        comparison.mbs_mass,
        comparison.groups,
        comparison.positions,
        largest,
        differences,
        comparison.frames,
        found.frozen,
        [str(problem) for problem in validate(data, str(model))],
    )


def _text(settings: Settings) -> bytes:
    if settings.source.suffix.lower() != ".xacro":
        return settings.source.read_bytes()
    return expand(
        settings.source, Packages(settings.packages, settings.source), settings.xacro_args
    ).text
