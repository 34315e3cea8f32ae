"""How much each thing that is said weighs: the user's choice, as in a linter.

An error stops the conversion, a warning is shown, a note is shown on demand, and what is ignored
is not said at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import msgspec

from urdf2mbs.diagnostics import ConversionError, Diagnostic

Level = Literal["error", "warning", "note", "ignore"]

#: All whose level can be changed, and the level that they have; what is not here is an error
#: that leaves nothing to convert.  (docs/diagnostics.md says what each means.)
DEFAULTS: dict[str, Level] = {
    # what the file leaves open, and what happens if it is no error: it is left out
    "xacro-macro-unknown": "error",
    "xacro-legacy": "error",
    # the robot's file
    "unknown-element": "warning",
    "unknown-attribute": "warning",
    "doubled-element": "warning",
    "robot-unnamed": "warning",
    "name-blank": "warning",
    "inertial-incomplete": "warning",
    "inertia-incomplete": "warning",
    "inertia-indefinite": "warning",
    "inertia-triangle": "warning",
    "inertia-without-mass": "warning",
    "mass-negative": "warning",
    "mass-without-inertia": "note",
    "number-left-out": "warning",
    "mesh-scale": "warning",
    "geometry-unknown": "warning",
    "geometry-size": "warning",
    "material-undefined": "warning",
    "material-unnamed": "warning",
    "color-range": "warning",
    "joint-type-spelling": "warning",
    "joint-limit-missing": "warning",
    "limit-order": "warning",
    "mimic-left-out": "warning",
    "link-unattached": "warning",
    "world-implied": "warning",
    "xml-namespace": "warning",
    "xml-mended": "warning",
    "property-unused": "warning",
    "package-unresolved": "warning",
    "xacro-warning": "warning",
    "xacro-message": "note",
    "xacro-unused-arg": "warning",
    # the conversion
    "no-mass": "warning",
    "inertia-estimated": "warning",
    "inertia-repaired": "warning",
    "base": "note",
    "massless-leaf": "warning",
    "singular": "warning",
    "singular-at-start": "warning",
    "generator-limits": "note",
    "layout-kept": "note",
    "layout-not-kept": "warning",
    # what a project needs to run
    "mimic-leader": "warning",
    "mimic-driven": "warning",
    "posture-limit": "warning",
    "posture-state": "warning",
    "stand": "note",
    "contacts-mesh": "warning",
    "sensor-left-out": "warning",
    "force-torque": "note",
    "loops": "note",
    "loop-open": "warning",
    "loop-left-out": "warning",
    "project-renamed": "warning",
    "mbs-name": "note",
    "ground-mass": "note",
    "axis-aligned": "note",
    "mimic": "warning",
    "point-without-rotation": "note",
    "texture": "warning",
    "collision": "note",
    "joint-dynamics": "warning",
    "limit": "note",
    "safety-controller": "note",
    "calibration": "note",
    "extension": "note",
    "mesh-not-converted": "note",
    "mesh-missing": "warning",
    "mesh-unreadable": "warning",
    "mesh-part": "warning",
    "mesh-file-missing": "warning",
    "mesh-not-ours": "warning",
    "mesh-up-axis": "warning",
    "plugin-idle": "warning",
}


class Levels(msgspec.Struct, frozen=True):
    """The levels that the user has set."""

    by_code: Mapping[str, Level] = {}
    strict: bool = False
    """Warnings are errors, except those whose level is set."""

    def applied(self, said: list[Diagnostic]) -> list[Diagnostic]:
        """The same diagnostics at the user's levels, without those that are ignored."""
        out = []
        for one in said:
            level: Any = self.by_code.get(one.code)
            if level is None:
                level = "error" if self.strict and one.level == "warning" else one.level
            if level == one.level:
                out.append(one)
            elif level != "ignore":
                # a hint never recommends what is already set
                hint = None if one.hint and "--level" in one.hint else one.hint
                out.append(msgspec.structs.replace(one, level=level, hint=hint))
        return out

    def judge(self, said: list[Diagnostic]) -> None:
        """Raise ConversionError if there is an error among diagnostics at the user's levels."""
        errors = [one for one in said if one.level == "error"]
        if errors:
            *before, last = errors
            error = ConversionError(
                last.code, last.message, file=last.file, line=last.line, hint=last.hint
            )
            error.said = before
            raise error
