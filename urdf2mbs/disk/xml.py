"""Parse XML files that may come from anywhere, and explain syntax errors, with their line."""

from __future__ import annotations

import re
from typing import Any, NamedTuple, NoReturn

from lxml import etree

from urdf2mbs.messages.diagnostics import ConversionError

#: Blanks and byte order marks, in any encoding.
BLANK = b"\0 \t\r\n\xef\xbb\xbf\xfe\xff"
#: The lines around the two versions of a merge conflict.
_CONFLICT_MARKER = rb"(?m)^(<{7} |>{7} |={7}\s*$)"
#: libxml2's first error for a file that is cut off.
_UNFINISHED = r"ERR_((TAG|COMMENT|CDATA|PI|XMLDECL)_NOT_FINISHED|DOCUMENT_EMPTY)"
#: libxml2's first error for a file with something after the end of its outermost element.
_TEXT_AFTER_END = "ERR_DOCUMENT_END"
_UNKNOWN_REASON = "it cannot be read here"
_ESCAPE_AMPERSAND = "write &amp; for an ampersand"
_SAVE_UTF_8 = 'save the file as UTF-8, or name its encoding: <?xml version="1.0" encoding=...?>'


class Explanation(NamedTuple):
    """An error of libxml2 in words for the user."""

    reason: str
    """The fault; ``{0}`` is the first group of ``pattern``."""
    hint: str | None = None
    """What to do."""
    pattern: str = ""
    """A regular expression for libxml2's message."""


_EXPLANATIONS = {
    "ERR_TAG_NAME_MISMATCH": Explanation(
        "expected </{0}> for <{0}> of line {1}, got </{2}>",
        pattern=r"mismatch: (\S+) line (\d+) and (\S+)",
    ),
    "ERR_NAME_REQUIRED": Explanation(
        "a '<' or '&' begins no element or entity", "write &lt; and &amp; for < and &"
    ),
    "ERR_UNDECLARED_ENTITY": Explanation(
        "XML does not define '&{0};'", _ESCAPE_AMPERSAND, r"Entity '(.*?)'"
    ),
    "ERR_ENTITYREF_SEMICOL_MISSING": Explanation("an '&' begins no entity", _ESCAPE_AMPERSAND),
    _TEXT_AFTER_END: Explanation(
        "expected nothing after the end of the outermost element",
        "an XML file has one outermost element: remove what comes after it",
    ),
    "ERR_ATTRIBUTE_NOT_STARTED": Explanation(
        "the value of an attribute has no quotes", 'write name="value"'
    ),
    "ERR_ATTRIBUTE_WITHOUT_VALUE": Explanation(
        "the attribute '{0}' has no value", 'write name="value"', r"attribute (\S+)"
    ),
    "ERR_ATTRIBUTE_REDEFINED": Explanation(
        "the attribute '{0}' is there twice", "remove one of the two", r"Attribute (\S+)"
    ),
    "ERR_LT_IN_ATTRIBUTE": Explanation(
        "the value of an attribute contains a '<'", "write &lt;, or close the quotes before it"
    ),
    "ERR_SPACE_REQUIRED": Explanation(
        "a blank is missing between two attributes", "look for quotes that are not closed"
    ),
    "ERR_GT_REQUIRED": Explanation("a tag is not closed by '>'"),
    "ERR_INVALID_CHAR": Explanation(
        "XML does not allow the character number {0}",
        "remove it",
        r"[Vv]alue (0x[0-9A-Fa-f]+|\d+)",
    ),
    "ERR_INVALID_ENCODING": Explanation(
        "its characters are not in the encoding that it names", _SAVE_UTF_8
    ),
    "ERR_UNSUPPORTED_ENCODING": Explanation("the encoding that it names is unknown", _SAVE_UTF_8),
    "ERR_RESERVED_XML_NAME": Explanation(
        "<?xml ...?> is not at the beginning of the file", "move it to the first line, or remove it"
    ),
}


def safe_parser(**options: Any) -> etree.XMLParser:
    """Return a parser that reads nothing but the text itself."""
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, **options)


