"""From a URDF or xacro file to a ``Robot``, or to errors with file and line.

A file without a meaning is an error.  Odd parts stay as they are, with a warning.  Unreadable parts
that the .mbs does not need are left out, with a warning.  If URDF leaves a choice, the reader does
as urdfdom does.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from lxml import etree

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic, some
from urdf2mbs.urdf import written, xml
from urdf2mbs.urdf.elements import FOREIGN, plain, quote, split_tag
from urdf2mbs.urdf.harmless import is_harmless_child
from urdf2mbs.urdf.joints import check_mimics, read_joint
from urdf2mbs.urdf.links import read_link
from urdf2mbs.urdf.macros import list_uncalled_macros, propose_caller
from urdf2mbs.urdf.model import JOINT_TYPES, Extension, Robot
from urdf2mbs.urdf.rewrite import rename_doubled, rename_drake_joints, split_joints
from urdf2mbs.urdf.shapes import check_materials, read_global_material
from urdf2mbs.urdf.tree import check_tree
from urdf2mbs.urdf.unread import report_stray_texts, report_xacro
from urdf2mbs.urdf.values import Reading

if TYPE_CHECKING:
    from collections.abc import Sequence

#: Roots of other kinds of file.
OTHER_ROOTS = {
    "sdf": "an SDF file (Gazebo)",
    "mujoco": "an MJCF file (MuJoCo)",
    "mbsDescR7": "an .mbs file (Robotran) already",
}
#: Endings of a robot's file, which are no part of its name.
ROBOT_ENDINGS = (".urdf", ".xacro", ".xml", ".mjcf")
#: A name of such words alone is a placeholder: programs write it where nobody has named a robot.
_PLACEHOLDER_WORDS = """
    assembly base default demo description dummy example export exported main model mujoco my name
    new no noname onshape robot scene simple template test the unnamed untitled urdf xacro
"""
PLACEHOLDERS = frozenset(_PLACEHOLDER_WORDS.split())


class Expansion(NamedTuple):
    """The URDF that a file of another format, such as xacro, is expanded to."""

    text: bytes
    """In UTF-8."""
    files: list[str]
    """All files that were read, the source first."""
    warnings: list[Diagnostic]
    settings: Mapping[str, Any] = {}
    """What the file states and a URDF cannot, as defaults of the keys ``base``, ``gravity`` and
    ``passes`` of a config.  A value of the config overrules them, key by key."""
    states: Mapping[type, Any] = {}
    """Data for passes of the reader's plugin: the objects of ``conversion.state``, by class."""


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
    remaining_path = source
    while remaining_path.suffix.lower() in ROBOT_ENDINGS:
        remaining_path = remaining_path.with_suffix("")
    return remaining_path.name


def choose_title(robot_name: str, source: Path) -> str:
    """Return what people call a robot: its name, or that of its file if the name is a placeholder.

    Args:
        robot_name: The name that the robot's file states, such as ``a1`` or ``my_robot``.
        source: The robot's file.
    """
    words = re.findall(r"[^\W\d_]+", robot_name)
    parts = re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", robot_name))
    is_placeholder = any(PLACEHOLDERS.issuperset(map(str.lower, texts)) for texts in (words, parts))
    return stem(source) if is_placeholder else robot_name


def choose_file_name(robot_name: str, source: Path) -> str:
    """Return the name, without an ending, of the files that are made of a robot.

    This is the name of the robot; or that of its file, if the name is a placeholder or no name of
    a file, or if the file's name contains it and so says more: ``talos_reduced`` of ``talos``.
    """
    file_stem, title = stem(source), choose_title(robot_name, source)
    name = re.sub(r"[^\w.-]+", "_", title).strip("._-")
    is_in_stem = _simplify(name) in _simplify(file_stem)
    return file_stem if is_in_stem or not files.is_portable(name) else name


def _simplify(name: str) -> str:
    """Return the letters and digits of a name, in small letters."""
    return re.sub(r"[\W_]", "", name).lower()


def read_robot_file(source: Path) -> bytes:
    """Return the bytes of a robot's file.

    Raises:
        ConversionError: The file is empty, or cannot be read.
    """
    file_name = str(source)
    try:
        robot_bytes = files.read_bytes(source)
    except FileNotFoundError:
        hint = files.suggest_file(source, (".urdf", ".xacro"))
        raise ConversionError("file-not-found", "no such file", file=file_name, hint=hint) from None
    except IsADirectoryError:
        message, hint = "this is a folder, not a URDF or xacro file", "name the file in it"
        raise ConversionError("file-is-directory", message, file=file_name, hint=hint) from None
    except (OSError, ValueError) as error:
        message = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        raise ConversionError("file-unreadable", message, file=file_name) from None
    if not robot_bytes.strip():
        raise ConversionError("file-empty", "the file is empty", file=file_name)
    return robot_bytes


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
    urdf_bytes, expanded_files, warnings = expansion[:3] if expansion else (data, [], [])
    try:
        robot, diagnostics = parse_urdf(
            urdf_bytes, str(source), expanded=expanded_files, extend=extend
        )
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
    xml_root, _ = xml.parse(data, str(source))
    macro_names = list_uncalled_macros(xml_root)
    if macro_names:
        error.message += f": the file defines the macro(s) '{some(macro_names)}' and calls none"
        error.hint = propose_caller(source, xml_root)


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
    file_name = file + written.EXPANDED if expanded else file
    reading = Reading(file_name, expanded)
    try:
        robot_element = reading.xml(data)
        return _read_root(reading, robot_element, extend)
    except ConversionError as error:
        error.earlier = [*reading.diagnostics(), *reading.errors]
        raise


