"""A family of robots from one config: one for each combination of the values of its ``sweep``."""

from __future__ import annotations

import re
from decimal import Decimal
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from urdf2mbs.disk.files import one_name, portable
from urdf2mbs.engine.config import Config, Key, Lines, Project, Range
from urdf2mbs.engine.settings import expand
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.messages.diagnostics import ConfigError, nearest

#: The most robots of one config.
MOST = 1_000_000

#: ``{height}`` in a path.
_PLACE = re.compile(r"\{([^{}]*)\}")

#: What a value may not bring into a name: what no name has on Windows, and what is expanded.
_UNSAFE = re.compile(r"[<>:\"/\\|?*$~%\x00-\x1f\x7f]")


class Member(NamedTuple):
    """One robot of a sweep."""

    config: Config
    values: dict[str, Any]
    """Its own values: xacro arguments by name, options as ``PASS.OPTION``."""


def members(config: Config, lines: Lines) -> list[Member]:
    """The robots that a config stands for, the last value of its sweep changing fastest.

    Without a sweep it stands for one.  Raises ConfigError.
    """
    lines.check()
    sweep = config.sweep
    if sweep is None:
        return [Member(config, {})]
    args = {
        name: [str(value) for value in _values(given, lines, ("sweep", "xacro_args", name))]
        for name, given in sweep.xacro_args.items()
    }
    options = {
        (pass_, option): _values(given, lines, ("sweep", "passes", pass_, option))
        for pass_, block in sweep.passes.items()
        for option, given in block.items()
    }
    lists: list[list[Any]] = [*args.values(), *options.values()]
    if not lists:
        raise lines.error(
            "sweep-empty", "the sweep has no values", ("sweep",),
            "such as 'sweep: {xacro_args: {height: [0.7, 0.8]}}'",
        )  # fmt: skip
    count = 1
    for values in lists:
        count *= len(values)
    if count > MOST:
        raise lines.error(
            "sweep-long", f"the sweep makes {count} robots, and {MOST} are the most", ("sweep",)
        )
    for name in args:
        if name in config.xacro_args:
            raise _twice(f"xacro_args.{name}", lines, ("sweep", "xacro_args", name))
    for pass_, option in options:
        if option in config.passes.get(pass_, {}):
            raise _twice(f"passes.{pass_}.{option}", lines, ("sweep", "passes", pass_, option))
    keys = [*args, *(".".join(key) for key in options)]
    found: list[Member] = []
    taken: dict[str, dict[str, Any]] = {}
    for combination in product(*lists):
        own = dict(zip(keys, combination, strict=True))
        passes = {name: dict(block) for name, block in config.passes.items()}
        for (pass_, option), value in zip(options, combination[len(args) :], strict=True):
            passes.setdefault(pass_, {})[option] = value
        output, place = _output(config, own, lines)
        before = taken.setdefault(one_name(place), own)
        if before is not own:
            raise lines.error(
                "sweep-output",
                f"two robots of the sweep would be written to '{place}': {in_words(before)}, "
                f"and {in_words(own)}",
                ("output",),
                f"name each by its values, such as 'output: models/{_names(keys)}.mbs'",
            )
        config_of_one = msgspec.structs.replace(
            config,
            output=output,
            sweep=None,
            passes=passes,
            xacro_args={**config.xacro_args, **dict(zip(args, combination, strict=False))},
        )
        found.append(Member(config_of_one, own))
    return found


def in_words(values: dict[str, Any]) -> str:
    """``height=0.7, arms=true``."""
    return ", ".join(f"{name}={_word(value)}" for name, value in values.items())


def _word(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _names(keys: list[str]) -> str:
    return "-".join(f"{{{key}}}" for key in keys)


def _twice(what: str, lines: Lines, at: Key) -> ConfigError:
    return lines.error(
        "sweep-twice", f"'{what}' has a value, and the sweep gives it others", at,
        "leave one of the two out",
    )  # fmt: skip


def _values(given: list[Any] | Range, lines: Lines, at: Key) -> list[Any]:
    values = given if isinstance(given, list) else _in_range(given, lines, at)
    if not values:
        raise lines.error("sweep-empty", f"'{'.'.join(map(str, at))}' has no values", at)
    return values


def _in_range(given: Range, lines: Lines, at: Key) -> list[int | float]:
    """The numbers of a range, in decimals: 0.7, 0.8, 0.9, and no 0.7999999999999999."""
    first, last = Decimal(str(given.first)), Decimal(str(given.last))
    if (given.step is None) == (given.count is None) or not (first + last).is_finite():
        raise lines.error(
            "sweep-range", "a range has 'from', 'to', and one of 'step' and 'count'", at,
            "such as {from: 0.7, to: 0.9, step: 0.1}",
        )  # fmt: skip
    if given.count is not None:
        if given.count < 2:
            raise lines.error("sweep-range", f"'count' is {given.count}, and not 2 or more", at)
        step = (last - first) / (given.count - 1)
        count = given.count
        whole = False
    else:
        step = Decimal(str(given.step))
        if not step.is_finite() or step == 0 or (last - first) / step < 0:
            raise lines.error(
                "sweep-range", f"no steps of {given.step} lead from {given.first} to {given.last}",
                at,
            )  # fmt: skip
        count = int((last - first) / step) + 1
        whole = all(isinstance(number, int) for number in (given.first, given.step))
    if count > MOST:
        raise lines.error("sweep-long", f"the range has {count} values, and {MOST} are most", at)
    numbers = [first + step * n for n in range(count)]
    return [int(number) for number in numbers] if whole else [float(number) for number in numbers]


def _output(config: Config, values: dict[str, Any], lines: Lines) -> tuple[Any, str]:
    """The output of one robot, its values put in, and the path that it is."""

    def value(found: re.Match[str]) -> str:
        if found[1] not in values:
            raise lines.error(
                "sweep-output",
                f"'{{{found[1]}}}' in the output is no value of the sweep",
                ("output",),
                nearest(found[1], values) or f"there are: {_names(list(values))}",
            )
        # a value is a word: it leads to no other folder, and names no variable
        return _UNSAFE.sub("_", _word(values[found[1]]))

    def name_path(output: str) -> str:
        """Each name in the path that has values, as every system has it."""
        names = re.split(r"([/\\])", expand(output, lines, ("output",)))
        return "".join(
            portable(_PLACE.sub(value, name).replace("~", "_")) if _PLACE.search(name) else name
            for name in names
        )

    output = config.output
    if isinstance(output, Project):
        path = Path(name_path(output.project))
        if _PLACE.search(Path(output.project).name):  # a project is called as its model is
            path = path.with_name(identifiers([path.name])[0])
        return msgspec.structs.replace(output, project=str(path)), str(path)
    if output is None:
        raise lines.error(
            "sweep-output", "a sweep needs an output", ("sweep",),
            f"such as 'output: models/{_names(list(values))}.mbs'",
        )  # fmt: skip
    place = name_path(output)
    return place, place
