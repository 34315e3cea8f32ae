"""From bytes to XML elements: harmless slips are mended and said, all else is one error.

Lines stay where they are: what is mended away is replaced by blanks.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator
from typing import Any, NoReturn

import msgspec
from lxml import etree

from urdf2mbs import xml_lines
from urdf2mbs.diagnostics import ConversionError


class Slip(msgspec.Struct, frozen=True):
    """Something that was mended or forgiven."""

    code: str
    message: str
    line: int | None


#: Blanks and byte order marks, in any encoding.
BLANK = b"\0 \t\r\n\xef\xbb\xbf\xfe\xff"
#: How files are parsed that may come from anywhere.
_SAFE: dict[str, Any] = {"resolve_entities": False, "no_network": True, "load_dtd": False}
#: Longer comments are not read by libxml2.
_LONG = 9_999_999
_BOM = b"\xef\xbb\xbf"
_DECLARATION = rb"<\?xml(?=[\s?])([^<>]*)\?>"
_VERSION = rb"""version\s*=\s*["']([^"']*)["']"""
_ENCODING = rb"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']"""
_COMMENT = rb"(?s)<!--(.*?)(?:-->|(\Z))"  # the second group: it is not closed
_CONFLICT = rb"(?m)^(<{7} |>{7} |={7}\s*$)"
_SAVE_UTF_8 = 'save the file as UTF-8, or name its encoding: <?xml version="1.0" encoding=...?>'
#: libxml2's first complaint about a file that is cut off.
_UNFINISHED = frozenset(
    f"ERR_{what}"
    for what in (
        "TAG_NOT_FINISHED", "COMMENT_NOT_FINISHED", "CDATA_NOT_FINISHED", "PI_NOT_FINISHED",
        "XMLDECL_NOT_FINISHED", "DOCUMENT_EMPTY",
    )
)  # fmt: skip

#: libxml2's complaints: what its message tells, what we say of that, and what to do.
_REASONS: dict[str, tuple[str, str, str | None]] = {
    "ERR_TAG_NAME_MISMATCH": (
        r"mismatch: (\S+) line (\d+) and (\S+)",
        "</{2}> stands where <{0}> of line {1} must be closed first", None,
    ),
    "ERR_NAME_REQUIRED": ("", "there is a '<' or '&' that begins no element or entity",
                          "write &lt; and &amp; for < and &"),
    "ERR_UNDECLARED_ENTITY": (r"Entity '(.*?)'", "'&{0};' is not known in XML",
                              "write &amp; for an ampersand"),
    "ERR_ENTITYREF_SEMICOL_MISSING": ("", "there is an '&' that begins no entity",
                                      "write &amp; for an ampersand"),
    "ERR_DOCUMENT_END": ("", "something stands after the end of the outermost element",
                         "an XML file has one outermost element"),
    "ERR_ATTRIBUTE_NOT_STARTED": ("", "the value of an attribute has no quotes around it",
                                  'write name="value"'),
    "ERR_ATTRIBUTE_WITHOUT_VALUE": (r"attribute (\S+)", "the attribute '{0}' has no value",
                                    'write name="value"'),
    "ERR_ATTRIBUTE_REDEFINED": (r"Attribute (\S+)", "the attribute '{0}' is there twice",
                                "take one of the two away"),
    "ERR_LT_IN_ATTRIBUTE": ("", "there is a '<' within the value of an attribute",
                            "write &lt;, or close the quotes before it"),
    "ERR_SPACE_REQUIRED": ("", "a blank is missing between two attributes",
                           "look for quotes that are not closed"),
    "ERR_GT_REQUIRED": ("", "a tag is not closed by '>'", None),
    "ERR_INVALID_CHAR": (r"[Vv]alue (0x[0-9A-Fa-f]+|\d+)",
                         "there is a character that XML does not allow (number {0})",
                         "take it away"),
    "ERR_INVALID_ENCODING": ("", "its letters are not in the encoding that it claims",
                             _SAVE_UTF_8),
    "ERR_UNSUPPORTED_ENCODING": ("", "the encoding that it names is not known", _SAVE_UTF_8),
    "ERR_RESERVED_XML_NAME": ("", "<?xml ...?> stands where it may not",
                              "it may only stand at the very beginning"),
}  # fmt: skip


