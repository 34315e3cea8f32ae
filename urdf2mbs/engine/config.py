"""The YAML file that says what to convert and by which passes, as typed data.

Errors name the file, the line and the key, and offer the nearest known one.
"""

# Without "from __future__ import annotations": msgspec would evaluate each text of a type, which
# takes as long as a tenth of the passes.
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from copy import deepcopy
from functools import cache
from os import PathLike, fspath
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.ranges import Acceleration, in_words

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
    """Numbers from one to another, both among them, in steps or so many."""

    first: Number = msgspec.field(name="from")
    """the first number"""
    last: Number = msgspec.field(name="to")
    """the last number, or a bound that the steps do not reach"""
    step: Number | None = None
    """from one number to the next"""
    count: Annotated[int, Meta(ge=-(10**9), le=10**9)] | None = None
    """how many numbers, instead of a step"""


class Sweep(msgspec.Struct, forbid_unknown_fields=True):
    """A robot for every combination of these values."""

    xacro_args: dict[Name, list[str | int | float | bool] | Range] = {}
    """xacro argument: its values, as a list or a range"""
    passes: dict[Name, dict[str, list[Any] | Range]] = {}
    """pass: its options, each with a list or a range of values"""


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
    """whether the base floats; auto: it does unless it is tied to 'world'"""
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, -9.81)
    """acceleration in base axes, m/s^2"""
    packages: Annotated[dict[Name, Name], _flag("--package NAME=DIR")] = {}
    """ROS package name: its directory"""
    xacro_args: Annotated[dict[Name, str], _flag("--arg NAME:=VALUE")] = {}
    """xacro argument: its value"""
    plugins: Annotated[list[Name], _flag("--plugin FILE.py")] = []
    """Python files that bring passes"""
    pipeline: Annotated[str | list[str], _flag("--pipeline PRESET")] = "faithful"
    """the name of a preset, or the passes in their order"""
    after: Annotated[dict[str, str | list[str]], _flag("--after PASS=NEW")] = {}
    """pass: the passes to put right after it"""
    before: dict[str, str | list[str]] = {}
    """pass: the passes to put right before it"""
    without: list[str] = []
    """passes to leave out"""
    alias: dict[Name, str] = {}
    """new name: the pass that it is, to run a pass twice"""
    swap: dict[str, str] = {}
    """pass: the plugin whose pass of the same name replaces it"""
    passes: Annotated[dict[str, dict[str, Any]], _flag("--set PASS.OPTION=VALUE")] = {}
    """pass: its options"""
    diagnostics: Annotated[dict[str, Level], _flag("--level CODE=LEVEL")] = {}
    """code of a warning, say: how much it weighs (error, warning, note or ignore)"""
    strict: Annotated[bool, _flag("--strict")] = False
    """warnings are errors"""
    trust_xacro: Annotated[bool, _flag("--trust-xacro")] = False
    """let the robot's xacro do whatever Python can, and read any file"""
    sweep: Sweep | None = None
    """make a family of robots, one for each combination"""


class Lines:
    """Where each value of a config file stands, for error messages."""

    def __init__(
        self,
        file: Path | None = None,
        lines: dict[Key, int] | None = None,
        folder: Path | None = None,
    ) -> None:
        self.file = file
        self.folder = folder or (file.parent if file else Path())
        """The paths in the config are relative to this folder."""
        self.faults: list[ConfigError] = []
        """What is wrong with the config, as far as it has been read; ``check`` raises it."""
        self.places = lines or {}

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
            said = [each for fault in before for each in (*fault.said, fault.diagnostic())]
            last.said = said + last.said
            raise last


def load(file: Path) -> tuple[Config, Lines]:
    """Read a config file; raises ConfigError if it is no config.

    Keys and values that are wrong are left out, and are faults of the lines.  Pipeline adds its
    own, so that a user reads them all at once.
    """
    try:
        text = files.read(file, MOST).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(
            "config-unreadable", f"cannot read the config: {reason}", file=str(file)
        ) from None
    if text.lstrip().startswith("<"):
        raise ConfigError(
            "config-yaml", "this is XML, such as a robot, and no config", file=str(file),
            hint=f"urdf2mbs init {file} writes a config for a robot; "
            f"urdf2mbs convert {file} needs none",
        )  # fmt: skip
    return parse(text, file)


def parse(text: str, file: Path | None) -> tuple[Config, Lines]:
    """What ``load`` gives, of a config's text."""
    from urdf2mbs.engine import yaml_text  # PyYAML: not for a robot without a config

    data, places = yaml_text.tree(text, file)
    lines = Lines(file, places)
    if not isinstance(data, dict):
        raise lines.error(
            "config-type", "a config is a list of 'key: value' lines, such as 'source: robot.urdf'"
        )
    return _read_fields(Config, data, lines, ()), lines


