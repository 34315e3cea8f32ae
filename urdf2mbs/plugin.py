"""All that a plugin imports, ours as anybody's: one door, stable from version to version.

Each name in ``__all__`` keeps its name and meaning within one ``VERSION``.  Before a name goes,
it warns for one minor release (``DeprecationWarning``; a hook by pluggy's ``warn_on_impl``).
Everything else in the package may change from one day to the next.

A plugin that only names its passes and commands imports no more than the hooks: the other names
are imported when they are first used.  A type checker and an editor read them in ``plugin.pyi``;
``python docs/make_stub.py`` writes it, from the table below.  So is the site's page "Plugin API".
"""

#: The version of this interface.
VERSION = 1

#: The names of each module, by subject.  ``write as write_output`` is called ``write_output`` here.
EXPORTS: dict[str, dict[str, tuple[str, ...]]] = {
    "A plugin: its hooks, passes and commands": {
        "hookspecs": (
            "Command",
            "GROUP",
            "Pass",
            "PassEntry",
            "always",
            "asked",
            "hookimpl",
            "in_project",
        ),
    },
    "A conversion: what passes share": {
        "conversion": (
            "Conversion",
            "File",
            "Intent",
            "Names",
            "Segment",
            "Settings",
            "Step",
            "Summary",
            "Use",
            "choose",
            "fits",
        ),
    },
    "What passes tell each other": {
        "states": (
            "Estimates",
            "JointModels",
            "OnPurpose",
            "Placed",
            "SecondOpinions",
        ),
    },
    "Messages and errors": {
        "messages.diagnostics": (
            "ConfigError",
            "ConversionError",
            "Diagnostic",
            "counted",
            "nearest",
            "not_installed",
            "printable",
            "quoted",
            "some",
        ),
    },
    "Configs": {
        "config.model": (
            "Config",
            "Project",
            "Range",
            "Sweep",
        ),
        "config.lines": (
            "Key",
            "Lines",
            "dotted",
        ),
        "config.load": (
            "config_of",
            "typed",
        ),
        "config.paths": ("expand",),
    },
    "Numbers of options": {
        "ranges": (
            "PositiveLength",
            "Tolerance",
            "rounded",
        ),
    },
    "Running passes": {
        "engine.pipeline": ("Pipeline",),
        "engine.plugins": (
            "Plugins",
            "load_pass",
        ),
        "engine.order": (
            "ConfiguredPass",
            "list_method",
        ),
        "engine.entry_points": ("version_of",),
    },
    "Writing files": {
        "engine.output": (
            "check_ours",
            "write as write_output",
            "write_files",
        ),
    },
    "Results in words": {
        "engine.summaries": ("of_plugins",),
        "summary": (
            "Report",
            "left_out",
            "report",
            "verdict",
        ),
    },
    "Commands": {
        "commands": ("parser",),
        "commands.kinds": (
            "check_ending",
            "check_kind",
            "find_kind",
            "find_model",
            "propose_in_folder",
        ),
        "commands.printing": (
            "beside",
            "near",
            "print_json",
            "print_summary as tell",
            "print_diagnostics as tell_diagnostics",
            "with_near_paths",
        ),
        "commands.progress": (
            "Progress",
            "estimate_end",
        ),
        "commands.settings": (
            "ALONE",
            "FLAGS",
            "READING",
            "add_fields",
            "add_json",
            "add_no_plugins",
            "add_printing",
            "add_running",
            "add_verbose",
            "choose_fields",
            "field_docs",
            "path",
            "refuse",
            "robot_or_config",
            "without_config",
        ),
        "commands.streams": (
            "STREAM",
            "is_stream",
            "saving",
        ),
    },
    "Files": {
        "disk.files": (
            "absolute",
            "is_file",
            "is_folder",
            "is_portable",
            "model_of",
            "noting",
            "project_of",
            "read_bytes",
            "read_model",
            "size",
            "temporary_name",
        ),
        "disk.record": (
            "RECORD",
            "checksum",
            "is_ours",
            "was_ours",
        ),
        "disk.xml": ("safe_parser",),
    },
    "Rotations, poses and inertias": {
        "spatial": (
            "HERE",
            "IDENTITY",
            "NO_INERTIA",
            "Pose",
            "ROUNDING",
            "Rot",
            "Sym",
            "Vec",
            "ZERO",
            "add",
            "axis_turns",
            "compose",
            "cross",
            "direction",
            "dot",
            "drop_rounding",
            "fewest_turns",
            "from_rpy",
            "from_turns",
            "inverse",
            "lump",
            "multiply",
            "rotate",
            "rotate_inertia",
            "transpose",
            "unit",
        ),
    },
    "The robot of a URDF": {
        "urdf.model": (
            "Box",
            "Capsule",
            "ClosingJoint",
            "Collision",
            "Cylinder",
            "Dynamics",
            "Extension",
            "Geometry",
            "Inertial",
            "JOINT_TYPES",
            "Joint as UrdfJoint",
            "Link",
            "Mesh",
            "Mimic",
            "Origin",
            "Robot",
            "Sensor as UrdfSensor",
            "Sphere",
            "Visual",
        ),
        "urdf.reader": (
            "Expansion",
            "Located",
            "choose_file_name",
            "choose_title",
            "is_name",
            "read_robot_file",
            "read_text",
            "stem",
        ),
        "urdf.macros": ("is_robot_file",),
        "urdf.values": ("Reading",),
        "urdf.elements": (
            "LEGACY",
            "LEGACY_HINT",
            "is_xacro",
            "plain",
            "quote",
            "split_tag",
        ),
        "urdf.harmless": (
            "OFF",
            "ON",
        ),
        "urdf.inertia": (
            "moments",
            "principal",
            "second_moment",
        ),
        "urdf.mimic": (
            "find_locked_joints",
            "follow",
        ),
        "urdf.renaming": ("rename_elements",),
        "urdf.packages": (
            "Packages",
            "absolute_path",
            "walk",
            "workspace",
        ),
    },
    "The .mbs": {
        "mbs.model": (
            "BASE",
            "Base",
            "Body",
            "CUTS",
            "Connection",
            "Drawing",
            "Joint as MbsJoint",
            "LinkFrame",
            "Mbs",
            "ORIGIN",
            "Parameter",
            "Part",
            "Point",
            "RGB",
            "SENSOR_MEASURES",
            "Sensor as MbsSensor",
            "Shape",
            "UserConstraint",
            "UserModel",
            "XY",
            "without_origin",
        ),
        "mbs.fields": (
            "INSIDE",
            "KEPT",
            "OBJECTS",
            "Table",
        ),
        "mbs.kinematics": (
            "PlacedJoint",
            "Placement",
            "compute_placement",
        ),
        "mbs.names": (
            "free_name",
            "identifiers",
        ),
        "mbs.reader": (
            "read_mbs",
            "read_mbs_again",
            "read_mbs_file",
        ),
    },
    "The proof": {
        "proof.verdict": ("Difference",),
        "proof.urdf_side": ("in_plane",),
    },
}
#: Modules by the names that they have here.
MODULES = {
    "files": "disk.files",
    "inertia": "urdf.inertia",
    "mbs": "mbs.model",
    "packages": "urdf.packages",
    "spatial": "spatial",
    "urdf": "urdf.model",
    "writer": "mbs.writer",
    "written": "urdf.written",
    "xml": "urdf.xml",
}


def _list_places() -> dict[str, tuple[str, str]]:
    """Return where each name of ``EXPORTS`` comes from: its module, and its name there."""
    places: dict[str, tuple[str, str]] = {}
    for modules in EXPORTS.values():
        for module, names in modules.items():
            for name in names:
                original, _, renamed = name.partition(" as ")
                places[renamed or original] = (f"urdf2mbs.{module}", original)
    return places


#: Where each name comes from: its module, and its name there.
PLACES = _list_places()
__all__ = ["VERSION", *MODULES, *PLACES]


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name in MODULES:
        value: object = import_module(f"urdf2mbs.{MODULES[name]}")
    else:
        module, original = PLACES.get(name, ("", ""))
        if not module:
            raise AttributeError(f"module 'urdf2mbs.plugin' has no attribute '{name}'")
        value = getattr(import_module(module), original)
    globals()[name] = value
    return value
