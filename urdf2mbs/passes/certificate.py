"""Certificate: beside the .mbs, what ``check`` compared, for others to replay.

Beyond the method.  ``NAME.proof.json`` is an in-toto Statement with the predicate "test result"
(https://github.com/in-toto/attestation, spec/v1/statement.md and spec/predicates/test-result.md):
whoever signs releases can sign it.  It names each file by its sha256, and has the numbers of each
rigid group.  ``proof/certificate.py`` replays the comparison.  A rejected file gets none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.seal import seal
from urdf2mbs.engine.config import Config
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import BASE, ORIGIN
from urdf2mbs.proof.parameters import stated
from urdf2mbs.proof.rigid import Frame
from urdf2mbs.proof.verdict import Compared, Proof
from urdf2mbs.spatial import ZERO, Pose, compose
from urdf2mbs.urdf.model import Inertial, Joint, Link, Origin

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

STATEMENT = "https://in-toto.io/Statement/v1"
PREDICATE = "https://in-toto.io/attestation/test-result/v0.1"
#: Where the URDF has the numbers of the user models: an element of the joint, its attribute, and
#: what it means where the URDF says nothing.
_NUMBERS = {
    "damping": ("dynamics", "damping", "0"), "friction": ("dynamics", "friction", "0"),
    "spring_stiffness": ("springStiffness", "value", "0"),
    "spring_reference": ("springReference", "value", "0"),
    "effort": ("limit", "effort", "nan"), "velocity": ("limit", "velocity", "nan"),
    "q_min": ("limit", "lower", "nan"), "q_max": ("limit", "upper", "nan"),
    "k_velocity": ("safety_controller", "k_velocity", "nan"),
    "k_position": ("safety_controller", "k_position", "nan"),
    "soft_q_min": ("safety_controller", "soft_lower_limit", "nan"),
    "soft_q_max": ("safety_controller", "soft_upper_limit", "nan"),
    "calibration_rising": ("calibration", "rising", "nan"),
    "calibration_falling": ("calibration", "falling", "nan"),
}  # fmt: skip
#: What of a config says where files are, and not what is made of them.
_PLACES = ("source", "output", "packages", "sweep")


class Certificate(Pass):
    reads = ("mbs-file",)

    write: Literal["project", "always", "never"] = "project"
    """Where one is written: in a project, beside a lone .mbs too, or nowhere."""

    def run(self, conversion: Conversion) -> None:
        output, project = conversion.settings.output, conversion.settings.project
        proof = conversion.proof
        if output.suffix.lower() != ".mbs" or conversion.rejected is not None:
            return
        path = output.with_suffix(".proof.json")
        if proof is None or self.write == "never" or (self.write == "project" and project is None):
            conversion.obsolete.add(path)
            return
        statement = {
            "_type": STATEMENT,
            "subject": _files(conversion, project or output.parent),
            "predicateType": PREDICATE,
            "predicate": {
                "result": "WARNED" if _warned(conversion, proof) else "PASSED",
                "configuration": _sources(conversion),
                "passedTests": _passed(proof),
                "warnedTests": _warned(conversion, proof),
                "failedTests": [],
                "urdf2mbs": _compared(conversion, proof),
            },
        }
        conversion.report["certificate"] = {"file": path.name}
        conversion.files[path] = _text(statement)


def _text(data: Any) -> bytes:
    import json  # a name of a file may be no text, which msgspec refuses

    text = json.dumps(data, allow_nan=False).encode()
    with suppress(msgspec.DecodeError):
        text = msgspec.json.format(text, indent=1)
    return text + b"\n"


def _files(conversion: Conversion, folder: Path) -> list[Any]:
    """The files made, the .mbs first; their names are seen from the project's folder."""
    files = sorted(conversion.files, key=lambda path: (path != conversion.settings.output, path))
    return [
        _described(
            path.relative_to(folder).as_posix(),
            # a merged file gets no seal
            conversion.files[path]
            if path in conversion.replaces
            else seal(path, conversion.files[path]),
        )
        for path in files
        if path.is_relative_to(folder)
    ]


