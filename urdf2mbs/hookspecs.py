"""The hooks of plugins, and what plugins bring through them: passes and commands.

docs/hooks.md shows hooks at work.  A plugin is any module with functions of these names,
marked with ``hookimpl`` of ``urdf2mbs.plugin``.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
import pluggy

if TYPE_CHECKING:
    from urdf2mbs.config.lines import Lines
    from urdf2mbs.config.model import Config
    from urdf2mbs.conversion import Conversion, Intent, Summary
    from urdf2mbs.urdf.model import Extension, Robot
    from urdf2mbs.urdf.packages import Packages
    from urdf2mbs.urdf.reader import Expansion, Located
    from urdf2mbs.urdf.values import Reading

#: The entry point group of plugins, and the name of our own distribution.
GROUP = "urdf2mbs"

hookspec = pluggy.HookspecMarker(GROUP)
hookimpl = pluggy.HookimplMarker(GROUP)


class Pass(msgspec.Struct, forbid_unknown_fields=True):
    """One step of a conversion.

    A subclass is a pass.  Its fields are the pass's options, filled from the config: a field
    without a default must be given there.  ``run`` changes the conversion in place.

    The sections of a conversion are listed in ``engine.sections``, and the rules in
    ``engine.contract``.
    """

    name: ClassVar[str] = ""
    """The name of the pass in a config; by default that of the class: ``LockJoints`` is
    ``lock-joints``."""
    reads: ClassVar[tuple[str, ...]] = ()
    """The sections from which the pass makes its result or its messages."""
    writes: ClassVar[tuple[str, ...]] = ()
    """The sections that the pass fills or changes."""
    after: ClassVar[tuple[str, ...]] = ()
    """The place of the pass in each preset: after all of these passes that are present.  The pass
    is left out if the first of them is absent.  Empty: the config places the pass."""

    def __init_subclass__(cls, **settings: Any) -> None:
        super().__init_subclass__(**settings)
        if "name" not in cls.__dict__:
            cls.name = re.sub(r"(?<=.)(?=[A-Z])", "-", cls.__name__).lower()

    def run(self, conversion: Conversion) -> None:
        """Change the conversion in place.

        Raises:
            ConversionError: The robot cannot be converted, or an option does not fit it.
        """
        raise NotImplementedError

    @classmethod
    def summary(cls) -> str:
        """Return the first sentence of the docstring of the class or module, without the name."""
        module = sys.modules.get(cls.__module__)
        text = cls.__doc__ or (module.__doc__ if module else None) or ""
        paragraph = " ".join(text.strip().partition("\n\n")[0].split())
        title = rf"(?i)^{cls.name.replace('-', '[ -]')}: "
        return re.sub(title, "", re.split(r"(?<=\.) ", paragraph)[0])


def always(conversion: Conversion, given: bool) -> bool:
    """Return True: the pass has work with every robot."""
    return True


def asked(conversion: Conversion, given: bool) -> bool:
    """Return whether the config names the pass or sets its options."""
    return given


def in_project(conversion: Conversion, given: bool) -> bool:
    """Return whether the output is a project, or the config asks for the pass."""
    return given or conversion.settings.project is not None


class PassEntry(msgspec.Struct, frozen=True):
    """A pass by its name; its file is imported when the pass has work.

    The pass ``my-pass`` of the package ``lab`` is the class ``MyPass`` of ``lab.passes.my_pass``.
    A plugin that returns the class itself gets an entry for it.
    """

    name: str
    package: str
    """The Python package that has the pass in its folder ``passes``."""
    after: tuple[str, ...]
    """As ``Pass.after``."""
    work: Callable[[Conversion, bool], bool] = asked
    """Return whether the pass has work in the current conversion.  The second argument is True if
    the config names the pass or sets its options."""
    presets: tuple[str, ...] = ()
    """The presets that the pass joins, and those that extend them; empty: all."""
    kind: type[Pass] | None = None
    """The class of the pass, if the plugin has returned the class itself."""
    plugin: str = ""
    """The plugin that brings the pass; this and the next two are filled in as it is loaded."""
    distribution: str = ""
    """The installed distribution that brings the plugin; empty for a file of a config."""
    file: str = ""
    """The file of the plugin."""

    @property
    def module(self) -> str:
        """The module that has the class of the pass."""
        if self.kind is not None:
            return self.kind.__module__
        return f"{self.package}.passes.{self.name.replace('-', '_')}"

    @property
    def is_core(self) -> bool:
        """Whether the pass is one of the method."""
        return self.plugin == GROUP

    @property
    def is_ours(self) -> bool:
        """Whether the pass comes with urdf2mbs, in the core or in a plugin."""
        return self.distribution == GROUP

    @property
    def source(self) -> str:
        """The file that the pass is written in; that of the plugin until the pass is imported."""
        if not self.is_ours and self.module.partition(".")[0].startswith(GROUP):
            return self.file  # the plugin's class borrows our ``run``
        module = sys.modules.get(self.module)
        return str(getattr(module, "__file__", None) or self.file)

    def joins(self, presets: Collection[str]) -> bool:
        """Return whether the pass has a place in one of these presets."""
        return not self.presets or any(preset in presets for preset in self.presets)

    def load(self) -> type[Pass]:
        """Import the class of the pass; raises what its file raises."""
        if self.kind is not None:
            return self.kind
        kind: type[Pass] = getattr(import_module(self.module), self.name.title().replace("-", ""))
        return kind


class Command(msgspec.Struct, frozen=True):
    """A command of the command line; its file is imported when the command is called."""

    name: str
    does: str
    """One sentence, with which the help begins."""
    module: str
    """The module of the command.  It has ``EXAMPLES`` (command lines), ``add_options(parser)`` and
    ``carry_out(arguments)``, which returns the exit code.  The help shows the second paragraph of
    its docstring, too."""


@hookspec
def urdf2mbs_passes() -> list[type[Pass] | PassEntry]:
    """Return the passes that this plugin brings: the classes, or entries that name them."""
    raise NotImplementedError


@hookspec
def urdf2mbs_commands() -> list[Command]:
    """Return the commands that this plugin brings."""
    raise NotImplementedError


@hookspec
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    """Add options to a command of the core.

    Args:
        command: ``run``, ``convert`` or ``verify``.
        parser: The parser of the command.
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
        configs: The configs of ``run``, and the line of each value in its file.
        arguments: The options of the command.
    """


@hookspec(firstresult=True)
def urdf2mbs_expand_sweep(config: Config, lines: Lines) -> list[tuple[Config, str]] | None:
    """Return the robots of a sweep: the config of each, and its values in words.

    Args:
        config: A config with ``sweep``.
        lines: The line of each value in the config's file.
    """


@hookspec
def urdf2mbs_observe_verify(
    robot: str, arguments: argparse.Namespace
) -> AbstractContextManager[Callable[[Any], bool]] | None:
    """Return a context in which ``verify`` reads and compares one robot.

    The context is left with the error that ends the comparison, if there is one.  It yields a
    function that takes the ``urdf2mbs.Verdict``, and returns whether it has printed it.

    Args:
        robot: The file of the robot.
        arguments: The options of ``verify``, those of ``urdf2mbs_options`` among them.
    """


@hookspec(firstresult=True)
def urdf2mbs_intent(model: Path) -> Intent | None:
    """Return what an earlier conversion changed on purpose, as recorded beside its .mbs.

    Args:
        model: The .mbs.
    """


@hookspec
def urdf2mbs_folders() -> list[str]:
    """Return the folders of a Robotran project that this plugin fills, such as ``workR``."""
    raise NotImplementedError


@hookspec
def urdf2mbs_api() -> dict[str, str]:
    """Return names for users of Python: ``urdf2mbs.NAME`` is the ``module:name`` of each."""
    raise NotImplementedError


@hookspec(firstresult=True)
def urdf2mbs_locate(source: str) -> Located | None:
    """Return the file of a robot that is named as ``KIND:NAME``; None: of another plugin's kind."""


