"""The passes of the method, in its order, and the presets that they make."""

from __future__ import annotations

from typing import Any

from urdf2mbs.hookspecs import PassEntry, always, hookimpl

#: Passes of plugins say themselves where among these they stand.
_NAMES = (
    "expand",
    "insert-base",
    "prune-massless",
    "lump-fixed",
    "merge-massless",
    "align-frames",
    "reframe-inertia",
    "decompose-joints",
    "collect-anchors",
    "joint-parameters",  # limits, damping, friction, as user models
    "convert-visuals",
    "assign-names",
    "layout",
    "fit-view",
    "left-out",
    "emit",
    "check",
)
#: The passes of ``compact`` that ``faithful`` does without.
_COMPACT = ("lump-fixed", "merge-massless", "align-frames")


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    return [PassEntry(name, "urdf2mbs", (), always) for name in _NAMES]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    return {
        # The method's conversion, frame for frame: every URDF link frame is a body frame or a
        # point.
        "faithful": {"pipeline": [name for name in _NAMES if name not in _COMPACT]},
        # The same robot with the fewest joints: a body for what moves as one, its frame along its
        # joint.
        "compact": {"pipeline": list(_NAMES)},
    }
