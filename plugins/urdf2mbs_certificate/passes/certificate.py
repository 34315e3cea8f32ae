"""Certificate: beside the .mbs, what others need to compare it with the URDF.

Beyond the method.  ``proof/certificate.py`` reads the URDF and the .mbs itself.  The certificate,
``NAME.proof.json``, has what stands in neither file: which joints of the .mbs are a joint of the
URDF, which joints are held and why, what passes changed on purpose, and what people edited.
A rejected file gets none.
"""

from __future__ import annotations

from collections.abc import Iterator
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
    files,
    in_plane,
    unit,
)
from urdf2mbs.plugin import UrdfJoint as Joint

#: The passes that change the robot when they are asked to; ``verify`` asks them again.
CHANGING = ("snap", "estimate-inertia", "rotors")
#: The kinds of changes that concern a link's ``<inertial>``.
_INERTIAL = ("mass", "centre", "inertia")


class Certificate(Pass):
    reads = ("robot", "mbs-file")

    write: Literal["project", "always", "never"] = "project"
    """Where one is written: in a project, beside a lone .mbs too, or nowhere."""

    def run(self, conversion: Conversion) -> None:
        output, project = conversion.settings.output, conversion.settings.project
        if output.suffix.lower() != ".mbs" or conversion.checked.rejected is not None:
            return
        path = output.with_suffix(".proof.json")
        wanted = self.write == "always" or (self.write == "project" and project is not None)
        if conversion.checked.proof is None or not wanted:
            conversion.files[path] = File(kind="obsolete")
            return
        conversion.report["certificate"] = {"file": path.name}
        said = _certificate(conversion)
        if conversion.state(OnPurpose).edited:
            said["edited"] = _edited(conversion, said)
        conversion.files[path] = msgspec.json.format(msgspec.json.encode(said), indent=1) + b"\n"


def _certificate(conversion: Conversion) -> dict[str, Any]:
    """What a certificate says, but for what people edited."""
    from importlib.metadata import version

    config, robot = conversion.settings.config, conversion.robot
    natures = {name: joint.nature for name, joint in conversion.mbs.joints().items()}
    joints: dict[str, list[str]] = {}
    driven: list[str] = []
    for name, own in conversion.names.coordinates.items():
        if len(own) == JOINT_TYPES[robot.joints[name].type]:  # people may have removed one
            joints[name] = own
        if robot.joints[name].mimic is not None:
            driven += [one for one in own if natures.get(one) == "driven"]
    return {
        "urdf2mbs": version("urdf2mbs"),
        "passes": {name: config.passes[name] for name in CHANGING if name in config.passes},
        "gravity": config.gravity,
        "joints": joints,
        "planes": {
            name: in_plane(unit(robot.joints[name].axis))
            for name in joints
            if robot.joints[name].type == "planar"
        },
        "driven": driven,
        "held": conversion.frozen,
        "changes": [*_changes(conversion)],
        "edited": [],
    }


def _changes(conversion: Conversion) -> Iterator[tuple[tuple[str, str | None], str]]:
    """What passes changed: a link or joint, and an element of it as it is now, in XML.

    A link or joint that was added is an element of the robot.
    """
    robot, inserted = conversion.robot, conversion.base.inserted
    changed = [
        (change.kind, change.name) for by in conversion.checked.changed for change in by.changes
    ]
    if inserted is not None and robot.joints[inserted].moves:
        changed += [("link-added", robot.joints[inserted].parent), ("joint-added", inserted)]
    for kind, name in dict.fromkeys(("inertial" if k in _INERTIAL else k, n) for k, n in changed):
        tag = "link" if kind in ("inertial", "link-added") else "joint"
        part = robot.links.get(name) if tag == "link" else robot.joints.get(name)
        elements = {element.tag: element for element in _elements(part)}
        if part is not None and kind == f"{tag}-added":
            whole = {"name": name} | ({"type": part.type} if isinstance(part, Joint) else {})
            yield ("robot", None), tostring(_element(tag, whole, *elements.values()), "unicode")
        elif kind in elements and (f"{tag}-added", name) not in changed:
            yield (tag, name), tostring(elements[kind], "unicode")


def _elements(part: Link | Joint | None) -> Iterator[Element]:
    """The elements of a link or joint that the certificate compares."""
    if isinstance(part, Link) and part.inertial is not None:
        tensor = dict(
            zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), part.inertial.inertia, strict=True)
        )
        parts = _origin(part.inertial.origin), _element("mass", {"value": part.inertial.mass})
        yield _element("inertial", {}, *parts, _element("inertia", tensor))
    if isinstance(part, Joint):
        yield _element("parent", {"link": part.parent})
        yield _element("child", {"link": part.child})
        yield _origin(part.origin)
        yield _element("axis", {"xyz": part.axis})
        for tag in ("limit", "dynamics", "mimic"):
            inner = getattr(part, tag)
            if inner is not None:
                yield _element(tag, msgspec.structs.asdict(inner))


def _origin(origin: Origin) -> Element:
    return _element("origin", {"xyz": origin.xyz, "rpy": origin.rpy})


def _element(tag: str, attributes: dict[str, Any], *parts: Element) -> Element:
    """An element of URDF, without the attributes that have no value."""
    element = Element(tag)
    for key, value in attributes.items():
        if value is not None and not key.startswith("spring"):  # which a URDF has elsewhere
            text = " ".join(map(repr, value)) if isinstance(value, tuple) else value
            element.set(key, text if isinstance(text, str) else repr(text))
    element.extend(parts)
    return element


def _edited(conversion: Conversion, said: dict[str, Any]) -> list[str]:
    """What the replay finds to be not the same: people changed it in the .mbs."""
    from urdf2mbs_certificate.certificate import replay

    model = conversion.files[conversion.settings.output]
    with suppress(ParseError, ValueError):  # the replay refuses what our reader mends
        urdf = conversion.expanded or conversion.input.data
        return [*replay(urdf, model, msgspec.json.encode(said))[0]]
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
