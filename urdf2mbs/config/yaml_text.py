"""Parses the YAML of a config, with the line of each value."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from urdf2mbs.config.lines import Key
from urdf2mbs.messages.diagnostics import ConfigError


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """PyYAML's loader, for which 1e-9 is a number, too, as in YAML 1.2 (PyYAML: only 1.0e-9)."""


Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+\Z"), list("-+0123456789")
)

_TEXT_TAG = "tag:yaml.org,2002:str"

#: The most lists and blocks inside one another.
MAX_DEPTH = 100
#: The most values, with every alias written out.
MAX_VALUES = 100_000

_TOO_MANY = f"it has more than {MAX_VALUES} values, or more than {MAX_DEPTH} lists in one another"


def parse_value(value_text: str) -> Any:
    """Return a value of a command line, parsed as YAML; the text itself if it is not YAML."""
    try:
        return parse_yaml(value_text, None)[0]
    except ConfigError:
        return value_text


def parse_yaml(yaml_text: str, yaml_file: Path | None) -> tuple[Any, dict[Key, int]]:
    """Return the data of a YAML text, and the line of each value.

    Raises:
        ConfigError: ``config-yaml`` or ``config-key-doubled``.
    """
    file_name = str(yaml_file) if yaml_file else None
    try:
        if len(yaml_text) > 20 * MAX_DEPTH:
            _check_depth(yaml_text)
        loader = Loader(yaml_text)
        root_node = loader.get_single_node()
        if root_node is None:
            return None, {}
        lines_by_key = _find_lines(root_node, file_name)
        return loader.construct_document(root_node), lines_by_key
    except yaml.MarkedYAMLError as error:
        from urdf2mbs.config.yaml_errors import explain

        line, fault = explain(error, yaml_text)
        # libyaml 0.2.6 and later limits the depth, too
        reason = _TOO_MANY if "nesting depth" in str(error) else fault.reason
        message = f"this is not YAML: {reason}"
        raise ConfigError(
            "config-yaml", message, file=file_name, line=line, hint=fault.hint
        ) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ConfigError("config-yaml", f"this is not YAML: {error}", file=file_name) from None


def _check_depth(yaml_text: str) -> None:
    """Raise YAMLError for lists too deep in one another, which would crash PyYAML's C code."""
    nesting_depth = 0
    for event in yaml.parse(yaml_text, Loader):
        nesting_depth += isinstance(event, yaml.CollectionStartEvent)
        nesting_depth -= isinstance(event, yaml.CollectionEndEvent)
        if nesting_depth > MAX_DEPTH:
            raise _too_many_error(event)


def _too_many_error(position: yaml.Node | yaml.Event) -> yaml.MarkedYAMLError:
    start_mark: Any = position.start_mark
    return yaml.MarkedYAMLError(problem=_TOO_MANY, problem_mark=start_mark)


def _find_lines(root_node: yaml.Node, file_name: str | None) -> dict[Key, int]:
    """Return the line of each value; keep arguments as they are written, and refuse doubled keys.

    An alias is followed each time that it occurs, so that an alias of itself is too deep.
    """
    lines_by_key: dict[Key, int] = {}
    pending: list[tuple[yaml.Node, Key]] = [(root_node, ())]
    while pending:
        node, node_key = pending.pop()
        _check_value(node, file_name)
        lines_by_key.setdefault(node_key, node.start_mark.line + 1)
        if len(lines_by_key) > MAX_VALUES or len(node_key) > MAX_DEPTH:
            raise _too_many_error(node)
        if isinstance(node, yaml.SequenceNode):
            pending += [
                (value_node, (*node_key, index)) for index, value_node in enumerate(node.value)
            ]
        for key_node, value_node in node.value if isinstance(node, yaml.MappingNode) else ():
            inner_key = (*node_key, str(key_node.value))
            key_line = key_node.start_mark.line + 1
            if inner_key in lines_by_key:
                message = f"'{'.'.join(map(str, inner_key))}' is there twice"
                raise ConfigError("config-key-doubled", message, file=file_name, line=key_line)
            lines_by_key[inner_key] = key_line
            if (
                len(node_key) < 3
                and isinstance(key_node, yaml.ScalarNode)
                and key_node.value != "<<"
            ):
                key_node.tag = _TEXT_TAG  # 'on' and '1' are names, too
            if node_key in (("xacro_args",), ("sweep", "xacro_args")):
                _keep_as_text(value_node)
            pending.append((value_node, inner_key))
    return lines_by_key


def _check_value(node: yaml.Node, file_name: str | None) -> None:
    """Raise ConfigError for a value that goes on in the next line, which was meant as an item."""
    start, end = node.start_mark, node.end_mark
    if isinstance(node, yaml.ScalarNode) and not node.style and end.line > start.line:
        value, dash, item = str(node.value).partition(" - ")
        if dash:
            message = (
                f"line {start.line + 2} ('- {item}') is further in than line {start.line + 1}, and "
                f"so goes on with its value '{value}'"
            )
            hint = "indent all items of a list alike, below a key without a value"
            raise ConfigError(
                "config-yaml", message, file=file_name, line=start.line + 2, hint=hint
            )


def _keep_as_text(argument_node: yaml.Node) -> None:
    """Keep the value of an argument as it is written: ``hand: false``, ``mass: 1.50``."""
    for value_node in (
        argument_node.value if isinstance(argument_node, yaml.SequenceNode) else [argument_node]
    ):
        if isinstance(value_node, yaml.ScalarNode):
            value_node.tag = _TEXT_TAG
