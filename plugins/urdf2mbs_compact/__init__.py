"""The same robot with the fewest joints: a body for what moves as one, framed along its joint."""

from typing import Any

from urdf2mbs.plugin import PassEntry, always, hookimpl

PASSES = ("lump-fixed", "merge-massless", "align-frames")


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    before = ("prune-massless", "force-torque")
    return [
        PassEntry(name, "urdf2mbs_compact", (*before, *PASSES[:n]), always, presets=("compact",))
        for n, name in enumerate(PASSES)
    ]


@hookimpl
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    return {"compact": {"extends": "faithful"}}
