"""Certificate: beside the .mbs, what ``check`` compared, for others to replay.

Beyond the method.  ``NAME.proof.json`` is an in-toto Statement with the predicate "test result"
(https://github.com/in-toto/attestation, spec/v1/statement.md and spec/predicates/test-result.md):
whoever signs releases can sign it.  It names each file by its sha256, and has the numbers of each
rigid group.  ``proof/certificate.py`` replays the comparison.  A rejected file gets none.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, Literal

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.seal import seal
from urdf2mbs.engine.config import Config
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import BASE, ORIGIN, Connection
from urdf2mbs.proof.parameters import stated
from urdf2mbs.proof.verdict import Compared, Proof
from urdf2mbs.spatial import ZERO, Pose, compose, inverse
from urdf2mbs.urdf.model import Inertial, Joint, Link

STATEMENT = "https://in-toto.io/Statement/v1"
PREDICATE = "https://in-toto.io/attestation/test-result/v0.1"
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
        conversion.facts["certificate"] = {"file": path.name}
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
    from xml.etree.ElementTree import fromstring

    from urdf2mbs.proof.certificate import rest_of

    mbs = conversion.mbs
    packages = ["urdf2mbs"] + ["xacro"] * (conversion.expanded is not None)
    return {
        "versions": {package: version(package) for package in packages},
        "options": _options(conversion.settings.config),
        "changed": [str(change) for change in conversion.changed],
        "changes": msgspec.to_builtins([*_changes(conversion)]),
        "held": conversion.frozen,
        "but_for": proof.but_for,
        "by_code": proof.by_code,
        "not_compared": proof.not_compared,
        "rest": rest_of(fromstring(conversion.files[conversion.settings.output])),
        "ends": [end for cut in mbs.cuts for end in _ends(conversion, cut)],
        "frames": {
            link: ("joint" if at.joint else "body", at.joint or at.body or BASE, _flat(at.pose))
            for link, at in conversion.frames.items()
        },
        "groups": [_group(group) for group in proof.compared],
    }


def _changes(conversion: Conversion) -> Iterator[tuple[str, str, Any, Any]]:
    """Each value that passes changed or added, also of joints that count the other way round: its
    kind, its link or joint, what the replay reads in the URDF, and what it became."""
    from xml.etree.ElementTree import ParseError, fromstring

    from urdf2mbs.proof.certificate import urdf_values

    flipped, inserted = conversion.names.flipped, conversion.inserted
    robot, read = conversion.robot.with_flipped(flipped), {}
    changes = [change.name for changed in conversion.changed for change in changed.changes]
    if changes or flipped:
        with suppress(ParseError, ValueError):  # the reader mends what no other parser reads
            read = urdf_values(fromstring(conversion.expanded or conversion.source))
    added = () if inserted is None else (inserted, robot.joints[inserted].parent)
    for name in dict.fromkeys((*changes, *flipped, *added)):
        for part in (robot.links.get(name), robot.joints.get(name)):
            for kind, after in _said(part).items():
                before = read.get((kind, name))
                if after != before:
                    yield kind, name, before, after


def _said(part: Link | Joint | None) -> dict[str, list[Any]]:
    """What of a link or joint moves or weighs something, as the replay reads it."""
    if isinstance(part, Joint):
        return {
            "type": [part.type], "parent": [part.parent], "child": [part.child],
            "origin": [*part.origin.xyz, *part.origin.rpy], "axis": [*part.axis],
            **({"mimic": [part.mimic.joint]} if part.mimic else {}),
            **{kind: [value] for kind, value in stated(part).items()},
        }  # fmt: skip
    if part is None:
        return {}
    mass, inertia, origin = msgspec.structs.astuple(part.inertial or Inertial())
    centre = [*origin.xyz, *origin.rpy]
    return {"link": [part.name], "mass": [mass], "inertia": [*inertia], "centre": centre}


def _ends(conversion: Conversion, cut: Connection) -> Iterator[tuple[Any, ...]]:
    """Where a cut ends: the cut, a link, the point in it with the axes of the body; and both names
    in the .mbs."""
    links = {at.body: (link, at.pose) for link, at in conversion.frames.items() if not at.joint}
    points = conversion.mbs.points()
    known = [end for end in (cut.endpoint1, cut.endpoint2) if end[0] in links]
    for body, point in known:  # a body that people drew has no link
        link, pose = links[body]
        at = compose(inverse(pose), Pose(points[body, point].coordinates if point else ZERO))
        yield cut.name, link, _flat(at), body or BASE, point or ORIGIN


def _flat(frame: Pose) -> list[float]:
    """A rotation row by row, then an origin (m)."""
    return [*frame.rot, *frame.xyz]


def _group(group: Compared) -> dict[str, Any]:
    """What was compared; of what people have edited, also what is in the .mbs."""
    numbers = msgspec.structs.asdict(group)
    numbers["deviation"] = float(f"{group.deviation:.1e}")  # the rest of its digits is noise
    if not group.found:
        del numbers["found"]
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
