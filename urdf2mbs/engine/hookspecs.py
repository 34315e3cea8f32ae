"""What a plugin may offer: its passes, and a look at every pass before and after it runs.

A plugin is any module with functions of these names, marked with ``hookimpl``::

    from urdf2mbs.engine.hookspecs import Pass, hookimpl

    def shout(conversion, options):
        \"\"\"Write the robot's name in capitals.\"\"\"
        conversion.robot.name = conversion.robot.name.upper()

    @hookimpl
    def urdf2mbs_passes():
        return [Pass("shout", shout, changes=("robot",))]
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import Any

import msgspec
import pluggy

from urdf2mbs.conversion import Conversion, Settings

hookspec = pluggy.HookspecMarker("urdf2mbs")
hookimpl = pluggy.HookimplMarker("urdf2mbs")


class NoOptions(msgspec.Struct, forbid_unknown_fields=True):
    """The options of a pass that has none."""


class Pass(msgspec.Struct, frozen=True):
    """One step of a conversion.

    ``run(conversion, options)`` changes the conversion in place; ``options`` is an instance
    of the class ``options`` (a ``msgspec.Struct`` or a dataclass), filled from the config:
    its fields without a default must be given there.

    ``needs`` and ``gives`` name what must be known before and what is known after (see
    ``Conversion``).  ``changes`` names what was known before and is another after: whatever
    earlier passes derived from it is stale until it is derived again.  A pass that needs what
    nobody has given yet, or what is stale, is an error before anything runs.
    """

    name: str
    run: Callable[[Conversion, Any], None]
    options: type = NoOptions
    needs: tuple[str, ...] = ()
    gives: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """The first sentence of the docstring of ``run``, else of its module."""
        module = sys.modules.get(self.run.__module__)
        doc = self.run.__doc__ or (module.__doc__ if module else None) or ""
        paragraph = " ".join(doc.strip().partition("\n\n")[0].split())
        return re.split(r"(?<=\.) ", paragraph)[0]


@hookspec
def urdf2mbs_passes() -> list[Pass]:
    """The passes that this plugin brings.

    Example::

        @hookimpl
        def urdf2mbs_passes():
            return [Pass("drop-grippers", drop_grippers, changes=("robot",))]
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    """The presets that this plugin brings: name, then ``pipeline`` and ``passes`` as in a config.

    Example::

        @hookimpl
        def urdf2mbs_presets():
            return {"bare": {"pipeline": ["expand", "insert-base", "prune-massless"]}}
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_before_run(settings: Settings) -> None:
    """Called once, before the source is read: to fetch or make what it needs.

    Example::

        @hookimpl
        def urdf2mbs_before_run(settings):
            print("converting", settings.source)
    """


@hookspec
def urdf2mbs_before_pass(pass_: Pass, conversion: Conversion) -> None:
    """Called before each pass: for progress, own checks, a breakpoint.

    Example::

        @hookimpl
        def urdf2mbs_before_pass(pass_, conversion):
            print("now", pass_.name)
    """


@hookspec
def urdf2mbs_progress(text: str) -> None:
    """Called by a pass that takes long, with what it is at (``conversion.progress(text)``).

    Example::

        @hookimpl
        def urdf2mbs_progress(text):
            print("now", text)
    """


@hookspec
def urdf2mbs_after_pass(pass_: Pass, conversion: Conversion, seconds: float) -> None:
    """Called after each pass, with the time that it took.

    Example::

        @hookimpl
        def urdf2mbs_after_pass(pass_, conversion, seconds):
            assert conversion.robot.links, f"{pass_.name} left no links"
    """
