"""Masses and inertias."""

CODES = {
    "inertia-repaired": "warning: inertias were moved to possible ones (`estimate-inertia`). "
    "Correct the URDF, if you know better numbers.",
    "inertia-estimated": "warning: links without inertia got an inertia, as the config asks. "
    "State masses in the URDF, if you know them.",
    "inertia-partial": "warning: an inertia is estimated without a mesh of the link, or not at "
    "all. Put the mesh there, or save it anew, as a closed surface.",
    "snapped": "note: angles are taken for exact ones, as the config asks (`snap`)",
    "nothing-estimated": "warning: the config asks for inertias, and no link without one has a "
    "shape. State inertias in the URDF.",
    "rotors-left-out": "warning: `<transmission>` states the inertia of rotors, which only "
    "`rotors` adds. Set `from_urdf` of `rotors`.",
    "rotors-joints": "error: `rotors` names no joint that moves by one coordinate. "
    "Correct the name.",
    "rotors-project": "error: `rotors` requires a project: nothing else couples a rotor to its "
    "joint. Write a project.",
    "estimate-inertia": "error: the options contradict each other or the robot. "
    "Correct the option that is named.",
}
