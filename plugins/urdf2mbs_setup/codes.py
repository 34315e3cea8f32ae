"""Setting up."""

CODES = {
    "pass-name": "error: `new-pass` cannot use the name. Write small letters, digits and hyphens.",
}
