"""New plugins."""

CODES = {
    "pass-name": "error: `new-pass` cannot use the name. Write small letters, digits and hyphens.",
    "plugin-name": "error: `new-plugin` cannot use the name. Write small letters, digits and "
    "hyphens, and no name of a package that is installed.",
}
