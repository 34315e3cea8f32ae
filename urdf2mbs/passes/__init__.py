"""The passes of the method, in its order, and the preset that they make."""

from __future__ import annotations

from typing import Any

from urdf2mbs.hookspecs import PassEntry, always, hookimpl

#: In the order in which they run.  Passes of plugins say between which of these they run.
_PASS_NAMES = (
    "expand",
    "insert-base",
    "prune-massless",
    "reframe-inertia",
    "decompose-joints",
    "collect-anchors",
    "joint-parameters",
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
    """Return the passes of the method."""
    return [PassEntry(name, "urdf2mbs", (), always) for name in _PASS_NAMES]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    """Return the preset ``faithful``, the method's conversion frame for frame.

    The frame of every URDF link is that of a body, or an anchor point.
    """
    return {"faithful": {"pipeline": list(_PASS_NAMES)}}
