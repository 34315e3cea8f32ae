"""What passes tell each other beyond the sections: each class by ``conversion.state(CLASS)``."""

from __future__ import annotations

from typing import Any

import msgspec

from urdf2mbs.mbs.model import Joint
from urdf2mbs.urdf.model import Extension


class Estimates(msgspec.Struct):
    """The inertias that are no more than estimates."""

    links: list[str] | None = None
    """Whose inertia is an estimate; None: no estimate was asked for."""

    def sections(self) -> dict[str, Any]:
        return {"robot": self.links}


class JointModels(msgspec.Struct):
    """What joint-parameters wrote for each property of joints."""

    values: dict[str, dict[str, float]] = {}
    """By the name of the user model: the value at each joint of the .mbs."""
    stop_frequency: float | None = None
    """Stiffness (Hz) of the soft stops of a project; None: it has no stops."""


class Placed(msgspec.Struct):
    """What of the URDF has found a place, so that ``left-out`` does not name it."""

    joints: dict[str, set[str]] = {}
    """Code of a note of ``left-out``: the URDF joints whose property has found a place."""
    elements: list[Extension] = []
    """The elements of other programs in which a pass has found something."""


class OnPurpose(msgspec.Struct):
    """What makes the .mbs another robot than the URDF's on purpose; ``check`` says so."""

    massless: set[str] = set()
    """The joints of ``frozen`` that are left out because nothing that they move has mass."""
    driven: list[Joint] = []
    """The followers that user code moves."""
    edited: dict[str, None] = {}
    """The files whose edits make the .mbs another robot than the URDF's."""
    added: dict[str, str] = {}
    """What people added to the .mbs: each thing, and where."""
