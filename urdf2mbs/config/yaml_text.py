"""Parses the YAML of a config, with the line of each value, and explains what is not YAML."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import msgspec
import yaml

from urdf2mbs.config.lines import Key
from urdf2mbs.messages.diagnostics import ConfigError


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """PyYAML's loader, for which 1e-9 is a number, too, as in YAML 1.2 (PyYAML: only 1.0e-9)."""


Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+\Z"), list("-+0123456789")
)

_TEXT = "tag:yaml.org,2002:str"

#: The most lists and blocks inside one another.
MAX_DEPTH = 100
#: The most values, with every alias written out.
MAX_VALUES = 100_000

_TOO_MANY = f"it has more than {MAX_VALUES} values, or more than {MAX_DEPTH} lists in one another"


class _Explanation(msgspec.Struct, frozen=True):
    """How a message of PyYAML is explained."""

    pattern: str
    """What the message of PyYAML contains."""
    reason: str
    hint: str | None = None


_EXPLANATIONS = [
    _Explanation("nesting depth", _TOO_MANY),  # libyaml 0.2.6 and later limits it, too
    _Explanation("'\\\\t'|tab character", "there is a tab character", "indent by blanks"),
    _Explanation("undefined alias", "a word begins with '*'", "write it in quotes"),
    _Explanation("constructor", "a value begins with '!'", "write it in quotes"),
    _Explanation("another document", "a line '---' begins a second config", "keep one of the two"),
    _Explanation("quoted scalar", "a quote is not closed", "close it"),
    _Explanation(
        "flow (mapping|sequence|node)",
        "a bracket is not closed, or a comma is missing",
        "look for [ and { in this line and before it",
    ),
    _Explanation(
        "mapping values are not allowed", "a second ':' in one line", "write the value in quotes"
    ),
    _Explanation("could not find expected ':'", "this line has no ':'", "write 'key: value'"),
    _Explanation(
        "block (mapping|collection|sequence)",
        "this line does not continue the lines before it",
        "look at its indentation",
    ),
]


def parse_value(text: str) -> Any:
    """Return a value of a command line: what it means as YAML, or the text itself."""
    try:
        return parse_yaml(text, None)[0]
    except ConfigError:
        return text


def parse_yaml(text: str, file: Path | None) -> tuple[Any, dict[Key, int]]:
    """Return the data of a YAML text, and the line of each value.

    Raises:
        ConfigError: ``config-yaml`` or ``config-key-doubled``.
    """
    name = str(file) if file else None
    try:
        if len(text) > 20 * MAX_DEPTH:
            _check_depth(text)
        loader = Loader(text)
        root = loader.get_single_node()
        if root is None:
            return None, {}
        lines = _find_lines(root, name)
        return loader.construct_document(root), lines
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        message = " ".join(part for part in (error.context, error.problem) if part)
        matching = (each for each in _EXPLANATIONS if re.search(each.pattern, message))
        explanation = next(matching, _Explanation("", message))
        raise ConfigError(
            "config-yaml",
            f"this is not YAML: {explanation.reason}",
            file=name,
            line=mark.line + 1 if mark else None,
            hint=explanation.hint,
        ) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ConfigError("config-yaml", f"this is not YAML: {error}", file=name) from None


def _check_depth(text: str) -> None:
    """Raise YAMLError for lists too deep in one another, which would crash PyYAML's C code."""
    depth = 0
    for event in yaml.parse(text, Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            raise _too_many(event)


def _too_many(position: yaml.Node | yaml.Event) -> yaml.MarkedYAMLError:
    mark: Any = position.start_mark
    return yaml.MarkedYAMLError(problem=_TOO_MANY, problem_mark=mark)


def _find_lines(root: yaml.Node, file: str | None) -> dict[Key, int]:
    """Return the line of each value; keep arguments as they are written, and refuse doubled keys.

    An alias is followed each time that it occurs, so that an alias of itself is too deep.
    """
    lines: dict[Key, int] = {}
    pending: list[tuple[yaml.Node, Key]] = [(root, ())]
    while pending:
        node, key = pending.pop()
        lines.setdefault(key, node.start_mark.line + 1)
        if len(lines) > MAX_VALUES or len(key) > MAX_DEPTH:
            raise _too_many(node)
        if isinstance(node, yaml.SequenceNode):
            pending += [(value, (*key, index)) for index, value in enumerate(node.value)]
        for name, value in node.value if isinstance(node, yaml.MappingNode) else ():
            inner = (*key, str(name.value))
            line = name.start_mark.line + 1
            if inner in lines:
                message = f"'{'.'.join(map(str, inner))}' is there twice"
                raise ConfigError("config-key-doubled", message, file=file, line=line)
            lines[inner] = line
            if len(key) < 3 and isinstance(name, yaml.ScalarNode) and name.value != "<<":
                name.tag = _TEXT  # 'on' and '1' are names, too
            if key in (("xacro_args",), ("sweep", "xacro_args")):
                _keep_as_text(value)
            pending.append((value, inner))
    return lines


def _keep_as_text(node: yaml.Node) -> None:
    """Keep the value of an argument as it is written: ``hand: false``, ``mass: 1.50``."""
    for value in node.value if isinstance(node, yaml.SequenceNode) else [node]:
        if isinstance(value, yaml.ScalarNode):
            value.tag = _TEXT
