"""XML files that may come from anywhere: their parser, and what is wrong with a text, by line."""

from __future__ import annotations

import re
from typing import Any, NoReturn

from lxml import etree

from urdf2mbs.messages.diagnostics import ConversionError

#: Blanks and byte order marks, in any encoding.
BLANK = b"\0 \t\r\n\xef\xbb\xbf\xfe\xff"
_CONFLICT = rb"(?m)^(<{7} |>{7} |={7}\s*$)"
_SAVE_UTF_8 = 'save the file as UTF-8, or name its encoding: <?xml version="1.0" encoding=...?>'
#: libxml2's first complaint about a file that is cut off.
_UNFINISHED = r"ERR_((TAG|COMMENT|CDATA|PI|XMLDECL)_NOT_FINISHED|DOCUMENT_EMPTY)"
_UNTOLD = "it cannot be read here"

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


def safe_parser(**options: Any) -> etree.XMLParser:
    """A parser that reads nothing but the text."""
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, **options)


def raise_syntax_error(
    data: bytes, file: str, error: etree.XMLSyntaxError, log: list[Any], begins: str
) -> NoReturn:
    """Raise the one error for a text that is no XML; ``begins`` says how such a file begins.

    :raises ConversionError: ``file-empty``, ``not-xml``, ``merge-conflict``, ``xml-syntax``,
        ``xml-truncated``, ``xml-entity``, ``xml-too-large``
    """
    line = error.lineno or None
    text = data.strip(BLANK)
    check_conflict(data, file)
    if not text.startswith(b"<"):
        begin = " ".join(text[:60].replace(b"\0", b"").decode("utf-8", "replace").split())[:30]
        what = f"not an XML file: it begins with {begin!r}"
        raise ConversionError("not-xml", what, file=file, line=line, hint=begins)
    first = log[0].type_name if log else ""
    pattern, reason, hint = _REASONS.get(first, ("", _UNTOLD, None))
    told = re.search(pattern, log[0].message if log else "")
    reason = reason.format(*told.groups()) if told else _UNTOLD
    _check_size(log, file, line)
    at_end = line is not None and line > data.rstrip(BLANK).count(b"\n")
    if re.fullmatch(_UNFINISHED, first) or (at_end and not text.endswith(b">")):
        what = "the file ends before its elements are closed"
        hint = "it seems to be cut off: get it again, or close the elements"
        raise ConversionError("xml-truncated", what, file=file, line=line, hint=hint)
    if b"<!ENTITY" in data:
        _refuse_entities(file, line)
    what = f"not well-formed XML: {reason}"
    raise ConversionError("xml-syntax", what, file=file, line=line, hint=hint)


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
    what = f"the file is too large to be read: {what}"
    hint = "no robot needs that: look at the program that has made the file"
    raise ConversionError("xml-too-large", what, file=file, line=line, hint=hint)


def check_conflict(data: bytes, file: str) -> None:
    """Raise the error for a text in which a merge has left both versions."""
    # The plain search is 100 times faster.
    marks = any(mark in data for mark in (b"<<<<<<< ", b">>>>>>> ", b"======="))
    conflict = re.search(_CONFLICT, data) if marks else None
    if conflict:
        line = data.count(b"\n", 0, conflict.start()) + 1
        what = "a merge conflict was left in the file"
        hint = "choose one version, and take the lines <<<<<<<, ======= and >>>>>>> away"
        raise ConversionError("merge-conflict", what, file=file, line=line, hint=hint)


def check_entities(root: Any, file: str) -> None:
    """Raise the error for a file that declares entities."""
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and next(dtd.iterentities(), None) is not None:
        _refuse_entities(file, 1)


def _refuse_entities(file: str, line: int | None) -> NoReturn:
    what = "the file declares XML entities, which are not read"
    hint = "write out the entities, and take the DOCTYPE away"
    raise ConversionError("xml-entity", what, file=file, line=line, hint=hint)
