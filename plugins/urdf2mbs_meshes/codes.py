"""Meshes."""

CODES = {
    "mesh-missing": "warning: a mesh file was not found; its shape is left out. Put the file "
    "there, or name its package with `--package`.",
    "mesh-borrowed": "warning: a mesh was found in the folder of another robot only, and is "
    "taken from there. Name the right folder with `--package`.",
    "mesh-unreadable": "warning: a mesh file cannot be read; its shape is left out. Save the "
    "mesh anew, as `.stl` or `.obj`.",
    "mesh-too-large": "warning: the mesh files exceed `at_most`; the rest is left out. Raise "
    "`at_most`, or simplify the meshes.",
    "mesh-part": "warning: a part of a mesh cannot be shown. Save the mesh anew, if the part "
    "matters.",
    "mesh-file-missing": "warning: a file that a mesh names, such as a texture, was not "
    "found. Put the file where the mesh names it.",
    "mesh-not-ours": "warning: a `.wrl` was edited, or written by another program, and stays as "
    "it is. Remove the `.wrl` to make it anew.",
    "mesh-up-axis": "warning: COLLADA meshes were turned so that z is up, as the config asks. "
    "Leave `up_axis` out, if the robot looks wrong.",
    "mesh-moved": "note: a mesh was found elsewhere",
    "mesh-not-converted": "note: the output is one file and not a project; meshes are left out",
}
