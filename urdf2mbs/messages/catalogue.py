"""The catalogue: every error, warning and note, and what it means.

``python -m urdf2mbs.messages.catalogue`` makes docs/diagnostics.md from this table.  The levels
that a user can change come from it, too.  A message says itself what to do; the texts here are
Markdown.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

NONE: Mapping[str, str] = MappingProxyType({})


class Section(NamedTuple):
    """Codes of one kind, each with its meaning."""

    title: str
    errors: Mapping[str, str] = NONE
    warnings: Mapping[str, str] = NONE
    notes: Mapping[str, str] = NONE
    changeable: bool = False
    """True if the user may give them another level."""

    @property
    def levels(self) -> dict[str, Mapping[str, str]]:
        """The codes and their meanings by level."""
        return {"error": self.errors, "warning": self.warnings, "note": self.notes}


SECTIONS = [
    Section(
        "Errors that can be lowered",
        changeable=True,
        errors={
            "xacro-macro-unknown": "no file defines a xacro macro; its call is left out",
            "xacro-legacy": "an element of xacro from before 2014, without `xacro:`, is left out",
        },
    ),
    Section(
        "The robot's file (exit code 1)",
        errors={
            "file-not-found": "there is no such file",
            "file-is-directory": "the source is a folder",
            "file-unreadable": "a file cannot be read, or is too large",
            "file-empty": "the file is empty",
            "not-xml": "the file is not XML",
            "xml-syntax": "the XML is not well-formed",
            "merge-conflict": "the file has a merge conflict",
            "xml-truncated": "the file ends before its elements are closed",
            "xml-too-large": "the XML is nested too deeply, or a text in it is too long",
            "xml-entity": "the file declares XML entities; they can hide attacks and are not read",
            "wrong-root": "the root is not `<robot>`: the file is SDF, MJCF or something else",
            "no-links": "the robot has no link",
            "name-missing": "a link or joint has no name",
            "name-doubled": "two links or joints have one name and differ",
            "number-missing": "a number that the `.mbs` needs is missing",
            "number-invalid": "a number is not finite, or not a number",
            "number-count": "there are too many or too few numbers",
            "joint-type-missing": "a joint has no type",
            "joint-type-unknown": "a joint has a type that URDF does not know",
            "joint-link-missing": "a joint has no parent or no child",
            "joint-same-link": "a joint has one link as parent and child",
            "link-unknown": "a joint names a link that does not exist",
            "axis-zero": "the axis of a moving joint is 0 0 0",
            "two-parents": "a link is the child of two joints; a URDF is a tree",
            "several-roots": "several links have no parent; a URDF is one robot",
            "loop": "links form a loop; a URDF is a tree",
            "mbs-unwritable": (
                "the model has an infinite number, or a word that the format does not know"
            ),
            "xacro": "xacro cannot expand the file",
            "xacro-expression": "an [expression](passes/expand.md) has a part that is not allowed",
            "xacro-file": "xacro would read a file outside of the workspace and the packages",
            "xacro-too-large": "an expression or the expansion takes too much work or memory",
            "xacro-arg": "a xacro argument has no value",
            "xacro-unexpanded": "after xacro an expression stands where a number must be",
            "package-not-found": "the ROS package of an included file was not found",
        },
    ),
    Section(
        "The robot's file: warnings and notes",
        changeable=True,
        warnings={
            "misspelt": "the name of an element or attribute is nearly one of URDF; no effect",
            "mechanics-unread": (
                "an element or attribute states mechanics where URDF does not know it; no effect"
            ),
            "doubled-element": "an element is there twice; the first counts",
            "robot-unnamed": "`<robot>` has no name; the robot gets the name of its file",
            "name-blank": "a name begins or ends with a blank; the blank is kept",
            "inertial-incomplete": "`<inertial>` has no `<mass>` or no `<inertia>`",
            "inertia-incomplete": "products of inertia are missing; they are zero, as in Drake",
            "inertia-indefinite": "no body has this inertia: a principal moment is negative",
            "inertia-triangle": (
                "no body has this inertia: one principal moment exceeds the other two"
            ),
            "mass-negative": "a mass is negative",
            "inertia-without-mass": "a link has inertia, but no mass",
            "inertia-repaired": (
                "inertias were [moved](passes/estimate-inertia.md) to possible ones"
            ),
            "inertia-estimated": "links without inertia got an inertia, as the config asks",
            "number-left-out": "a number of a limit, damping, mimic, colour or shape is left out",
            "mesh-scale": "a mesh has one number as scale; it counts for all directions",
            "geometry-unknown": "a shape has no geometry that URDF knows; it is left out",
            "geometry-size": "a size is zero or negative",
            "material-undefined": "a material is named, and defined nowhere",
            "material-unnamed": "a material of `<robot>` has no name; no visual can use it",
            "color-range": "a colour is outside of 0 to 1",
            "joint-type-spelling": "the type of a joint has capitals or blanks",
            "mimic-left-out": "a joint mimics itself, or no joint; it moves freely",
            "world-implied": "a joint has the parent `world`, and no link has this name",
            "link-unattached": "a link has no joint and no content; it is left out",
            "joint-limit-missing": "a joint has no `<limit>`; it moves without limits",
            "limit-order": "the lower limit is above the upper limit",
            "xml-namespace": "a prefix is not declared; its elements are read",
            "xml-mended": "a slip in the `<?xml ...?>` line or in a comment is mended",
            "property-unused": "a `<property>` has no prefix `xacro:`, and nothing uses it",
            "package-unresolved": "the ROS package of a mesh was not found",
            "xacro-warning": "a warning of xacro",
            "xacro-unused-arg": "no file uses the xacro argument; it has no effect",
        },
        notes={
            "unknown-element": "URDF does not know the element; it has no effect",
            "unknown-attribute": "URDF does not know the attribute; it has no effect",
            "mass-without-inertia": "a link has mass, but no inertia: a point mass",
            "xacro-message": "a message of xacro",
        },
    ),
    Section(
        "The conversion: warnings and notes",
        changeable=True,
        warnings={
            "base-guessed": (
                "the URDF does not say whether the base floats; `base: fixed` or "
                "`base: floating` does"
            ),
            "no-mass": "no link has mass or inertia; the model has no dynamics",
            "massless-leaf": "joints move no mass; they are [held](passes/prune-massless.md)",
            "singular": "the mass matrix is [singular](passes/find-singular.md) at every position",
            "singular-at-start": "the mass matrix is singular at the initial position",
            "mimic": (
                "joints that follow others are independent; a [project](passes/mimic.md) couples "
                "them"
            ),
            "mimic-leader": (
                "a joint follows a joint that is not one coordinate; it stays independent"
            ),
            "mimic-driven": "a joint is driven by its leader, which does not feel its inertia",
            "posture-limit": "joints start beyond their limits; a project starts them at a limit",
            "posture-state": "a group state names a joint that has not one position",
            "time-step-softened": "numbers give way, because the time step would be below 1e-5 s",
            "time-step-short": (
                "a number of the robot or the config makes the time step shorter than 1e-5 s"
            ),
            "contacts-balance": (
                "the centre of mass of a robot that floats is not over its contact points"
            ),
            "contacts-mesh": "the lowest points of a mesh cannot be found",
            "sensor-left-out": "a sensor is on no moving body, or cannot be read",
            "sensor-renamed": "a sensor has no name, or the name of another; it gets its own",
            "actuator-unknown": "a transmission names a joint that does not exist",
            "loop-open": "a loop is open at the start position",
            "loop-never-closes": "no joint can close a loop; Robotran says nothing",
            "loop-row-of-zeros": "a planar loop and mimic: MBsysC of 2017 may find no partition",
            "loop-left-out": "a joint in `<gazebo>` cannot become a cut, or cannot be read",
            "loop-renamed": "a cut has the name of another cut or of a link; it gets its own",
            "project-renamed": "your user functions call the generated module by another name",
            "layout-not-kept": (
                "the earlier output cannot be read; all places in the diagram are new"
            ),
            "texture": "textures of materials are left out",
            "joint-dynamics-lost": (
                "damping and friction of joints that are not one coordinate are left out"
            ),
            "mesh-missing": "a mesh file was not found",
            "mesh-unreadable": "a mesh file cannot be read",
            "mesh-too-large": (
                "the mesh files exceed [`at_most`](meshes.md#bounds); the rest is left out"
            ),
            "mesh-part": "a part of a mesh cannot be shown",
            "mesh-file-missing": "a file that a mesh names, a texture for example, was not found",
            "mesh-not-ours": "a `.wrl` was edited, or another program wrote it; it stays as it is",
            "mesh-up-axis": (
                "[COLLADA meshes](meshes.md) were turned so that z is up, as the config asks"
            ),
            "equations-stale": "equations in `symbolicR` are of another model; ours are removed",
            "project-obsolete": "generated code of an earlier conversion is removed",
            "plugin-idle": "no pass of a plugin is in the pipeline",
        },
        notes={
            "base": "whether the base floats, and why",
            "mbs-name": "the name of the file is no identifier; the model has another name",
            "ground-mass": "mass that is fixed to the ground has no body",
            "axis-aligned": (
                "an axis is within 1e-9 of a coordinate axis or plane, and is put there"
            ),
            "mimic-held": "a joint follows another with the multiplier 0; it is held at its offset",
            "mimic-massless": "a joint without mass leads joints with mass; a project keeps it",
            "stand": "how far the base was moved so that the robot stands on the ground",
            "time-step": (
                "the [`TIME_STEP`](passes/time-step.md) of a project, and what makes it short"
            ),
            "force-torque": "force-torque sensors of the URDF are left out",
            "loops": "how many cuts there are, and which joints they make dependent",
            "law-unknown": "a plugin adds a force law, which nothing proves",
            "generator-limits": "the model exceeds most accounts of Robotran's generator",
            "point-without-rotation": "frames became anchor points, which have no rotation",
            "layout-kept": "how many bodies stay where the earlier output has them",
            "collision": "collision shapes are left out",
            "joint-dynamics": "nothing applies damping and friction; a project does",
            "limit": "limits of joints that are not one coordinate are left out",
            "safety-controller": "safety controllers of such joints are left out",
            "calibration": "the calibration of such joints is left out",
            "extension": "elements of other programs are left out",
            "mesh-moved": "a mesh was [found elsewhere](meshes.md#where-meshes-are-found)",
            "mesh-not-converted": "the output is one file and not a project; meshes are left out",
        },
    ),
    Section(
        "Config and command line (exit code 2)",
        errors={
            "path-invalid": "a path is too long, or has a character that no path can have",
            "usage": "an argument of the command line is wrong",
            "config-unreadable": "the config cannot be read",
            "config-yaml": "the config is not YAML",
            "config-type": "a value has the wrong type",
            "config-key-missing": "a key is missing",
            "config-key-doubled": "a key is there twice",
            "config-name": "the name of the file that `init` writes does not end in `.yaml`",
            "value-range": "a number is outside of the range of its option",
            "tolerance-invalid": "the tolerance of `verify` is outside of its range",
            "unknown-key": "there is no such key",
            "unknown-preset": "there is no such preset",
            "preset-circle": "presets extend each other in a circle",
            "unknown-code": "`diagnostics` or `--level` names a code that cannot be changed",
            "unknown-pass": "there is no such pass, or it is not in the pipeline",
            "unknown-plugin": "`swap` names a plugin that does not bring the pass",
            "pass-doubled": "a pass is in the pipeline twice",
            "pass-ambiguous": "two plugins bring a pass of one name",
            "pass-name": "`new-pass` cannot use the name",
            "need-not-given": "a pass reads a section that no pass writes",
            "wrong-order": "a pass reads a section that a later pass writes",
            "stale": "a pass changes a section from which an earlier pass has made another",
            "plugin-verdict": "a plugin changes the settings or the result of `check`",
            "mimic-joints": "`mimic` names no joint that follows another",
            "actuators-joints": "`actuators` names no joint that moves",
            "posture-joint": "`posture` names no joint with a position of its own",
            "posture-srdf": "the SRDF file cannot be read, or has no such group state",
            "posture-hold": "no joint fits a pattern of `hold`",
            "contacts-links": "`contacts` names no link",
            "contacts-body": "no force can act on a link: it never moves, or has no body",
            "contacts-shape": "a link has no shape that gives contact points",
            "sensors-only": "`only` of `sensors` names no sensor of the URDF",
            "sensors-links": "`sensors` names no link",
            "force-torque-joint": "a joint cannot be a force-torque sensor",
            "loops-link": "an end of a cut is not on a link with a body",
            "loops-length": "a ball or a solid has a length; only a rod has one",
            "loops-dependent": "the constraints cannot be solved for the joints in `dependent`",
            "loops-name": "a cut has the name of a link",
            "forces-link": "a force does not act on a link with a body that moves",
            "forces-name": "the name of a wrench or spring is no identifier",
            "forces-spring": "the ends of a spring are at one place",
            "estimate-inertia": "the options contradict each other or the robot",
            "package-missing": "`packages` names a folder that does not exist",
            "package-folder": "`packages` names a folder that xacro cannot find",
            "output-is-source": "the output would replace the robot",
            "output-is-folder": "the output is a folder",
            "output-not-ours": (
                "the output [was edited](first-simulation.md#whose-a-file-is), or is not ours"
            ),
            "output-unwritable": "a file cannot be written; no file was written",
            "output-doubled": "two robots have one output",
            "project-in-source": "a new project would be in the folder of the robot",
            "folder-empty": "there is no robot in the folder",
            "sweep-empty": "a sweep, or a list in it, has no values",
            "sweep-long": "a sweep makes more than a million robots",
            "sweep-many": "the config makes many robots, and the command wants one",
            "sweep-output": "two robots have one output, or the output names an unknown value",
            "sweep-range": "a range is incomplete, or its steps do not end at `to`",
            "sweep-twice": "a value is given and swept",
            "cluster-unreachable": "no Dask scheduler answers at the address",
            "cluster-failed": "the workers of the cluster cannot convert",
            "worker-died": "the system ended the process of a robot twice",
            "variable-unset": "a path names a `$VARIABLE` that is not set",
            "unknown-description": "`robot_descriptions` has no robot of this name",
            "description-no-urdf": "`robot_descriptions` has the robot as MJCF only",
            "description-unreachable": "the robot is not in the cache, and cannot be fetched",
            "extra-missing": "a package is not installed",
            "pinocchio-refused": "Pinocchio's reader refuses the URDF",
            "no-mbs": "the pipeline makes no `.mbs` for the report",
        },
    ),
    Section(
        "Plugins (exit code 2)",
        errors={
            "plugin-missing": "the file of the plugin does not exist",
            "plugin-broken": "the plugin cannot be loaded; an installed plugin is left out",
            "plugin-empty": "the plugin has no function marked `@hookimpl`",
            "plugin-doubled": "two plugins have one name",
        },
    ),
    Section(
        "Plugins at work (exit code 1)",
        errors={
            "plugin-failed": "a plugin's pass or hook has failed; `--debug` shows the traceback",
            "plugin-robot-broken": "a plugin's pass leaves links and joints that are not a tree",
            "plugin-output-broken": (
                "a plugin's pass leaves files or a report that cannot be written"
            ),
            "law-missing": "a plugin's law has no function in a language of the project",
            "law-doubled": "two laws of plugins have one name",
            "memory-full": "there is not enough memory",
            "internal": "urdf2mbs has failed: please report it",
        },
    ),
    Section(
        "Reading an .mbs",
        errors={
            "model-unreadable": "the `.mbs` cannot be read, or is too large (exit code 2)",
            "mbsname-no-identifier": "`<mbsname>` is no identifier, and the equations need one",
            "not-mbs": "the root is not `mbsDescR7`",
            "mbs-incomplete": "an element is missing that Robotran needs",
            "mbs-schema": "a warning: the file departs from the schema of the format",
            "body-without-joint": "a body has no joint; Robotran would lose it",
            "parent-missing": "a body has no parent",
            "parent-unknown": "the parent of a body does not exist",
            "parent-order": "the parent of a body stands later in the file",
            "point-unknown": "an anchor point does not exist",
            "name-unknown": "a plugin's cut, link or user constraint names nothing in the model",
            "joint-unknown": "a user constraint names a joint that does not exist",
            "joint-nature-unknown": "a joint is not `independent`, `dependent` or `driven`",
            "value-unknown": "a measure of a sensor is not `true`",
            "mbs-not-first": (
                "a name or `coordinates` is not the first child; Robotran would read zeros"
            ),
            "mbs-not-plain": "a comment or an element stands in a name",
            "origin-moved": "a point called `origin` is not at 0 0 0",
            "base-sensor": "a sensor or an external force is on the base",
            "no-drawing": "the file has no 2D diagram",
        },
    ),
]

#: The meaning of each code.
CATALOGUE = {
    code: meaning
    for section in SECTIONS
    for codes in section.levels.values()
    for code, meaning in codes.items()
}

#: The codes whose level can be changed, with their level.  Any other code is an error that leaves
#: nothing to convert.
DEFAULTS = {
    code: level
    for section in SECTIONS
    if section.changeable
    for level, codes in section.levels.items()
    for code in codes
}


# --- the page: python -m urdf2mbs.messages.catalogue > docs/diagnostics.md ---

HEAD = """\
# Errors, warnings, notes

