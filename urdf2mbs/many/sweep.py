"""A family of robots from one config: one for each combination of the values of its ``sweep``."""

from __future__ import annotations

import re
from collections.abc import Iterable
from decimal import Decimal
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from urdf2mbs.disk.files import one_name, portable
from urdf2mbs.engine.config import (
    Config,
    Key,
    Lines,
    Project,
    Range,
    Sweep,
    config_of,
    dotted,
)
from urdf2mbs.engine.settings import expand
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.messages.diagnostics import nearest

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
    if config.sweep is None:
        return [Member(config, {})]
    values = _swept(config, config.sweep, lines)
    found: list[Member] = []
    taken: dict[str, dict[str, Any]] = {}
    for combination in product(*values.values()):
        own: dict[str, Any] = {}
        changed: dict[str, Any] = {"xacro_args": {}, "passes": {}}
        for (block, *key), value in zip(values, combination, strict=True):
            own[".".join(key)] = value
            inner = changed[block].setdefault(key[0], {}) if block == "passes" else changed[block]
            inner[key[-1]] = value
        output, place = _output(config, own, lines)
        before = taken.setdefault(one_name(place), own)
        if before is not own:
            raise lines.error(
                "sweep-output",
                f"two robots of the sweep would be written to '{place}': {in_words(before)}, "
                f"and {in_words(own)}",
                ("output",), f"name each by its values, such as 'models/{_names(own)}.mbs'",
            )  # fmt: skip
        robot, _ = config_of(config, **changed, output=output, sweep=None)
        found.append(Member(robot, own))
    return found


def _swept(config: Config, sweep: Sweep, lines: Lines) -> dict[tuple[str, ...], list[Any]]:
    """The values of each key of a config that a sweep changes."""
    given: dict[tuple[str, ...], Any] = {
        ("xacro_args", name): one for name, one in sweep.xacro_args.items()
    }
    for pass_, options in sweep.passes.items():
        given |= {("passes", pass_, option): one for option, one in options.items()}
    if not given:
        raise lines.error(
            "sweep-empty", "the sweep has no values", ("sweep",),
            "such as 'sweep: {xacro_args: {height: [0.7, 0.8]}}'",
        )  # fmt: skip
    values: dict[tuple[str, ...], list[Any]] = {}
    for key, one in given.items():
        block, at = key[0], ("sweep", *key)
        if key[-1] in (config.xacro_args if len(key) == 2 else config.passes.get(key[1], {})):
            raise lines.error(
                "sweep-twice", f"'{dotted(key)}' has a value, and the sweep gives it others",
                at, "leave one of the two out",
            )  # fmt: skip
        values[key] = one if isinstance(one, list) else _in_range(one, lines, at)
        if not values[key]:
            raise lines.error("sweep-empty", f"'{dotted(at)}' has no values", at)
        if block == "xacro_args":
            values[key] = [str(value) for value in values[key]]
    count = prod(map(len, values.values()))
    if count > MOST:
        raise lines.error(
            "sweep-long", f"the sweep makes {count} robots, and {MOST} are the most", ("sweep",)
        )
    return values


def in_words(values: dict[str, Any]) -> str:
    """``height=0.7, arms=true``."""
    return ", ".join(f"{name}={_word(value)}" for name, value in values.items())


def _word(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _names(keys: Iterable[str]) -> str:
    return "-".join(f"{{{key}}}" for key in keys)


def _in_range(given: Range, lines: Lines, at: Key) -> list[int | float]:
    """The numbers of a range, in decimals: 0.7, 0.8, 0.9, and no 0.7999999999999999."""
    first, last = Decimal(str(given.first)), Decimal(str(given.last))
    step = count = None
    if given.count is not None and given.count >= 2 and given.step is None:
        step, count = (last - first) / (given.count - 1), given.count
    elif given.step and given.count is None and (last - first) / Decimal(str(given.step)) >= 0:
        step = Decimal(str(given.step))
        count = int((last - first) / step) + 1
    if step is None or count is None:
        raise lines.error(
            "sweep-range", "these numbers are no range", at,
            "a range has 'from', 'to', and a 'step' that leads there, or a 'count' of 2 or more: "
            "{from: 0.7, to: 0.9, step: 0.1}",
        )  # fmt: skip
    if count > MOST:
        raise lines.error("sweep-long", f"the range has {count} values, and {MOST} are most", at)
    whole = given.count is None and all(isinstance(n, int) for n in (given.first, given.step))
    numbers = [first + step * n for n in range(count)]
    return [int(number) for number in numbers] if whole else [float(number) for number in numbers]


def _output(config: Config, values: dict[str, Any], lines: Lines) -> tuple[Any, str]:
    """The output of one robot, its values put in, and the path that it is."""

    def value(found: re.Match[str]) -> str:
        if found[1] not in values:
            raise lines.error(
                "sweep-output",
                f"'{{{found[1]}}}' in the output is no value of the sweep",
                ("output",), nearest(found[1], values) or f"there are: {_names(values)}",
            )  # fmt: skip
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
            f"such as 'output: models/{_names(values)}.mbs'",
        )  # fmt: skip
    place = name_path(output)
    return place, place
