"""Files and paths."""

CODES = {
    "file-unreadable": "error: a file cannot be read, or is too large",
    "path-invalid": "error: a path is too long, or has a character that no path can have",
    "project-unknown": "error: a folder is no Robotran project (exit code 2)",
    "model-unreadable": "error: the `.mbs` cannot be read, or is too large (exit code 2)",
}
