"""Make a family of robots from one config: one for each combination of the values of its sweep.

sweep:                                   keys                       values
  xacro_args: {height: [0.7, 0.8]}       (xacro_args, height)       0.7, 0.8
  passes: {check: {tolerance: [1e-8]}}   (passes, check, tolerance) 1e-8
"""

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

#: Maximum number of robots of one config.
MAX_ROBOTS = 1_000_000
#: Maximum distance between the last step of a range and its end, relative to a step.
_STEP_TOLERANCE = Decimal("1e-9")
#: ``{height}`` in a path.
_PLACEHOLDER = re.compile(r"\{([^{}]*)\}")
#: Characters that a value must not bring into the name of a file or folder: those that Windows
#: does not allow, at the end blanks and dots, and those that ``expand`` would replace.
_UNSAFE_CHARACTER = re.compile(r"[<>:\"/\\|?*$~%\x00-\x1f\x7f]|[ .](?=[ .]*$)")


class Member(NamedTuple):
    """One robot of a sweep."""

    config: Config
    values: dict[str, Any]
    """The values that the sweep gives it: xacro arguments by name, options as ``PASS.OPTION``."""


def list_members(config: Config, lines: Lines) -> list[Member]:
    """List the robots of a config: one without a sweep, else one for each combination.

    Args:
        config: The config.
        lines: Where its values come from.

    Returns:
        The robots, the last value of the sweep changing fastest.

    Raises:
        ConfigError: The config or its sweep is wrong.
    """
    lines.check()
    if config.sweep is None:
        return [Member(config, {})]
    swept_values = _list_swept_values(config, config.sweep, lines)
    members: list[Member] = []
    for combination in product(*swept_values.values()):
        values: dict[str, Any] = {}
        xacro_args: dict[str, Any] = {}
        passes: dict[str, dict[str, Any]] = {}
        for (section, *key), swept_value in zip(swept_values, combination, strict=True):
            values[".".join(key)] = swept_value
            options = xacro_args if section == "xacro_args" else passes.setdefault(key[0], {})
            options[key[-1]] = swept_value
        output = _fill_output(config, values, lines)
        robot_config, _ = config_of(
            config, xacro_args=xacro_args, passes=passes, output=output, sweep=None
        )
        members.append(Member(robot_config, values))
    return members


def _list_swept_values(
    config: Config, sweep: Sweep, lines: Lines
) -> dict[tuple[str, ...], list[Any]]:
    """List the values of a sweep by the keys of the config that they change."""
    given_values: dict[tuple[str, ...], list[Any] | Range] = {
        ("xacro_args", argument_name): values for argument_name, values in sweep.xacro_args.items()
    }
    for pass_name, options in sweep.passes.items():
        given_values |= {
            ("passes", pass_name, option_name): values for option_name, values in options.items()
        }
    if not given_values:
        hint = "give some: 'sweep: {xacro_args: {height: [0.7, 0.8]}}'"
        raise lines.error("sweep-empty", "the sweep has no values", ("sweep",), hint)
    swept_values: dict[tuple[str, ...], list[Any]] = {}
    for key, values in given_values.items():
        sweep_key = ("sweep", *key)
        if key[-1] in (config.xacro_args if len(key) == 2 else config.passes.get(key[1], {})):
            message = f"'{dotted(key)}' has a value, and the sweep gives it others"
            raise lines.error("sweep-twice", message, sweep_key, "remove one of the two")
        swept_values[key] = (
            values if isinstance(values, list) else _list_numbers(values, lines, sweep_key)
        )
        if not swept_values[key]:
            raise lines.error("sweep-empty", f"'{dotted(sweep_key)}' has no values", sweep_key)
        if key[0] == "xacro_args":
            swept_values[key] = [str(value) for value in swept_values[key]]
    _check_count(prod(map(len, swept_values.values())), lines, ("sweep",))
    return swept_values


def format_values(values: dict[str, Any]) -> str:
    """Format values for a message: ``height=0.7, arms=true``."""
    return ", ".join(f"{name}={_format_value(value)}" for name, value in values.items())


