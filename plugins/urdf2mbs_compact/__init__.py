"""The same robot with the fewest joints: one body for each rigid group, aligned with its joint."""

from typing import Any

from urdf2mbs.plugin import PassEntry, always, hookimpl

PASSES = ("lump-fixed", "merge-massless", "align-frames")


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the passes, each placed after those before it."""
    previous = ("prune-massless", "force-torque")
    return [
        PassEntry(
            pass_name,
            "urdf2mbs_compact",
            (*previous, *PASSES[:index]),
            always,
            presets=("compact",),
        )
        for index, pass_name in enumerate(PASSES)
    ]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    """Return the preset ``compact``."""
    return {"compact": {"extends": "faithful"}}