<!-- Made by `python -m urdf2mbs.messages.catalogue > docs/diagnostics.md`: do not edit. -->

An **error** ends a conversion, and nothing is written. A **warning** says that something of the robot is not in the `.mbs` as one would expect. A **note** says what was decided; `-v` shows notes, and `--json` has all. Each message reads `file:line: level[code]: message`. Most have a line below that says what to do. The codes are stable.

A conversion shows up to 20 errors in a URDF's links and joints at once. An error in xacro names the macros and files that led to it, the innermost first.

## Levels are yours

A config can make each warning and note an `error`, a `warning`, a `note` or nothing (`ignore`). The errors in the first table can be changed, too. All other errors leave nothing to convert.

```yaml
diagnostics: {inertia-indefinite: error, mesh-missing: ignore}
strict: true   # all other warnings are errors
```

`--level CODE=LEVEL` and `--strict` do the same on the command line, and overrule the config. A level that is given for a code overrules `strict`. A run shows all its errors at once.

Exit codes: 0 done; 1 this robot cannot be converted; 2 the command line, the config or a plugin is wrong; 3 converted, but not the same robot.
"""  # noqa: E501


def page() -> str:
    """Return the text of docs/diagnostics.md."""
    return "".join([HEAD, *(part for section in SECTIONS for part in _section(section))])


def _section(section: Section) -> Iterator[str]:
    yield f"\n## {section.title}\n\n"
    level_column = section.changeable
    yield "| code |" + " level |" * level_column + " meaning |\n"
    yield "|---|---|" + "---|" * level_column + "\n"
    for level, codes in section.levels.items():
        for code, meaning in codes.items():
            yield f"| `{code}` |" + f" {level} |" * level_column + f" {meaning} |\n"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")  # type: ignore[union-attr]
    sys.stdout.write(page())
