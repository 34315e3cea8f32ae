"""Files, paths, and a file that is no sound XML."""

CODES = {
    "file-unreadable": "error: a file cannot be read, or is too large",
    "not-xml": "error: the file is not XML",
    "xml-syntax": "error: the XML is not well-formed",
    "merge-conflict": "error: the file has a merge conflict",
    "xml-truncated": "error: the file ends before its elements are closed",
    "xml-too-large": "error: the XML is nested too deeply, or a text in it is too long",
    "xml-entity": "error: the file declares XML entities; they can hide attacks and are not read",
    "path-invalid": "error: a path is too long, or has a character that no path can have",
    "project-unknown": "error: a folder is no Robotran project (exit code 2)",
    "model-unreadable": "error: the `.mbs` cannot be read, or is too large (exit code 2)",
}
