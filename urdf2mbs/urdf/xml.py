"""From bytes to XML elements: harmless slips are fixed with a warning, any other is an error.

Blanks replace a slip, so that the line numbers stay.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from typing import Any, NamedTuple

from lxml import etree

from urdf2mbs.disk.xml import BLANK, check_entities, raise_syntax_error, safe_parser
from urdf2mbs.messages.diagnostics import ConversionError


class Slip(NamedTuple):
    """A slip that was fixed or forgiven."""

    code: str
    message: str
    line: int | None


_BEGINNING = "a URDF file begins with <?xml ...?> or <robot name=...>"
_CONFIG = "a config is run by: urdf2mbs run {}"
#: Longer comments are not read by libxml2.
_MAX_COMMENT = 10_000_000
_BOM = b"\xef\xbb\xbf"
_DECLARATION = rb"<\?xml(?=[\s?])([^<>]*)\?>"
_VERSION = rb"""version\s*=\s*["']([^"']*)["']"""
_COMMENT = rb"(?s)<!--(.*?)(?:-->|(\Z))"  # the second group: it is not closed
_ENCODING = rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']"""


def parse(data: bytes, file: str) -> tuple[Any, list[Slip]]:
    """Return the root element of an XML text, and the slips that were fixed or forgiven.

    Args:
        data: The text.
        file: The name of its file, for messages.

    Raises:
        ConversionError: ``file-empty``, ``not-xml``, ``merge-conflict``, ``xml-syntax``,
            ``xml-truncated``, ``xml-entity``, ``xml-too-large``.
    """
    if not data.strip(BLANK):
        raise ConversionError("file-empty", "the file is empty", file=file)
    root, log, error = _attempt(data)
    slips: list[Slip] = []
    if error is not None and not _has_only_prefixes(log):
        data, slips = fix_slips(data)
        if slips:
            root, log, error = _attempt(data)
    if error is not None:
        if not _has_only_prefixes(log):
            is_config = file.lower().endswith((".yaml", ".yml"))
            hint = _CONFIG.format(file) if is_config else _BEGINNING
            raise_syntax_error(data, file, error, log, hint)
        # old files use prefixes that they do not declare
        slips += [Slip("xml-namespace", e.message.strip().rstrip("."), e.line) for e in log]
        root = etree.fromstring(data, safe_parser(recover=True))
    if root is None:
        raise ConversionError("xml-syntax", "there is no XML element in the file", file=file)
    check_entities(root, file)
    return root, slips


def fix_slips(data: bytes) -> tuple[bytes, list[Slip]]:
    """Return a text without slips that leave its meaning clear, and these slips."""
    fixer = _Fixer(data)
    return fixer.fix(), fixer.slips


class _Fixer:
    """Fixes a text: first its end, then ``<?xml ...?>``, comments and the encoding."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.slips: list[Slip] = []
        self._line_ends = [-1, *(match.start() for match in re.finditer(b"\n", data))]
        self._comments: list[tuple[int, int]] = []
        self._encoding: bytes | None = None
        """The encoding of a declaration that was removed."""
        self._start = len(_BOM) if data.startswith(_BOM) else 0
        """Where a declaration may be."""

    def fix(self) -> bytes:
        """Return the text without the slips, which are added to ``slips``."""
        self._remove_final_nulls()
        self._comments = [match.span() for match in re.finditer(_COMMENT, self.data)]
        text = re.sub(_DECLARATION, self._fix_declaration, self.data)
        text = re.sub(_COMMENT, self._fix_comment, text)
        if self._encoding is not None:
            declaration = b'<?xml version="1.0" encoding="' + self._encoding + b'"?>'
            text = text[: self._start] + declaration + text[self._start :]
        if re.search(_ENCODING, text[:200]) or _is_utf_8(text):
            return text
        without_comments = re.sub(_COMMENT, _blank_comment, text)
        if not _is_utf_8(without_comments):
            return text
        comments = re.finditer(_COMMENT, text)
        position = next(match.start() for match in comments if not _is_utf_8(match[1]))
        self._add("there are letters within a comment that are not UTF-8", position)
        return without_comments

    def _add(self, message: str, position: int) -> None:
        """Add a slip at a position (bytes) of the text."""
        self.slips.append(Slip("xml-mended", message, bisect_left(self._line_ends, position)))

    def _remove_final_nulls(self) -> None:
        bare = self.data.rstrip(BLANK)
        if b"\0" in self.data[len(bare) :] and b"\0" not in bare:  # in UTF-16 a letter has one
            self._add("the file ends in NUL bytes", len(bare))
            self.data = bare.ljust(len(self.data))

    def _fix_declaration(self, match: re.Match[bytes]) -> bytes:
        """Return a declaration, or blanks if it is misplaced or has a wrong version."""
        position = match.start()
        number = bisect_left(self._comments, (position,))
        if number and position < self._comments[number - 1][1]:
            return match[0]  # it is within a comment
        version, encoding = re.search(_VERSION, match[1]), re.search(_ENCODING, match[1])
        if position != self._start:
            first = len(self.data) - len(self.data[self._start :].lstrip())
            before = "there is something" if first < position else "there are blanks"
            message = f"<?xml ...?> is not at the very beginning of the file: {before} before it"
            self._add(message, position)
        elif version is None:
            self._add("<?xml ...?> says no version", position)
        elif not version[1].startswith(b"1."):
            number_text = version[1].decode("ascii", "replace")
            self._add(f"there is no XML version {number_text!r}: 1.0 is read", position)
        elif version[1] == b"1.0":
            return match[0]
        self._encoding = self._encoding or (encoding[1] if encoding else None)
        return _blank(match[0])

    def _fix_comment(self, match: re.Match[bytes]) -> bytes:
        """Return a comment, or blanks in it if it is too long or has ``--`` in it."""
        if match[2] is not None:
            return match[0]
        if len(match[1]) > _MAX_COMMENT:
            self._add("a comment has more than 10,000,000 letters", match.start())
            return b"<!--" + b"\n" * match[1].count(b"\n") + b"-->"
        if b"--" not in match[1] and not match[1].endswith(b"-"):
            return match[0]
        self._add("there is a '--' within a comment", match.start())
        return _blank_comment(match)


def _attempt(data: bytes) -> tuple[Any, list[Any], etree.XMLSyntaxError | None]:
    """Return the root element of a text, or the log of its errors and the last one."""
    parser = safe_parser()
    try:
        return etree.fromstring(data, parser), [], None
    except etree.XMLSyntaxError as error:
        # an exception's own log also has the errors of other parsers
        entries: Any = parser.error_log
        return None, list(entries), error


def _has_only_prefixes(log: list[Any]) -> bool:
    """Return True if all errors are prefixes that are not declared."""
    return bool(log) and all(entry.domain_name == "NAMESPACE" for entry in log)


def _blank(text: bytes) -> bytes:
    """Return blanks in place of a text, with its line ends."""
    return re.sub(rb"[^\r\n]", b" ", text)


def _blank_comment(match: re.Match[bytes]) -> bytes:
    end = b"-->" if match[2] is None else b""
    return b"<!--" + _blank(match[1]) + end


def _is_utf_8(text: bytes) -> bool:
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
