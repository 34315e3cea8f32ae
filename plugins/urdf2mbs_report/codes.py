"""Reports and diagrams."""

CODES = {
    "no-mbs": "error: the pipeline makes no `.mbs` for the report. Add the pass `emit`.",
    "viewer-missing": "error: the installed packages have no three.js that the page can use. "
    "Install the package that is named.",
    "motion-unreadable": "warning: the results of a simulation cannot be played. Simulate again.",
    "limit-unreadable": "warning: a limit of a joint is not a number. Correct it in the `.mbs`.",
    "no-drawing": "error: the file has no 2D diagram. Convert the robot with `layout`.",
}
