"""From a URDF or xacro file to a ``Robot``, or to errors with file and line.

A file without a meaning is an error.  Odd parts stay as they are, with a warning.  Unreadable parts
that the .mbs does not need are left out, with a warning.  If URDF leaves a choice, the reader does
as urdfdom does.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from lxml import etree

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic, nearest, some
from urdf2mbs.urdf import written, xml
from urdf2mbs.urdf.elements import FOREIGN, plain, quote, split_tag
from urdf2mbs.urdf.harmless import is_harmless_child
from urdf2mbs.urdf.joints import check_mimics, read_joint
from urdf2mbs.urdf.links import read_link
from urdf2mbs.urdf.model import JOINT_TYPES, Extension, Robot
from urdf2mbs.urdf.rewrite import rename_doubled, rename_drake_joints, split_joints
from urdf2mbs.urdf.shapes import check_materials, read_global_material
from urdf2mbs.urdf.tree import check_tree
from urdf2mbs.urdf.unread import report_stray_texts
from urdf2mbs.urdf.values import Reading

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

#: Roots of other kinds of file.
OTHER_ROOTS = {
    "sdf": "an SDF file (Gazebo)",
    "mujoco": "an MJCF file (MuJoCo)",
    "mbsDescR7": "an .mbs file (Robotran) already",
}
#: Endings of a robot's file that are no part of its name.
_ENDINGS = (".urdf", ".xacro", ".xml")


class Expansion(NamedTuple):
    """The URDF that a file of another format, such as xacro, is expanded to."""

    text: bytes
    """In UTF-8."""
    files: list[str]
    """All files that were read, the source first."""
    warnings: list[Diagnostic]


class Located(NamedTuple):
    """The file of a robot that has a name, and how it is read."""

    source: Path
    packages: dict[str, Path]
    """ROS packages whose folder has another name, or is elsewhere."""
    xacro_args: dict[str, str]


#: Reads the elements of other programs, as the hook ``urdf2mbs_extension``.
ReadExtension = Callable[..., object]


def is_name(source: str) -> bool:
    """Return True for a robot that is no file but has a name, as ``robot_descriptions:atlas``."""
    return re.match(r"[a-z]\w+:(?![/\\])", source) is not None


def stem(source: Path) -> str:
    """Return a robot's file name without its endings: ``panda`` of ``panda.urdf.xacro``."""
    name = source
    while name.suffix.lower() in _ENDINGS:
        name = name.with_suffix("")
    return name.name


def read_robot_file(source: Path) -> bytes:
    """Return the bytes of a robot's file.

    Raises:
        ConversionError: The file is empty, or cannot be read.
    """
    file = str(source)
    try:
        data = files.read_bytes(source)
    except FileNotFoundError:
        hint = nearest(source.name, _list_similar_robots(source))
        raise ConversionError("file-not-found", "no such file", file=file, hint=hint) from None
    except IsADirectoryError:
        message, hint = "this is a folder, not a URDF or xacro file", "name the file in it"
        raise ConversionError("file-is-directory", message, file=file, hint=hint) from None
    except (OSError, ValueError) as error:
        message = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        raise ConversionError("file-unreadable", message, file=file) from None
    if not data.strip():
        raise ConversionError("file-empty", "the file is empty", file=file)
    return data


def _list_similar_robots(source: Path) -> list[str]:
    """Return the robots' files beside a file whose names begin nearly as its name."""
    try:
        names = [entry.name for entry in sorted(source.parent.iterdir())]
    except OSError:
        return []
    robots = [name for name in names if name.lower().endswith((".urdf", ".xacro"))]
    beginning = source.name.split(".")[0]
    return [name for name in robots if nearest(beginning, [name.split(".")[0]])]


def read_text(
    source: Path,
    data: bytes,
    expansion: Expansion | None,
    xacro_args: Mapping[str, str],
    extend: ReadExtension | None = None,
) -> tuple[Robot, list[Diagnostic]]:
    """Read a robot's file, or the URDF that it was expanded to.

    Args:
        source: The file; a robot without a name is called as the file.
        data: The bytes of the file.
        expansion: The URDF that they were expanded to; None if they are URDF.
        xacro_args: The arguments of xacro, which have no effect without an expansion.
        extend: As of ``parse_urdf``.

    Raises:
        ConversionError: The last of the errors, with the others in its ``earlier``.
    """
    text, names, warnings = expansion or (data, [], [])
    try:
        robot, diagnostics = parse_urdf(text, str(source), expanded=names, extend=extend)
    except ConversionError as error:
        error.earlier[:0] = warnings
        if expansion is not None and error.code == "no-links":
            _explain_macros(error, data, source)
        raise
    diagnostics[:0] = warnings
    if expansion is None and xacro_args:
        message = "arguments have no effect, as there is no xacro in the file: "
        message += ", ".join(sorted(xacro_args))
        diagnostics.append(Diagnostic("warning", "xacro-unused-arg", message, file=str(source)))
    if not robot.name:
        robot.name = stem(source)
    return robot, diagnostics


def _explain_macros(error: ConversionError, data: bytes, source: Path) -> None:
    """Add to an error that a file without links defines macros and calls none."""
    root, _ = xml.parse(data, str(source))
    macros = [macro.get("name", "") for macro in root.iter("{*}macro")]
    called = {element.tag.partition("}")[2] for element in root.iter(etree.Element)}
    if macros and called.isdisjoint(macros):
        error.message += f": the file defines the macro(s) '{some(macros)}' and calls none"
        error.hint = "convert the file that calls it"


