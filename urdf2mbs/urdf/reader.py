"""From a URDF or xacro file to a ``Robot``, or to one error that says what is wrong where.

An error only where no meaning is left.  What is odd is kept as it is, and what the .mbs does not
need is left out where it cannot be read; both are warnings.  Where URDF leaves a choice,
urdfdom's is taken.
"""

from __future__ import annotations

import re
from math import hypot, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NoReturn, TypeVar

from lxml import etree

from urdf2mbs.diagnostics import ConversionError, Diagnostic, nearest
from urdf2mbs.spatial import NO_INERTIA, ZERO, to_xyz_angles
from urdf2mbs.urdf import inertia, xml
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
from urdf2mbs.urdf.xacro import LEGACY, LEGACY_HINT, Expansion, expand

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

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
_NAMES_SHOWN = 4
#: So many errors of one file are told together.
MOST_ERRORS = 20
_Part = TypeVar("_Part")
_REPAIR = "estimate-inertia: {repair: true} puts the nearest one that a body can have"
_BLANKS = re.compile(r"[ \t\r\n]+")
#: A file name that a package which was not found stands in.
_UNRESOLVED = re.compile(r"^file:/*(?=package://)")


def read_robot(
    source: Path, packages: Packages, xacro_args: Mapping[str, str]
) -> tuple[Robot, list[Diagnostic]]:
    """Read a robot; a file with xacro in it is expanded first, whatever its name.

    An error among the diagnostics is one that the user may lower; then what it is about is left
    out.

    :raises ConversionError: the codes of ``parse`` and of ``xacro.expand``, and
        ``file-not-found``, ``file-is-directory``, ``file-unreadable``
    """
    return read_text(source, *expanded(source, packages, xacro_args), xacro_args)


def expanded(
    source: Path, packages: Packages, xacro_args: Mapping[str, str]
) -> tuple[bytes, Expansion | None]:
    """A file's bytes, and what xacro makes of them; None where there is no xacro in it."""
    data = _read(source)
    if not data.strip():
        raise ConversionError("file-empty", "the file is empty", file=str(source))
    if source.suffix.lower() != ".xacro" and not has_xacro(data, str(source)):
        return data, None
    return data, expand(source, packages, xacro_args)


def has_xacro(data: bytes, file: str) -> bool:
    """Whether a URDF has elements, or values of links and joints, that xacro must expand."""
    if b"xacro" not in data and b"${" not in data and b"$(" not in data:
        return False
    root, _ = xml.parse(data, file)
    for element in root.iter(etree.Element):
        if _is_xacro(element):
            return True
    for child in root.iterchildren("{*}link", "{*}joint", "{*}material"):
        for element in child.iter(etree.Element):
            for value in element.values():
                if "${" in value or "$(" in value:
                    return True
    return False


