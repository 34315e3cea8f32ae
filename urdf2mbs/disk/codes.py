"""Files, paths and XML."""

CODES = {
    "file-unreadable": "error: a file cannot be read, or is too large. Check its rights and size.",
    "not-xml": "error: the file is not XML. Take the URDF.",
    "xml-syntax": "error: the XML is not well-formed. Correct the line.",
    "merge-conflict": "error: the file has a merge conflict. Resolve it.",
    "xml-truncated": "error: the file ends before its elements are closed. Close them.",
    "xml-too-large": "error: the XML is too deep, or a text is too long. Shorten it.",
    "xml-entity": "error: the XML has entities, which are not read. Write them out.",
    "path-invalid": "error: a path is too long, or has a wrong character. Shorten or correct it.",
    "project-unknown": "error: a folder is no Robotran project (exit code 2). Name a project.",
    "model-unreadable": "error: the `.mbs` cannot be read (exit code 2). Check its rights.",
}
