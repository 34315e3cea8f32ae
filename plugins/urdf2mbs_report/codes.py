"""Report and diagram."""

CODES = {
    "no-mbs": "error: the pipeline makes no `.mbs` for the report",
    "viewer-missing": "error: the installed three.js is another one",
    "no-drawing": "error: the file has no 2D diagram",
}