def _format_value(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _format_placeholders(keys: Iterable[str]) -> str:
    return "-".join(f"{{{key}}}" for key in keys)


# --- ranges ---


def _list_numbers(number_range: Range, lines: Lines, key: Key) -> list[int] | list[float]:
    """List the numbers of a range, both ends included.

    They are computed in decimals: 0.7, 0.8, 0.9, and not 0.7999999999999999.
    """
    first, last = Decimal(str(number_range.first)), Decimal(str(number_range.last))
    step, count = Decimal(str(number_range.step or 0)), number_range.count or 0
    if count > 1 and number_range.step is None:
        step = (last - first) / (count - 1)
    elif step and not count and (last - first) / step >= 0:
        count = _count_steps(first, last, step, lines, key) + 1
    else:
        message = (
            "expected a range with 'from', 'to', and either a 'step' that leads from one to the "
            "other or a 'count' of 2 or more"
        )
        raise lines.error("sweep-range", message, key, "such as {from: 0.7, to: 0.9, step: 0.1}")
    _check_count(count, lines, key)
    is_integer = isinstance(number_range.first, int) and isinstance(number_range.step, int)
    numbers = [(int if is_integer else float)(first + step * index) for index in range(count)]
    if not is_integer:  # the last step may miss the end by a digit
        numbers[-1] = float(last)
    return numbers


def _count_steps(first: Decimal, last: Decimal, step: Decimal, lines: Lines, key: Key) -> int:
    """Count the steps from one end of a range to the other.

    Raises:
        ConfigError: The steps do not end at the other end.
    """
    ratio = (last - first) / step
    count = int(ratio.to_integral_value())
    if abs(ratio - count) > _STEP_TOLERANCE:
        reached = first + step * int(ratio)
        message = f"the steps of {step} from {first} do not end at {last}, but at {reached}"
        even_count_hint = f"'count: {max(count, 1) + 1}' instead of 'step' divides the range evenly"
        hint = f"'to: {reached}' ends at a step; {even_count_hint}"
        raise lines.error("sweep-range", message, key, hint)
    return count


def _check_count(n_robots: int, lines: Lines, key: Key) -> None:
    """Raise ConfigError for more robots than one config may have."""
    if n_robots > MAX_ROBOTS:
        message = f"the sweep makes {n_robots} robots; expected {MAX_ROBOTS} or fewer"
        raise lines.error("sweep-long", message, key)


# --- output ---


def _fill_output(config: Config, values: dict[str, Any], lines: Lines) -> str | Project:
    """Return the output of one robot: the output of the config with the robot's values."""
    output = config.output
    if output is None:
        hint = f"add one, such as 'output: models/{_format_placeholders(values)}.mbs'"
        raise lines.error("sweep-output", "a sweep requires an output", ("sweep",), hint)
    if not isinstance(output, Project):
        return _fill_path(output, values, lines)
    project_path = Path(_fill_path(output.project, values, lines))
    if _PLACEHOLDER.search(Path(output.project).name):  # a project has the name of its model
        project_path = project_path.with_name(identifiers([project_path.name])[0])
    return msgspec.structs.replace(output, project=str(project_path))


def _fill_path(output_path: str, values: dict[str, Any], lines: Lines) -> str:
    """Replace the placeholders of a path by values; a value is a part of one name."""

    def get_value(placeholder: re.Match[str]) -> str:
        value_name = placeholder[1]
        if value_name not in values:
            message = f"'{{{value_name}}}' in the output is not a value of the sweep"
            hint = nearest(value_name, values) or f"values: {_format_placeholders(values)}"
            raise lines.error("sweep-output", message, ("output",), hint)
        value_text = _UNSAFE_CHARACTER.sub("_", _format_value(values[value_name]))
        return value_text if is_portable(value_text) else f"_{value_text}"

    filled_path = _PLACEHOLDER.sub(get_value, expand(output_path, lines, ("output",)))
    return f"./{filled_path}" if filled_path.startswith("~") else filled_path
