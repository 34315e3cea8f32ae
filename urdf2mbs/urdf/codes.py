"""What a robot's file may have wrong, and what of the file has no effect."""

CODES = {
    "xacro-legacy": "error, unless lowered: xacro of before 2014, without `xacro:`, is left out",
    "file-not-found": "error: there is no such file",
    "file-is-directory": "error: the source is a folder",
    "file-empty": "error: the file is empty",
    "wrong-root": "error: the root is not `<robot>`: the file is SDF, MJCF or something else",
    "no-links": "error: the robot has no link",
    "name-missing": "error: a link or joint has no name",
    "name-doubled": "error: two links or joints have one name and differ",
    "number-missing": "error: a number that the `.mbs` needs is missing",
    "number-invalid": "error: a number is not finite, or not a number",
    "number-count": "error: there are too many or too few numbers",
    "joint-type-missing": "error: a joint has no type",
    "joint-type-unknown": "error: a joint has a type that URDF does not know",
    "joint-link-missing": "error: a joint has no parent or no child",
    "joint-same-link": "error: a joint has one link as parent and child",
    "link-unknown": "error: a joint names a link that does not exist",
    "axis-zero": "error: the axis of a moving joint is 0 0 0",
    "two-parents": "error: a link is the child of two joints; a URDF is a tree",
    "several-roots": "error: several links have no parent; a URDF is one robot",
    "loop": "error: links form a loop; a URDF is a tree",
    "xacro-unexpanded": "error: after xacro an expression stands where a number must be",
    "package-not-found": "error: the ROS package of an included file was not found",
    "misspelt": "warning: the name of an element or attribute is nearly one of URDF; no effect. "
    "Correct the name.",
    "mechanics-unread": "warning: mechanics is stated where URDF does not know it; no effect. "
    "State it in URDF's words, if it matters.",
    "doubled-element": "warning: an element is there twice; the first counts. Remove one of the "
    "two.",
    "robot-unnamed": "warning: `<robot>` has no name; the robot gets the name of its file. Give "
    "the robot a name.",
    "name-blank": "warning: a name begins or ends with a blank; the blank is kept. Remove the "
    "blank.",
    "inertial-incomplete": "warning: `<inertial>` has no `<mass>` or no `<inertia>`. State both.",
    "inertia-incomplete": "warning: products of inertia are missing; they are zero, as in Drake. "
    "State all six numbers.",
    "inertia-indefinite": "warning: no body has this inertia: a principal moment is negative. "
    "Correct the signs, or let `estimate-inertia` repair it.",
    "inertia-triangle": "warning: no body has this inertia: a principal moment exceeds the "
    "others. Correct the numbers, or let `estimate-inertia` repair it.",
    "mass-negative": "warning: a mass is negative. Correct the mass.",
    "inertia-without-mass": "warning: a link has inertia, but no mass. State the mass.",
    "number-left-out": "warning: a number of a limit, damping, mimic, colour or shape is left "
    "out. Write one number.",
    "mesh-scale": "warning: a mesh has one number as scale; it counts for all directions. Write "
    "three numbers.",
    "geometry-unknown": "warning: a shape has no geometry that URDF knows; it is left out. Use "
    "one of the four shapes, or a mesh.",
    "geometry-size": "warning: a size is zero or negative. Write a size above zero.",
    "material-undefined": "warning: a material is named, and defined nowhere. Define it, with a "
    "colour.",
    "material-unnamed": "warning: a material of `<robot>` has no name; no visual can use it. "
    "Give it a name.",
    "color-range": "warning: a colour is outside of 0 to 1. Write four numbers from 0 to 1.",
    "joint-type-spelling": "warning: the type of a joint has capitals or blanks. Write it in "
    "small letters.",
    "joint-ball": "warning: a joint `spherical` or `ball` becomes three joints about x, y and z. "
    "Write three joints, if the order matters.",
    "joint-renamed": "warning: two joints of one name lead to different links; one is renamed. "
    "Give each joint a name of its own.",
    "number-zeros": "warning: zeros follow the three numbers of a `rpy`; they are left out. "
    "Write three numbers.",
    "number-commas": "warning: commas part numbers; they are read as blanks. Write blanks.",
    "mimic-left-out": "warning: a joint mimics itself, or no joint; it moves freely. Correct the "
    "name of the leader.",
    "world-implied": "warning: a joint has the parent `world`, and no link has this name. Add "
    "`<link name='world'/>`.",
    "link-unattached": "warning: a link has no joint and no content; it is left out. Remove the "
    "link, or add its joint.",
    "joint-limit-missing": "warning: a joint has no `<limit>`; it moves without limits. State "
    "limits, or make the joint `continuous`.",
    "limit-order": "warning: the lower limit is above the upper limit. Exchange the two.",
    "xml-namespace": "warning: a prefix is not declared; its elements are read. Declare the "
    "prefix.",
    "xml-mended": "warning: a slip in the `<?xml ...?>` line or in a comment is mended. Correct "
    "the line.",
    "property-unused": "warning: a `<property>` has no prefix `xacro:`, and nothing uses it. "
    "Write `xacro:property`, or remove it.",
    "xacro-left": "warning: a macro's call is left out, as the file tells xacro nothing else. "
    "Include the file that defines the macro.",
    "xacro-unused-arg": "warning: no file uses the xacro argument; it has no effect. Remove it, "
    "or correct its name.",
    "unknown-element": "note: URDF does not know the element; it has no effect",
    "unknown-attribute": "note: URDF does not know the attribute; it has no effect",
    "mass-without-inertia": "note: a link has mass, but no inertia: a point mass",
    "package-folder": "error: `packages` names a folder that xacro cannot find",
}
