"""Edits of an ``.mbs``."""

CODES = {
    "merge-conflict-won": "warning: the URDF and an edit changed the same value; one is used. "
    "The message has both; `prefer` says which is used.",
    "merge-orphaned": "warning: an edit is lost, since the URDF removed what was edited. "
    "Make it again elsewhere, or forget it.",
    "merge-inconsistent": "error: the URDF and your edits do not fit together; your file is "
    "unchanged. Change the `.mbs` or the URDF as the message says, or give `--fresh`.",
    "merge-other-robot": "error: an edited `.mbs` was made of another robot. "
    "Write elsewhere, or give `--fresh`.",
}
