"""Simulation."""

CODES = {
    "not-the-same": "error: the `.mbs` that was made is not the same robot (exit code 3). "
    "Look at the differences by `report`.",
    "not-compiled": "error: the C compiler refuses a file. Correct the code, or use Python.",
    "user-model-in-c": "error: a parameter of a user model is not a number, as C requires. "
    "Write a number, or use Python.",
    "equations-of-another-model": "error: equations in `symbolicR` do not fit the `.mbs`. "
    "Make the equations anew.",
    "equations-not-generated": "error: the equations that are needed cannot be made. "
    "Correct what the message names.",
    "partition": "error: the loops cannot be closed, or the constraints are too few or too many. "
    "Give another start position, or other cuts.",
    "joint-without-mass": "error: a force acts along a joint that moves no mass. "
    "Give mass to the links that it moves.",
    "not-actuated": "error: the actuated joints cannot make a motion. Actuate other joints.",
    "no-equilibrium": "error: no pose is found in which nothing accelerates. "
    "Start nearer to one, or give contacts.",
    "user-function-failed": "error: a user function has raised an exception. Correct the function.",
    "step-failed": "error: no step of the integrator is short enough. "
    "Give softer numbers, or more inertia.",
}
