"""Equations of motion."""

CODES = {
    "equations-language": "warning: `passes: {equations: ...}` has no `language`: no equations. "
    "Name a language, or leave the pass out.",
    "equations-stale": "warning: equations in `symbolicR` are of another model; those of urdf2mbs "
    "are removed, and each run warns until there are others. Make them again: "
    "`urdf2mbs equations`.",
    "mbsname-no-identifier": "error: `<mbsname>` is not an identifier, as the equations require. "
    "Rename the model.",
}
