"""The catalogue: every error, warning and note, what it means, and what to do about it.

docs/diagnostics.md is made from this table (``python -m urdf2mbs.catalogue``), and so are the
levels that a user can change.  The texts are Markdown.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Literal, NamedTuple


class Code(NamedTuple):
    """One thing that can be said."""

    meaning: str
    todo: str = ""
    level: Literal["error", "warning", "note"] = "error"


class Section(NamedTuple):
    """Codes of one kind."""

    title: str
    codes: dict[str, Code]
    intro: str = ""
    changeable: bool = False
    """Whether the user may give them another level."""


SECTIONS = [
    Section(
        "Errors that can be lowered",
        intro="What happens then is defined.",
        changeable=True,
        codes={
            "xacro-macro-unknown": Code(
                "a xacro macro is called that no file defines; the call is left out, with "
                "all that it would have made"
            ),
            "xacro-legacy": Code(
                "xacro of before 2014, without the prefix `xacro:`; the element is left "
                "out. (Where a number needs it, nothing is left to convert, and the level "
                "does not matter.)"
            ),
        },
    ),
    Section(
        "The robot's file (exit code 1)",
        codes={
            "file-not-found": Code("there is no such file", todo="mend the path"),
            "file-is-directory": Code("the source is a folder", todo="name the file in it"),
            "file-unreadable": Code(
                "a file cannot be read, or is larger than what is read; the message says which",
                todo="look at its rights",
            ),
            "file-empty": Code("there is nothing in it", todo="get it again"),
            "not-xml": Code("it is no XML", todo="a URDF begins with `<robot name=...>`"),
            "xml-syntax": Code("its XML is not well-formed", todo="mend the line named"),
            "merge-conflict": Code(
                "a merge conflict was left in the file", todo="choose one of the two versions"
            ),
            "xml-truncated": Code(
                "it ends before its elements are closed", todo="it was cut off: get it again"
            ),
            "xml-too-large": Code(
                "its XML is nested deeper, or a text in it is longer, than is read; the message "
                "says the bound",
                todo="look at the program that has made the file",
            ),
            "xml-entity": Code(
                "it declares XML entities, which are not read (they can hide attacks)",
                todo="write out what they stand for",
            ),
            "wrong-root": Code(
                "its root is not `<robot>`: SDF, MJCF, ...", todo="convert that to URDF first"
            ),
            "no-links": Code("the robot has no link"),
            "name-missing": Code("a link or joint has no name", todo="name it"),
            "name-doubled": Code("two of one name, which are not the same", todo="rename one"),
            "number-missing": Code("a number that the `.mbs` needs is not there", todo="give it"),
            "number-invalid": Code("it is not a finite number", todo="write it as 1.5 or -2e-3"),
            "number-count": Code("too many or too few numbers", todo="give as many as are wanted"),
            "joint-type-missing": Code("a joint has no type"),
            "joint-type-unknown": Code(
                "a joint's type is not known", todo="the message lists the types"
            ),
            "joint-link-missing": Code("a joint has no parent or child"),
            "joint-same-link": Code("a joint's parent is its child"),
            "link-unknown": Code(
                "a joint names a link that does not exist, and is not `world` as a parent",
                todo="the nearest name is offered",
            ),
            "axis-zero": Code("the axis of a moving joint is 0 0 0", todo="give a direction"),
            "two-parents": Code("a link is the child of two joints", todo="URDF is a tree"),
            "several-roots": Code(
                "several links have no parent, so it is not one robot",
                todo="join them, or take some away",
            ),
            "loop": Code("links form a loop", todo="URDF is a tree"),
            "mbs-unwritable": Code(
                "the model holds what an `.mbs` cannot: an infinite number (huge ones of "
                "the URDF add up), or a word of a plugin's that the format does not know",
                todo="the message says which",
            ),
            "xacro": Code(
                "xacro cannot expand the file",
                todo="the message is xacro's, with file and includes",
            ),
            "xacro-expression": Code(
                "an expression of xacro has what no robot needs: a lambda, an f-string, an "
                "attribute that begins with an underscore",
                todo="write it in another way, or `trust_xacro: true` if you trust the author",
            ),
            "xacro-file": Code(
                "xacro includes or loads a file outside of the workspace and the packages",
                todo="`packages: {NAME: DIR}`, or `trust_xacro: true` if you trust the author",
            ),
            "xacro-too-large": Code(
                "an expression or the expansion takes more work than any robot needs",
                todo="look for macros that call themselves, and for powers and repetitions",
            ),
            "xacro-arg": Code(
                "a xacro argument has no value", todo="`xacro_args`, or `--arg NAME:=VALUE`"
            ),
            "xacro-unexpanded": Code(
                "an expression is left, after xacro, where a number is wanted",
                todo="write the number",
            ),
            "package-not-found": Code(
                "a ROS package was not found, and a file in it is included; the message "
                "says where was looked",
                todo="`packages: {NAME: DIR}`, or `--package NAME=DIR`",
            ),
        },
    ),
    Section(
        "The robot's file: warnings and notes",
        changeable=True,
        codes={
            "unknown-element": Code(
                "an element that URDF does not know has no effect", level="warning"
            ),
            "unknown-attribute": Code(
                "an attribute that URDF does not know has no effect", level="warning"
            ),
            "doubled-element": Code(
                "only the first of two counts (in an `.mbs`: an error)", level="warning"
            ),
            "robot-unnamed": Code(
                "`<robot>` has no name: the robot is called as its file", level="warning"
            ),
            "name-blank": Code(
                "a name begins or ends with a blank, which is kept", level="warning"
            ),
            "inertial-incomplete": Code(
                "`<inertial>` without `<mass>` or `<inertia>`; read as ROS does", level="warning"
            ),
            "inertia-incomplete": Code(
                "products of inertia that are not given are zero, as in Drake: a tensor "
                "of three moments is a diagonal one",
                level="warning",
            ),
            "inertia-indefinite": Code(
                "no real body: a principal moment is below zero; it is kept. "
                "`estimate-inertia: {repair: true}` puts the [nearest possible "
                "one](passes/estimate-inertia.md)",
                level="warning",
            ),
            "inertia-triangle": Code(
                "no real body: one principal moment is more than the others together; it "
                "is kept, or repaired, likewise",
                level="warning",
            ),
            "mass-negative": Code(
                "no real body: a mass below zero; it is kept, or repaired to zero", level="warning"
            ),
            "inertia-without-mass": Code("inertia, but no mass", level="warning"),
            "mass-without-inertia": Code("mass, but no inertia: a point mass", level="note"),
            "inertia-repaired": Code(
                "inertias that no body can have were moved to the nearest possible ones, "
                "as asked for",
                level="warning",
            ),
            "inertia-estimated": Code(
                "links that had no inertia were given one, as asked for", level="warning"
            ),
            "number-left-out": Code(
                "a number that the `.mbs` does not need cannot be read: a limit (infinite "
                "ones, too), damping, mimic, colour; the item is left out. A visual or "
                "collision whose size or place cannot be read is left out as a whole, as "
                "it would be shown wrongly",
                level="warning",
            ),
            "mesh-scale": Code(
                "the scale of a mesh is one number; it is taken for all directions", level="warning"
            ),
            "geometry-unknown": Code(
                "a visual or collision without a geometry that we know is left out", level="warning"
            ),
            "geometry-size": Code("a size is zero or negative", level="warning"),
            "material-undefined": Code("a material is named, but nowhere defined", level="warning"),
            "material-unnamed": Code(
                "a material of `<robot>` has no name, so nobody can use it", level="warning"
            ),
            "color-range": Code("a colour is not within 0 and 1", level="warning"),
            "joint-type-spelling": Code("a joint's type has capitals or blanks", level="warning"),
            "mimic-left-out": Code(
                "a joint mimics itself, or one that does not exist: it moves freely",
                level="warning",
            ),
            "world-implied": Code(
                "a joint's parent is `world`, which is not declared: it is implied, as in Drake",
                level="warning",
            ),
            "link-unattached": Code(
                "a link without a joint and without any content is left out",
                level="warning",
            ),
            "joint-limit-missing": Code(
                "a revolute or prismatic joint without `<limit>`; read as one without limits",
                level="warning",
            ),
            "limit-order": Code("the lower limit is above the upper one", level="warning"),
            "xml-namespace": Code(
                "a prefix is not declared: its elements are read all the same", level="warning"
            ),
            "xml-mended": Code(
                "a slip that leaves the meaning clear: `<?xml ...?>` that is late, bare, "
                "doubled or of version 0.0; `--` or foreign letters within a comment",
                level="warning",
            ),
            "property-unused": Code(
                "a `<property>` without the prefix `xacro:`, which nothing uses", level="warning"
            ),
            "package-unresolved": Code(
                "a ROS package of a mesh or of another program's file was not found",
                level="warning",
            ),
            "xacro-warning": Code("xacro's own", level="warning"),
            "xacro-message": Code("xacro's own", level="note"),
            "xacro-unused-arg": Code(
                "an argument that no file uses has no effect", level="warning"
            ),
        },
    ),
    Section(
        "The conversion: warnings and notes",
        changeable=True,
        codes={
            "base": Code("whether the base floats, and why", level="note"),
            "no-mass": Code(
                "no link has mass or inertia: all frames are kept, as bodies without "
                "mass, and the model has no dynamics until masses are given",
                level="warning",
            ),
            "massless-leaf": Code(
                "joints move nothing that has mass: they are held at zero; keep them by "
                "`prune-massless: {keep: [...]}`",
                level="warning",
            ),
            "singular": Code(
                "the mass matrix is singular at every position: Robotran cannot solve the "
                "model; see [find-singular](passes/find-singular.md)",
                level="warning",
            ),
            "singular-at-start": Code(
                "the mass matrix is singular at the initial position: a simulation cannot "
                "start there",
                level="warning",
            ),
            "mbs-name": Code(
                "the file's stem is no identifier, so the model has another name", level="note"
            ),
            "ground-mass": Code("mass that is fixed to the ground has no body", level="note"),
            "axis-aligned": Code(
                "an axis is within 1e-9 of a coordinate axis or plane, and is taken to lie on it",
                level="note",
            ),
            "mimic": Code(
                "joints that follow others are independent in the `.mbs`; the message has "
                "the rules. A project couples them: see [mimic](passes/mimic.md)",
                level="warning",
            ),
            "mimic-leader": Code(
                "a joint follows one that does not move by one coordinate in the `.mbs`: "
                "it stays independent",
                level="warning",
            ),
            "mimic-held": Code(
                "a joint follows another with the multiplier 0, and is held at its offset",
                level="note",
            ),
            "mimic-massless": Code(
                "a joint moves nothing that has mass, but joints that do follow it: in a project "
                "it is kept, with a body without mass",
                level="note",
            ),
            "mimic-driven": Code(
                "a joint is driven by its leader, which does not feel its inertia, "
                "because the config says so",
                level="warning",
            ),
            "posture-limit": Code(
                "joints would start beyond their limits; in a project they start at the nearest "
                "limit: give a start position",
                level="warning",
            ),
            "posture-state": Code(
                "a group state gives a position to what is not a joint with one position",
                level="warning",
            ),
            "stand": Code(
                "how far the base was shifted so that the robot stands on the ground", level="note"
            ),
            "time-step": Code(
                "the `TIME_STEP` of a project, and which joint, foot or spring makes it shorter "
                "than 0.5 ms: see [time-step](passes/time-step.md)",
                level="note",
            ),
            "time-step-softened": Code(
                "the time step would be shorter than 1e-5 s, and numbers of stops, friction, "
                "`hold` or contacts have given way; the message has each",
                level="warning",
            ),
            "time-step-short": Code(
                "the time step is shorter than 1e-5 s, because of a number that the robot or "
                "the config states, and that does not give way",
                level="warning",
            ),
            "contacts-mesh": Code(
                "a mesh whose lowest points are wanted cannot be used", level="warning"
            ),
            "sensor-left-out": Code(
                "a sensor is on a link that is not part of a moving body, or its place, link or "
                "frame cannot be read",
                level="warning",
            ),
            "sensor-renamed": Code(
                "a sensor has no name, or that of another sensor: it gets a name of its own",
                level="warning",
            ),
            "actuator-unknown": Code(
                "a `<transmission>` or `<ros2_control>` is for a joint that does not exist",
                level="warning",
            ),
            "force-torque": Code(
                "force-torque sensors of the URDF that are left out, and how to have them",
                level="note",
            ),
            "loops": Code(
                "how many cuts there are, and which joints they make dependent", level="note"
            ),
            "loop-open": Code(
                "a loop is not closed at the start position; the message has the distance",
                level="warning",
            ),
            "loop-never-closes": Code(
                "the ends of a cut stay apart in a direction in which no joint moves them; "
                "Robotran leaves this equation out and says nothing",
                level="warning",
                todo="let the ends of the cut be at one place",
            ),
            "loop-row-of-zeros": Code(
                "a project in C has a planar loop and joints that follow others by constraints; "
                "MBsysC of 2017 may find no partition for both",
                level="warning",
                todo="move the followers by `passes: {mimic: {joints: {'*': driven}}}`",
            ),
            "loop-left-out": Code(
                "a joint in `<gazebo>` closes a loop in a way for which Robotran has no cut, or "
                "its place, links or frames cannot be read",
                level="warning",
            ),
            "loop-renamed": Code(
                "the cut of a joint in `<gazebo>` has the name of another cut or of a link, and "
                "gets another",
                level="warning",
            ),
            "generator-limits": Code(
                "more joints, cuts or sensors than most accounts of Robotran's generator "
                "of equations allow (80, 30, 30); [equations](passes/equations.md) has no "
                "limit",
                level="note",
            ),
            "project-renamed": Code(
                "user functions that were there already call the generated module by another name",
                level="warning",
            ),
            "point-without-rotation": Code(
                "frames became anchor points, which have no rotation; it is in the report",
                level="note",
            ),
            "layout-kept": Code(
                "how many bodies stay where the output that was there has them (`layout: "
                "{keep: true}`)",
                level="note",
            ),
            "layout-not-kept": Code(
                "that output cannot be read, so all places are new", level="warning"
            ),
            "texture": Code("textures of materials are left out", level="warning"),
            "collision": Code("collision shapes are left out", level="note"),
            "joint-dynamics": Code(
                "nothing applies damping and friction: a project does, or your own "
                "`user_JointForces`",
                level="warning",
            ),
            "limit": Code(
                "limits of joints that do not move by one coordinate in the `.mbs` are left out",
                level="note",
            ),
            "safety-controller": Code("the same for safety controllers", level="note"),
            "calibration": Code("the same for calibration", level="note"),
            "extension": Code("other programs' elements are left out", level="note"),
            "mesh-not-converted": Code(
                "the output is one file, not a project: meshes are not converted", level="note"
            ),
            "mesh-missing": Code(
                "a mesh file was not found; the message says where was looked", level="warning"
            ),
            "mesh-unreadable": Code("a mesh file cannot be read", level="warning"),
            "mesh-too-large": Code(
                "the mesh files of the robot are more than is read: those beyond are left out",
                todo="`convert-meshes: {at_most: MIB}`",
                level="warning",
            ),
            "mesh-part": Code("a part of a mesh cannot be shown", level="warning"),
            "mesh-file-missing": Code(
                "a file that meshes name (a texture, an `.mtl`) was not found", level="warning"
            ),
            "mesh-not-ours": Code(
                "a `.wrl` that we did not write, or that was changed since, stays as it is",
                level="warning",
                todo="remove it, and it is made of the mesh",
            ),
            "equations-stale": Code(
                "equations in `symbolicR` are of another model: ours are removed, others stay",
                level="warning",
                todo="make them anew",
            ),
            "project-obsolete": Code(
                "generated code of an earlier conversion fits no more (another language or name) "
                "and is removed",
                level="warning",
                todo="`language: both` keeps Python and C",
            ),
            "mesh-up-axis": Code(
                "COLLADA meshes were turned so that z is up, as asked; RViz and Gazebo do "
                "not: see [meshes.md](meshes.md)",
                level="warning",
            ),
            "plugin-idle": Code(
                "none of a plugin's passes is in the pipeline: put one in by `after`",
                level="warning",
            ),
        },
    ),
    Section(
        "Config and command line (exit code 2)",
        codes={
            "path-invalid": Code(
                "a path is too long, or has a character that none can have", todo="another path"
            ),
            "usage": Code("an argument does not read as it should", todo="the message says how"),
            "config-unreadable": Code("the config cannot be read"),
            "config-yaml": Code("it is not YAML", todo="mend the line named"),
            "config-type": Code("a value is of the wrong type"),
            "plugin-verdict": Code(
                "a plugin's pass or hook sets the settings, or what `check` has found",
                todo="these are for reading",
            ),
            "value-range": Code(
                "a number is outside the range of its option, infinite, or not a number",
                todo="the message says the range; the page of the pass says the unit",
            ),
            "config-key-missing": Code("a key must be given"),
            "config-key-doubled": Code("a key is there twice"),
            "unknown-key": Code("there is no such key", todo="the nearest name is offered"),
            "unknown-preset": Code("there is no such preset"),
            "unknown-code": Code(
                "`diagnostics` or `--level` names no code that can be changed",
                todo="the nearest one is offered",
            ),
            "unknown-pass": Code(
                "there is no such pass, or it is not in this pipeline",
                todo="`urdf2mbs passes` lists all",
            ),
            "unknown-plugin": Code("`swap` names a plugin that does not bring the pass"),
            "pass-doubled": Code("a pass is in the pipeline twice"),
            "pass-ambiguous": Code(
                "two plugins bring a pass of one name", todo="`swap: {PASS: PLUGIN}`"
            ),
            "pass-name": Code("`new-pass` cannot use this name"),
            "need-not-given": Code("a pass needs what no pass gives", todo="put in one that does"),
            "wrong-order": Code("a pass needs what is given only later", todo="change the order"),
            "given-twice": Code("two passes give the same", todo="leave one out"),
            "mimic-joints": Code("the option of mimic names no joint that follows another"),
            "actuators-joints": Code("actuators names no joint that moves"),
            "posture-joint": Code(
                "posture names something that is not a joint with a position of its own",
                todo="the nearest name is offered",
            ),
            "posture-srdf": Code(
                "the SRDF file cannot be read, or has no such group state",
                todo="those that it has are offered",
            ),
            "posture-hold": Code("no joint fits a pattern of `hold`"),
            "contacts-links": Code("contacts names no link", todo="the nearest name is offered"),
            "contacts-body": Code(
                "no force can act on a link: it never moves, or has no body of its own",
                todo="the message says what to do",
            ),
            "contacts-shape": Code("a link has no shape to take points of", todo="give the points"),
            "sensors-only": Code(
                "sensors: `only` names no sensor of the URDF", todo="the nearest name is offered"
            ),
            "sensors-links": Code("sensors names no link", todo="the nearest name is offered"),
            "force-torque-joint": Code(
                "a joint cannot be a force-torque sensor", todo="the message says why"
            ),
            "loops-link": Code(
                "a cut does not end at a link with a body", todo="the nearest name is offered"
            ),
            "loops-length": Code("a cut that is no rod has a length"),
            "loops-dependent": Code(
                "the joints in `dependent` cannot be solved for", todo="name more, or leave it out"
            ),
            "forces-link": Code(
                "a force does not act on a link with a body that moves",
                todo="the nearest name is offered",
            ),
            "forces-name": Code(
                "a wrench or spring has a name that Robotran cannot use",
                todo="letters, digits and `_`, a letter first",
            ),
            "loops-name": Code("a cut is called as a link is", todo="another name"),
            "forces-spring": Code("the ends of a spring coincide"),
            "stale": Code(
                "a pass needs what is out of date: another pass changed what it was made from",
                todo="the message names both passes: change the order",
            ),
            "tolerance-invalid": Code(
                "the tolerance of `verify` is not above 0 and at most 1e-3", todo="such as `1e-9`"
            ),
            "estimate-inertia": Code("its options contradict each other or the robot"),
            "package-missing": Code("`packages` names a folder that does not exist"),
            "package-folder": Code("the same, found by xacro"),
            "output-is-source": Code("the output would overwrite the robot"),
            "output-is-folder": Code("the output is a folder", todo="name the file"),
            "output-not-ours": Code(
                "a file that would be replaced was edited since urdf2mbs wrote it, or another "
                "program wrote it (MBSysPad saves an `.mbs` without the seal; Robotran's generator "
                "gives its files in `symbolicR` the names of ours)",
                todo="move it away, write elsewhere, or replace it by `--force`",
            ),
            "project-in-source": Code(
                "a new project would land in the folder that holds the robot",
                todo="name another folder",
            ),
            "output-unwritable": Code(
                "a file cannot be written; of several files none is", todo="look at the rights"
            ),
            "output-doubled": Code(
                "two of many robots would be written to one file",
                todo="give each an output of its own",
            ),
            "folder-empty": Code(
                "there is no robot in the folder",
                todo="a robot is a `.urdf` file, or a `.xacro` file whose `<robot>` has a name",
            ),
            "sweep-empty": Code("a sweep, or one of its lists, has no values"),
            "sweep-long": Code("a sweep makes more than a million robots"),
            "sweep-many": Code(
                "the config is a sweep, and one robot is wanted",
                todo="`urdf2mbs run` makes them all",
            ),
            "sweep-output": Code(
                "the output does not tell the robots of a sweep apart, or names a value that "
                "is none",
                todo="`output: models/{height}.mbs`",
            ),
            "sweep-range": Code(
                "a range has no `from` and `to`, not one of `step` and `count`, or its steps do "
                "not lead there",
                todo="`{from: 0.7, to: 0.9, step: 0.1}`",
            ),
            "sweep-twice": Code("a value is given, and swept", todo="leave one of the two out"),
            "cluster-unreachable": Code(
                "no Dask scheduler answers at the address", todo="`dask scheduler` prints its own"
            ),
            "cluster-failed": Code(
                "the workers of the cluster cannot convert",
                todo="install the same urdf2mbs there",
            ),
            "worker-died": Code(
                "of many robots: the process that converts this one was ended twice by the system",
                todo="it may need more memory than there is",
            ),
            "variable-unset": Code(
                "a path in the config names a `$VARIABLE` that is not set", todo="set it"
            ),
            "unknown-description": Code(
                "`robot_descriptions` has no robot of this name", todo="the hint names the nearest"
            ),
            "description-no-urdf": Code(
                "`robot_descriptions` has this robot in another format only (MJCF)",
                todo="another name",
            ),
            "description-unreachable": Code(
                "the robot is not in the cache, and cannot be fetched",
                todo="connect to the network once",
            ),
            "config-name": Code(
                "the file that `init` is to write does not end in .yaml", todo="another name"
            ),
            "extra-missing": Code(
                "a package that is not installed is needed", todo="`pip install 'urdf2mbs[EXTRA]'`"
            ),
            "pinocchio-refused": Code(
                "`verify --engine pinocchio`: Pinocchio's own reader refuses the URDF",
                todo="compare with the own engine",
            ),
            "no-mbs": Code("the pipeline makes no `.mbs` to report on", todo="put `emit` in"),
        },
    ),
    Section(
        "Plugins (exit code 2)",
        codes={
            "plugin-missing": Code("the file does not exist"),
            "plugin-broken": Code(
                "the plugin cannot be loaded, or what it brings is wrong; the message "
                "says what. A warning, without exit code, for an installed plugin: it is "
                "left out"
            ),
            "plugin-empty": Code("it has no function marked `@hookimpl`"),
            "plugin-doubled": Code("two plugins of one name"),
        },
    ),
    Section(
        "Plugins at work (exit code 1)",
        codes={
            "plugin-failed": Code(
                "an exception in a plugin's pass or hook; `--debug` shows the traceback"
            ),
            "plugin-robot-broken": Code("a plugin's pass leaves links and joints that are no tree"),
            "plugin-output-broken": Code(
                "a plugin's pass leaves files that are not `Path: bytes`, or a report "
                "that cannot be JSON"
            ),
            "memory-full": Code("there is not enough memory", todo="the message says for what"),
            "internal": Code("an exception in urdf2mbs itself: please report it"),
        },
    ),
    Section(
        "Reading an .mbs",
        codes={
            "model-unreadable": Code(
                "the `.mbs` cannot be read, or is larger than what is read (exit code 2)",
                todo="mend its path, or look at its rights",
            ),
            "mbsname-no-identifier": Code(
                "`equations`: the files are called after `<mbsname>`, and it is no name "
                "that a program can have"
            ),
            "not-mbs": Code("its root is not `mbsDescR7`"),
            "mbs-incomplete": Code("an element is missing without which Robotran goes wrong"),
            "mbs-schema": Code("a warning: it departs from the format's schema", level="warning"),
            "body-without-joint": Code("Robotran would lose the body"),
            "parent-missing": Code("a body has no parent"),
            "parent-unknown": Code("its parent does not exist"),
            "parent-order": Code("its parent stands later in the file"),
            "point-unknown": Code("its anchor point does not exist"),
            "name-unknown": Code(
                "a cut, a link or a user constraint that a plugin's pass has added names "
                "what the model does not have"
            ),
            "joint-unknown": Code("a user constraint names a joint that does not exist"),
            "joint-nature-unknown": Code(
                "a joint's nature is none of `independent`, `dependent`, `driven`"
            ),
            "value-unknown": Code("a measure of a sensor is not `true`"),
            "mbs-not-first": Code(
                "a comment or an element stands before a name or before `coordinates`: Robotran's "
                "C library takes the first child, whatever it is",
                todo="move it behind",
            ),
            "mbs-not-plain": Code(
                "a comment or an element stands within a name", todo="take it away"
            ),
            "origin-moved": Code(
                "a point called `origin`, which is the body's own frame, is not at 0 0 0",
                todo="give it another name",
            ),
            "base-sensor": Code(
                "a sensor or an external force sits on the base", todo="put it on a body"
            ),
            "no-drawing": Code("the file has no 2D diagram to draw"),
        },
    ),
]

CATALOGUE = {code: one for section in SECTIONS for code, one in section.codes.items()}

#: All whose level can be changed, and the level that they have; what is not here is an error
#: that leaves nothing to convert.
DEFAULTS = {
    code: one.level
    for section in SECTIONS
    if section.changeable
    for code, one in section.codes.items()
}


# --- the page: python -m urdf2mbs.catalogue > docs/diagnostics.md ---

HEAD = """\
# Errors, warnings, notes