def from_values(values: Config | Mapping[str, Any], **more: Any) -> tuple[Config, Lines]:
    """The config of a call from Python: a path is a word, any sequence a list.

    Paths are relative to the working folder.  Raises ConfigError.
    """
    given = msgspec.structs.asdict(values) if isinstance(values, Config) else values
    lines = Lines()
    plain = msgspec.to_builtins({**given, **more}, enc_hook=_word_or_list, str_keys=True)
    return typed(Config, plain, lines), lines


def _word_or_list(value: Any) -> Any:
    if isinstance(value, PathLike):
        return fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    try:
        return list(value)
    except TypeError:
        raise ConfigError("config-type", f"a config holds no such thing: {value!r}") from None


def typed(kind: Any, data: Any, lines: Lines, at: Key = ()) -> Any:
    """``data`` as an instance of a Struct or dataclass; raises ConfigError naming the key."""
    own = Lines(lines.file, lines.places, lines.folder)
    value = _read_fields(kind, data, own, at)
    own.check()
    return value


def _read_fields(kind: Any, data: Any, lines: Lines, at: Key) -> Any:
    """``data`` as an instance of a class, without what is wrong, which becomes faults.

    A key that is nearly a known one is read as the known one.  Raises ConfigError if nothing can
    be read.
    """
    # msgspec takes long to tell the fields of a class, and only an error needs to know them
    with suppress(Exception):
        if data == {}:
            return kind()
        if data.keys() <= {*kind.__struct_encode_fields__}:
            return msgspec.convert(data, kind, strict=True)
    fields = _fields(kind)
    if not isinstance(data, dict):
        raise lines.error(
            "config-type", f"'{_dotted(at)}' wants 'key: value' lines, not {data!r}", at
        )
    data = deepcopy(data)
    for key in [key for key in data if key not in fields]:
        hint = nearest(str(key), fields) or f"known: {', '.join(fields) or 'no keys at all'}"
        lines.faults.append(
            lines.error("unknown-key", f"unknown key '{_dotted((*at, key))}'", (*at, key), hint)
        )
        _correct(data, key, fields)
    for name, field in fields.items():
        if field.required and name not in data:
            lines.faults.append(lines.error(
                "config-key-missing", f"'{_dotted((*at, name))}' must be given", at,
                f"add '{name}: ...'" + (f" under '{_dotted(at)}'" if at else ""),
            ))  # fmt: skip
    # one word where a list is wanted is a list of one
    data = {
        key: [value] if isinstance(value, str) and _is_list(fields[key].type) else value
        for key, value in data.items()
    }
    while all(name in data or not field.required for name, field in fields.items()):
        try:
            return msgspec.convert(data, kind, strict=True)
        except UnicodeEncodeError as error:  # half a letter, of a command line or a file's name
            raise lines.error("config-type", f"{error.object!r} is no text", at) from None
        except msgspec.ValidationError as error:
            lines.faults.append(_take_out(error, data, kind, lines, at))
    lines.check()
    return None


def _correct(block: dict[Any, Any], key: Any, known: Collection[str]) -> None:
    """Take an unknown key out of a block; its value goes to the key that is surely meant."""
    from difflib import get_close_matches

    value = block.pop(key)
    for close in get_close_matches(str(key), known, n=1, cutoff=0.75):
        block.setdefault(close, value)


def _take_out(
    error: msgspec.ValidationError, data: Any, kind: Any, lines: Lines, at: Key
) -> ConfigError:
    """What msgspec has against a value of ``data``, in our words; the value is taken out."""
    what, path = _place_of(error, data, kind)
    where: Key = (*at, *path)
    types = _types_at(msgspec.inspect.type_info(kind), path)
    hint = _choices(types, _inside(data, path))
    unknown = re.search("unknown field `(.*)`", what)
    if unknown:
        keys = [field.encode_name for kind in types for field in getattr(kind, "fields", ())]
        hint = nearest(unknown[1], keys) or f"known: {', '.join(keys)}"
        where = (*where, unknown[1])
        _correct(_inside(data, path), unknown[1], keys)
    number = next((each for each in types if isinstance(each, _NUMBERS)), None)
    if number is not None and " got " not in what:
        code = "value-range"
        said = f"'{_dotted(where)}' is {_inside(data, path)!r}: {in_words(number)} is wanted"
    else:
        code, said = "config-type", f"'{_dotted((*at, *path))}': {_plainly(what)}"
    fault = lines.error(code, said, where, hint)
    if not path and not unknown:  # a class that refuses its values together
        raise fault
    if not unknown:
        del data[path[0]]
    return fault