def raise_syntax_error(
    data: bytes, file: str, error: etree.XMLSyntaxError, error_log: list[Any], begins: str
) -> NoReturn:
    """Raise the error that explains best why a text is not XML.

    Args:
        data: The text.
        file: Its name, for the error.
        error: The error of lxml.
        error_log: libxml2's errors; the first one is explained.
        begins: How such a file begins, as a hint.

    Raises:
        ConversionError: ``not-xml``, ``merge-conflict``, ``xml-syntax``, ``xml-truncated``,
            ``xml-entity`` or ``xml-too-large``.
    """
    line = error.lineno or None
    stripped_bytes = data.strip(BLANK)
    check_conflict(data, file)
    if not stripped_bytes.startswith(b"<"):
        beginning = stripped_bytes[:60].replace(b"\0", b"").decode("utf-8", "replace")
        message = f"not an XML file: it begins with {' '.join(beginning.split())[:30]!r}"
        raise ConversionError("not-xml", message, file=file, line=line, hint=begins)
    _check_size(error_log, file, line)
    error_name = error_log[0].type_name if error_log else ""
    is_at_end = line is not None and line > data.rstrip(BLANK).count(b"\n")
    is_cut_off = is_at_end and not stripped_bytes.endswith(b">") and error_name != _TEXT_AFTER_END
    if is_cut_off or re.fullmatch(_UNFINISHED, error_name):
        message = "the file ends before its elements are closed"
        hint = "it seems to be cut off: get it again, or close the elements"
        raise ConversionError("xml-truncated", message, file=file, line=line, hint=hint)
    if b"<!ENTITY" in data:
        _refuse_entities(file, line)
    explanation = _EXPLANATIONS.get(error_name, Explanation(_UNKNOWN_REASON))
    explained = re.search(explanation.pattern, error_log[0].message if error_log else "")
    reason = explanation.reason.format(*explained.groups()) if explained else _UNKNOWN_REASON
    message = f"not well-formed XML: {reason}"
    raise ConversionError("xml-syntax", message, file=file, line=line, hint=explanation.hint)


def _check_size(error_log: list[Any], file: str, line: int | None) -> None:
    """Raise an error if libxml2's first error is that something is too large for it."""
    problem = error_log[0].message if error_log else ""
    depth_limit = re.search(r"depth in document: (\d+)", problem)
    if depth_limit:
        reason = f"elements are nested more than {depth_limit[1]} deep"
    elif "Name too long" in problem:
        reason = "a name of an element or attribute has more than 50,000 letters"
    elif "too big found" in problem or "Resource limit" in problem:
        reason = "one text, comment or value of an attribute has more than 10,000,000 letters"
    else:
        return
    message = f"the file is too large to be read: {reason}"
    hint = "no robot needs that: look at the program that has made the file"
    raise ConversionError("xml-too-large", message, file=file, line=line, hint=hint)


def check_conflict(data: bytes, file: str) -> None:
    """Raise an error if a merge has left both versions in a text."""
    # The plain search is 100 times faster.
    has_marker = any(marker in data for marker in (b"<<<<<<< ", b">>>>>>> ", b"======="))
    conflict = re.search(_CONFLICT_MARKER, data) if has_marker else None
    if conflict:
        line = data.count(b"\n", 0, conflict.start()) + 1
        message = "a merge conflict was left in the file"
        hint = "choose one version, and remove the lines <<<<<<<, ======= and >>>>>>>"
        raise ConversionError("merge-conflict", message, file=file, line=line, hint=hint)


def check_entities(root: Any, file: str) -> None:
    """Raise an error if a file declares entities."""
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and next(dtd.iterentities(), None) is not None:
        _refuse_entities(file, 1)


def _refuse_entities(file: str, line: int | None) -> NoReturn:
    """Raise the error for entities, which could make a small file as large as they like."""
    message = "the file declares XML entities, which are not read"
    hint = "write out the entities, and remove the DOCTYPE"
    raise ConversionError("xml-entity", message, file=file, line=line, hint=hint)