@hookspec(firstresult=True)
def urdf2mbs_read(
    source: Path, data: bytes, packages: Packages, args: Mapping[str, str], trust: bool
) -> Expansion | None:
    """Return the URDF of a robot's file; None: it is not of this plugin's format.

    Args:
        source: The file.
        data: The bytes of the file.
        packages: The folders of ROS packages.
        args: The arguments of xacro, or of another macro language.
        trust: Whether the file may do whatever Python can.
    """


@hookspec
def urdf2mbs_extension(
    elements: list[tuple[Any, Extension]], reading: Reading, robot: Robot
) -> None:
    """Read what elements of other programs state of a robot, such as ``<gazebo>``.

    Args:
        elements: Each element of lxml, and the extension that is kept of it.
        reading: Reads numbers and names, and warns with their lines.
        robot: The robot, with its links and joints.
    """


@hookspec
def urdf2mbs_summary(conversion: Conversion, for_page: bool) -> Summary | None:
    """Return the lines and tables of this plugin for a finished conversion.

    Args:
        conversion: A finished conversion.
        for_page: True for a page, False for the command line, which shows no tables: tables that
            take time are made for a page only.
    """


@hookspec(firstresult=True)
def urdf2mbs_show(conversion: Conversion) -> str | None:
    """Return HTML that shows a finished conversion in a notebook."""


@hookspec
def urdf2mbs_find_faults(conversion: Conversion) -> None:
    """Warn of the faults of a robot, for ``lint``.

    Args:
        conversion: A conversion whose robot has been read and changed, but has no base yet.
    """


@hookspec
def urdf2mbs_doctor() -> dict[str, str]:
    """Return what ``doctor`` shows of this machine, such as a compiler and its path."""
    raise NotImplementedError


@hookspec
def urdf2mbs_presets() -> dict[str, dict[str, Any]]:
    """Return the presets that this plugin brings, each by its name.

    A preset has the keys ``pipeline``, ``after``, ``before``, ``without`` and ``passes`` of a
    config.  ``extends`` names the preset that it changes.
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of this plugin's messages with their meaning.

    Such as ``{"links-dropped": "warning: links are left out. Name them in keep."}``.  A config may
    set the level of each, unless the text begins with ``error:``.  The hook is called when a config
    sets levels, or a warning has no hint: the second sentence of the text is the hint then.
    """
    raise NotImplementedError


@hookspec
def urdf2mbs_before_pass(pass_: Pass, conversion: Conversion) -> None:
    """Act before each pass, for a check or a breakpoint."""


@hookspec
def urdf2mbs_progress(text: str) -> None:
    """Show what a pass that takes long is doing (``conversion.progress(text)``)."""


@hookspec
def urdf2mbs_after_pass(pass_: Pass, conversion: Conversion, seconds: float) -> None:
    """Act after each pass, with the time that it took in seconds."""