<!-- Made by `python -m urdf2mbs.catalogue > docs/diagnostics.md`: do not edit. -->

An **error** ends a conversion, and nothing is written. A **warning** says that something of the robot is not in the `.mbs` as one would expect. A **note** says what was decided (`-v` shows notes; `--json` has all). Each reads `file:line: level[code]: message`, with what to do below it. The codes are stable.

The errors in a URDF's links and joints are told all at once, up to 20 of them. An error in xacro names the macros and files that led to it, the innermost first.

## Levels are yours

Every warning and note below can be made an `error`, a `warning`, a `note` or nothing (`ignore`), and so can the errors in the first table. In the config:

```yaml
diagnostics: {inertia-indefinite: error, mesh-missing: ignore}
strict: true   # all other warnings are errors
```

On the command line, of `run`, `convert`, `report` and `explain`, `--level CODE=LEVEL` (as often as wanted) goes before the config, and `--strict` is the same as `strict: true`. A level that is given by its code goes before `strict`. All errors of a run are told at once.

All errors but those of the first table leave nothing to convert, and cannot be changed.

Exit codes: 0 done; 1 this robot cannot be converted; 2 the command line, the config or a plugin is wrong; 3 converted, but not the same robot.
"""  # noqa: E501


def page() -> str:
    """The text of docs/diagnostics.md."""
    return "".join([HEAD, *(part for section in SECTIONS for part in _section(section))])


def _section(section: Section) -> Iterator[str]:
    yield f"\n## {section.title}\n\n"
    if section.intro:
        yield f"{section.intro}\n\n"
    level = section.changeable
    yield "| code |" + " |" * level + " meaning | what to do |\n" + "|---" * (3 + level) + "|\n"
    for code, one in section.codes.items():
        yield f"| `{code}` |" + f" {one.level} |" * level + f" {one.meaning} | {one.todo} |\n"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")  # type: ignore[union-attr]
    sys.stdout.write(page())