def _sources(conversion: Conversion) -> list[Any]:
    """The robot's file as it was read, and the URDF that xacro made of it."""
    name = conversion.settings.source.name
    sources = [_described(name, conversion.source)]
    if conversion.expanded is not None:
        from xml.etree.ElementTree import ParseError, canonicalize

        # xacro puts a path of this machine into a comment
        with suppress(ParseError):  # the reader mends what no other parser reads
            text = canonicalize(conversion.expanded.decode("utf-8-sig"))
            sources.append(_described("expanded.urdf", text.encode()))
            sources[1]["annotations"] = {"canonicalization": "Canonical XML 2.0, no comments"}
    return sources


def _described(name: str, data: bytes) -> dict[str, Any]:
    """A resource descriptor of in-toto."""
    from hashlib import sha256

    return {"name": name, "digest": {"sha256": sha256(data).hexdigest()}}


def _passed(proof: Proof) -> list[str]:
    groups = [group.coordinate for group in proof.compared]
    return ["gravity", *(f"motion and inertia behind '{name}'" for name in groups)]


def _warned(conversion: Conversion, proof: Proof) -> list[str]:
    """What is known not to be as in the URDF, and what nothing compares."""
    return [
        *map(str, conversion.changed),
        *(f"{thing}: {why}" for thing, why in (proof.but_for | proof.not_compared).items()),
    ]


def _compared(conversion: Conversion, proof: Proof) -> dict[str, Any]:
    """The rest, which is ours: versions, options, what plugins changed, and all groups."""
    from importlib.metadata import version

    from urdf2mbs.proof.certificate import read, rest_of

    packages = ["urdf2mbs"] + ["xacro"] * (conversion.expanded is not None)
    return {
        "versions": {package: version(package) for package in packages},
        "options": _options(conversion.settings.config),
        "changed": [str(change) for change in conversion.changed],
        "changes": [*_changes(conversion)],
        "but_for": proof.but_for,
        "not_compared": proof.not_compared,
        "numbers": {
            m.name: _NUMBERS[m.name] for m in conversion.mbs.user_models if m.name in _NUMBERS
        },
        "rest": rest_of(read(conversion.files[conversion.settings.output])),
        "frames": [*_frames(conversion, proof)],
        "groups": [_group(group) for group in proof.compared],
    }


def _changes(conversion: Conversion) -> Iterator[tuple[list[str], tuple[str, Any], Any]]:
    """Each element that passes changed or added: where it is, its text and attributes in the
    URDF, and the attributes that it got."""
    inserted, robot = conversion.inserted, conversion.robot
    changed = [change.name for changed in conversion.changed for change in changed.changes]
    added = () if inserted is None else (inserted, robot.joints[inserted].parent)
    names = dict.fromkeys((*changed, *added))
    urdf: dict[tuple[str, str | None], list[Element]] = {}
    for element in _urdf(conversion) if names else ():
        named = element.tag if element.tag in ("link", "joint") else ""
        key = named, element.get("name" if named else "reference")
        urdf.setdefault(key, []).append(element)
    for name in names:
        parts = {"link": robot.links.get(name), "joint": robot.joints.get(name)}
        for tag, part in parts.items():
            own = [*urdf.get((tag, name), ()), *urdf.get(("", name), ())]
            for path, after in _said(part).items():
                found = [element for e in own for element in e.iterfind(path or ".")]
                text, said = ((found[0].text or "").strip(), found[0].attrib) if found else ("", {})
                if any(_read(said.get(key, text)) != _read(value) for key, value in after.items()):
                    yield [tag, name, *filter(None, path.split("/"))], (text, said), after


def _urdf(conversion: Conversion) -> list[Element]:
    """The elements of the URDF, as the replay reads it."""
    from xml.etree.ElementTree import ParseError

    from urdf2mbs.proof.certificate import read

    with suppress(ParseError):  # the reader mends what no other parser reads
        return [*read(conversion.expanded or conversion.source)]
    return []


