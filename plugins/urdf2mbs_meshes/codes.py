"""Meshes."""

CODES = {
    "mesh-missing": "warning: a mesh file was not found; its shape is left out",
    "mesh-borrowed": "warning: a mesh was found in the folder of another robot only; it is taken",
    "mesh-unreadable": "warning: a mesh file cannot be read; its shape is left out",
    "mesh-too-large": "warning: the mesh files exceed `at_most`; the rest is left out",
    "mesh-part": "warning: a part of a mesh cannot be shown",
    "mesh-file-missing": "warning: a file that a mesh names, a texture for example, was not found",
    "mesh-not-ours": "warning: a `.wrl` was edited, or another program wrote it; it stays as it is",
    "mesh-up-axis": "warning: COLLADA meshes were turned so that z is up, as the config asks",
    "mesh-moved": "note: a mesh was found elsewhere",
    "mesh-not-converted": "note: the output is one file and not a project; meshes are left out",
}
