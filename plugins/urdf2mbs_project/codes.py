"""A Robotran project."""

CODES = {
    "singular": "warning: the mass matrix is singular at every position (`find-singular`). Give "
    "masses and inertias to what the message names.",
    "singular-at-start": "warning: the mass matrix is singular at the initial position. Start in "
    "another posture.",
    "mimic-leader": "warning: a joint whose leader is not one coordinate stays independent. "
    "Drive it by user functions, if it must follow.",
    "mimic-conflict": "warning: `<mimic>` and another element contradict one another; `<mimic>` is "
    "used. Correct one.",
    "mimic-driven": "warning: a joint is driven by its leader, which does not feel its inertia. "
    "Take `dependent`, if the inertia matters.",
    "posture-limit": "warning: joints start beyond their limits; a project starts them at a "
    "limit. Give start positions within the limits.",
    "posture-state": "warning: a group state names a joint that has not one position. Remove the "
    "joint from the state.",
    "time-step-short": "warning: a number of robot or config makes the time step less than 1e-5 "
    "s. State a smaller damping or stiffness.",
    "contacts-balance": "warning: a floating robot's centre of mass is not well over its feet, or "
    "motors cannot hold it there. Put the feet under it, by `posture`; correct `effort`.",
    "contacts-mesh": "warning: a link's mesh cannot be used; its centre of mass, other shapes or "
    "nothing of it touch. Give the points of contact in the config.",
    "sensor-left-out": "warning: a sensor is on no moving body, or cannot be read. Put the "
    "sensor on a link that moves.",
    "sensor-renamed": "warning: a sensor has no name, or the name of another; it gets its own. "
    "Give the sensor a name of its own.",
    "actuator-unknown": "warning: a transmission drives a joint that does not exist. Correct the "
    "name.",
    "loop-open": "warning: a loop is open at the start position. Give a start position in which "
    "it is closed.",
    "loop-never-closes": "warning: no joint can close a loop; Robotran says nothing. Move the "
    "ends of the cut.",
    "loop-row-of-zeros": "warning: a planar loop and mimic: MBsysC of 2017 may find no "
    "partition. Try; if it fails, let followers be `driven`.",
    "loop-left-out": "warning: a joint in `<gazebo>` cannot become a cut, or cannot be read. "
    "Give the cut in the config, by `loops`.",
    "loop-renamed": "warning: a cut has the name of another cut or of a link; it gets its own. "
    "Give the cut a name of its own.",
    "project-names-lost": "warning: your user functions name what the model has no more. Correct "
    "the names in the lines given.",
    "project-renamed": "warning: your user functions call the generated module by another name. "
    "Correct the import in the lines given.",
    "project-obsolete": "warning: generated code of an earlier conversion is removed. Keep "
    "a copy of the old code if you need it.",
    "mimic-held": "note: a joint follows another with the multiplier 0; it is held at its offset",
    "posture-urdf": "note: joints start where `<ros2_control>` says; `from_urdf: false` ends this",
    "stand": "note: the base was moved so that the robot stands on the ground",
    "time-step": "note: something makes the `TIME_STEP` of a project short (`time-step`)",
    "force-torque": "note: force-torque sensors of the URDF are left out",
    "loops": "note: cuts make joints dependent",
    "law-unknown": "note: a plugin adds a force law, which `TIME_STEP` does not know, and which "
    "nothing proves unless the plugin states the expected result",
    "contacts-most": "note: the URDF states more friction of contacts than is used",
    "config-name": "error: the name of the file that `init` writes does not end in `.yaml`. "
    "Name it so.",
    "mimic-joints": "error: `mimic` names no joint that follows another. Correct the name.",
    "actuators-joints": "error: `actuators` names no joint that moves. Correct the name.",
    "posture-joint": "error: `posture` names no joint with a position of its own. "
    "Correct the name.",
    "posture-srdf": "error: the SRDF file cannot be read, or has no such group state. "
    "Correct the path or name.",
    "posture-hold": "error: no joint fits a pattern of `hold`. Correct the pattern.",
    "contacts-links": "error: `contacts` names no link. Correct the name.",
    "contacts-body": "error: no force can act on a link: it never moves, or has no body. "
    "Name a link that moves.",
    "contacts-shape": "error: a link has no shape that gives contact points. Give `points`.",
    "sensors-only": "error: `only` of `sensors` names no sensor of the URDF. Correct the name.",
    "sensors-links": "error: `sensors` names no link. Correct the name.",
    "force-torque-joint": "error: a joint cannot be a force-torque sensor. Name a fixed joint.",
    "loops-link": "error: an end of a cut is not on a link with a body. Name a link with mass.",
    "loops-length": "error: a ball or a solid has a length; only a rod has one. Remove the length.",
    "loops-dependent": "error: the constraints cannot be solved for the joints in `dependent`. "
    "Name more joints, or none.",
    "loops-name": "error: a cut has the name of a link. Rename the cut.",
    "forces-link": "error: a force does not act on a link with a body that moves. "
    "Name a link with a body that moves.",
    "forces-name": "error: the name of a wrench or spring is no identifier. "
    "Write letters, digits and `_`.",
    "forces-spring": "error: the ends of a spring are at one place. Move one end.",
    "project-states": "error: a project whose links or joints rub has no pass "
    "`friction-states`. "
    "Add the pass.",
    "law-missing": "error: a plugin's law has no function in a language of the project. "
    "Write the function.",
    "law-doubled": "error: two laws of plugins have one name. Rename one.",
}