def parse_urdf(
    data: bytes, file: str, *, expanded: Sequence[str] = (), extend: ReadExtension | None = None
) -> tuple[Robot, list[Diagnostic]]:
    """Read a plain URDF text.

    Args:
        data: The text.
        file: The name of its file.
        expanded: The files from which xacro has made the text.
        extend: Reads the elements of other programs; without it they are kept as they are.

    Returns:
        The robot, and the warnings and notes about it.

    Raises:
        ConversionError: The last of the errors, with the others in its ``earlier``.
    """
    name = file + written.EXPANDED if expanded else file
    reading = Reading(name, expanded)
    try:
        root = reading.xml(data)
        return _read_root(reading, root, extend)
    except ConversionError as error:
        error.earlier = [*reading.diagnostics(), *reading.errors]
        raise


def _read_root(
    reading: Reading, root: Any, extend: ReadExtension | None
) -> tuple[Robot, list[Diagnostic]]:
    """Return the robot of a URDF's root element, and the warnings; raise ConversionError."""
    _check_root(reading, root)
    _rewrite(reading, root)
    reading.quaternions = root.get("version") in ("1.1", "1.2")
    robot = Robot("", file=reading.file)
    foreign = _read_children(reading, root, robot)
    report_stray_texts(reading, root)
    if reading.last is not None:  # the tree is unknown where links or joints are
        raise reading.last
    robot.name = reading.values(root).get("name", "").strip()
    if not robot.name:
        reading.warn("robot-unnamed", "<robot> has no name", root.sourceline)
    check_materials(reading, robot)
    check_tree(reading, robot, root.sourceline)
    robot.extensions = [_keep(element) for element in foreign]
    if extend is not None and foreign:
        elements = list(zip(foreign, robot.extensions, strict=True))
        extend(elements=elements, reading=reading, robot=robot)
    check_mimics(reading, robot)
    return robot, reading.diagnostics()


def _read_children(reading: Reading, root: Any, robot: Robot) -> list[Any]:
    """Add the links, joints and materials of a URDF; return the elements of other programs."""
    foreign: list[Any] = []
    unknown: list[Any] = []
    for child in root:
        tag = child.tag
        if tag in ("link", "joint"):
            try:
                if tag == "link":
                    read_link(reading, child, robot.links)
                    foreign += child.iterchildren("contact")  # of Bullet
                else:
                    read_joint(reading, child, robot.joints)
            except ConversionError as error:
                reading.keep(error)
        elif tag == "material":
            read_global_material(reading, child, robot)
        elif isinstance(tag, str):
            reading.owner = ("robot", "")
            if tag not in FOREIGN and reading.report_xacro(child):
                continue
            if tag not in FOREIGN and not _is_joint_of_another_program(reading, child):
                unknown.append(child)
            foreign.append(child)
    reading.owner = ("robot", "")
    reading.unknown_children("robot", unknown, ("link", "joint", "material", *FOREIGN))
    return foreign


def _is_joint_of_another_program(reading: Reading, element: Any) -> bool:
    """Return True, after an error, for an element with a prefix that joins two links."""
    name, namespace = split_tag(element.tag)
    tags = {split_tag(child.tag)[0]: child for child in element.iterchildren("*")}
    if not namespace or not {"parent", "child"} <= tags.keys():
        return False
    if is_harmless_child("robot", name, namespace.strip("{}:")):
        return False
    tag = f"{element.prefix}:{name}" if element.prefix else element.tag
    ends = " and ".join(f"'{tags[end].get('link')}'" for end in ("parent", "child"))
    message = (
        f"<{tag}> {quote(element.get('name') or '')} of the type "
        f"{quote(element.get('type') or '')} joins the links {ends}, and is not read; expected a "
        "<joint> of URDF"
    )
    hint = f"write a <joint> of one of the types: {', '.join(JOINT_TYPES)}"
    try:
        reading.fail("joint-type-unknown", message, element, hint)
    except ConversionError as error:
        reading.keep(error)
    return True


def _keep(element: Any) -> Extension:
    """Return an element of another program, as it is written."""
    tag = plain(element.tag)
    parent = element.getparent()
    reference = parent.get("name") if tag == "contact" else element.get("reference")
    text = etree.tostring(element, encoding=str, with_tail=False)
    return Extension(tag, text, reference, element.sourceline)


def _rewrite(reading: Reading, root: Any) -> None:
    """Rewrite elements that URDF does not allow but that have one meaning, with a warning."""
    rename_drake_joints(root)
    lines = {joint.get("name"): joint.sourceline for joint in root.iterchildren("joint")}
    for new_name, name in rename_doubled(root).items():
        message = f"several joints are called '{name}', and this one is renamed"
        reading.warn("joint-renamed", message, lines.get(name), owner=("joint", new_name))
    for name, count in split_joints(root):
        names = ", ".join(f"NAME_R{number}" for number in range(1, count + 1))
        message = f"a joint of {count} rotations becomes {count} joints without limits: {names}"
        reading.warn("joint-ball", message, lines.get(name), owner=("joint", name))


def _check_root(reading: Reading, root: Any) -> None:
    """Remove a namespace of <robot>; raise ConversionError for another root."""
    tag = root.tag
    if tag.startswith("{"):
        namespace = root.nsmap[root.prefix]
        tag = etree.QName(root).localname
        if tag == "robot":
            _strip_namespace(root, f"{{{namespace}}}")
    if tag == "robot":
        return
    format_name = f": this looks like {OTHER_ROOTS[tag]}" if tag in OTHER_ROOTS else ""
    message = f"the root element is <{tag}>, not <robot>{format_name}"
    reading.fail("wrong-root", message, root, "URDF and xacro files are read")


def _strip_namespace(root: Any, namespace: str) -> None:
    """Remove the namespace of <robot>, which says nothing, from all elements."""
    for element in root.iter(f"{namespace}*"):
        element.tag = element.tag[len(namespace) :]
