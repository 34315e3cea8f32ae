"""Your edits of an ``.mbs``."""

CODES = {
    "merge-conflict-won": "warning: the URDF and an edit changed the same thing; one counts. "
    "Look into `NAME.orphaned.mbs` for yours.",
    "merge-orphaned": "warning: an edit has no place in the new model: see `NAME.orphaned.mbs`. "
    "Draw it anew, or forget it.",
    "merge-other-robot": "error: an edited `.mbs` was made of another robot. "
    "Write elsewhere, or give `--fresh`.",
}
