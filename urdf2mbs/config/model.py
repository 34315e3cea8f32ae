"""The YAML file that says what to convert and by which passes, as typed data.

Errors name the file, the line and the key, and offer the nearest known one.
"""

# Without "from __future__ import annotations": msgspec would evaluate each text of a type, which
# takes as long as a tenth of the passes.
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.ranges import Acceleration

#: The most bytes of a config that are read.
MOST = 2**20

#: The place of a value in a config: the keys (and list positions) that lead to it.
Key = tuple[str | int, ...]

#: A number of a range.
Number = Annotated[int, Meta(ge=-(10**15), le=10**15)] | Annotated[float, Meta(ge=-1e15, le=1e15)]

#: How much a message weighs.
Level = Literal["error", "warning", "note", "ignore"]

#: A name or a path.  An empty text would stand for the folder of the config.
Name = Annotated[str, Meta(min_length=1)]


def _flag(words: str) -> Meta:
    """The option of a command line that sets a field, with the form of its value."""
    return Meta(extra={"flag": words})


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
    """A pipeline with a name: what a config may say of passes."""

    extends: Name | None = None
    """the name of another preset, which this one changes"""
    pipeline: list[Name] = []
    """the passes in their order, instead of those of another preset"""
    after: dict[str, str | list[str]] = {}
    before: dict[str, str | list[str]] = {}
    without: list[str] = []
    passes: dict[str, dict[str, Any]] = {}


