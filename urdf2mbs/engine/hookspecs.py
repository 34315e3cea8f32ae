"""What a plugin may offer: its passes, and a look at every pass before and after it runs.

docs/passes.md shows each hook at work.  A plugin is any module with functions of these names,
marked with ``hookimpl`` of ``urdf2mbs.plugin``.
"""

from __future__ import annotations

import re
import sys
from typing import Any, ClassVar

import msgspec
import pluggy

from urdf2mbs.conversion import Conversion, Settings

hookspec = pluggy.HookspecMarker("urdf2mbs")
hookimpl = pluggy.HookimplMarker("urdf2mbs")


class Pass(msgspec.Struct, forbid_unknown_fields=True):
    """One step of a conversion.

    A subclass is a pass.  Its fields are the pass's options, filled from the config: a field
    without a default must be given there.  ``run`` changes the conversion in place.

    The sections of a conversion are listed in ``engine.sections``.  A pass that reads a section
    stands behind a pass that writes the section, and before no pass that writes the section anew.
    """

    name: ClassVar[str] = ""
    """How a config calls the pass; by default the name of the class: ``LockJoints`` is
    ``lock-joints``."""
    reads: ClassVar[tuple[str, ...]] = ()
    """The sections that the pass needs."""
    writes: ClassVar[tuple[str, ...]] = ()
    """The sections that the pass fills or changes."""

    def __init_subclass__(cls, **settings: Any) -> None:
        super().__init_subclass__(**settings)
        if "name" not in cls.__dict__:
            cls.name = re.sub(r"(?<=.)(?=[A-Z])", "-", cls.__name__).lower()

    def run(self, conversion: Conversion) -> None:
        raise NotImplementedError

    @classmethod
    def summary(cls) -> str:
        """The first sentence of the docstring of the class, else of its module."""
        module = sys.modules.get(cls.__module__)
        text = cls.__doc__ or (module.__doc__ if module else None) or ""
        paragraph = " ".join(text.strip().partition("\n\n")[0].split())
        return re.split(r"(?<=\.) ", paragraph)[0]


@hookspec
def urdf2mbs_passes() -> list[type[Pass]]:
    """The passes that this plugin brings: the classes."""
    raise NotImplementedError


@hookspec
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    """The presets that this plugin brings, each by its name.

    A preset has the keys ``pipeline``, ``after``, ``before``, ``without`` and ``passes`` of a
    config.  ``extends`` names the preset that it changes.
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_codes() -> list[str]:
    """The codes of this plugin's warnings and notes: a config may set the level of each."""
    raise NotImplementedError


@hookspec
def urdf2mbs_before_run(settings: Settings) -> None:
    """Called once, before the source is read: to fetch or make what it needs."""


@hookspec
def urdf2mbs_before_pass(pass_: Pass, conversion: Conversion) -> None:
    """Called before each pass: for progress, own checks, a breakpoint."""


@hookspec
def urdf2mbs_progress(text: str) -> None:
    """Called by a pass that takes long, with what it is at (``conversion.progress(text)``)."""


@hookspec
def urdf2mbs_after_pass(pass_: Pass, conversion: Conversion, seconds: float) -> None:
    """Called after each pass, with the time that it took."""
