"""What can happen anywhere."""

CODES = {
    "memory-full": "error: there is not enough memory",
    "extra-missing": "error: a package is not installed; the message says what to install",
}
