"""How much each thing that is said weighs: the user's choice, as in a linter.

An error stops the conversion, a warning is shown, a note is shown on demand, and what is ignored
is not said at all.
"""

from __future__ import annotations

from typing import Any

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic

_CODES = """
actuator-unknown axis-aligned base base-guessed calibration collision color-range contacts-balance
contacts-mesh contacts-most doubled-element equations-language equations-stale
extension force-torque
generator-limits geometry-size geometry-unknown ground-mass inertia-estimated inertia-incomplete
inertia-indefinite inertia-repaired inertia-triangle inertia-without-mass inertial-incomplete
joint-ball joint-dynamics joint-dynamics-lost joint-limit-missing joint-renamed
joint-type-spelling law-unknown limit limit-order link-unattached loop-left-out loop-never-closes
loop-open loop-renamed loop-row-of-zeros loops mass-negative mass-without-inertia massless-leaf
material-undefined material-unnamed mbs-name mechanics-unread merge-conflict-won merge-orphaned
mesh-file-missing mesh-missing mesh-moved mesh-not-converted mesh-not-ours mesh-part mesh-scale
mesh-too-large mesh-unreadable mesh-up-axis mimic mimic-driven mimic-held mimic-leader
mimic-left-out mimic-massless misspelt name-blank no-mass nothing-estimated number-commas
number-left-out package-unresolved plugin-idle point-without-rotation posture-limit posture-state
project-names-lost project-obsolete project-renamed property-unused robot-unnamed
rotors-left-out safety-controller sensor-left-out sensor-renamed singular singular-at-start
singular-not-tested snapped
stand texture time-step time-step-short time-step-softened unknown-attribute unknown-element
world-implied xacro-left xacro-legacy xacro-macro-unknown xacro-message xacro-unused-arg
xacro-warning xml-mended xml-namespace
"""

#: The codes whose level a user can change.  docs/diagnostics.md says what each means.
CHANGEABLE = frozenset(_CODES.split())


def weigh(diagnostics: list[Diagnostic], config: Config) -> list[Diagnostic]:
    """The same diagnostics at the user's levels, without those that are ignored.

    Strict makes warnings errors, except those whose level is set.
    """
    weighed = []
    for diagnostic in diagnostics:
        strict = config.strict and diagnostic.level == "warning"
        level: Any = config.diagnostics.get(
            diagnostic.code, "error" if strict else diagnostic.level
        )
        if level == diagnostic.level:
            weighed.append(diagnostic)
        elif level != "ignore":
            # a hint never recommends what is already set
            hint = None if "--level" in (diagnostic.hint or "") else diagnostic.hint
            weighed.append(msgspec.structs.replace(diagnostic, level=level, hint=hint))
    return weighed


def judge(diagnostics: list[Diagnostic]) -> None:
    """Raise ConversionError if there is an error among diagnostics at the user's levels."""
    errors = [diagnostic for diagnostic in diagnostics if diagnostic.level == "error"]
    if errors:
        *before, last = errors
        error = ConversionError(
            last.code, last.message, file=last.file, line=last.line, hint=last.hint
        )
        error.said = before
        raise error
