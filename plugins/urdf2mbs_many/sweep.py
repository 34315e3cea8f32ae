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

from urdf2mbs.plugin import (
    Config,
    Key,
    Lines,
    Project,
    Range,
    Sweep,
    config_of,
    dotted,
    expand,
    identifiers,
    is_portable,
    nearest,
)

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
    swept = _swept(config, config.sweep, lines)
    found: list[Member] = []
    for combination in product(*swept.values()):
        own: dict[str, Any] = {}
        xacro_args: dict[str, Any] = {}
        passes: dict[str, dict[str, Any]] = {}
        for (block, *key), value in zip(swept, combination, strict=True):
            own[".".join(key)] = value
            options = xacro_args if block == "xacro_args" else passes.setdefault(key[0], {})
            options[key[-1]] = value
        output = _output(config, own, lines)
        robot, _ = config_of(
            config, xacro_args=xacro_args, passes=passes, output=output, sweep=None
        )
        found.append(Member(robot, own))
    return found


def _swept(config: Config, sweep: Sweep, lines: Lines) -> dict[tuple[str, ...], list[Any]]:
    """The values of each key of a config that a sweep changes."""
    given: dict[tuple[str, ...], list[Any] | Range] = {
        ("xacro_args", name): values for name, values in sweep.xacro_args.items()
    }
    for pass_, options in sweep.passes.items():
        given |= {("passes", pass_, option): values for option, values in options.items()}
    if not given:
        raise lines.error(
            "sweep-empty", "the sweep has no values", ("sweep",),
            "such as 'sweep: {xacro_args: {height: [0.7, 0.8]}}'",
        )  # fmt: skip
    swept: dict[tuple[str, ...], list[Any]] = {}
    for key, values in given.items():
        at = ("sweep", *key)
        if key[-1] in (config.xacro_args if len(key) == 2 else config.passes.get(key[1], {})):
            raise lines.error(
                "sweep-twice", f"'{dotted(key)}' has a value, and the sweep gives it others",
                at, "leave one of the two out",
            )  # fmt: skip
        swept[key] = values if isinstance(values, list) else _numbers(values, lines, at)
        if not swept[key]:
            raise lines.error("sweep-empty", f"'{dotted(at)}' has no values", at)
        if key[0] == "xacro_args":
            swept[key] = [str(value) for value in swept[key]]
    _check_count(prod(map(len, swept.values())), lines, ("sweep",))
    return swept


def in_words(values: dict[str, Any]) -> str:
    """``height=0.7, arms=true``."""
    return ", ".join(f"{name}={_word(value)}" for name, value in values.items())


def _word(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _names(keys: Iterable[str]) -> str:
    return "-".join(f"{{{key}}}" for key in keys)


def _numbers(given: Range, lines: Lines, at: Key) -> list[int] | list[float]:
    """Return the numbers of a range, both ends among them.

    They are computed in decimals: 0.7, 0.8, 0.9, and no 0.7999999999999999.
    """
    first, last = Decimal(str(given.first)), Decimal(str(given.last))
    step, count = Decimal(str(given.step or 0)), given.count or 0
    if count > 1 and given.step is None:
        step = (last - first) / (count - 1)
    elif step and not count and (last - first) / step >= 0:
        count = _count_steps(first, last, step, lines, at) + 1
    else:
        message = "these numbers are no range"
        hint = (
            "a range has 'from', 'to', and a 'step' that leads there, or a 'count' of 2 or more: "
            "{from: 0.7, to: 0.9, step: 0.1}"
        )
        raise lines.error("sweep-range", message, at, hint)
    _check_count(count, lines, at)
    whole = isinstance(given.first, int) and isinstance(given.step, int)
    numbers = [(int if whole else float)(first + step * n) for n in range(count)]
    if not whole:  # the steps may miss the end by their last digit
        numbers[-1] = float(last)
    return numbers


#: How far the steps of a range may end from its end, relative to a step.
_MISSED = Decimal("1e-9")


def _count_steps(first: Decimal, last: Decimal, step: Decimal, lines: Lines, at: Key) -> int:
    """Return the number of steps that lead from one end of a range to the other.

    Raises:
        ConfigError: The steps do not end at the other end.
    """
    ratio = (last - first) / step
    count = int(ratio.to_integral_value())
    if abs(ratio - count) > _MISSED:
        reached = first + step * int(ratio)
        message = f"the steps of {step} from {first} do not end at {last}, but at {reached}"
        evenly = f"'count: {max(count, 1) + 1}' instead of 'step' divides the range evenly"
        hint = f"'to: {reached}' ends at a step; {evenly}"
        raise lines.error("sweep-range", message, at, hint)
    return count


def _check_count(count: int, lines: Lines, at: Key) -> None:
    if count > MOST:
        raise lines.error("sweep-long", f"this makes {count} robots, and {MOST} are the most", at)


def _output(config: Config, values: dict[str, Any], lines: Lines) -> str | Project:
    """The output of one robot, with its values put in."""

    def value(found: re.Match[str]) -> str:
        if found[1] not in values:
            raise lines.error(
                "sweep-output",
                f"'{{{found[1]}}}' in the output is no value of the sweep",
                ("output",), nearest(found[1], values) or f"there are: {_names(values)}",
            )  # fmt: skip
        # a value is a part of one name: it leads to no other folder, and names no variable
        return _portable(_UNSAFE.sub("_", _word(values[found[1]])))

    def fill(output: str) -> str:
        path = _PLACE.sub(value, expand(output, lines, ("output",)))
        return f"./{path}" if path.startswith("~") else path

    output = config.output
    if output is None:
        raise lines.error(
            "sweep-output", "a sweep needs an output", ("sweep",),
            f"such as 'output: models/{_names(values)}.mbs'",
        )  # fmt: skip
    if not isinstance(output, Project):
        return fill(output)
    path = Path(fill(output.project))
    if _PLACE.search(Path(output.project).name):  # a project is called as its model is
        path = path.with_name(identifiers([path.name])[0])
    return msgspec.structs.replace(output, project=str(path))


def _portable(name: str) -> str:
    """A name of a file or folder, so that every system has it and it is no other folder."""
    name = re.sub(r"[ .]+$", lambda end: "_" * len(end[0]), name)
    return name if is_portable(name) else f"_{name}"