class Config(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A config file's content. Paths are relative to the folder of the file."""

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


class Lines(msgspec.Struct):
    """Where each value of a config file stands, for error messages."""

    file: Path | None = None
    places: dict[Key, int] = {}
    """The line of each value."""
    folder: Path = Path()
    """The paths in the config are relative to this folder."""
    faults: list[ConfigError] = []
    """What is wrong with the config, as far as it has been read; ``check`` raises it."""

    def error(self, code: str, message: str, at: Key = (), hint: str | None = None) -> ConfigError:
        line = next(
            (self.places[at[:n]] for n in range(len(at), -1, -1) if at[:n] in self.places), None
        )
        return ConfigError(
            code, message, file=str(self.file) if self.file else None, line=line, hint=hint
        )

    @contextmanager
    def gather(self) -> Iterator[None]:
        """Keep a ConfigError among the faults."""
        try:
            yield
        except ConfigError as error:
            self.faults.append(error)

    def check(self) -> None:
        """Raise the faults as one ConfigError, in the order of their lines."""
        if self.faults:
            *before, last = sorted(self.faults, key=lambda fault: fault.line or 0)
            self.faults = []
            said = [each for fault in before for each in (*fault.earlier, fault.diagnostic())]
            last.earlier = said + last.earlier
            raise last


#: A variable in a path, ``$NAME`` or ``${NAME}``, or the beginning of one that is not closed.
_VARIABLE = re.compile(r"\$(?:(?P<plain>[A-Za-z_]\w*)|\{(?P<braced>[A-Za-z_]\w*)\}|\{)")
#: ``~`` or ``~USER`` at the beginning of a path.
_HOME = re.compile(r"~[^/\\$]*(?![^/\\])")


def expand(given: str, lines: Lines, at: Key) -> str:
    """Return a path of a config with ``~`` and ``$VARIABLE`` filled in, as a shell does.

    The values of variables are not expanded again.

    Raises:
        ConfigError: A variable is not set, or a ``${`` is not closed.
    """
    if lines.file is None:
        return given

    def value_of(variable: re.Match[str]) -> str:
        name = variable["plain"] or variable["braced"]
        if name is None:
            message = f"'{given}' has a '${{' that does not begin a variable; expected '${{NAME}}'"
            raise lines.error("variable-unclosed", message, at, "close it by '}' after the name")
        value = os.environ.get(name)
        if not value:
            message = f"'{given}' uses ${name}, which is not set or empty"
            hint = f"for instance: export {name}=DIR; the config's comments may say which folder"
            raise lines.error("variable-unset", message, at, hint)
        return value

    home = _HOME.match(given)
    start = home.end() if home else 0
    return os.path.expanduser(given[:start]) + _VARIABLE.sub(value_of, given[start:])  # noqa: PTH111


def place(given: str, lines: Lines, at: Key) -> Path:
    """The absolute path of a path of a config."""
    return files.absolute(lines.folder / expand(given, lines, at))


def load(file: Path) -> tuple[Config, Lines]:
    """Read a config file; raises ConfigError if it is no config.

    Keys and values that are wrong are left out, and are faults of the lines.  Pipeline adds its
    own, so that a user reads them all at once.
    """
    try:
        text = files.read_bytes(file, MOST).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(
            "config-unreadable", f"cannot read the config: {reason}", file=str(file)
        ) from None
    if text.lstrip().startswith("<"):
        message = "this is XML, such as a robot, and no config"
        hint = (
            f"urdf2mbs init {file} writes a config for a robot; urdf2mbs convert {file} needs none"
        )
        if file.suffix.lower() == ".mbs":
            message = "this is a model, and no config"
            hint = f"urdf2mbs verify ROBOT {file} compares it; urdf2mbs report {file} shows it"
        raise ConfigError("config-yaml", message, file=str(file), hint=hint)
    return parse(text, file)


def parse(text: str, file: Path | None) -> tuple[Config, Lines]:
    """What ``load`` gives, of a config's text."""
    from urdf2mbs.config import yaml_text  # PyYAML: not for a robot without a config

    data, places = yaml_text.tree(text, file)
    lines = Lines(file, places, file.parent if file else Path())
    if not isinstance(data, dict):
        raise lines.error(
            "config-type", "a config is a list of 'key: value' lines, such as 'source: robot.urdf'"
        )
    return _read_fields(Config, data, lines, ()), lines


def config_of(
    source: Config | Mapping[str, Any] | str | os.PathLike[str], **fields: Any
) -> tuple[Config, Lines]:
    """The config of a call from Python, with ``fields`` in it.

    ``source`` is a robot, a config file, a ``Config``, or a mapping of its fields.  A field that
    is a block of keys, such as ``xacro_args``, changes the block of the source; of ``passes``, the
    block of each pass.  A path is a word, any sequence a list.  Paths are relative to the working
    folder, those of a config file to its folder.  Raises ConfigError.
    """
    lines = Lines()
    values: Any = {"source": source}
    if isinstance(source, (Config, Mapping)):
        values = source
    elif os.fspath(source).lower().endswith((".yaml", ".yml")):
        values, lines = load(Path(source))
    if isinstance(values, Config):
        values = msgspec.structs.asdict(values)
    values, fields = (
        msgspec.to_builtins(given, enc_hook=_word_or_list, str_keys=True)
        for given in (values, fields)
    )
    for name, value in fields.items():
        before = values.get(name)
        if isinstance(value, dict) and isinstance(before, dict):
            if name == "passes":
                value = {key: {**before.get(key, {}), **own} for key, own in value.items()}
            value = {**before, **value}
        values[name] = value
    return typed(Config, values, Lines()), lines


def _word_or_list(value: Any) -> Any:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    try:
        return list(value)
    except TypeError:
        raise ConfigError("config-type", f"a config holds no such thing: {value!r}") from None


def typed(kind: Any, data: Any, lines: Lines, at: Key = ()) -> Any:
    """``data`` as an instance of a Struct; raises ConfigError naming the key."""
    own = Lines(lines.file, lines.places, lines.folder)
    value = _read_fields(kind, data, own, at)
    own.check()
    return value


def _read_fields(kind: Any, data: Any, lines: Lines, at: Key) -> Any:
    """``data`` as an instance of a Struct, without what is wrong, which becomes faults.

    A key that is nearly a known one is read as the known one.  Raises ConfigError if nothing can
    be read.
    """
    with suppress(TypeError, *_REFUSED):
        # a class by its defaults: msgspec takes long for the first value of a class
        return kind() if data == {} else msgspec.convert(data, kind)
    if not isinstance(data, dict):
        said = f"'{dotted(at)}' wants 'key: value' lines, not {data!r}"
        raise lines.error("config-type", said, at)
    schema = msgspec.json.schema(kind)
    known = schema["$defs"][schema["$ref"].rpartition("/")[2]]["properties"]
    # one word where a list is wanted is a list of one
    data = {
        key: [value] if isinstance(value, str) and known.get(key, {}).get("items") else value
        for key, value in data.items()
    }
    try:
        return msgspec.convert(data, kind)
    except _REFUSED as error:
        from urdf2mbs.config.faults import take_faults  # jsonschema takes long

        faults = take_faults(schema, data, lines, at)
        if not faults:  # values that the class refuses together, or a text with half a letter
            said = str(error).partition(" - at `")[0]
            raise lines.error("config-type", f"'{dotted(at)}': {said}", at) from None
    lines.faults += faults
    with suppress(*_REFUSED):
        return msgspec.convert(data, kind)
    lines.check()
    return None


#: The exceptions by which msgspec refuses a value.
_REFUSED = (msgspec.ValidationError, UnicodeEncodeError)


def dotted(at: Key) -> str:
    """The place of a value in a message."""
    return ".".join(map(str, at)) or "config"
