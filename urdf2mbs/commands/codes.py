"""The command line, and the functions of Python."""

CODES = {
    "usage": "error: an argument of the command line is wrong. See `--help`.",
    "tolerance-invalid": "error: the tolerance of `verify` is outside of its range. Write another.",
}
