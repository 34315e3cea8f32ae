"""From a URDF or xacro file to a ``Robot``, or to one error that says what is wrong where.

Stricter than ROS's own parser (urdfdom): what that one drops or guesses is an error or a
warning here. Where URDF leaves a choice, urdfdom's is taken.
"""

from __future__ import annotations

import re
from math import hypot, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NoReturn

from lxml import etree

from urdf2mbs import xml_lines
from urdf2mbs.diagnostics import ConversionError, Diagnostic, nearest
from urdf2mbs.spatial import NO_INERTIA, ZERO, to_xyz_angles
from urdf2mbs.urdf.model import (
    JOINT_TYPES,
    Box,
    Calibration,
    Collision,
    Cylinder,
    Dynamics,
    Extension,
    Geometry,
    Inertial,
    Joint,
    Limit,
    Link,
    Material,
    Mesh,
    Mimic,
    Origin,
    Robot,
    SafetyController,
    Sphere,
    Visual,
)
from urdf2mbs.urdf.xacro import LEGACY, LEGACY_HINT, expand

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from urdf2mbs.spatial import Sym, Vec
    from urdf2mbs.urdf.packages import Packages

#: The attributes of each element that we read; any other is reported.
ATTRIBUTES: dict[str, frozenset[str]] = {
    "robot": frozenset(("name", "version")),
    "link": frozenset(("name",)),
    "inertial": frozenset(),
    "origin": frozenset(("xyz", "rpy")),
    "mass": frozenset(("value",)),
    "inertia": frozenset(("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    "visual": frozenset(("name",)),
    "collision": frozenset(("name",)),
    "geometry": frozenset(),
    "box": frozenset(("size",)),
    "cylinder": frozenset(("radius", "length")),
    "sphere": frozenset(("radius",)),
    "mesh": frozenset(("filename", "scale")),
    "material": frozenset(("name",)),
    "color": frozenset(("rgba",)),
    "texture": frozenset(("filename",)),
    "joint": frozenset(("name", "type")),
    "parent": frozenset(("link",)),
    "child": frozenset(("link",)),
    "axis": frozenset(("xyz",)),
    "limit": frozenset(("lower", "upper", "effort", "velocity")),
    "dynamics": frozenset(("damping", "friction")),
    "mimic": frozenset(("joint", "multiplier", "offset")),
    "safety_controller": frozenset(
        ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
    ),
    "calibration": frozenset(("rising", "falling")),
}
#: The children of each element that we read, at most one of each.
CHILDREN: dict[str, frozenset[str]] = {
    "inertial": frozenset(("origin", "mass", "inertia")),
    "visual": frozenset(("origin", "geometry", "material")),
    "collision": frozenset(("origin", "geometry")),
    "material": frozenset(("color", "texture")),
    "joint": frozenset(
        (
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "calibration",
            "safety_controller",
        )
    ),
}
#: Elements of other programs that one meets in URDF files: kept, and not worth a word.
FOREIGN = frozenset(("gazebo", "transmission", "sensor", "ros2_control", "mujoco"))
#: Roots of other kinds of file.
OTHER_ROOTS = {
    "sdf": "an SDF file (Gazebo)",
    "gazebo": "an old SDF file (Gazebo)",
    "mujoco": "an MJCF file (MuJoCo)",
    "mujocoinclude": "an MJCF file (MuJoCo)",
    "COLLADA": "a COLLADA mesh or model",
    "mbsDescR7": "an .mbs file (Robotran) already",
    "html": "a web page",
    "package": "a package.xml",
    "launch": "a launch file",
    "X3D": "an X3D scene",
    "svg": "a picture",
}
#: How far, as a share of the trace, a principal moment may be below zero, and the largest
#: above the sum of the two others.
PSD_TOLERANCE = 1e-9
TRIANGLE_TOLERANCE = 1e-6
#: m^2; times the mass, what rounding may leave of a zero (iCub has -5e-20 kg m^2).
NOISE = 1e-15

_NAMES_SHOWN = 4
#: Blanks and byte order marks, in any encoding.
_BLANK = b"\0 \t\r\n\xef\xbb\xbf\xfe\xff"
_BLANKS = re.compile(r"[ \t\r\n]+")
_SAVE_UTF_8 = 'save the file as UTF-8, or name its encoding: <?xml version="1.0" encoding=...?>'
#: libxml2's first complaint about a file that is cut off.
_UNFINISHED = frozenset(
    f"ERR_{what}"
    for what in (
        "TAG_NOT_FINISHED", "COMMENT_NOT_FINISHED", "CDATA_NOT_FINISHED", "PI_NOT_FINISHED",
        "XMLDECL_NOT_FINISHED", "DOCUMENT_EMPTY",
    )
)  # fmt: skip


def read_robot(
    source: Path, packages: Packages, xacro_args: Mapping[str, str]
) -> tuple[Robot, list[Diagnostic]]:
    """Read a robot; a file called ``*.xacro`` is expanded first.

    :raises ConversionError: the codes of ``parse`` and of ``xacro.expand``, and
        ``file-not-found``, ``file-is-directory``, ``file-unreadable``
    """
    data = _read(source)
    if source.suffix.lower() != ".xacro":
        robot, diagnostics = parse(data, str(source))
        if xacro_args:
            diagnostics.append(
                Diagnostic(
                    "warning",
                    "xacro-unused-arg",
                    "arguments have no effect: the file is not a .xacro: "
                    + ", ".join(sorted(xacro_args)),
                    file=str(source),
                )
            )
    else:
        if not data.strip():
            _fail_empty(str(source))
        expansion = expand(source, packages, xacro_args)
        robot, diagnostics = parse(expansion.text, str(source), expanded=True)
        diagnostics[:0] = expansion.warnings
    if not robot.name:
        robot.name = stem(source)
    return robot, diagnostics


#: Endings of a robot's file that are no part of its name.
_ENDINGS = (".urdf", ".xacro", ".xml")


def stem(source: Path) -> str:
    """A robot's file name without its endings: ``panda_v1.0`` of ``panda_v1.0.urdf.xacro``."""
    name = source
    while name.suffix.lower() in _ENDINGS:
        name = name.with_suffix("")
    return name.name


def parse(data: bytes, file: str, *, expanded: bool = False) -> tuple[Robot, list[Diagnostic]]:
    """Read a plain URDF text; ``expanded`` says that xacro has written it from ``file``.

    :raises ConversionError: one for the first thing that is wrong
    """
    return _Reader(f"{file} (expanded)" if expanded else file, expanded).robot(data)


def _read(source: Path) -> bytes:
    file = str(source)
    try:
        return source.read_bytes()
    except FileNotFoundError:
        try:
            known = [entry.name for entry in source.parent.iterdir()]
        except OSError:
            known = []
        raise ConversionError(
            "file-not-found", "no such file", file=file, hint=nearest(source.name, known)
        ) from None
    except IsADirectoryError:
        raise ConversionError(
            "file-is-directory",
            "this is a folder, not a URDF or xacro file",
            file=file,
            hint="name the file in it",
        ) from None
    except (OSError, ValueError) as error:
        raise ConversionError(
            "file-unreadable",
            f"cannot be read: {getattr(error, 'strerror', None) or error}",
            file=file,
        ) from None


def _fail_empty(file: str) -> NoReturn:
    raise ConversionError("file-empty", "the file is empty", file=file)


class _Group:
    """Warnings of one kind, said once for all the elements they are about."""

    def __init__(self, level: Literal["warning", "note"], line: int | None, hint: str | None):
        self.level = level
        self.line = line
        self.hint = hint
        self.owners: dict[tuple[str, str], None] = {}
        self.count = 0


class _Reader:
    """One file being read: where we are, what has been said."""

    def __init__(self, file: str, expanded: bool) -> None:
        self.file = file
        self.expanded = expanded
        self.groups: dict[tuple[str, str], _Group] = {}
        self.owner = ("robot", "")
        """Kind and name of the element being read, for messages."""
        self.vectors: dict[str, Vec] = {}
        self.line: int | None = None
        """Of <robot>."""
        self.quaternions = False
        """Whether the file's version has ``quat_xyzw``; urdfdom ignores it in older ones."""

    # -- messages ---------------------------------------------------------------------

    @property
    def where(self) -> str:
        kind, name = self.owner
        return f"{kind} '{name}'" if name else f"<{kind}>"

    def fail(
        self, code: str, message: str, element: Any = None, hint: str | None = None
    ) -> NoReturn:
        line = element if element is None or isinstance(element, int) else element.sourceline
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)

    def warn(
        self,
        code: str,
        message: str,
        line: int | None,
        *,
        hint: str | None = None,
        like: tuple[str, Iterable[str]] | None = None,
        owner: tuple[str, str] | None = None,
        level: Literal["warning", "note"] = "warning",
    ) -> None:
        """The same message about several links or joints is said once, with their names.

        ``like``: a wrong name and the right ones, the nearest of which is offered.
        """
        group = self.groups.get((code, message))
        if group is None:
            if like is not None:
                hint = nearest(like[0], sorted(like[1]))
            group = self.groups[code, message] = _Group(level, line, hint)
        group.owners[owner or self.owner] = None
        group.count += 1

    def diagnostics(self) -> list[Diagnostic]:
        said = []
        for (code, message), group in self.groups.items():
            owners = list(group.owners)
            kind, name = owners[0]
            shown = ", ".join(f"{kind} '{name}'" for kind, name in owners[:_NAMES_SHOWN] if name)
            more = len(owners) - _NAMES_SHOWN
            text = f"{message}: {shown}" if shown else message
            if more > 0:
                text += f" and {more} more"
            if group.count > len(owners):
                text += f" ({group.count} times)"
            said.append(
                Diagnostic(
                    group.level, code, text,
                    name if kind == "link" and len(owners) == 1 else None,
                    name if kind == "joint" and len(owners) == 1 else None,
                    self.file, group.line, group.hint,
                )
            )  # fmt: skip
        return said

    # -- XML --------------------------------------------------------------------------

    def xml(self, data: bytes) -> Any:
        if not data.strip(_BLANK):
            _fail_empty(self.file)
        parser = _parser()
        try:
            root = xml_lines.parse(data, parser)
        except etree.XMLSyntaxError as error:
            root = self._undeclared_prefixes(data, error, _log(parser))
        if root is None:
            self.fail("xml-syntax", "there is no XML element in the file")
        dtd: Any = root.getroottree().docinfo.internalDTD
        if dtd is not None and next(dtd.iterentities(), None) is not None:
            self.bad_entities(1)
        return root

    def _undeclared_prefixes(self, data: bytes, error: etree.XMLSyntaxError, log: list[Any]) -> Any:
        """Old files use prefixes that they do not declare; only that is forgiven."""
        if not log or any(entry.domain_name != "NAMESPACE" for entry in log):
            self._not_xml(data, error, {entry.type_name for entry in log[:1]})
        for entry in log:
            if not self.expanded and "xacro" in entry.message:
                self.unexpanded("an element or attribute with the prefix xacro:", entry.line)
            self.warn("xml-namespace", entry.message.strip().rstrip("."), entry.line)
        return xml_lines.parse(data, _parser(recover=True))

    def _not_xml(self, data: bytes, error: etree.XMLSyntaxError, first: set[str]) -> NoReturn:
        line = error.lineno or None
        text = data.strip(_BLANK)
        if not text.startswith(b"<"):
            begin = text[:60].replace(b"\0", b"").decode("utf-8", "replace")
            self.fail(
                "not-xml",
                f"not an XML file: it begins with {_shown(begin[:30])}",
                line,
                "a URDF file begins with <?xml ...?> or <robot name=...>",
            )
        reason = (error.msg or "it cannot be parsed").partition(", ")[0].strip().rstrip(".")
        at_end = line is not None and line > data.rstrip(_BLANK).count(b"\n")
        if first & _UNFINISHED or (at_end and not text.endswith(b">")):
            self.fail(
                "xml-truncated",
                f"the file ends before its elements are closed ({reason})",
                line,
                "it seems to be cut off: get it again, or close the elements",
            )
        if b"<!ENTITY" in data:
            self.bad_entities(line, reason)
        hints = {
            "ERR_RESERVED_XML_NAME": "nothing may stand before <?xml ...?>",
            "ERR_INVALID_ENCODING": _SAVE_UTF_8,
            "ERR_UNSUPPORTED_ENCODING": _SAVE_UTF_8,
            "ERR_UNDECLARED_ENTITY": "write &amp; for an ampersand",
            "ERR_ENTITYREF_SEMICOL_MISSING": "write &amp; for an ampersand",
            "ERR_NAME_REQUIRED": "write &lt; and &amp; for < and &",
            "ERR_DOCUMENT_END": "an XML file has one outermost element",
        }
        hint = next((hints[name] for name in first if name in hints), None)
        self.fail("xml-syntax", f"not well-formed XML: {reason}", line, hint)

    def bad_entities(self, line: int | None, reason: str = "") -> NoReturn:
        self.fail(
            "xml-entity",
            "the file declares XML entities, which are not read" + (reason and f" ({reason})"),
            line,
            "write out what the entities stand for, and take the DOCTYPE away",
        )

    def attributes(self, element: Any) -> dict[str, str]:
        """All of an element's attributes; those that we do not know are reported."""
        found = dict(zip(element.keys(), element.values(), strict=True))
        if not ATTRIBUTES[element.tag].issuperset(found):
            self.unknown_attributes(element)
        return found

    def attribute(self, element: Any, name: str) -> str | None:
        """The same for an element that has one attribute at most."""
        value: str | None = element.get(name)
        if len(element.attrib) != (value is not None):
            self.unknown_attributes(element)
        return value

    def unknown_attributes(self, element: Any) -> None:
        known = ATTRIBUTES[element.tag]
        for name in element.keys():  # noqa: SIM118 (an element iterates over its children)
            if name in known:
                continue
            if name.startswith("{") or ":" in name:
                if "xacro" in name:
                    self.unexpanded(f"the attribute {_plain(name)}", element.sourceline)
                continue
            self.warn(
                "unknown-attribute",
                f"the attribute '{name}' of <{element.tag}> is not known and has no effect",
                element.sourceline,
                like=(name, known),
            )

    def parts(self, element: Any) -> dict[str, Any]:
        """The children of an element by tag, the first of each; others are reported."""
        tag = element.tag
        known = CHILDREN[tag]
        found: dict[str, Any] = {}
        for child in element:
            name = child.tag
            if name not in known:
                self.unknown_child(tag, child, known)
            elif name in found:
                self.doubled(tag, child)
            else:
                found[name] = child
        return found

    def unknown_child(self, parent: str, child: Any, known: Iterable[str]) -> None:
        tag = child.tag
        if not isinstance(tag, str):  # a comment or processing instruction
            return
        self.xacro_left(child)
        self.warn(
            "unknown-element",
            f"<{_plain(tag)}> in <{parent}> is not known and has no effect",
            child.sourceline,
            like=(tag, known),
        )

    def doubled(self, parent: str, child: Any) -> None:
        self.warn(
            "doubled-element",
            f"more than one <{child.tag}> in <{parent}>, the first one counts",
            child.sourceline,
        )

    def xacro_left(self, element: Any) -> None:
        """Fail for an element that xacro should have dealt with."""
        tag = element.tag
        space = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
        if element.prefix == "xacro" or (space != tag and "xacro" in space):
            self.unexpanded(f"<xacro:{_plain(tag).rpartition(':')[2]}>", element.sourceline)
        if tag in LEGACY:
            self.fail(
                "xacro-legacy",
                f"<{tag}> without the prefix xacro: is not read by xacro any more",
                element,
                LEGACY_HINT.format(tag=tag)
                + ("" if self.expanded else ", and give the file a name that ends in .xacro"),
            )

    def unexpanded(self, what: str, line: int | None) -> NoReturn:
        self.fail(
            "xacro-unexpanded",
            f"{self.where}: {what} was left by xacro"
            if self.expanded
            else f"{what}: this is xacro that has not been expanded",
            line,
            None if self.expanded else "give the file a name that ends in .xacro: it is expanded",
        )

    # -- values -----------------------------------------------------------------------

    def name(self, element: Any, kind: str, taken: Mapping[str, Any]) -> str:
        """The ``name`` of a link or joint: there must be one, and only once."""
        name: str | None = element.get("name")
        if not name or not name.strip():
            self.fail(
                "name-missing",
                f"a {kind} without a name",
                element,
                f"every <{kind}> needs a name of its own",
            )
        self.owner = (kind, name)
        if "$" in name:
            self.text(element, "name", name)
        if name != name.strip():
            self.warn(
                "name-blank", "the name begins or ends with a blank, which is kept",
                element.sourceline,
            )  # fmt: skip
        if name in taken:
            self.fail(
                "name-doubled",
                f"two {kind}s are called '{name}'; the first is in line {taken[name].line}",
                element,
                f"give one of the {kind}s another name",
            )
        return name

    def text(self, element: Any, attribute: str, text: str) -> str:
        if "${" in text or "$(" in text:
            self.unexpanded(f"{attribute}={_shown(text)} of {self.where}", element.sourceline)
        return text

    def number(self, element: Any, attribute: str, text: str | None) -> float:
        if text is not None and text.isascii() and "_" not in text:
            try:
                value = float(text)
            except ValueError:
                pass
            else:
                if isfinite(value):
                    return value
        return self.bad_number(element, attribute, text, 1)

    def numbers(
        self, element: Any, attribute: str, text: str | None, count: int
    ) -> tuple[float, ...]:
        if text is not None and text.isascii() and "_" not in text:
            try:
                values = tuple(map(float, text.split()))
            except ValueError:
                pass
            else:
                if len(values) == count and all(map(isfinite, values)):
                    return values
        return self.bad_number(element, attribute, text, count)

    def vector(self, element: Any, attribute: str, text: str | None) -> Vec:
        if text is None:
            return self.bad_number(element, attribute, text, 3)
        vector = self.vectors.get(text)
        if vector is None:
            x, y, z = self.numbers(element, attribute, text, 3)
            vector = self.vectors[text] = (x, y, z)
        return vector

    def bad_number(self, element: Any, attribute: str, text: str | None, count: int) -> NoReturn:
        wanted = "a number" if count == 1 else f"{count} numbers"
        what = f"{self.where}: {attribute} of <{element.tag}>"
        if text is None or not text.strip():
            self.fail("number-missing", f"{what} is missing", element, f"give {wanted}")
        self.text(element, attribute, text)
        for word in text.split() if text.isascii() else [text]:
            try:
                value = float(word) if word.isascii() and "_" not in word else None
            except ValueError:
                value = None
            if value is None:
                point = word.count(",") == 1 and word.replace(",", "").lstrip("+-").isdecimal()
                self.fail(
                    "number-invalid",
                    f"{what} is {_shown(text)}: {_shown(word)} is not a number",
                    element,
                    "write decimals with a point" if point else "write it as 1.5 or -2e-3",
                )
            if not isfinite(value):
                self.fail(
                    "number-invalid",
                    f"{what} is {_shown(text)}: numbers must be finite",
                    element,
                    f"give {wanted}",
                )
        self.fail(
            "number-count",
            f"{what} is {_shown(text)}: {wanted} wanted, {len(text.split())} given",
            element,
            f"give {wanted}" + (", with blanks between them" if count > 1 else ""),
        )

    def origin(self, element: Any) -> Origin:
        if element is None:
            return Origin()
        xyz, rpy = element.get("xyz"), element.get("rpy")
        if len(element.attrib) != (xyz is not None) + (rpy is not None):
            if self.quaternions and element.get("quat_xyzw") is not None:
                return self.turned_origin(element)
            self.unknown_attributes(element)
        return Origin(
            ZERO if xyz is None else self.vector(element, "xyz", xyz),
            ZERO if rpy is None else self.vector(element, "rpy", rpy),
        )

    def turned_origin(self, element: Any) -> Origin:
        """An origin that gives its rotation as a quaternion, as URDF 1.1 permits."""
        attributes = dict(element.items())
        quaternion = self.numbers(element, "quat_xyzw", attributes.pop("quat_xyzw"), 4)
        length = hypot(*quaternion)
        if length == 0.0 or "rpy" in attributes:
            self.fail(
                "number-invalid",
                f"{self.where}: quat_xyzw of <origin> is zero"
                if length == 0.0
                else f"{self.where}: <origin> has both rpy and quat_xyzw",
                element,
                "give a rotation, and give it once",
            )
        x, y, z, w = (value / length for value in quaternion)
        inverse = (
            1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
            2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
            2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y),
        )  # fmt: skip
        # R = Rz Ry Rx is the inverse of Rx Ry Rz by the negative angles.
        roll, pitch, yaw = to_xyz_angles(inverse)
        xyz = attributes.get("xyz")
        return Origin(
            ZERO if xyz is None else self.vector(element, "xyz", xyz), (-roll, -pitch, -yaw)
        )

    # -- links ------------------------------------------------------------------------

    def link(self, element: Any, links: dict[str, Link]) -> None:
        name = self.name(element, "link", links)
        if len(element.attrib) != 1:
            self.unknown_attributes(element)
        inertial: Any = None
        visuals: list[Visual] = []
        collisions: list[Collision] = []
        for child in element:
            tag = child.tag
            if tag == "visual":
                self.visual(child, visuals)
            elif tag == "collision":
                self.collision(child, collisions)
            elif tag == "inertial":
                if inertial is None:
                    inertial = child
                else:
                    self.doubled("link", child)
            else:
                self.unknown_child("link", child, ("visual", "collision", "inertial"))
        links[name] = Link(
            name,
            None if inertial is None else self.inertial(inertial),
            visuals,
            collisions,
            element.sourceline,
        )

    def inertial(self, element: Any) -> Inertial | None:
        if element.attrib:
            self.unknown_attributes(element)
        parts = self.parts(element)
        origin = self.origin(parts.get("origin"))
        mass_element, inertia_element = parts.get("mass"), parts.get("inertia")
        mass, inertia = 0.0, NO_INERTIA
        if mass_element is not None:
            mass = self.number(mass_element, "value", self.attribute(mass_element, "value"))
            if mass < 0.0:
                self.fail(
                    "mass-negative", f"{self.where}: the mass is negative ({mass!r} kg)",
                    mass_element,
                )  # fmt: skip
        if inertia_element is not None:
            get = self.attributes(inertia_element).get
            inertia = (
                self.number(inertia_element, "ixx", get("ixx")),
                self.number(inertia_element, "ixy", get("ixy")),
                self.number(inertia_element, "ixz", get("ixz")),
                self.number(inertia_element, "iyy", get("iyy")),
                self.number(inertia_element, "iyz", get("iyz")),
                self.number(inertia_element, "izz", get("izz")),
            )
            if inertia != NO_INERTIA:
                self.check_inertia(inertia, mass, inertia_element)
        line = element.sourceline
        if mass_element is None:
            self.warn(
                "inertial-incomplete",
                "<inertial> without <mass> is not used, as in ROS: no mass, no inertia",
                line,
                hint="give <mass value=.../>, or take <inertial> away",
            )
            return None
        if inertia_element is None:
            self.warn(
                "inertial-incomplete",
                "<inertial> without <inertia>: mass, but no inertia, as in ROS",
                line,
                hint="give <inertia ixx=... ixy=... ixz=... iyy=... iyz=... izz=.../>",
            )
            return Inertial(mass, NO_INERTIA, origin)
        if mass == 0.0 and inertia != NO_INERTIA:
            self.warn("inertia-without-mass", "inertia, but no mass", line)
        elif mass > 0.0 and inertia == NO_INERTIA:
            self.warn("mass-without-inertia", "mass, but no inertia", line, level="note")
        return Inertial(mass, inertia, origin)

    def check_inertia(self, tensor: Sym, mass: float, element: Any) -> None:
        """Principal moments a, b, c are those of a body if a + b >= c and so on.

        That holds just where ``J = trace/2 - I`` is positive semi-definite, which implies that
        I is; and J is positive definite if its leading minors are positive.
        """
        xx, xy, xz, yy, yz, zz = tensor
        half = (xx + yy + zz) / 2
        a, b, c = half - xx, half - yy, half - zz
        least = 1e-12 * half
        ab = a * b - xy * xy
        determinant = ab * c - a * yz * yz - b * xz * xz - 2 * xy * xz * yz
        if a > least and ab > least * half and determinant > least * half * half:
            return
        small, middle, large = _principal_moments(tensor)
        trace = small + middle + large
        moments = f"its principal moments are {small:.6g}, {middle:.6g}, {large:.6g} kg m^2"
        if small < -NOISE * mass - PSD_TOLERANCE * abs(trace):
            self.fail(
                "inertia-not-psd",
                f"{self.where}: the inertia is not positive semi-definite: {moments}",
                element,
                "no body has such an inertia: check its signs, and that it is about the centre"
                " of mass",
            )
        if large - small - middle > NOISE * mass + TRIANGLE_TOLERANCE * abs(trace):
            self.warn(
                "inertia-triangle",
                f"no real body has such an inertia: {moments}, the largest is more than the"
                " others together",
                element.sourceline,
            )

    def visual(self, element: Any, visuals: list[Visual]) -> None:
        name = self.attribute(element, "name")
        parts = self.parts(element)
        origin = self.origin(parts.get("origin"))
        geometry = self.geometry(element, parts.get("geometry"))
        material = parts.get("material")
        look = None if material is None else self.material(material)
        if geometry is not None:
            visuals.append(Visual(geometry, origin, look, name, element.sourceline))

    def collision(self, element: Any, collisions: list[Collision]) -> None:
        name = self.attribute(element, "name")
        parts = self.parts(element)
        origin = self.origin(parts.get("origin"))
        geometry = self.geometry(element, parts.get("geometry"))
        if geometry is not None:
            collisions.append(Collision(geometry, origin, name, element.sourceline))

    def geometry(self, owner: Any, element: Any) -> Geometry | None:
        shape = None
        if element is not None:
            if element.attrib:
                self.unknown_attributes(element)
            for child in element:
                if isinstance(child.tag, str):
                    if shape is not None:
                        self.doubled("geometry", child)
                    else:
                        shape = child
        if shape is None:
            self.warn(
                "geometry-unknown",
                f"<{owner.tag}> without a geometry is left out",
                owner.sourceline,
            )
            return None
        tag = shape.tag
        attributes = self.attributes(shape) if tag in ("mesh", "box", "cylinder", "sphere") else {}
        sizes: tuple[float, ...]
        geometry: Geometry
        if tag == "mesh":
            filename = attributes.get("filename")
            if not filename or not filename.strip():
                self.warn(
                    "geometry-unknown", f"<{owner.tag}> whose mesh has no filename is left out",
                    shape.sourceline,
                )  # fmt: skip
                return None
            if "$" in filename:
                self.text(shape, "filename", filename)
            if "scale" not in attributes:
                return Mesh(filename)
            scale = self.vector(shape, "scale", attributes["scale"])
            geometry, sizes = Mesh(filename, scale), tuple(map(abs, scale))  # < 0 is a mirror
        elif tag == "box":
            geometry = Box(self.vector(shape, "size", attributes.get("size")))
            sizes = geometry.size
        elif tag == "cylinder":
            geometry = Cylinder(
                self.number(shape, "radius", attributes.get("radius")),
                self.number(shape, "length", attributes.get("length")),
            )
            sizes = (geometry.radius, geometry.length)
        elif tag == "sphere":
            geometry = Sphere(self.number(shape, "radius", attributes.get("radius")))
            sizes = (geometry.radius,)
        else:
            self.xacro_left(shape)
            self.warn(
                "geometry-unknown",
                f"<{owner.tag}> is left out, its geometry <{_plain(tag)}> is not known",
                shape.sourceline,
            )
            return None
        if min(sizes) <= 0.0:
            self.warn(
                "geometry-size",
                f"the <{tag}> of a <{owner.tag}> has a size that is zero or negative",
                shape.sourceline,
            )
        return geometry

    def material(self, element: Any) -> Material | None:
        name = self.attribute(element, "name") or ""
        if "$" in name:
            self.text(element, "name", name)
        color: tuple[float, float, float, float] | None = None
        texture: str | None = None
        if len(element):
            parts = self.parts(element)
            if "color" in parts:
                child = parts["color"]
                rgba = self.attribute(child, "rgba")
                r, g, b, a = self.numbers(child, "rgba", rgba, 4)
                color = (r, g, b, a)
                if min(color) < 0.0 or max(color) > 1.0:
                    self.warn("color-range", "rgba is not within 0 and 1", child.sourceline)
            if "texture" in parts:
                child = parts["texture"]
                texture = self.attribute(child, "filename") or None
                if texture and "$" in texture:
                    self.text(child, "filename", texture)
        if not name and color is None and texture is None:
            return None
        return Material(name, color, texture)

    # -- joints -----------------------------------------------------------------------

    def joint(self, element: Any, joints: dict[str, Joint]) -> None:
        name = self.name(element, "joint", joints)
        kind = element.get("type")
        if len(element.attrib) != 2:
            self.unknown_attributes(element)
        if kind not in JOINT_TYPES:
            types = ", ".join(JOINT_TYPES)
            if not kind:
                self.fail(
                    "joint-type-missing", f"joint '{name}' has no type", element,
                    f"the types are: {types}",
                )  # fmt: skip
            self.text(element, "type", kind)
            self.fail(
                "joint-type-unknown",
                f"joint '{name}' is of the type {_shown(kind)}, which URDF does not know",
                element,
                nearest(kind.lower(), JOINT_TYPES) or f"the types are: {types}",
            )
        parts = self.parts(element)
        parent = self.end(element, parts, "parent")
        child = self.end(element, parts, "child")
        if parent == child:
            self.fail(
                "joint-same-link",
                f"joint '{name}' has the link '{parent}' as its parent and as its child",
                parts["child"],
            )
        joint = joints[name] = Joint(
            name, kind, parent, child, self.origin(parts.get("origin")), line=element.sourceline
        )
        axis = parts.get("axis")
        if axis is not None and kind not in ("fixed", "floating"):  # these have none
            self.axis(joint, axis)
        limit = parts.get("limit")
        if limit is not None:
            joint.limit = self.limit(joint, limit)
        elif kind in ("revolute", "prismatic"):
            self.warn(
                "joint-limit-missing",
                f"a {kind} joint wants a <limit>, and is read as one without limits",
                element.sourceline,
            )
        if "dynamics" in parts:
            joint.dynamics = Dynamics(**self.known_numbers(parts["dynamics"]))
        if "mimic" in parts:
            part = parts["mimic"]
            leader = self.text(part, "joint", part.get("joint") or "")
            joint.mimic = Mimic(leader, **self.known_numbers(part))
        if "safety_controller" in parts:
            part = parts["safety_controller"]
            if part.get("k_velocity") is None:
                self.bad_number(part, "k_velocity", None, 1)
            joint.safety_controller = SafetyController(**self.known_numbers(part))
        if "calibration" in parts:
            joint.calibration = Calibration(**self.known_numbers(parts["calibration"]))

    def known_numbers(self, element: Any) -> dict[str, float]:
        """All attributes that are numbers, by their names in the model."""
        known = ATTRIBUTES[element.tag]
        return {
            name: self.number(element, name, text)
            for name, text in self.attributes(element).items()
            if name in known and name != "joint"
        }

    def end(self, element: Any, parts: dict[str, Any], which: str) -> str:
        """The name of a joint's ``parent`` or ``child`` link."""
        part = parts.get(which)
        name = None if part is None else self.attribute(part, "link")
        if part is None or not name:
            self.fail(
                "joint-link-missing",
                f"{self.where} has no {which} link",
                element if part is None else part,
                f'give <{which} link="..."/>',
            )
        return self.text(part, "link", name) if "$" in name else name

    def axis(self, joint: Joint, element: Any) -> None:
        joint.axis = self.vector(element, "xyz", self.attribute(element, "xyz"))
        if joint.axis == ZERO:
            self.fail(
                "axis-zero",
                f"joint '{joint.name}' is {joint.type}, and its axis is zero",
                element,
                'give a direction, such as xyz="0 0 1", or make the joint fixed',
            )

    def limit(self, joint: Joint, element: Any) -> Limit:
        limit = Limit(**self.known_numbers(element))
        if limit.lower > limit.upper and joint.type in ("revolute", "prismatic"):
            self.warn(
                "limit-order",
                f"the lower limit ({limit.lower!r}) is above the upper one ({limit.upper!r})",
                element.sourceline,
            )
        return limit

    # -- the robot --------------------------------------------------------------------

    def robot(self, data: bytes) -> tuple[Robot, list[Diagnostic]]:
        root = self.xml(data)
        self.check_root(root)
        self.line = root.sourceline
        self.quaternions = root.get("version") in ("1.1", "1.2")
        robot = Robot("", file=self.file)
        links, joints, extensions = robot.links, robot.joints, robot.extensions
        for child in root:
            tag = child.tag
            if tag == "link":
                self.link(child, links)
            elif tag == "joint":
                self.joint(child, joints)
            elif tag == "material":
                self.global_material(child, robot)
            elif isinstance(tag, str):
                self.owner = ("robot", "")
                if tag not in FOREIGN:
                    self.xacro_left(child)
                    if "{" not in tag and ":" not in tag:
                        self.warn(
                            "unknown-element",
                            f"<{tag}> in <robot> is not known: kept as it is, without effect",
                            child.sourceline,
                            like=(tag, ("link", "joint", "material", *FOREIGN)),
                        )
                xml = etree.tostring(child, encoding="unicode", with_tail=False)
                extensions.append(
                    Extension(_plain(tag), xml, child.get("reference"), child.sourceline)
                )
        self.owner = ("robot", "")
        self.robot_name(root, robot)
        self.check_materials(robot)
        self.check_tree(robot)
        self.check_mimics(robot)
        return robot, self.diagnostics()

    def check_root(self, root: Any) -> None:
        tag = root.tag
        if tag.startswith("{"):
            space = root.nsmap[root.prefix]
            tag = etree.QName(root).localname
            if tag == "robot":
                _strip_namespace(root, f"{{{space}}}")
        if tag == "robot":
            return
        if "xacro" in tag or tag in LEGACY:
            self.xacro_left(root)
        kind = OTHER_ROOTS.get(tag)
        self.fail(
            "wrong-root",
            f"the root element is <{tag}>, not <robot>"
            + (f": this looks like {kind}" if kind else ""),
            root,
            "URDF and xacro files are read",
        )

    def robot_name(self, root: Any, robot: Robot) -> None:
        robot.name = (self.attributes(root).get("name") or "").strip()
        if not robot.name:
            self.warn("robot-unnamed", "<robot> has no name", root.sourceline)
        elif "$" in robot.name:
            self.text(root, "name", robot.name)

    def global_material(self, element: Any, robot: Robot) -> None:
        self.owner = ("material", element.get("name") or "")
        material = self.material(element)
        if material is None or not material.name:
            self.warn("material-unnamed", "a material of <robot> has no name", element.sourceline)
        elif material.name in robot.materials:
            self.doubled("robot", element)
        elif material.color is not None or material.texture is not None:
            robot.materials[material.name] = material

    def check_materials(self, robot: Robot) -> None:
        """A material that a link defines in place is known by its name everywhere."""
        used = []
        for link in robot.links.values():
            for visual in link.visuals:
                material = visual.material
                if material is None or not material.name:
                    continue
                if material.color is None and material.texture is None:
                    used.append((material.name, link.name, visual.line))
                else:
                    robot.materials.setdefault(material.name, material)
        for name, link_name, line in used:
            if name not in robot.materials:
                self.warn(
                    "material-undefined",
                    f"the material '{name}' is not defined",
                    line,
                    owner=("link", link_name),
                    like=(name, robot.materials),
                )

    def check_tree(self, robot: Robot) -> None:
        """One root, and every other link the child of exactly one joint."""
        links = robot.links
        if not links:
            self.fail("no-links", "the robot has no links", self.line)
        above: dict[str, Joint] = {}
        for joint in robot.joints.values():
            for which, name in (("parent", joint.parent), ("child", joint.child)):
                if name not in links:
                    self.fail(
                        "link-unknown",
                        f"joint '{joint.name}': there is no link called '{name}' ({which})",
                        joint.line,
                        nearest(name, links),
                    )
            other = above.setdefault(joint.child, joint)
            if other is not joint:
                self.fail(
                    "two-parents",
                    f"link '{joint.child}' has two parents: '{other.parent}' by the joint"
                    f" '{other.name}' (line {other.line}), and '{joint.parent}' by the joint"
                    f" '{joint.name}'",
                    joint.line,
                    "a robot in URDF is a tree: a loop cannot be closed in it",
                )
        self.check_loops(links, above)
        roots = [name for name in links if name not in above]
        if len(roots) > 1:
            self.fail(
                "several-roots",
                f"{len(roots)} links have no parent: {_listed(roots)}",
                links[roots[1]].line,
                "join them by a joint, or take away what does not belong to the robot",
            )

    def check_loops(self, links: Mapping[str, Link], above: Mapping[str, Joint]) -> None:
        seen: dict[str, str] = {}
        for start in links:
            name = start
            while name not in seen:
                seen[name] = start
                if name not in above:
                    break
                name = above[name].parent
            else:
                if seen[name] == start:
                    loop = [above[name]]
                    while loop[-1].parent != name:
                        loop.append(above[loop[-1].parent])
                    loop.reverse()
                    self.fail(
                        "loop",
                        f"the links {_listed([joint.parent for joint in loop])} form a loop"
                        f" (joints {_listed([joint.name for joint in loop])})",
                        loop[0].line,
                        "a robot in URDF is a tree: a loop cannot be closed in it",
                    )

    def check_mimics(self, robot: Robot) -> None:
        joints = robot.joints
        leaders: dict[str, str] = {}
        for joint in joints.values():
            if joint.mimic is None:
                continue
            leader = joint.mimic.joint
            if leader not in joints:
                self.fail(
                    "mimic-unknown",
                    f"joint '{joint.name}' mimics '{leader}', which is no joint"
                    if leader
                    else f"joint '{joint.name}' does not say which joint it mimics",
                    joint.line,
                    nearest(leader, joints),
                )
            leaders[joint.name] = leader
        seen: dict[str, str] = {}
        for start in leaders:
            name = start
            while name in leaders and name not in seen:
                seen[name] = start
                name = leaders[name]
            if name in leaders and seen[name] == start:
                loop = [name]
                while leaders[loop[-1]] != name:
                    loop.append(leaders[loop[-1]])
                self.fail(
                    "mimic-loop",
                    f"joint '{name}' mimics itself"
                    if len(loop) == 1
                    else f"the joints {_listed(loop)} mimic one another",
                    joints[name].line,
                    "take one <mimic> away",
                )


