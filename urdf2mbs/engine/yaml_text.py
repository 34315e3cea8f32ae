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

#: The keys, and positions in lists, that lead to a value.
Key = tuple[str | int, ...]

#: Lists and blocks in one another, and values where every alias is written out: so many at most.
DEEPEST, LONGEST = 100, 100_000

#: What PyYAML says, what we say of it, and what to do.
_YAML: list[tuple[str, str, str | None]] = [
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
        _check_size(text)
        return yaml.load(text, Loader)
    except (yaml.YAMLError, ValueError, RecursionError):
        return text


def _check_size(text: str) -> None:
    """Raise YAMLError for lists too deep in one another, which would crash PyYAML's C code, and
    for aliases that stand for themselves or for too many values."""
    if len(text) < 20 * DEEPEST and "*" not in text:
        return
    sizes: dict[str | None, int | None] = {}
    """Values below each anchor; None: it is still open."""
    above: list[tuple[str | None, int]] = []
    size = 0
    for event in yaml.parse(text, Loader):
        problem = None
        if isinstance(event, yaml.CollectionStartEvent):
            above.append((event.anchor, size))
            sizes[event.anchor] = None
            size += 1
            if len(above) > DEEPEST:
                problem = f"more than {DEEPEST} lists or blocks are in one another"
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, before = above.pop()
            sizes[anchor] = size - before
        elif isinstance(event, yaml.ScalarEvent):
            sizes[event.anchor] = 1
            size += 1
        elif isinstance(event, yaml.AliasEvent):
            more = sizes.get(event.anchor, 0)
            size += more or 0
            if more is None:
                problem = f"'*{event.anchor}' stands for what it is in"
        if size > LONGEST:
            problem = f"it has more than {LONGEST} values"
        if problem is not None:
            mark: Any = event.start_mark
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=mark)


def tree(text: str, file: Path | None) -> tuple[Any, dict[Key, int]]:
    """The data, and the line of each value; raises ConfigError."""
    loader = None
    try:
        _check_size(text)
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
    finally:
        if loader is not None:
            loader.dispose()


def _find_lines(root: yaml.Node, file: Path | None) -> dict[Key, int]:
    """Every value's line; give arguments as they are written; refuse doubled keys."""
    lines: dict[Key, int] = {}
    todo: list[tuple[yaml.Node, Key]] = [(root, ())]
    seen: set[int] = set()
    while todo:
        node, at = todo.pop()
        lines.setdefault(at, node.start_mark.line + 1)
        if id(node) in seen:
            continue
        if isinstance(node, yaml.MappingNode):
            seen.add(id(node))
            for key, value in node.value:
                path = (*at, str(key.value))
                if path in lines:
                    lines[path] = key.start_mark.line + 1
                    raise ConfigError(
                        "config-key-doubled", f"'{'.'.join(map(str, path))}' is there twice",
                        file=str(file) if file else None, line=lines[path],
                    )  # fmt: skip
                lines[path] = key.start_mark.line + 1
                if len(at) < 3 and isinstance(key, yaml.ScalarNode) and key.value != "<<":
                    key.tag = "tag:yaml.org,2002:str"  # 'on' and '1' are names, too
                # 'hand: false' and 'mass: 1.50' mean just these words
                if at == ("xacro_args",) and isinstance(value, yaml.ScalarNode):
                    value.tag = "tag:yaml.org,2002:str"
                elif at == ("sweep", "xacro_args") and isinstance(value, yaml.SequenceNode):
                    for item in value.value:
                        if isinstance(item, yaml.ScalarNode):
                            item.tag = "tag:yaml.org,2002:str"
                todo.append((value, path))
        elif isinstance(node, yaml.SequenceNode):
            seen.add(id(node))
            todo += [(value, (*at, index)) for index, value in enumerate(node.value)]
    return lines
