"""Setting up."""

CODES = {
    "pass-name": "error: `new-pass` cannot use the name",
}
