"""Equations of motion."""

CODES = {
    "equations-language": "warning: `passes: {equations: ...}` has no `language`: no equations",
    "equations-stale": "warning: equations in `symbolicR` are of another model; ours are removed",
    "mbsname-no-identifier": "error: `<mbsname>` is no identifier, and the equations need one",
}