def _log(parser: etree.XMLParser) -> list[Any]:
    """What the parser said; an exception's own log also has what other parsers said before."""
    entries: Any = parser.error_log
    return list(entries)


def _parser(recover: bool = False) -> etree.XMLParser:
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, recover=recover)


def _strip_namespace(root: Any, space: str) -> None:
    """A default namespace on <robot> says nothing: read the elements as if without it."""
    for child in root.iterchildren(*(space + tag for tag in ("link", "joint", "material"))):
        for element in child.iter(f"{space}*"):
            element.tag = element.tag[len(space) :]
    for child in root.iterchildren(f"{space}*"):
        child.tag = child.tag[len(space) :]
    root.tag = "robot"


def _plain(tag: str) -> str:
    """A tag or attribute without its namespace."""
    return tag.rpartition("}")[2]


def _shown(text: str) -> str:
    text = _BLANKS.sub(" ", text).strip(" ")
    return repr(text if len(text) <= 60 else text[:57] + "...")


def _listed(names: list[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:6])
    return f"{shown} and {len(names) - 6} more" if len(names) > 6 else shown


def _principal_moments(tensor: Sym) -> tuple[float, float, float]:
    """Eigenvalues of a symmetric tensor, ascending, by Jacobi's method (Golub and Van Loan,
    Matrix Computations, 8.5): each as exact as the tensor's largest element allows."""
    size = max(map(abs, tensor))
    xx, xy, xz, yy, yz, zz = (value / size for value in tensor)
    a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    for _ in range(10):
        if abs(a[0][1]) + abs(a[0][2]) + abs(a[1][2]) < 1e-17:
            break
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if a[p][q] == 0.0:
                continue
            theta = (a[q][q] - a[p][p]) / (2 * a[p][q])
            t = (1.0 if theta >= 0 else -1.0) / (abs(theta) + hypot(theta, 1.0))
            c = 1.0 / hypot(t, 1.0)
            s = t * c
            for k in range(3):
                a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
            for k in range(3):
                a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
    small, middle, large = sorted(a[k][k] * size for k in range(3))
    return small, middle, large