def read_text(
    source: Path, data: bytes, expansion: Expansion | None, xacro_args: Mapping[str, str]
) -> tuple[Robot, list[Diagnostic]]:
    """Read what ``expanded`` gave; raises ConversionError."""
    if expansion is None:
        robot, diagnostics = parse(data, str(source))
        if xacro_args:
            diagnostics.append(
                Diagnostic(
                    "warning",
                    "xacro-unused-arg",
                    "arguments have no effect, as there is no xacro in the file: "
                    + ", ".join(sorted(xacro_args)),
                    file=str(source),
                )
            )
    else:
        try:
            robot, diagnostics = parse(expansion.text, str(source), expanded=True)
        except ConversionError as error:
            error.said[:0] = expansion.warnings
            raise
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

    :raises ConversionError: the last of the errors, with the others in its ``said``
    """
    reader = _Reader(f"{file} (expanded)" if expanded else file, expanded)
    try:
        return reader.robot(data)
    except ConversionError as error:
        error.said = [*reader.diagnostics(), *reader.errors]
        raise


def _read(source: Path) -> bytes:
    file = str(source)
    try:
        return source.read_bytes()
    except FileNotFoundError:
        try:
            known = [
                entry.name
                for entry in sorted(source.parent.iterdir())
                if entry.suffix.lower() in (".urdf", ".xacro")
                and nearest(source.name.split(".")[0], [entry.name.split(".")[0]])
            ]
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


class _Group:
    """Warnings of one kind, said once for all the elements they are about."""

    def __init__(
        self, level: Literal["error", "warning", "note"], line: int | None, hint: str | None
    ) -> None:
        self.level = level
        self.line = line
        self.hint = hint
        self.owners: dict[tuple[str, str], str] = {}
        """Kind and name, and what is to be said of it alone."""


class _Reader:
    """One file being read: where we are, what has been said."""

    def __init__(self, file: str, expanded: bool) -> None:
        self.file = file
        self.expanded = expanded
        self.groups: dict[tuple[str, str], _Group] = {}
        self.errors: list[Diagnostic] = []
        """What is wrong, but for the last."""
        self.last: ConversionError | None = None
        self.owner = ("robot", "")
        """Kind and name of the element being read, for messages."""
        self.vectors: dict[str, Vec] = {}
        self.line: int | None = None
        """Of <robot>."""
        self.colourless: set[str] = set()
        """Materials whose colour could not be read, which is said."""
        self.legacy: str | None = None
        """The first ``<property>`` that xacro does not read any more."""
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
        if self.expanded:
            more = "the line is one of the expanded text: --dump DIR writes it, as expanded.urdf"
            hint = f"{hint}; {more}" if hint else more
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)

    def keep(self, error: ConversionError) -> None:
        """Go on after an error, so that those that follow are told with it."""
        if self.last is not None:
            self.errors.append(self.last.diagnostic())
        self.last = error
        if len(self.errors) + 1 == MOST_ERRORS:
            more = f"these are the first {MOST_ERRORS} errors: there may be more"
            error.hint = f"{error.hint}; {more}" if error.hint else more
            raise error

    def warn(
        self,
        code: str,
        message: str,
        line: int | None,
        *,
        hint: str | None = None,
        like: tuple[str, Iterable[str]] | None = None,
        owner: tuple[str, str] | None = None,
        level: Literal["error", "warning", "note"] = "warning",
        detail: str = "",
    ) -> None:
        """The same message about several links or joints is said once, with their names.

        ``like``: a wrong name and the right ones, the nearest of which is offered; ``detail``:
        what differs from one link or joint to the next.
        """
        group = self.groups.get((code, message))
        if group is None:
            if like is not None:
                hint = nearest(like[0], sorted(like[1]))
            group = self.groups[code, message] = _Group(level, line, hint)
        owner = owner or self.owner
        before = group.owners.get(owner, "")
        group.owners[owner] = f"{before}; {detail}" if before and detail else before or detail

    def diagnostics(self) -> list[Diagnostic]:
        said = []
        for (code, message), group in self.groups.items():
            owners = list(group.owners)
            kind, name = owners[0]
            shown = ", ".join(
                f"{kind} '{name}'" + (f" ({detail})" if detail else "")
                for (kind, name), detail in list(group.owners.items())[:_NAMES_SHOWN]
                if name
            )
            more = len(owners) - _NAMES_SHOWN
            text = f"{message}: {shown}" if shown else message
            if more > 0:
                text += f" and {more} more"
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
        root, slips = xml.parse(data, self.file)
        for slip in slips:
            self.warn(slip.code, slip.message, slip.line)
        return root

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
        if self.xacro_left(child):
            return
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

    def xacro_left(self, element: Any) -> bool:
        """Whether an element is one that xacro should have dealt with; it is left out, and that
        is said."""
        tag = element.tag
        if _is_xacro(element):
            self.warn(
                "xacro-macro-unknown",
                f"<xacro:{_plain(tag).rpartition(':')[2]}> was left by xacro",
                element.sourceline,
                level="error",
            )
            return True
        if tag == "property":
            self.legacy = self.legacy or element.get("name") or "?"
            self.warn(
                "property-unused",
                "<property> without the prefix xacro: has no effect, and is not used",
                element.sourceline,
                owner=("property", element.get("name") or ""),
            )
            return True
        if tag in LEGACY:
            self.warn(
                "xacro-legacy",
                f"<{tag}> without the prefix xacro: is not read by xacro any more",
                element.sourceline,
                hint=LEGACY_HINT.format(tag=tag),
                level="error",
            )
            return True
        return False

    def unexpanded(self, what: str, line: int | None) -> NoReturn:
        if self.legacy is not None:
            self.fail(
                "xacro-legacy",
                f"{what}: '{self.legacy}' is given by <property> without the prefix xacro:, which "
                "is not read by xacro any more",
                line,
                LEGACY_HINT.format(tag="property"),
            )
        self.fail("xacro-unexpanded", f"{what} was left by xacro", line)

    # -- values -----------------------------------------------------------------------

    def name(self, element: Any, kind: str, taken: Mapping[str, Any]) -> str | None:
        """The ``name`` of a link or joint: there must be one, and only once.

        None for an element that says again, word for word, what another of its name has said.
        """
        name: str | None = element.get("name")
        if not name or not name.strip():
            self.fail(
                "name-missing",
                f"a {kind} without a name",
                element,
                f"every <{kind}> needs a name of its own",
            )
        self.owner = (kind, name)
        if name != name.strip():
            self.warn(
                "name-blank", "the name begins or ends with a blank, which is kept",
                element.sourceline,
            )  # fmt: skip
        if name in taken:
            if _says_the_same(element, kind, name):
                self.doubled("robot", element)
                return None
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
                self.fail(
                    "number-invalid",
                    f"{what} is {_shown(text)}: {_shown(word)} is not a number",
                    element,
                    _comma_hint(text, count) or "write it as 1.5 or -2e-3",
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

    def left_out(self, element: Any, what: str, error: ConversionError) -> None:
        """Say that something that the .mbs does not need is left out, as it cannot be read."""
        reason = error.message.partition(f"{self.where}: ")[2] or error.message
        self.warn(
            "number-left-out", f"{what} is left out, as it cannot be read", element.sourceline,
            detail=reason,
        )  # fmt: skip

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
        if name is None:
            return
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
        mass, tensor = 0.0, NO_INERTIA
        if mass_element is not None:
            mass = self.number(mass_element, "value", self.attribute(mass_element, "value"))
            if mass < 0.0:
                self.warn(
                    "mass-negative", "no body has a mass below zero; it is kept",
                    mass_element.sourceline, detail=f"{mass!r} kg", hint=_REPAIR,
                )  # fmt: skip
        if inertia_element is not None and not inertia_element.attrib:
            inertia_element = None
        if inertia_element is not None:
            given = self.attributes(inertia_element)
            missing = [name for name in ("ixy", "ixz", "iyz") if name not in given]
            if missing:
                self.warn(
                    "inertia-incomplete",
                    "<inertia> has not all products of inertia; those missing are zero",
                    inertia_element.sourceline, detail=", ".join(missing),
                )  # fmt: skip
            xx, xy, xz, yy, yz, zz = (
                0.0 if name in missing else self.number(inertia_element, name, given.get(name))
                for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            )
            tensor = (xx, xy, xz, yy, yz, zz)
            if tensor != NO_INERTIA:
                self.check_inertia(tensor, mass, inertia_element)
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
        if mass == 0.0 and tensor != NO_INERTIA:
            self.warn("inertia-without-mass", "inertia, but no mass", line)
        elif mass > 0.0 and tensor == NO_INERTIA:
            self.warn("mass-without-inertia", "mass, but no inertia", line, level="note")
        return Inertial(mass, tensor, origin)

    def check_inertia(self, tensor: Sym, mass: float, element: Any) -> None:
        """Warn of an inertia that no body has."""
        fault = inertia.fault(tensor, mass)
        if fault is None:
            return
        self.warn(
            fault.code,
            "no body has such an inertia, which is kept: "
            + (
                "a principal moment is below zero"
                if fault.code == "inertia-indefinite"
                else "one principal moment is more than the others together"
            ),
            element.sourceline,
            detail="principal moments " + ", ".join(f"{m:.6g}" for m in fault.moments) + " kg m^2",
            hint="check that it is about the centre of mass, and its signs; " + _REPAIR,
        )

    def visual(self, element: Any, visuals: list[Visual]) -> None:
        name = self.attribute(element, "name")
        parts = self.parts(element)
        material = parts.get("material")
        look = None if material is None else self.material(material)
        placed = self.shape(element, parts)
        if placed is not None:
            visuals.append(Visual(*placed, look, name, element.sourceline))

    def collision(self, element: Any, collisions: list[Collision]) -> None:
        name = self.attribute(element, "name")
        placed = self.shape(element, self.parts(element))
        if placed is not None:
            collisions.append(Collision(*placed, name, element.sourceline))

    def shape(self, element: Any, parts: dict[str, Any]) -> tuple[Geometry, Origin] | None:
        """Of a visual or collision; None where it cannot be read, which is said."""
        try:
            geometry = self.geometry(element, parts.get("geometry"))
            return None if geometry is None else (geometry, self.origin(parts.get("origin")))
        except ConversionError as error:
            self.left_out(element, f"a <{element.tag}>", error)
            return None

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
            filename = _UNRESOLVED.sub("", filename)
            if "scale" not in attributes:
                return Mesh(filename)
            scale = self.scale(shape, attributes["scale"])
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

    def scale(self, element: Any, text: str) -> Vec:
        """Of a mesh: three numbers, or one for all directions."""
        if len(text.split()) != 1:
            return self.vector(element, "scale", text)
        factor = self.number(element, "scale", text)
        self.warn(
            "mesh-scale", "the scale of a mesh is one number, taken for all directions",
            element.sourceline, detail=text.strip(),
        )  # fmt: skip
        return (factor, factor, factor)

    def material(self, element: Any) -> Material | None:
        name = self.attribute(element, "name") or ""
        color: tuple[float, float, float, float] | None = None
        texture: str | None = None
        if len(element):
            parts = self.parts(element)
            if "color" in parts:
                child = parts["color"]
                rgba = self.attribute(child, "rgba")
                try:
                    r, g, b, a = self.numbers(child, "rgba", rgba, 4)
                    color = (r, g, b, a)
                except ConversionError as error:
                    self.left_out(child, "a colour", error)
                    self.colourless.add(name)
                if color is not None and (min(color) < 0.0 or max(color) > 1.0):
                    self.warn("color-range", "rgba is not within 0 and 1", child.sourceline)
            if "texture" in parts:
                child = parts["texture"]
                texture = self.attribute(child, "filename") or None
        if not name and color is None and texture is None:
            return None
        return Material(name, color, texture)

    # -- joints -----------------------------------------------------------------------

    def joint(self, element: Any, joints: dict[str, Joint]) -> None:
        name = self.name(element, "joint", joints)
        if name is None:
            return
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
            plain = kind.strip().lower()
            if plain not in JOINT_TYPES:
                self.fail(
                    "joint-type-unknown",
                    f"joint '{name}' is of the type {_shown(kind)}, which URDF does not know",
                    element,
                    nearest(plain, JOINT_TYPES) or f"the types are: {types}",
                )
            self.warn(
                "joint-type-spelling", f"the type {_shown(kind)} is read as '{plain}'",
                element.sourceline,
            )  # fmt: skip
            kind = plain
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
        joint.dynamics = self.optional(parts, "dynamics", self.dynamics)
        joint.mimic = self.optional(parts, "mimic", self.mimic)
        joint.safety_controller = self.optional(parts, "safety_controller", self.safety)
        joint.calibration = self.optional(parts, "calibration", self.calibration)

    def optional(
        self, parts: dict[str, Any], tag: str, read: Callable[[Any], _Part]
    ) -> _Part | None:
        """A part of a joint that the .mbs does not have: left out where it cannot be read."""
        if tag not in parts:
            return None
        try:
            return read(parts[tag])
        except ConversionError as error:
            self.left_out(parts[tag], f"<{tag}>", error)
            return None

    def dynamics(self, element: Any) -> Dynamics:
        return Dynamics(**self.known_numbers(element))

    def mimic(self, element: Any) -> Mimic:
        return Mimic(element.get("joint") or "", **self.known_numbers(element))

    def safety(self, element: Any) -> SafetyController:
        if element.get("k_velocity") is None:
            self.bad_number(element, "k_velocity", None, 1)
        return SafetyController(**self.known_numbers(element))

    def calibration(self, element: Any) -> Calibration:
        return Calibration(**self.known_numbers(element))

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
        return name

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
        """Each number by itself; one that cannot be read, or is infinite, is no limit."""
        numbers: dict[str, float | None] = {}
        for name, text in self.attributes(element).items():
            if name not in ATTRIBUTES["limit"]:
                continue
            try:
                numbers[name] = self.number(element, name, text)
            except ConversionError as error:
                self.left_out(element, "a limit", error)
                numbers[name] = None
        limit = Limit(**numbers)
        lower, upper = limit.lower, limit.upper
        ranged = joint.type in ("revolute", "prismatic") and None not in (lower, upper)
        if ranged and lower > upper:  # type: ignore[operator]
            self.warn(
                "limit-order", "the lower limit is above the upper one", element.sourceline,
                detail=f"{lower!r} and {upper!r}",
            )  # fmt: skip
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
            if tag in ("link", "joint"):
                try:
                    if tag == "link":
                        self.link(child, links)
                    else:
                        self.joint(child, joints)
                except ConversionError as error:
                    self.keep(error)
            elif tag == "material":
                self.global_material(child, robot)
            elif isinstance(tag, str):
                self.owner = ("robot", "")
                if tag not in FOREIGN:
                    if self.xacro_left(child):
                        continue
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
        if self.last is not None:  # the tree cannot be judged where links or joints are not known
            raise self.last
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
            if name not in robot.materials and name not in self.colourless:
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
        self.imply_world(robot)
        links = robot.links
        for joint in robot.joints.values():
            try:
                self.check_ends(joint, links, above)
            except ConversionError as error:
                self.keep(error)
        if self.last is not None:
            raise self.last
        self.check_loops(links, above)
        roots = [name for name in links if name not in above]
        if len(roots) > 1:
            roots = self.without_unattached(robot, roots)
        if len(roots) > 1:
            self.fail(
                "several-roots",
                f"{len(roots)} links have no parent: {_listed(roots)}",
                links[roots[1]].line,
                "join them by a joint, or take away what does not belong to the robot",
            )

    def check_ends(
        self, joint: Joint, links: Mapping[str, Link], above: dict[str, Joint]
    ) -> None:
        """A joint's links exist, and its child has no other parent."""
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

    def imply_world(self, robot: Robot) -> None:
        """A link ``world`` that joints name as their parent need not be declared."""
        for joint in robot.joints.values():
            if joint.parent == "world" and "world" not in robot.links:
                robot.links = {"world": Link("world"), **robot.links}
                self.warn(
                    "world-implied", "there is no link called 'world': it is implied",
                    joint.line, owner=("joint", joint.name),
                )  # fmt: skip

    def without_unattached(self, robot: Robot, roots: list[str]) -> list[str]:
        """Take away links that no joint holds and that hold nothing: no mass, no shape."""
        holding = {joint.parent for joint in robot.joints.values()}
        empty = [
            link
            for name, link in robot.links.items()
            if name in roots and name not in holding
            and link.massless and not link.visuals and not link.collisions
        ]  # fmt: skip
        for link in empty if len(empty) < len(roots) else []:
            del robot.links[link.name]
            self.warn(
                "link-unattached", "no joint leads to it, and nothing is in it: left out",
                link.line, owner=("link", link.name),
            )  # fmt: skip
        return [name for name in roots if name in robot.links]

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
        """A joint that follows nothing, or itself, is free: the .mbs has no mimic anyway."""
        joints = robot.joints
        leaders: dict[str, str] = {}
        for joint in joints.values():
            if joint.mimic is None:
                continue
            leader = joint.mimic.joint
            if leader not in joints:
                joint.mimic = None
                self.warn(
                    "mimic-left-out",
                    f"it mimics '{leader}', which is no joint, so it is free"
                    if leader
                    else "it does not say which joint it mimics, so it is free",
                    joint.line, owner=("joint", joint.name), like=(leader, joints),
                )  # fmt: skip
            else:
                leaders[joint.name] = leader
        seen: dict[str, str] = {}
        for start in list(leaders):
            name = start
            while name in leaders and name not in seen:
                seen[name] = start
                name = leaders[name]
            if name in leaders and seen[name] == start:
                loop = [name]
                while leaders[loop[-1]] != name:
                    loop.append(leaders[loop[-1]])
                for one in loop:
                    joints[one].mimic = None
                    self.warn(
                        "mimic-left-out",
                        "joints that mimic one another, or themselves, are free",
                        joints[loop[0]].line, owner=("joint", one),
                    )  # fmt: skip


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


def _is_xacro(element: Any) -> bool:
    """Whether an element is xacro's, by its namespace or its prefix."""
    tag = element.tag
    space = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
    return element.prefix == "xacro" or (space != tag and "xacro" in space)


def _says_the_same(element: Any, kind: str, name: str) -> bool:
    """Whether the first element of a kind and name is the same as this one, blanks aside."""
    first = next(one for one in element.getparent().iterchildren(kind) if one.get("name") == name)
    said = [
        [
            (e.tag, len(e), sorted(e.items()), (e.text or "").strip())
            for e in one.iter(etree.Element)
        ]
        for one in (first, element)
    ]
    return said[0] == said[1]


def _comma_hint(text: str, count: int) -> str | None:
    """What to do about commas in numbers."""
    if "," not in text:
        return None
    if count > 1 and len(text.replace(",", " ").split()) == count:
        return "numbers are separated by blanks, not commas"
    return "write decimals with a point"
