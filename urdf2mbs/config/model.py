"""The content of a config, as typed data: what to convert, and by which passes."""

# Without "from __future__ import annotations": msgspec would evaluate each text of a type, which
# takes as long as a tenth of the passes.
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from urdf2mbs.ranges import Acceleration

#: A number of a range.
Number = Annotated[int, Meta(ge=-(10**15), le=10**15)] | Annotated[float, Meta(ge=-1e15, le=1e15)]

#: The level of a message.
Level = Literal["error", "warning", "note", "ignore"]

#: A name or a path.  An empty text would be the folder of the config.
Name = Annotated[str, Meta(min_length=1)]


def _flag(option_text: str) -> Meta:
    """Return the metadata of a field that an option of the command line sets."""
    return Meta(extra={"flag": option_text})


class Project(msgspec.Struct, forbid_unknown_fields=True):
    """A whole Robotran project folder instead of one file."""

    project: Name
    """the project's folder"""
    language: Literal["python", "c", "both"] | list[Literal["python", "c"]] = "python"
    """of the project's code: python for MBsysPy, c for MBsysC, or both"""


class Range(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Evenly spaced numbers, by ``step`` or by ``count``."""

    first: Number = msgspec.field(name="from")
    """the first number"""
    last: Number = msgspec.field(name="to")
    """the last number"""
    step: Number | None = None
    """from one number to the next"""
    count: Annotated[int, Meta(ge=-(10**9), le=10**9)] | None = None
    """how many numbers, instead of a step"""


class Sweep(msgspec.Struct, forbid_unknown_fields=True):
    """A robot for every combination of these values."""

    xacro_args: dict[Name, list[str | int | float | bool] | Range] = {}
    """the values of each xacro argument, as a list or a range"""
    passes: dict[Name, dict[str, list[Any] | Range]] = {}
    """the options of each pass, each with a list or a range of values"""


class Preset(msgspec.Struct, forbid_unknown_fields=True):
    """A pipeline with a name."""

    extends: Name | None = None
    """the name of another preset, which this one changes"""
    pipeline: list[Name] = []
    """the passes in their order, instead of those of another preset"""
    after: dict[str, str | list[str]] = {}
    before: dict[str, str | list[str]] = {}
    without: list[str] = []
    passes: dict[str, dict[str, Any]] = {}


class Config(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The content of a config file.  Paths are relative to the folder of the file."""

    # A field is a key of the file, a keyword of ``urdf2mbs.convert``, and an option of the command
    # line where it has a flag.  The text below the field is the help of all three.

    source: Name
    """the robot: a .urdf or .xacro file, or robot_descriptions:NAME"""
    output: Name | Project | None = None
    """the .mbs file (default: the source's name)"""
    base: Annotated[Literal["auto", "floating", "fixed"], _flag("--base")] = "auto"
    """whether the base floats (default: auto, which guesses)"""
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, -9.81)
    """acceleration in base axes, m/s^2"""
    packages: Annotated[dict[Name, Name], _flag("--package NAME=DIR")] = {}
    """the folder of each ROS package that is not found by itself"""
    xacro_args: Annotated[dict[Name, str], _flag("--arg NAME:=VALUE")] = {}
    """the value of each xacro argument"""
    plugins: Annotated[list[Name], _flag("--plugin FILE.py")] = []
    """Python files that bring passes"""
    pipeline: Annotated[str | list[str], _flag("--pipeline PRESET")] = "faithful"
    """the name of a preset, or the passes in their order"""
    after: Annotated[dict[str, str | list[str]], _flag("--after PASS=NEW")] = {}
    """the passes to put right after a pass"""
    before: dict[str, str | list[str]] = {}
    """the passes to put right before a pass"""
    without: list[str] = []
    """passes to leave out"""
    swap: dict[str, str] = {}
    """the plugin whose pass of the same name replaces a pass"""
    passes: Annotated[dict[str, dict[str, Any]], _flag("--set PASS.OPTION=VALUE")] = {}
    """the options of each pass"""
    diagnostics: Annotated[dict[str, Level], _flag("--level CODE=LEVEL")] = {}
    """the level of a code: error, warning, note or ignore"""
    strict: Annotated[bool, _flag("--strict")] = False
    """warnings are errors"""
    trust_xacro: Annotated[bool, _flag("--trust-xacro")] = False
    """let the robot's xacro do whatever Python can, and read any file"""
    sweep: Sweep | None = None
    """make a family of robots, one for each combination"""
