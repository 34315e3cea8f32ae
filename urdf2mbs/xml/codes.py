"""A file that is no sound XML."""

CODES = {
    "not-xml": "error: the file is not XML",
    "xml-syntax": "error: the XML is not well-formed",
    "merge-conflict": "error: the file has a merge conflict",
    "xml-truncated": "error: the file ends before its elements are closed",
    "xml-too-large": "error: the XML is nested too deeply, or a text in it is too long",
    "xml-entity": "error: the file declares XML entities; they can hide attacks and are not read",
}
