"""The text of a config."""

CODES = {
    "config-unreadable": "error: the config cannot be read",
    "config-yaml": "error: the config is not YAML",
    "config-type": "error: a value has the wrong type",
    "config-key-missing": "error: a key is missing",
    "config-key-doubled": "error: a key is there twice",
    "value-range": "error: a number is outside of the range of its option",
    "variable-unset": "error: a path names a `$VARIABLE` that is not set",
    "unknown-key": "error: there is no such key",
}
