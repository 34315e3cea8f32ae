"""Report and diagram."""

CODES = {
    "no-mbs": "error: the pipeline makes no `.mbs` for the report",
    "no-drawing": "error: the file has no 2D diagram",
}
