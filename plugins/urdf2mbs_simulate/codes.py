"""A simulation."""

CODES = {
    "not-the-same": "error: the `.mbs` that was made is not the same robot (exit code 3)",
    "not-compiled": "error: the C compiler refuses a file",
    "user-model-in-c": "error: a parameter of a user model is no number, and C wants it",
    "equations-of-another-model": "error: equations in `symbolicR` do not fit the `.mbs`",
    "equations-not-generated": "error: the equations that are needed cannot be made",
    "partition": "error: the loops cannot be closed, or the constraints are too few or too many",
    "joint-without-mass": "error: a force acts along a joint that moves nothing that has mass",
    "not-actuated": "error: the actuated joints cannot make a motion",
    "no-equilibrium": "error: no pose is found in which nothing accelerates",
    "user-function-failed": "error: a user function has raised an exception",
    "step-failed": "error: no step of the integrator is short enough",
}
