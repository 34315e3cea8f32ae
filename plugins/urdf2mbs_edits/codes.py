"""Your edits of an ``.mbs``."""

CODES = {
    "merge-conflict-won": "warning: the URDF and an edit changed the same thing; one counts",
    "merge-orphaned": "warning: an edit has no place in the new model: see `NAME.orphaned.mbs`",
    "merge-other-robot": "error: an edited `.mbs` was made of another robot",
}
