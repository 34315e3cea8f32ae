"""The limits of a process of its own for xacro (``isolated``)."""

from __future__ import annotations

import re
from typing import Annotated

import msgspec
from msgspec import Meta

_UNITS = {"": 1, "kib": 2**10, "mib": 2**20, "gib": 2**30, "kb": 10**3, "mb": 10**6, "gb": 10**9}


class Isolate(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Limits of a process."""

    seconds: Annotated[float, Meta(gt=0, le=86400)] = 60.0
    """How long it may take."""
    memory: Annotated[str, Meta(pattern=r"^[0-9]{1,9} ?([KMG]i?B)?$")] | None = "2GiB"
    """How much memory it may take: a number with MB, MiB, GB or GiB; null is no limit."""

    def bytes(self) -> int | None:
        """The memory in bytes; None: no limit."""
        found = re.fullmatch(r"(\d+) ?(\w*)", self.memory or "")
        return int(found[1]) * _UNITS[found[2].lower()] if found else None