def _read(text: str) -> Any:
    """The numbers of an attribute, if it has numbers."""
    try:
        return [float(number) for number in text.split()]
    except ValueError:
        return text


def _said(part: Link | Joint | None) -> dict[str, dict[str, str]]:
    """The elements of a link or joint that move or weigh something, and their attributes."""
    if part is None:
        return {}
    if isinstance(part, Link):
        mass, inertia, origin = msgspec.structs.astuple(part.inertial or Inertial())
        tensor = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), map(repr, inertia), strict=True)
        return {
            "": {"name": part.name},
            "inertial/mass": {"value": repr(mass)},
            "inertial/inertia": dict(tensor),
            "inertial/origin": _place(origin),
        }
    said = {
        "": {"name": part.name, "type": part.type},
        "parent": {"link": part.parent},
        "child": {"link": part.child},
        "origin": _place(part.origin),
        "axis": {"xyz": _words(part.axis)},
        **({"mimic": {"joint": part.mimic.joint}} if part.mimic else {}),
    }
    for kind, value in stated(part).items():
        path, key, _ = _NUMBERS[kind]
        said.setdefault(path, {})[key] = repr(value)
    return said


def _place(origin: Origin) -> dict[str, str]:
    return {"xyz": _words(origin.xyz), "rpy": _words(origin.rpy)}


def _words(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))


def _frames(conversion: Conversion, proof: Proof) -> Iterator[tuple[str, str, Any]]:
    """Each link, a joint, body or point of the .mbs that is fixed to it, and the link seen from
    there.  Points are those where cuts end."""
    moves = {group.mbs: f"joint '{group.coordinate}'" for group in proof.compared}
    bodies = {}
    for link, at in conversion.frames.items():
        if at.joint is None:
            bodies[at.body] = link, at.pose
        if not any(f"link '{link}': its frame is " in edit for edit in proof.but_for):
            fixed = f"body {at.body or BASE}"
            there = moves.get(at.joint, f"held {at.joint}") if at.joint else fixed
            yield link, there, _rows((*at.pose.rot, *at.pose.xyz))
    points = conversion.mbs.points()
    ends = (end for cut in conversion.mbs.cuts for end in (cut.endpoint1, cut.endpoint2))
    for body, point in ends:
        if body in bodies:  # a body that people drew has no link
            link, pose = bodies[body]
            x, y, z = points[body, point].coordinates if point else ZERO
            seen = compose(Pose((-x, -y, -z)), pose)
            yield link, f"point {body or BASE} {point or ORIGIN}", _rows((*seen.rot, *seen.xyz))


def _rows(frame: Frame) -> list[list[float]]:
    """A frame as a matrix of 4 x 4."""
    return [[*frame[k : k + 3], frame[9 + k // 3]] for k in (0, 3, 6)] + [[0.0, 0.0, 0.0, 1.0]]


def _group(group: Compared) -> dict[str, Any]:
    """What was compared; of what people have edited, also what is in the .mbs."""
    numbers = msgspec.structs.asdict(group)
    numbers["deviation"] = float(f"{group.deviation:.1e}")  # the rest of its digits is noise
    numbers["place"] = _rows(group.place)
    del numbers["found"]
    if group.found:
        numbers["found"] = {**group.found, "place": _rows(group.found["place"])}
    return numbers


def _options(config: Config) -> dict[str, Any]:
    """What the config says beside the defaults, without the folders of this machine."""
    defaults = Config(source=config.source)
    return {
        name: _without_folder(value)
        for name, value in msgspec.to_builtins(config).items()
        if name not in _PLACES and getattr(config, name) != getattr(defaults, name)
    }


def _without_folder(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_folder(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_folder(inner) for inner in value]
    if isinstance(value, str):
        for kind in (PurePosixPath, PureWindowsPath):
            if kind(value).is_absolute():
                return kind(value).name
    return value
