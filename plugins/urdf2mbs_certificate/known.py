"""What a certificate says that concerns the comparison of its .mbs with a URDF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.disk import files


class _Certified(msgspec.Struct):
    passes: dict[str, Any] = {}
    driven: list[str] = []


def certified(model: str) -> tuple[dict[str, Any], list[str]]:
    """The options of the passes that changed the robot on purpose, and the joints that are driven
    on purpose; nothing, where no certificate beside the .mbs can be read."""
    try:
        data = files.read(Path(model).with_suffix(".proof.json"))
        said = msgspec.json.decode(data, type=_Certified)
    except (OSError, ValueError, msgspec.MsgspecError):
        return {}, []
    return said.passes, said.driven
