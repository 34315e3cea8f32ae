"""What plugins of version 1 of the door may still ask a conversion for: it works, and warns."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from urdf2mbs import states
from urdf2mbs.conversion import Conversion, File

#: Each attribute that has gone, and where in the conversion it is now.
MOVED = {
    "source": "input.data", "expansion": "input.expansion",
    "floating": "base.floating", "base_reason": "base.reason", "inserted": "base.inserted",
    "proof": "checked.proof", "proven": "checked.proven", "rejected": "checked.rejected",
    "changed": "checked.changed", "estimated": "state(Estimates).links",
    "weightless": "state(OnPurpose).weightless", "driven": "state(OnPurpose).driven",
    "edited": "state(OnPurpose).edited", "added": "state(OnPurpose).added",
    "kept": "state(Placed).joints", "used": "state(Placed).elements",
    "stop_frequency": "state(JointModels).stop_frequency",
}  # fmt: skip


def keep_attributes() -> None:
    """Let conversions have the attributes that have gone."""
    kind: Any = Conversion
    for name, now in MOVED.items():
        setattr(kind, name, _moved(name, now))
    kind.simulation, kind.starters = property(_simulation), property(_starters)


def _moved(name: str, now: str) -> property:
    owner, _, field = now.rpartition(".")
    state = getattr(states, owner[6:-1], None)

    def find(conversion: Any) -> Any:
        _warn(name, now, 4)
        return conversion.state(state) if state else getattr(conversion, owner)

    return property(
        lambda conversion: getattr(find(conversion), field),
        lambda conversion, value: setattr(find(conversion), field, value),
    )


def _simulation(conversion: Any) -> Any:
    _warn("simulation", "state(simulation.Simulation)")
    return conversion.state(conversion.find("simulation").Simulation)


def _starters(conversion: Any) -> _Starters:
    _warn("starters", "files[path] = File(data, 'starter')")
    return _Starters(conversion.files)


class _Starters(dict[Path, bytes]):
    """What ``conversion.starters`` was: a file that is put in becomes a starter."""

    def __init__(self, files: dict[Path, bytes]) -> None:
        super().__init__()
        self.files = files

    def __setitem__(self, path: Path, data: bytes) -> None:
        self.files[path] = File(data, "starter")


def _warn(name: str, now: str, level: int = 3) -> None:
    said = f"conversion.{name} goes: write conversion.{now}"
    warnings.warn(said, DeprecationWarning, stacklevel=level)
