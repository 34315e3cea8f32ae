"""The conversion."""

CODES = {
    "mbs-unwritable": "error: the model has an infinite number or unknown word. Look into plugins.",
    "base-guessed": "warning: it is a guess if the base floats or not. Say `base: fixed` or "
    "`base: floating`.",
    "no-mass": "warning: no link has mass or inertia; the model has no dynamics. Give masses, or "
    "use `estimate-inertia`.",
    "massless-leaf": "warning: joints move no mass; they are locked at zero (`prune-massless`). "
    "Give the links mass; `keep` keeps the joints, but not to simulate.",
    "mimic": "warning: joints that follow others are independent; a project (`mimic`) couples "
    "them. Write a project.",
    "mimic-locked": "warning: the limits of joints that follow each other leave no motion. Correct "
    "the limits, or `multiplier` and `offset` of the `<mimic>`.",
    "texture": "warning: textures of materials are left out. Give the material a colour.",
    "joint-dynamics-lost": "warning: damping and springs of joints of several axes are left out. "
    "Write them into user functions.",
    "base": "note: the base floats, or is fixed; the note says why",
    "mbs-name": "note: the name of the file is no identifier; the model has another name",
    "ground-mass": "note: mass that is fixed to the ground has no body",
    "axis-aligned": "note: an axis within 1e-9 of a coordinate axis or plane is taken to lie there",
    "mimic-massless": "note: a joint without mass leads joints with mass; a project keeps it",
    "generator-limits": "note: the model exceeds most accounts of Robotran's generator",
    "point-without-rotation": "note: frames became anchor points, which have no rotation",
    "collision": "note: collision shapes are left out",
    "joint-dynamics": "note: only a project applies damping, friction and springs of joints",
    "limit": "note: limits of joints of several coordinates are left out",
    "safety-controller": "note: safety controllers of joints of several coordinates are left out",
    "calibration": "note: calibrations of joints of several coordinates are left out",
    "extension": "note: elements of other programs are left out",
}