def _read_root(
    reading: Reading, robot_element: Any, extend: ReadExtension | None
) -> tuple[Robot, list[Diagnostic]]:
    """Return the robot of a URDF's root element, and the warnings; raise ConversionError."""
    _check_root(reading, robot_element)
    _rewrite_elements(reading, robot_element)
    reading.quaternions = robot_element.get("version") in ("1.1", "1.2")
    robot = Robot("", file=reading.file)
    foreign_elements = _read_children(reading, robot_element, robot)
    report_stray_texts(reading, robot_element)
    if reading.last is not None:  # the tree is unknown where links or joints are
        raise reading.last
    robot.name = reading.values(robot_element).get("name", "").strip()
    if not robot.name:
        reading.warn("robot-unnamed", "<robot> has no name", robot_element.sourceline)
    check_materials(reading, robot)
    check_tree(reading, robot, robot_element.sourceline)
    robot.extensions = [_read_extension(element) for element in foreign_elements]
    if extend is not None and foreign_elements:
        elements = list(zip(foreign_elements, robot.extensions, strict=True))
        extend(elements=elements, reading=reading, robot=robot)
    check_mimics(reading, robot)
    return robot, reading.diagnostics()


def _read_children(reading: Reading, robot_element: Any, robot: Robot) -> list[Any]:
    """Add the links, joints and materials of a URDF; return the elements of other programs."""
    foreign_elements: list[Any] = []
    unknown_children: list[Any] = []
    for child in robot_element:
        child_tag = child.tag
        if child_tag in ("link", "joint"):
            try:
                if child_tag == "link":
                    read_link(reading, child, robot.links)
                    foreign_elements += child.iterchildren("contact")  # of Bullet
                else:
                    read_joint(reading, child, robot.joints)
            except ConversionError as error:
                reading.keep(error)
        elif child_tag == "material":
            read_global_material(reading, child, robot)
        elif isinstance(child_tag, str):
            reading.owner = ("robot", "")
            if child_tag not in FOREIGN and report_xacro(reading, child):
                continue
            if child_tag not in FOREIGN and not _is_joint_of_another_program(reading, child):
                unknown_children.append(child)
            foreign_elements.append(child)
    reading.owner = ("robot", "")
    reading.unknown_children("robot", unknown_children, ("link", "joint", "material", *FOREIGN))
    return foreign_elements


def _is_joint_of_another_program(reading: Reading, element: Any) -> bool:
    """Return True, after an error, for an element with a prefix that joins two links."""
    bare_tag, namespace = split_tag(element.tag)
    children_by_tag = {split_tag(child.tag)[0]: child for child in element.iterchildren("*")}
    if not namespace or not {"parent", "child"} <= children_by_tag.keys():
        return False
    if is_harmless_child("robot", bare_tag, namespace.strip("{}:")):
        return False
    written_tag = f"{element.prefix}:{bare_tag}" if element.prefix else element.tag
    end_names = " and ".join(
        f"'{children_by_tag[end_tag].get('link')}'" for end_tag in ("parent", "child")
    )
    message = (
        f"<{written_tag}> {quote(element.get('name') or '')} of the type "
        f"{quote(element.get('type') or '')} joins the links {end_names}, and is not read; "
        "expected a <joint> of URDF"
    )
    hint = f"write a <joint> of one of the types: {', '.join(JOINT_TYPES)}"
    try:
        reading.fail("joint-type-unknown", message, element, hint)
    except ConversionError as error:
        reading.keep(error)
    return True


def _read_extension(element: Any) -> Extension:
    """Return an element of another program, as it is written."""
    bare_tag = plain(element.tag)
    parent_element = element.getparent()
    reference = parent_element.get("name") if bare_tag == "contact" else element.get("reference")
    element_xml = etree.tostring(element, encoding=str, with_tail=False)
    return Extension(bare_tag, element_xml, reference, element.sourceline)


def _rewrite_elements(reading: Reading, robot_element: Any) -> None:
    """Rewrite elements that URDF does not allow but that have one meaning, with a warning."""
    rename_drake_joints(robot_element)
    lines_by_joint = {
        joint.get("name"): joint.sourceline for joint in robot_element.iterchildren("joint")
    }
    for new_name, joint_name in rename_doubled(robot_element).items():
        message = f"several joints are called '{joint_name}', and this one is renamed"
        reading.warn(
            "joint-renamed", message, lines_by_joint.get(joint_name), owner=("joint", new_name)
        )
    for joint_name, n_rotations in split_joints(robot_element):
        rotation_names = ", ".join(
            f"NAME_R{rotation_number}" for rotation_number in range(1, n_rotations + 1)
        )
        message = (
            f"a joint of {n_rotations} rotations becomes {n_rotations} joints without limits: "
            f"{rotation_names}"
        )
        reading.warn(
            "joint-ball", message, lines_by_joint.get(joint_name), owner=("joint", joint_name)
        )


def _check_root(reading: Reading, root_element: Any) -> None:
    """Remove a namespace of <robot>; raise ConversionError for another root."""
    root_tag = root_element.tag
    if root_tag.startswith("{"):
        namespace = root_element.nsmap[root_element.prefix]
        root_tag = etree.QName(root_element).localname
        if root_tag == "robot":
            _strip_namespace(root_element, f"{{{namespace}}}")
    if root_tag == "robot":
        return
    format_name = f": this looks like {OTHER_ROOTS[root_tag]}" if root_tag in OTHER_ROOTS else ""
    message = f"the root element is <{root_tag}>, not <robot>{format_name}"
    reading.fail("wrong-root", message, root_element, "URDF and xacro files are read")


def _strip_namespace(robot_element: Any, namespace: str) -> None:
    """Remove the namespace of <robot>, which says nothing, from all elements."""
    for element in robot_element.iter(f"{namespace}*"):
        element.tag = element.tag[len(namespace) :]
