"""Certificate: write beside the .mbs what others need to compare it with the URDF.

Beyond the method.  ``urdf2mbs_certificate/certificate.py`` reads the URDF and the .mbs itself.  The
certificate, ``NAME.proof.json``, has the rest: which joints of the .mbs are a joint of the URDF,
which joints are locked and why, and what passes or people changed on purpose.  A rejected file gets
no certificate.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal
from xml.etree.ElementTree import Element, ParseError, tostring

import msgspec

from urdf2mbs.plugin import (
    JOINT_TYPES,
    Conversion,
    File,
    Intent,
    Link,
    OnPurpose,
    Origin,
    Pass,
    UrdfJoint,
    Vec,
    files,
    in_plane,
    unit,
)

#: The passes that change the robot if they are asked to; ``verify`` runs them again.
CHANGING_PASSES = ("snap", "estimate-inertia", "rotors")
#: The kinds of changes of a link's ``<inertial>``.
INERTIAL_CHANGES = ("mass", "centre", "inertia")
TENSOR_ATTRIBUTES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


class Change(msgspec.Struct, array_like=True):
    """An element of the URDF that is different now."""

    owner: tuple[str, str | None]
    """Tag and name of the element that it is in; ``("robot", None)`` for a new link or joint."""
    element: str
    """The element as it is now, in XML."""


class Content(msgspec.Struct, kw_only=True):
    """The content of a certificate."""

    urdf2mbs: str
    """The version."""
    passes: dict[str, Any]
    """Options of the passes that changed the robot."""
    gravity: Vec
    """m/s^2."""
    joints: dict[str, list[str]]
    """The .mbs joints of each URDF joint that moves."""
    planes: dict[str, tuple[Vec, Vec]]
    """The two directions in which each planar joint shifts."""
    driven: list[str]
    """The .mbs joints that are driven, although the URDF has them follow others."""
    held: dict[str, str]
    """The URDF joints that are locked at zero, each with the reason."""
    changes: list[Change]
    """Changes by passes, on purpose."""
    edited: list[str] = []
    """Differences that people made in the .mbs."""


class Certificate(Pass):
    """Write the certificate of a conversion."""

    reads = ("robot", "mbs-file")

    write: Literal["project", "always", "never"] = "project"
    """Where one is written: in a project, beside a lone .mbs too, or nowhere."""

    def run(self, conversion: Conversion) -> None:
        """Write the certificate of an .mbs that was checked, or remove an older one."""
        settings, checked = conversion.settings, conversion.checked
        if settings.output.suffix.lower() != ".mbs" or checked.rejected is not None:
            return
        path = settings.output.with_suffix(".proof.json")
        is_asked_for = self.write == "always" or (
            self.write == "project" and settings.project is not None
        )
        if checked.proof is None or not is_asked_for:
            conversion.files[path] = File(kind="obsolete")
            return
        conversion.report["certificate"] = {"file": path.name}
        content = build_content(conversion)
        if conversion.state(OnPurpose).edited:
            content.edited = find_edits(conversion, content)
        data = msgspec.json.encode(content)
        conversion.files[path] = msgspec.json.format(data, indent=1) + b"\n"


def build_content(conversion: Conversion) -> Content:
    """Build the content of a certificate, without the differences that people made."""
    from importlib.metadata import version

    config, robot = conversion.settings.config, conversion.robot
    natures = {name: joint.nature for name, joint in conversion.mbs.joints().items()}
    joints: dict[str, list[str]] = {}
    driven: list[str] = []
    for name, mbs_joints in conversion.names.coordinates.items():
        joint = robot.joints[name]
        if len(mbs_joints) == JOINT_TYPES[joint.type]:  # people may have removed one
            joints[name] = mbs_joints
        if joint.mimic is not None:
            driven += [mbs_joint for mbs_joint in mbs_joints if natures.get(mbs_joint) == "driven"]
    planar_joints = [name for name in joints if robot.joints[name].type == "planar"]
    return Content(
        urdf2mbs=version("urdf2mbs"),
        passes={name: config.passes[name] for name in CHANGING_PASSES if name in config.passes},
        gravity=config.gravity,
        joints=joints,
        planes={name: in_plane(unit(robot.joints[name].axis)) for name in planar_joints},
        driven=driven,
        held=conversion.frozen,
        changes=[*list_changes(conversion)],
    )


def list_changes(conversion: Conversion) -> Iterator[Change]:
    """List the elements of the URDF that passes changed, and the links and joints they added."""
    robot, inserted = conversion.robot, conversion.base.inserted
    changed = [
        (change.kind, change.name)
        for robot_change in conversion.checked.changed
        for change in robot_change.changes
    ]
    if inserted is not None and robot.joints[inserted].moves:
        changed += [("link-added", robot.joints[inserted].parent), ("joint-added", inserted)]
    changed_elements = dict.fromkeys(
        ("inertial" if kind in INERTIAL_CHANGES else kind, name) for kind, name in changed
    )
    for kind, name in changed_elements:
        tag = "link" if kind in ("inertial", "link-added") else "joint"
        owner = robot.links.get(name) if tag == "link" else robot.joints.get(name)
        if owner is None:
            continue
        elements = {element.tag: element for element in list_elements(owner)}
        if kind == f"{tag}-added":
            attributes = {"name": name}
            if isinstance(owner, UrdfJoint):
                attributes["type"] = owner.type
            element = create_element(tag, attributes, *elements.values())
            yield Change(("robot", None), tostring(element, "unicode"))
        elif kind in elements and (f"{tag}-added", name) not in changed:
            yield Change((tag, name), tostring(elements[kind], "unicode"))


def list_elements(owner: Link | UrdfJoint) -> Iterator[Element]:
    """List the elements of a link or joint that the replay compares."""
    if isinstance(owner, UrdfJoint):
        yield create_element("parent", {"link": owner.parent})
        yield create_element("child", {"link": owner.child})
        yield create_origin(owner.origin)
        yield create_element("axis", {"xyz": owner.axis})
        for tag in ("limit", "dynamics", "mimic"):
            value = getattr(owner, tag)
            if value is not None:
                yield create_element(tag, msgspec.structs.asdict(value))
    elif owner.inertial is not None:
        inertial = owner.inertial
        tensor = dict(zip(TENSOR_ATTRIBUTES, inertial.inertia, strict=True))
        yield create_element(
            "inertial",
            {},
            create_origin(inertial.origin),
            create_element("mass", {"value": inertial.mass}),
            create_element("inertia", tensor),
        )


def create_origin(origin: Origin) -> Element:
    """Create an ``<origin>``."""
    return create_element("origin", {"xyz": origin.xyz, "rpy": origin.rpy})


def create_element(tag: str, attributes: Mapping[str, Any], *children: Element) -> Element:
    """Create an element of URDF, without the attributes that have no value."""
    element = Element(tag)
    for key, value in attributes.items():
        # URDF has springs elsewhere than in <dynamics>.
        if value is not None and not key.startswith("spring"):
            text = " ".join(map(repr, value)) if isinstance(value, tuple) else value
            element.set(key, text if isinstance(text, str) else repr(text))
    element.extend(children)
    return element


def find_edits(conversion: Conversion, content: Content) -> list[str]:
    """Find the differences that the replay reports: people made them in the .mbs."""
    from urdf2mbs_certificate.certificate import replay

    model = conversion.files[conversion.settings.output]
    urdf = conversion.expanded or conversion.input.data
    with suppress(ParseError, ValueError):  # the replay refuses some files that urdf2mbs repairs
        differences, _ = replay(urdf, model, msgspec.json.encode(content))
        return [*differences]
    return []


def read_intent(model: Path) -> Intent | None:
    """Return what the certificate beside an .mbs records of changes on purpose.

    Args:
        model: The .mbs.

    Returns:
        The options of the passes that changed the robot, and the joints that are driven although
        the URDF has them follow others; None if there is no certificate that can be read.
    """
    try:
        data = files.read_bytes(model.with_suffix(".proof.json"))
        return msgspec.json.decode(data, type=Intent)
    except (OSError, ValueError, msgspec.MsgspecError):
        return None
