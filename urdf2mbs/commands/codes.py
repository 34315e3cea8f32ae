"""The command line and the Python API."""

CODES = {
    "usage": "error: an argument of the command line is wrong. See `--help`.",
}
