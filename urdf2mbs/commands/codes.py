"""The command line, and the functions of Python."""

CODES = {
    "usage": "error: an argument of the command line is wrong. See `--help`.",
}
