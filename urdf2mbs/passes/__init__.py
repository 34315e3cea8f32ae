"""The passes of the method, in its order, and the preset that they make."""

from __future__ import annotations

from typing import Any

from urdf2mbs.hookspecs import PassEntry, always, hookimpl

#: Passes of plugins say themselves where among these they stand.
_NAMES = (
    "expand",
    "insert-base",
    "prune-massless",
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


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    return [PassEntry(name, "urdf2mbs", (), always) for name in _NAMES]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    # The method's conversion, frame for frame: every URDF link frame is a body frame or a point.
    return {"faithful": {"pipeline": list(_NAMES)}}
