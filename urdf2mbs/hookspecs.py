"""The door: what a plugin may offer, ours as anybody's.

docs/passes.md shows each hook at work.  A plugin is any module with functions of these names,
marked with ``hookimpl`` of ``urdf2mbs.plugin``.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
import pluggy

if TYPE_CHECKING:
    from urdf2mbs.config.model import Config, Lines
    from urdf2mbs.conversion import Conversion, Summary
    from urdf2mbs.urdf.model import Extension, Robot
    from urdf2mbs.urdf.packages import Packages
    from urdf2mbs.urdf.reader import Expansion, Located
    from urdf2mbs.urdf.values import Reading

hookspec = pluggy.HookspecMarker("urdf2mbs")
hookimpl = pluggy.HookimplMarker("urdf2mbs")


class Pass(msgspec.Struct, forbid_unknown_fields=True):
    """One step of a conversion.

    A subclass is a pass.  Its fields are the pass's options, filled from the config: a field
    without a default must be given there.  ``run`` changes the conversion in place.

    The sections of a conversion are listed in ``engine.sections``, and the rules in
    ``engine.order``.
    """

    name: ClassVar[str] = ""
    """How a config calls the pass; by default the name of the class: ``LockJoints`` is
    ``lock-joints``."""
    reads: ClassVar[tuple[str, ...]] = ()
    """The sections that the pass uses for what it writes, or says."""
    writes: ClassVar[tuple[str, ...]] = ()
    """The sections that the pass fills or changes."""
    after: ClassVar[tuple[str, ...]] = ()
    """The place of the pass in each preset: behind the first of these passes, which must be there,
    and behind the others that are there.  None: the config says where the pass stands."""

    def __init_subclass__(cls, **settings: Any) -> None:
        super().__init_subclass__(**settings)
        if "name" not in cls.__dict__:
            cls.name = re.sub(r"(?<=.)(?=[A-Z])", "-", cls.__name__).lower()

    def run(self, conversion: Conversion) -> None:
        raise NotImplementedError

    @classmethod
    def summary(cls) -> str:
        """The first sentence of the docstring of the class or its module, without the name."""
        module = sys.modules.get(cls.__module__)
        text = cls.__doc__ or (module.__doc__ if module else None) or ""
        paragraph = " ".join(text.strip().partition("\n\n")[0].split())
        named = rf"(?i)^{cls.name.replace('-', '[ -]')}: "
        return re.sub(named, "", re.split(r"(?<=\.) ", paragraph)[0])


def always(conversion: Conversion, given: bool) -> bool:
    """True for a pass that has work with every robot."""
    return True


def asked(conversion: Conversion, given: bool) -> bool:
    """True if the config gives the pass options, or names the pass."""
    return given


def in_project(conversion: Conversion, given: bool) -> bool:
    """True if the output is a project."""
    return given or conversion.settings.project is not None


class PassEntry(msgspec.Struct, frozen=True):
    """A pass by its name: its file is imported when the pass has work.

    The pass ``my-pass`` of the package ``our`` is the class ``MyPass`` of ``our.passes.my_pass``.
    """

    name: str
    package: str
    after: tuple[str, ...]
    """As ``Pass.after``."""
    work: Callable[[Conversion, bool], bool] = asked
    """True if the pass has something to do with the conversion as it stands.  The second argument
    is True if the config gives the pass options, or names the pass."""
    presets: tuple[str, ...] = ()
    """The presets that the pass joins, and those that extend them; none: all."""


class Command(msgspec.Struct, frozen=True):
    """A command of the command line; its file is imported when the command is called."""

    name: str
    does: str
    """One sentence, with which the help begins."""
    module: str
    """Has ``EXAMPLES`` (command lines), ``add_options(parser)`` and ``carry_out(arguments)``, which
    gives the exit code.  The help has the second paragraph of its docstring, too."""


@hookspec
def urdf2mbs_passes() -> list[type[Pass] | PassEntry]:
    """The passes that this plugin brings: the classes, or entries that name them."""
    raise NotImplementedError


@hookspec
def urdf2mbs_commands() -> list[Command]:
    """The commands that this plugin brings."""
    raise NotImplementedError


@hookspec
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    """Add options to a command of the core.

    Args:
        command: ``run``, ``convert`` or ``verify``.
        parser: What reads the words of the command.
    """


@hookspec
def urdf2mbs_observe(arguments: argparse.Namespace) -> object | None:
    """Return an object whose own hooks are called around the passes of one robot.

    Its method ``finish``, if it has one, is called when the passes have ended, also by an error.

    Args:
        arguments: The options of ``run`` or ``convert``, those of ``urdf2mbs_options`` among them.
    """


@hookspec(firstresult=True)
def urdf2mbs_carry_out(
    command: str, configs: list[tuple[Config, Lines]], arguments: argparse.Namespace
) -> int | None:
    """Carry out a command for many robots, and return the exit code; None: another plugin may.

    Args:
        command: ``run``, of several configs or a sweep; or ``convert``, of a folder of robots.
        configs: The configs of ``run``, and where each value stands in its file.
        arguments: The options of the command.
    """


@hookspec
def urdf2mbs_folders() -> list[str]:
    """Return the folders of a Robotran project that this plugin fills, such as ``workR``."""
    raise NotImplementedError


@hookspec
def urdf2mbs_api() -> dict[str, str]:
    """Functions and classes that others call by name: each name, and ``module:name`` of the thing.

    ``conversion.find(NAME)`` gives the thing; of our own plugins, ``urdf2mbs.NAME`` does, too.
    """
    raise NotImplementedError


@hookspec(firstresult=True)
def urdf2mbs_locate(source: str) -> Located | None:
    """The file of a robot that is named as ``KIND:NAME``; None: the kind is not this plugin's."""


@hookspec(firstresult=True)
def urdf2mbs_read(
    source: Path, data: bytes, packages: Packages, args: Mapping[str, str], trust: bool
) -> Expansion | None:
    """The URDF that a robot's file stands for; None: the file is not of this plugin's format.

    ``trust``: the file may do whatever Python can.
    """


@hookspec
def urdf2mbs_extension(
    elements: list[tuple[Any, Extension]], reading: Reading, robot: Robot
) -> None:
    """Read what elements of other programs say of a robot, such as ``<gazebo>``.

    Each is an element of lxml, and what is kept of the element.  The robot's links and joints are
    there already.
    """


@hookspec
def urdf2mbs_summary(conversion: Conversion) -> Summary | None:
    """What a plugin has to say of a conversion that is done."""


@hookspec
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    """The presets that this plugin brings, each by its name.

    A preset has the keys ``pipeline``, ``after``, ``before``, ``without`` and ``passes`` of a
    config.  ``extends`` names the preset that it changes.
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_codes() -> dict[str, str]:
    """The codes of this plugin's messages, and what each means: ``{"links-dropped": "warning: links
    are left out"}``.  A config may set the level of each, unless the text begins with ``error:``.

    The hook is called when a config sets levels, or a warning has no hint: the second sentence of
    the text is the hint then.
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_before_pass(pass_: Pass, conversion: Conversion) -> None:
    """Called before each pass: for progress, own checks, a breakpoint."""


@hookspec
def urdf2mbs_progress(text: str) -> None:
    """Called by a pass that takes long, with what it is at (``conversion.progress(text)``)."""


@hookspec
def urdf2mbs_after_pass(pass_: Pass, conversion: Conversion, seconds: float) -> None:
    """Called after each pass, with the time that it took."""
