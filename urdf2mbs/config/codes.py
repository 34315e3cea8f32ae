"""The config."""

CODES = {
    "config-unreadable": "error: the config cannot be read. Correct the path.",
    "config-yaml": "error: the config is not YAML. Correct the line.",
    "config-type": "error: a value has the wrong type. Write the type that is named.",
    "config-key-missing": "error: a key is missing. Add it.",
    "config-key-doubled": "error: a key is there twice. Remove one.",
    "value-range": "error: a number is out of range. Write a number in the range.",
    "variable-unset": "error: a path names a `$VARIABLE` that is not set. Set it.",
    "variable-unclosed": "error: a path has a `${` without a name and `}`. Write `${NAME}`.",
    "unknown-key": "error: there is no such key. Correct it.",
}
