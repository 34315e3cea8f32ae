"""The YAML of a config, with the line of every value, and what is wrong with it in plain words."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from urdf2mbs.messages.diagnostics import ConfigError


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """PyYAML's own, but 1e-9 is a number, as YAML 1.2 has it; PyYAML wants 1.0e-9."""


Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+\Z"), list("-+0123456789")
)

_TEXT = "tag:yaml.org,2002:str"

#: The keys, and positions in lists, that lead to a value.
Key = tuple[str | int, ...]

#: The most lists and blocks in one another, and the most values with every alias written out.
DEEPEST, LONGEST = 100, 100_000

_TOO_MANY = f"it has more than {LONGEST} values, or more than {DEEPEST} lists in one another"

#: What PyYAML says, what we say of it, and what to do.
_YAML: list[tuple[str, str, str | None]] = [
    ("nesting depth", _TOO_MANY, None),  # libyaml 0.2.6 and later counts, too
    ("'\\\\t'|tab character", "there is a tab character", "indent by blanks"),
    ("undefined alias", "a word begins with '*'", "write it in quotes"),
    ("constructor", "a value begins with '!'", "write it in quotes"),
    ("another document", "a line '---' begins a second config", "keep one of the two"),
    ("quoted scalar", "a quote is not closed", "close it"),
    ("flow (mapping|sequence|node)", "a bracket is not closed, or a comma is missing",
     "look for [ and { in this line and before it"),
    ("mapping values are not allowed", "a second ':' in one line", "write the value in quotes"),
    ("could not find expected ':'", "this line has no ':'", "write 'key: value'"),
    ("block (mapping|collection|sequence)", "this line does not continue the lines before it",
     "look at its indentation"),
]  # fmt: skip


def word(text: str) -> Any:
    """A value given on the command line: YAML where it is YAML, else the text itself."""
    try:
        return tree(text, None)[0]
    except ConfigError:
        return text


def tree(text: str, file: Path | None) -> tuple[Any, dict[Key, int]]:
    """The data, and the line of each value; raises ConfigError."""
    try:
        if len(text) > 20 * DEEPEST:
            _check_depth(text)
        loader = Loader(text)
        node = loader.get_single_node()
        if node is None:
            return None, {}
        lines = _find_lines(node, file)
        return loader.construct_document(node), lines
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        message = " ".join(part for part in (error.context, error.problem) if part)
        reason, hint = next(
            (said for pattern, *said in _YAML if re.search(pattern, message)), (message, None)
        )
        raise ConfigError(
            "config-yaml", f"this is not YAML: {reason}", file=str(file) if file else None,
            line=mark.line + 1 if mark else None, hint=hint,
        ) from None  # fmt: skip
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ConfigError(
            "config-yaml", f"this is not YAML: {error}", file=str(file) if file else None
        ) from None


def _check_depth(text: str) -> None:
    """Raise YAMLError for lists too deep in one another, which would crash PyYAML's C code."""
    depth = 0
    for event in yaml.parse(text, Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise _too_many(event)


def _too_many(where: yaml.Node | yaml.Event) -> yaml.MarkedYAMLError:
    mark: Any = where.start_mark
    return yaml.MarkedYAMLError(problem=_TOO_MANY, problem_mark=mark)


def _find_lines(root: yaml.Node, file: Path | None) -> dict[Key, int]:
    """Every value's line; give arguments as they are written; refuse doubled keys.

    What an alias stands for is walked through each time, so an alias of itself is too deep.
    """
    lines: dict[Key, int] = {}
    todo: list[tuple[yaml.Node, Key]] = [(root, ())]
    while todo:
        node, at = todo.pop()
        lines.setdefault(at, node.start_mark.line + 1)
        if len(lines) > LONGEST or len(at) > DEEPEST:
            raise _too_many(node)
        if isinstance(node, yaml.SequenceNode):
            todo += [(value, (*at, index)) for index, value in enumerate(node.value)]
        for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
            path = (*at, str(key.value))
            if path in lines:
                raise ConfigError(
                    "config-key-doubled", f"'{'.'.join(map(str, path))}' is there twice",
                    file=str(file) if file else None, line=key.start_mark.line + 1,
                )  # fmt: skip
            lines[path] = key.start_mark.line + 1
            if len(at) < 3 and isinstance(key, yaml.ScalarNode) and key.value != "<<":
                key.tag = _TEXT  # 'on' and '1' are names, too
            # 'hand: false' and 'mass: 1.50' mean just these words
            if at in (("xacro_args",), ("sweep", "xacro_args")):
                for each in value.value if isinstance(value, yaml.SequenceNode) else [value]:
                    if isinstance(each, yaml.ScalarNode):
                        each.tag = _TEXT
            todo.append((value, path))
    return lines
