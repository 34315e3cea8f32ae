"""All commands."""

CODES = {
    "memory-full": "error: there is not enough memory. Give more, or simplify the robot.",
    "extra-missing": "error: a package is not installed. Install it as the message says.",
}
