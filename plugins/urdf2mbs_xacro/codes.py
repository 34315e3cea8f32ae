"""xacro, and robots by their name."""

CODES = {
    "xacro-macro-unknown": "error, unless lowered: no file defines a macro; its call is left out. "
    "Include its file.",
    "xacro": "error: xacro cannot expand the file. Correct the line that is named.",
    "xacro-expression": "error: an expression (`expand`) has a part that is not allowed. "
    "Rewrite it, or give `--trust-xacro`.",
    "xacro-file": "error: xacro would read a file outside of the workspace and the packages. "
    "Name its package, or give `--trust-xacro`.",
    "xacro-too-large": "error: a value, a file or the expansion is beyond its limit. "
    "Shorten it, or give `--trust-xacro`.",
    "xacro-arg": "error: a xacro argument has no value. Give it by `--arg`.",
    "xacro-incompatible": "error: the installed xacro lacks what urdf2mbs replaces in it. "
    "Install the version that is named.",
    "package-unresolved": "warning: the ROS package of a mesh was not found. Name its folder "
    "with `--package`.",
    "xacro-warning": "warning: a warning of xacro. Ask who wrote the file.",
    "xacro-message": "note: a message of xacro",
    "unknown-description": "error: `robot_descriptions` has no robot of this name. "
    "Correct the name.",
    "description-no-urdf": "error: `robot_descriptions` has the robot as MJCF only. "
    "Take another robot.",
    "description-unreachable": "error: the robot is not in the cache, and cannot be fetched. "
    "Connect to the network once.",
}
