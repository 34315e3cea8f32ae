"""Explains why a text is not YAML: the line, the fault, and what to do."""

from __future__ import annotations

import re

import msgspec
import yaml


class YamlFault(msgspec.Struct, frozen=True):
    """What is wrong with a text, in words for the user."""

    reason: str
    hint: str | None = None


#: What PyYAML says of a line without a colon, once it is at the next line.
_NO_COLON = "could not find expected ':'"
#: What PyYAML says where lines do not begin alike.
_INDENTATION = "mapping values are not allowed|block (mapping|collection|sequence)|<document start>"
#: What PyYAML says, and what it means.
_FAULTS = {
    "undefined alias": YamlFault("a word begins with '*'", "write it in quotes"),
    "constructor": YamlFault("a value begins with '!'", "write it in quotes"),
    "another document": YamlFault("a line '---' begins a second config", "keep one of the two"),
    "quoted scalar": YamlFault("a quote is not closed", "close it"),
    "flow (mapping|sequence|node)": YamlFault(
        "a bracket is not closed, or a comma is missing",
        "look for [ and { in this line and before it",
    ),
    "mapping values are not allowed": YamlFault(
        "a second ':' in one line", "write the value in quotes"
    ),
    _NO_COLON: YamlFault("this line has no ':'", "write 'key: value'"),
    "block (mapping|collection|sequence)": YamlFault(
        "this line does not continue the lines before it", "look at its indentation"
    ),
}


def explain(error: yaml.MarkedYAMLError, text: str) -> tuple[int | None, YamlFault]:
    """Return the line of an error of PyYAML, and the fault in it.

    Args:
        error: The error.
        text: The text that is not YAML.
    """
    message = " ".join(part for part in (error.context, error.problem) if part)
    position = error.problem_mark or error.context_mark
    if _NO_COLON in message:
        position = error.context_mark or position
    if position is None:
        return None, YamlFault(message)
    lines = text.split("\n")[: position.line + 1]
    last_line = lines[-1] if len(lines) > position.line else ""
    fault = _find_character(message, last_line, position.column)
    is_second_colon = re.search(r":\s", last_line[: position.column]) is not None
    if fault is None and re.search(_INDENTATION, message) and not is_second_colon:
        fault = _find_indentation(lines)
    if fault is None:
        known = (fault for pattern, fault in _FAULTS.items() if re.search(pattern, message))
        fault = next(known, YamlFault(message))
    return position.line + 1, fault


def _find_character(message: str, line: str, column: int) -> YamlFault | None:
    """Return the fault if a single character is one: a tab, a bracket, a sign of YAML.

    Args:
        message: What PyYAML says.
        line: The line of the error.
        column: The position of the error in the line.
    """
    if "\t" in line[: column + 1] and not line[:column].strip():
        return YamlFault("a tab indents this line", "indent it by blanks")
    character = line[column : column + 1]
    if "cannot start any token" in message and character:
        return YamlFault(f"a value begins with '{character}'", "write it in quotes")
    if character in ("]", "}"):
        return YamlFault(f"no '{character}' is expected here", "remove it")
    return None


class _Block(msgspec.Struct, frozen=True):
    """The first word of a line, or of an item of a list, below which others may begin."""

    line_number: int
    indent: int
    """The number of blanks before it, or of other characters."""
    word: str

    def __str__(self) -> str:
        """Return its line and word."""
        return f"line {self.line_number} ('{self.word}')"


def _find_indentation(lines: list[str]) -> YamlFault | None:
    """Return the fault if the last of some lines belongs to no block of those before it.

    Args:
        lines: The lines up to that of the error.

    Returns:
        The fault; None if the last line begins below another that is open there.
    """
    blocks: list[_Block] = []
    for number, line in enumerate(lines[:-1], start=1):
        for block in _list_blocks(line, number):
            blocks = [outer for outer in blocks if outer.indent < block.indent]
            blocks.append(block)
    last = next(iter(_list_blocks(lines[-1], len(lines))), None)
    if last is None:
        return None
    is_item = last.word.startswith("- ")
    level = [block for block in blocks if block.indent == last.indent]
    if level and is_item != level[-1].word.startswith("- "):
        kinds = ("an item of a list", "a key") if is_item else ("a key", "an item of a list")
        reason = f"{last} is {kinds[0]}, and not further in than {level[-1]}, which is {kinds[1]}"
        return YamlFault(reason, "a block has items or keys: indent a list below its own key")
    outer = [block for block in blocks if block.indent < last.indent]
    inner = [block for block in blocks if block.indent > last.indent]
    if len(outer) + len(inner) < len(blocks) or not blocks:
        return None
    if not inner:
        reason = f"{last} is further in than {outer[-1]}, which has its value already"
        return YamlFault(reason, f"indent it as '{outer[-1].word}'")
    if not outer:
        reason = f"{inner[0]} is further in than {last}"
        return YamlFault(reason, f"indent '{last.word}' as '{inner[0].word}'")
    reason = f"{last} is further in than {outer[-1]}, and not as far as {inner[0]}"
    hint = f"indent it as '{inner[0].word}'"
    return YamlFault(reason, hint if is_item else f"{hint}, or as '{outer[-1].word}'")


def _list_blocks(line: str, number: int) -> list[_Block]:
    """Return the blocks that a line begins: ``- key: 1`` that of the item and that of the key."""
    blocks: list[_Block] = []
    match = re.match(r"( *)((?:- +)*)([^\s#].*)", line)
    if match is None:  # a blank, or a comment
        return []
    indent, dashes, text = len(match[1]), match[2], match[3].partition(":")[0].strip()
    if dashes:
        blocks.append(_Block(number, indent, f"- {text}"))
    return [*blocks, _Block(number, indent + len(dashes), text)]
