"""From bytes to XML elements: harmless slips are mended with a warning, any other is an error.

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
    """A slip that was mended or forgiven."""

    code: str
    message: str
    line: int | None


_BEGINS = "a URDF file begins with <?xml ...?> or <robot name=...>"
_CONFIG = "a config is run by: urdf2mbs run {}"
#: Longer comments are not read by libxml2.
_LONG = 10_000_000
_BOM = b"\xef\xbb\xbf"
_DECLARATION = rb"<\?xml(?=[\s?])([^<>]*)\?>"
_VERSION = rb"""version\s*=\s*["']([^"']*)["']"""
_COMMENT = rb"(?s)<!--(.*?)(?:-->|(\Z))"  # the second group: it is not closed
_ENCODING = rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']"""


def parse(data: bytes, file: str) -> tuple[Any, list[Slip]]:
    """The root element of an XML text, and the slips that were mended or forgiven.

    :raises ConversionError: ``file-empty``, ``not-xml``, ``merge-conflict``, ``xml-syntax``,
        ``xml-truncated``, ``xml-entity``, ``xml-too-large``
    """
    if not data.strip(BLANK):
        raise ConversionError("file-empty", "the file is empty", file=file)
    root, log, error = _attempt(data)
    slips: list[Slip] = []
    if error is not None and not _only_prefixes(log):
        data, slips = mend(data)
        if slips:
            root, log, error = _attempt(data)
    if error is not None:
        if not _only_prefixes(log):
            is_config = file.lower().endswith((".yaml", ".yml"))
            raise_syntax_error(
                data, file, error, log, _CONFIG.format(file) if is_config else _BEGINS
            )
        # old files use prefixes that they do not declare
        slips += [Slip("xml-namespace", e.message.strip().rstrip("."), e.line) for e in log]
        root = etree.fromstring(data, safe_parser(recover=True))
    if root is None:
        raise ConversionError("xml-syntax", "there is no XML element in the file", file=file)
    check_entities(root, file)
    return root, slips


def mend(data: bytes) -> tuple[bytes, list[Slip]]:
    """The text without slips that leave its meaning clear, and these slips."""
    slips: list[Slip] = []
    before_lines = [-1, *(match.start() for match in re.finditer(b"\n", data))]

    def slip(message: str, at: int) -> None:
        slips.append(Slip("xml-mended", message, bisect_left(before_lines, at)))

    start = len(_BOM) if data.startswith(_BOM) else 0
    encoding: bytes | None = None
    bare = data.rstrip(BLANK)
    if b"\0" in data[len(bare) :] and b"\0" not in bare:  # in UTF-16 a letter has one
        slip("the file ends in NUL bytes", len(bare))
        data = bare.ljust(len(data))
    first = len(data) - len(data[start:].lstrip())
    comments = [match.span() for match in re.finditer(_COMMENT, data)]

    def declaration(match: re.Match[bytes]) -> bytes:
        nonlocal encoding
        at = match.start()
        before = bisect_left(comments, (at,))
        if before and at < comments[before - 1][1]:
            return match[0]
        version, named = re.search(_VERSION, match[1]), re.search(_ENCODING, match[1])
        if at != start:
            stands = "something stands" if first < at else "there are blanks"
            slip(f"<?xml ...?> is not at the very beginning of the file: {stands} before it", at)
        elif version is None:
            slip("<?xml ...?> says no version", at)
        elif not version[1].startswith(b"1."):
            slip(
                f"there is no XML version {version[1].decode('ascii', 'replace')!r}: 1.0 is read",
                at,
            )
        elif version[1] == b"1.0":
            return match[0]
        encoding = encoding or (named[1] if named else None)
        return _blank(match[0])

    def comment(match: re.Match[bytes]) -> bytes:
        if match[2] is not None:
            return match[0]
        if len(match[1]) > _LONG:
            slip("a comment has more than 10,000,000 letters", match.start())
            return b"<!--" + b"\n" * match[1].count(b"\n") + b"-->"
        if b"--" not in match[1] and not match[1].endswith(b"-"):
            return match[0]
        slip("there is a '--' within a comment", match.start())
        return _blank_comment(match)

    text = re.sub(_COMMENT, comment, re.sub(_DECLARATION, declaration, data))
    if encoding is not None:
        text = text[:start] + b'<?xml version="1.0" encoding="' + encoding + b'"?>' + text[start:]
    if not re.search(_ENCODING, text[:200]) and not _is_utf_8(text):
        plain = re.sub(_COMMENT, _blank_comment, text)
        if _is_utf_8(plain):
            at = next(m.start() for m in re.finditer(_COMMENT, text) if not _is_utf_8(m[1]))
            slip("there are letters within a comment that are not UTF-8", at)
            text = plain
    return text, slips


def _attempt(data: bytes) -> tuple[Any, list[Any], etree.XMLSyntaxError | None]:
    parser = safe_parser()
    try:
        return etree.fromstring(data, parser), [], None
    except etree.XMLSyntaxError as error:
        # an exception's own log also has what other parsers said before
        entries: Any = parser.error_log
        return None, list(entries), error


def _only_prefixes(log: list[Any]) -> bool:
    return bool(log) and all(entry.domain_name == "NAMESPACE" for entry in log)


def _blank(text: bytes) -> bytes:
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