_NUMBERS = (msgspec.inspect.FloatType, msgspec.inspect.IntType)

#: The kinds of values: msgspec's word, and ours.
_KINDS = {
    "str": "a word",
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "array": "a list",
    "object": "a block of 'key: value' lines",
    "null": "nothing",
}


#: The message for an empty ``Name``.
_EMPTY = "is empty: write the name or the path that is meant"


def _plainly(what: str) -> str:
    """What msgspec says, in the words of a reader of YAML."""

    def kinds(match: re.Match[str]) -> str:
        return " or ".join(_KINDS.get(kind, kind) for kind in match[1].split(" | "))

    said = re.sub(r"contains unknown field `(.*)`", r"has the unknown key '\1'", what)
    said = re.sub(r"missing required field `(.*)`", r"must have the key '\1'", said)
    said = said.replace("Expected `str` of length >= 1", f"this {_EMPTY}")
    said = said.replace(": expected `str` of length >= 1", f" {_EMPTY}")
    said = re.sub(r"`([a-z |]+)`", kinds, said)
    begin = re.search("[Ee]xpected ", said)
    wanted, got, given = said[begin.end() :].rpartition(", got ") if begin else ("", "", "")
    if begin and got:
        said = f"{said[: begin.start()]}{wanted} is wanted, and this is {given}"
    said = re.sub(r"a list of length (\d+)", r"a list of \1", said)
    said = re.sub(r"^Invalid enum value '(.*)'$", r"'\1' is not one of its values", said)
    return said.replace("Object ", "this ")


def _choices(types: list[Any], value: Any) -> str | None:
    """The words that a value may be, for a hint."""
    words = [word for kind in types for word in getattr(kind, "values", ())]  # of a Literal
    close = nearest(value, words) if isinstance(value, str) else None
    said = f"it is one of: {', '.join(words)}" if words else None
    return f"{said}; {close}" if close else said


def _place_of(error: msgspec.ValidationError, data: Any, kind: type) -> tuple[str, Key]:
    """What msgspec says is wrong with ``data``, and the keys that lead to the wrong value.

    msgspec writes "..." for each key of a mapping.  So the keys whose removal does not change the
    error are removed: the key that remains is the wrong one.
    """
    what, path = _split(error)
    data = deepcopy(data)
    where: Key = ()
    for key in path:
        if key == "...":
            block = _inside(data, where)
            for name in list(block):
                value = block.pop(name)
                if str(_error(data, kind)) != str(error):
                    block[name] = value
            key = next(iter(block))
        where = (*where, key)
    return what, where


def _error(data: Any, kind: type) -> msgspec.ValidationError | None:
    try:
        msgspec.convert(data, kind, strict=True)
    except msgspec.ValidationError as error:
        return error
    return None


def _types_at(at: Any, path: Key) -> list[Any]:
    """The types that the value may have to which a path of keys leads."""
    if isinstance(at, msgspec.inspect.Metadata):
        return _types_at(at.type, path)
    if isinstance(at, msgspec.inspect.UnionType):
        return [kind for member in at.types for kind in _types_at(member, path)]
    if not path:
        return [at]
    key, rest = path[0], path[1:]
    if isinstance(at, msgspec.inspect.DictType):
        return _types_at(at.value_type, rest)
    if isinstance(at, msgspec.inspect.TupleType) and isinstance(key, int):
        return _types_at(at.item_types[key], rest)
    if isinstance(at, msgspec.inspect.ListType):
        return _types_at(at.item_type, rest)
    fields = (field for field in getattr(at, "fields", ()) if field.encode_name == key)
    return next((_types_at(field.type, rest) for field in fields), [])


def _split(error: msgspec.ValidationError) -> tuple[str, Key]:
    """What msgspec says, and the path that it gives; "..." stands for the key of a mapping."""
    what, _, path = str(error).partition(" - at `")
    if path.startswith("key` in `"):
        what = f"a key here: {what[0].lower()}{what[1:]}"
    words = re.findall(r"\.([^.\[`]+)|\[(\d+|\.\.\.)\]", path)
    return what, tuple(name or (int(at) if at.isdecimal() else at) for name, at in words)


def _inside(data: Any, path: Key) -> Any:
    for key in path:
        data = data[key]
    return data


@cache
def _fields(kind: type) -> dict[str, Any]:
    """The fields of a Struct or dataclass, by the names that they have in a config."""
    info: Any = msgspec.inspect.type_info(kind)
    return {field.encode_name: field for field in info.fields}


def _is_list(kind: Any) -> bool:
    if isinstance(kind, msgspec.inspect.Metadata):
        kind = kind.type
    return isinstance(kind, msgspec.inspect.ListType)


def _dotted(at: Key) -> str:
    return ".".join(str(key) for key in at) or "config"
