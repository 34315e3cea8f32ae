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
MAX_COMMENT = 10_000_000
_BOM = b"\xef\xbb\xbf"
_DECLARATION = rb"<\?xml(?=[\s?])([^<>]*)\?>"
_VERSION = rb"""version\s*=\s*["']([^"']*)["']"""
_COMMENT = rb"(?s)<!--(.*?)(?:-->|(\Z))"  # the second group: it is not closed
_ENCODING = rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']"""


def parse(xml_bytes: bytes, file: str) -> tuple[Any, list[Slip]]:
    """Return the root element of an XML text, and the slips that were fixed or forgiven.

    Args:
        xml_bytes: The text.
        file: The name of its file, for messages.

    Raises:
        ConversionError: ``file-empty``, ``not-xml``, ``merge-conflict``, ``xml-syntax``,
            ``xml-truncated``, ``xml-entity``, ``xml-too-large``.
    """
    if not xml_bytes.strip(BLANK):
        raise ConversionError("file-empty", "the file is empty", file=file)
    root_element, error_log, syntax_error = _try_parsing(xml_bytes)
    slips: list[Slip] = []
    if syntax_error is not None and not _has_only_prefixes(error_log):
        xml_bytes, slips = fix_slips(xml_bytes)
        if slips:
            root_element, error_log, syntax_error = _try_parsing(xml_bytes)
    if syntax_error is not None:
        if not _has_only_prefixes(error_log):
            is_config = file.lower().endswith((".yaml", ".yml"))
            hint = _CONFIG.format(file) if is_config else _BEGINNING
            raise_syntax_error(xml_bytes, file, syntax_error, error_log, hint)
        # old files use prefixes that they do not declare
        slips += [
            Slip("xml-namespace", prefix_error.message.strip().rstrip("."), prefix_error.line)
            for prefix_error in error_log
        ]
        root_element = etree.fromstring(xml_bytes, safe_parser(recover=True))
    if root_element is None:
        raise ConversionError("xml-syntax", "there is no XML element in the file", file=file)
    check_entities(root_element, file)
    return root_element, slips


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
        fixed_bytes = re.sub(_DECLARATION, self._fix_declaration, self.data)
        fixed_bytes = re.sub(_COMMENT, self._fix_comment, fixed_bytes)
        if self._encoding is not None:
            declaration = b'<?xml version="1.0" encoding="' + self._encoding + b'"?>'
            fixed_bytes = fixed_bytes[: self._start] + declaration + fixed_bytes[self._start :]
        if re.search(_ENCODING, fixed_bytes[:200]) or _is_utf_8(fixed_bytes):
            return fixed_bytes
        without_comments = re.sub(_COMMENT, _blank_comment, fixed_bytes)
        if not _is_utf_8(without_comments):
            return fixed_bytes
        comments = re.finditer(_COMMENT, fixed_bytes)
        position = next(match.start() for match in comments if not _is_utf_8(match[1]))
        self._add_slip("there are letters within a comment that are not UTF-8", position)
        return without_comments

    def _add_slip(self, message: str, position: int) -> None:
        """Add a slip at a position (bytes) of the text."""
        self.slips.append(Slip("xml-mended", message, bisect_left(self._line_ends, position)))

    def _remove_final_nulls(self) -> None:
        content = self.data.rstrip(BLANK)
        # in UTF-16 each letter has a NUL byte
        if b"\0" in self.data[len(content) :] and b"\0" not in content:
            self._add_slip("the file ends in NUL bytes", len(content))
            self.data = content.ljust(len(self.data))

    def _fix_declaration(self, declaration: re.Match[bytes]) -> bytes:
        """Return a declaration, or blanks if it is misplaced or has a wrong version."""
        position = declaration.start()
        comment_index = bisect_left(self._comments, (position,))
        if comment_index and position < self._comments[comment_index - 1][1]:
            return declaration[0]  # it is within a comment
        version_match = re.search(_VERSION, declaration[1])
        encoding_match = re.search(_ENCODING, declaration[1])
        if position != self._start:
            content_start = len(self.data) - len(self.data[self._start :].lstrip())
            preceding_text = (
                "there is something" if content_start < position else "there are blanks"
            )
            message = (
                f"<?xml ...?> is not at the very beginning of the file: {preceding_text} before it"
            )
            self._add_slip(message, position)
        elif version_match is None:
            self._add_slip("<?xml ...?> says no version", position)
        elif not version_match[1].startswith(b"1."):
            number_text = version_match[1].decode("ascii", "replace")
            self._add_slip(f"there is no XML version {number_text!r}: 1.0 is read", position)
        elif version_match[1] == b"1.0":
            return declaration[0]
        self._encoding = self._encoding or (encoding_match[1] if encoding_match else None)
        return _replace_by_blanks(declaration[0])

    def _fix_comment(self, comment: re.Match[bytes]) -> bytes:
        """Return a comment, or blanks in it if it is too long or has ``--`` in it."""
        if comment[2] is not None:
            return comment[0]
        if len(comment[1]) > MAX_COMMENT:
            self._add_slip("a comment has more than 10,000,000 letters", comment.start())
            return b"<!--" + b"\n" * comment[1].count(b"\n") + b"-->"
        if b"--" not in comment[1] and not comment[1].endswith(b"-"):
            return comment[0]
        self._add_slip("there is a '--' within a comment", comment.start())
        return _blank_comment(comment)


def _try_parsing(data: bytes) -> tuple[Any, list[Any], etree.XMLSyntaxError | None]:
    """Return the root element of a text, or the log of its errors and the last one."""
    parser = safe_parser()
    try:
        return etree.fromstring(data, parser), [], None
    except etree.XMLSyntaxError as error:
        # an exception's own log also has the errors of other parsers
        error_log: Any = parser.error_log
        return None, list(error_log), error


def _has_only_prefixes(error_log: list[Any]) -> bool:
    """Return True if all errors are prefixes that are not declared."""
    return bool(error_log) and all(entry.domain_name == "NAMESPACE" for entry in error_log)


def _replace_by_blanks(replaced_bytes: bytes) -> bytes:
    """Return blanks in place of a text, with its line ends."""
    return re.sub(rb"[^\r\n]", b" ", replaced_bytes)


def _blank_comment(comment: re.Match[bytes]) -> bytes:
    comment_end = b"-->" if comment[2] is None else b""
    return b"<!--" + _replace_by_blanks(comment[1]) + comment_end


def _is_utf_8(encoded_text: bytes) -> bool:
    try:
        encoded_text.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
