"""The comparison of two robots."""

CODES = {
    "tolerance-invalid": "error: the tolerance of `verify` is outside of its range. Write another.",
    "map-invalid": "error: the map of joints cannot be read, or names a joint that is not there. "
    "Correct it; `--write-map` writes one.",
}