def parse(data: bytes, file: str) -> tuple[Any, list[Slip]]:
    """The root element of an XML text, and what was mended or forgiven.

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
            explain(data, file, error, log)
        # old files use prefixes that they do not declare
        slips += [Slip("xml-namespace", e.message.strip().rstrip("."), e.line) for e in log]
        root = xml_lines.parse(data, _parser(recover=True))
    if root is None:
        raise ConversionError("xml-syntax", "there is no XML element in the file", file=file)
    dtd: Any = root.getroottree().docinfo.internalDTD
    if dtd is not None and next(dtd.iterentities(), None) is not None:
        _bad_entities(file, 1)
    return root, slips


def pieces(data: bytes) -> tuple[Any, Iterator[Any]]:
    """The root element of a large URDF text without any slip, and each of its children in turn;
    see ``xml_lines.pieces``, which says what it raises."""
    found = xml_lines.pieces(data, "robot", **_SAFE)
    root = next(found)
    if root.getroottree().docinfo.internalDTD is not None or root.tag != "robot":
        raise xml_lines.NotPieceByPieceError
    return root, found


def mend(data: bytes) -> tuple[bytes, list[Slip]]:
    """The same text without slips that leave its meaning clear, and what they were."""
    slips: list[Slip] = []

    def slip(message: str, at: int) -> None:
        if not lines:
            lines.extend([-1, *(match.start() for match in re.finditer(b"\n", data))])
        slips.append(Slip("xml-mended", message, bisect_left(lines, at)))

    lines: list[int] = []
    """The place before each line, once one is asked for."""
    start = len(_BOM) if data.startswith(_BOM) else 0
    encoding: bytes | None = None
    first = len(data) - len(data[start:].lstrip())
    comments = [match.span() for match in re.finditer(_COMMENT, data)]

    def declaration(match: re.Match[bytes]) -> bytes:
        nonlocal encoding
        at = match.start()
        before = bisect_left(comments, (at, 0))
        if before and at < comments[before - 1][1]:
            return match[0]
        version, named = re.search(_VERSION, match[1]), re.search(_ENCODING, match[1])
        if at != start:
            slip(
                "<?xml ...?> is not at the very beginning of the file: "
                + ("something stands" if first < at else "there are blanks")
                + " before it",
                at,
            )
        elif version is None:
            slip("<?xml ...?> says no version", at)
        elif not version[1].startswith(b"1."):
            slip(f"there is no XML version '{version[1].decode('ascii', 'replace')}'", at)
        elif version[1] == b"1.0":
            return match[0]
        encoding = encoding or (named[1] if named else None)
        return _blanked(match[0])

    def comment(match: re.Match[bytes]) -> bytes:
        if match[2] is not None:
            return match[0]
        if len(match[1]) > _LONG:
            slip("a comment has more than 10,000,000 letters", match.start())
            return b"<!--" + b"\n" * match[1].count(b"\n") + b"-->"
        if b"--" not in match[1] and not match[1].endswith(b"-"):
            return match[0]
        slip("there is a '--' within a comment", match.start())
        return b"<!--" + _blanked(match[1]) + b"-->"

    text = re.sub(_COMMENT, comment, re.sub(_DECLARATION, declaration, data))
    if encoding is not None:
        text = text[:start] + b'<?xml version="1.0" encoding="' + encoding + b'"?>' + text[start:]
    if not re.search(_ENCODING, text[:200]) and not _is_utf_8(text):
        plain = re.sub(
            _COMMENT,
            lambda match: b"<!--" + _blanked(match[1]) + match[0][4 + len(match[1]) :],
            text,
        )
        if _is_utf_8(plain):
            at = next(m.start() for m in re.finditer(_COMMENT, text) if not _is_utf_8(m[1]))
            slip("there are letters within a comment that are not UTF-8", at)
            text = plain
    return text, slips


def explain(data: bytes, file: str, error: etree.XMLSyntaxError, log: list[Any]) -> NoReturn:
    """Raise the one error for a text that is no XML."""

    def fail(code: str, message: str, line: int | None, hint: str | None) -> NoReturn:
        raise ConversionError(code, message, file=file, line=line, hint=hint)

    line = error.lineno or None
    text = data.strip(BLANK)
    conflict = re.search(_CONFLICT, data)
    if conflict:
        fail(
            "merge-conflict", "a merge conflict was left in the file",
            data.count(b"\n", 0, conflict.start()) + 1,
            "choose one of the two versions, and take the lines <<<<<<<, ======= and >>>>>>> away",
        )  # fmt: skip
    if not text.startswith(b"<"):
        begin = " ".join(text[:60].replace(b"\0", b"").decode("utf-8", "replace").split())[:30]
        fail(
            "not-xml", f"not an XML file: it begins with {begin!r}", line,
            "a URDF file begins with <?xml ...?> or <robot name=...>",
        )  # fmt: skip
    first = log[0].type_name if log else ""
    pattern, reason, hint = _REASONS.get(first, ("", "it cannot be read here", None))
    told = re.search(pattern, log[0].message) if pattern else None
    if told:
        reason = reason.format(*told.groups())
    elif pattern:
        reason = "it cannot be read here"
    _check_size(log, file, line)
    at_end = line is not None and line > data.rstrip(BLANK).count(b"\n")
    if first in _UNFINISHED or (at_end and not text.endswith(b">")):
        fail(
            "xml-truncated", "the file ends before its elements are closed", line,
            "it seems to be cut off: get it again, or close the elements",
        )  # fmt: skip
    if b"<!ENTITY" in data:
        _bad_entities(file, line)
    fail("xml-syntax", f"not well-formed XML: {reason}", line, hint)


def _check_size(log: list[Any], file: str, line: int | None) -> None:
    """Raise the error for what is larger than libxml2 reads."""
    said = log[0].message if log else ""
    depth = re.search(r"depth in document: (\d+)", said)
    if depth:
        what = f"elements are nested more than {depth[1]} deep"
    elif "Name too long" in said:
        what = "a name of an element or attribute has more than 50,000 letters"
    elif "too big found" in said or "Resource limit" in said:
        what = "one text, comment or value of an attribute has more than 10,000,000 letters"
    else:
        return
    raise ConversionError(
        "xml-too-large", f"the file is more than can be read: {what}", file=file, line=line,
        hint="no robot needs that: look at the program that has made the file",
    )  # fmt: skip


def explain_text(data: bytes, file: str) -> None:
    """Raise the error for a text that another parser has refused, if ours refuses it, too."""
    data, _ = mend(data)
    _, log, error = _attempt(data)
    if error is not None and not _only_prefixes(log):
        explain(data, file, error, log)


def _attempt(data: bytes) -> tuple[Any, list[Any], etree.XMLSyntaxError | None]:
    parser = _parser()
    try:
        return xml_lines.parse(data, parser), [], None
    except etree.XMLSyntaxError as error:
        # an exception's own log also has what other parsers said before
        entries: Any = parser.error_log
        return None, list(entries), error


def _only_prefixes(log: list[Any]) -> bool:
    return bool(log) and all(entry.domain_name == "NAMESPACE" for entry in log)


def _bad_entities(file: str, line: int | None) -> NoReturn:
    raise ConversionError(
        "xml-entity", "the file declares XML entities, which are not read", file=file, line=line,
        hint="write out what the entities stand for, and take the DOCTYPE away",
    )  # fmt: skip


def _parser(recover: bool = False) -> etree.XMLParser:
    return etree.XMLParser(recover=recover, **_SAFE)


def _blanked(text: bytes) -> bytes:
    return re.sub(rb"[^\r\n]", b" ", text)


def _is_utf_8(text: bytes) -> bool:
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
