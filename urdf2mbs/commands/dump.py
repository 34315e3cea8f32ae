"""The state after every pass, as YAML to read and to compare with ``diff``, and beside it the
URDF that xacro made.

What has its default value is left out, and so are the paths of this machine.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import yaml

from urdf2mbs.conversion import Conversion, Segment, Step
from urdf2mbs.disk.output import write_files
from urdf2mbs.disk.seal import intact
from urdf2mbs.engine.hookspecs import Pass, hookimpl
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic
from urdf2mbs.spatial import IDENTITY, Pose

#: How our files begin.
MARK = "# urdf2mbs, the state after pass "
#: The URDF that xacro made.
EXPANDED = "expanded.urdf"


class Dump:
    """An observer of a pipeline that writes ``NN-PASS.yaml`` after every pass."""

    def __init__(self, folder: Path, *, force: bool = False) -> None:
        self._folder = folder
        self._force = force
        self._count = 0
        self._conversion: Conversion | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for old in (*folder.glob("[0-9]*-*.yaml"), *folder.glob(EXPANDED)):
                if old.is_file() and intact(old.read_bytes()):
                    old.unlink()
        except (OSError, ValueError) as error:
            raise ConfigError(
                "output-unwritable",
                f"cannot write in '{folder}': {getattr(error, 'strerror', None) or error}",
            ) from None

    @hookimpl
    def urdf2mbs_before_pass(self, conversion: Conversion) -> None:
        self._conversion = conversion

    def finish(self) -> None:
        """Write the URDF that xacro made, also where it could not be read."""
        if self._conversion is not None and self._conversion.expanded is not None:
            write_files({self._folder / EXPANDED: self._conversion.expanded}, force=self._force)

    @hookimpl(trylast=True)
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Conversion) -> None:
        self._count += 1
        file = self._folder / f"{self._count:02}-{re.sub(r'[^A-Za-z0-9_.-]', '_', pass_.name)}.yaml"
        text = f"{MARK}'{pass_.name}'\n" + to_yaml(state(conversion))
        write_files({file: text.encode()}, force=self._force)


def state(conversion: Conversion) -> dict[str, Any]:
    """All that is known of the robot, as plain data without what has its default value."""
    everything = {
        "robot": {**_plain(conversion.robot), "file": None},
        "floating": conversion.floating,
        "segments": {name: _plain(segment) for name, segment in conversion.segments.items()},
        "mbs": _plain(conversion.mbs),
        "names": _plain(conversion.names),
        "frames": _plain(conversion.frames),
        "frozen": conversion.frozen,
        "meshes": conversion.meshes,
        "files": {
            # a name of a file may be no text
            path.name.encode("utf-8", "backslashreplace").decode(): f"{len(data)} bytes"
            for files in (conversion.ahead, conversion.files, conversion.behind)
            for path, data in files.items()
        },
        "changed": _plain(conversion.changed),
        "proof": _plain(conversion.proof),
        "report": _plain(conversion.facts),
        "diagnostics": [_plain(said) for said in conversion.diagnostics],
    }
    everything["robot"] = {k: v for k, v in everything["robot"].items() if v is not None}
    return {key: value for key, value in everything.items() if value}


def _plain(value: Any) -> Any:
    if isinstance(value, Step):
        # the joints themselves stand elsewhere: in the robot, and in the body
        return {
            "joint": value.joint.name,
            **_fields(value, "joint", "joints", "coordinates"),
            "joints": [joint.name for joint in value.joints],
            "coordinates": [joint.name for joint in value.coordinates],
        }
    if isinstance(value, Segment):
        return _fields(value, "holder")
    if isinstance(value, Diagnostic):
        return _fields(value, "file")
    if isinstance(value, msgspec.Struct):
        return _fields(value)
    if isinstance(value, Pose):
        return {"xyz": list(value.xyz)} | ({} if value.rot == IDENTITY else {"rot": value.rot})
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return str(value)


def _fields(struct: msgspec.Struct, *without: str) -> dict[str, Any]:
    tag = struct.__struct_config__.tag
    fields = {} if tag is None else {"kind": tag}
    for name, default in _defaults(type(struct)):
        value = getattr(struct, name)
        if value != default and name not in without:
            fields[name] = _plain(value)
    return fields


@cache  # msgspec looks all up anew each time
def _defaults(kind: type[msgspec.Struct]) -> list[tuple[str, Any]]:
    """The fields of a class, and the default of each; NODEFAULT where there is none."""
    return [
        (
            field.name,
            field.default
            if field.default_factory is msgspec.NODEFAULT
            else field.default_factory(),
        )
        for field in msgspec.structs.fields(kind)
    ]


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """PyYAML's own, but a list of numbers or words stands in one line."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        nested = any(isinstance(item, (dict, list, tuple)) for item in sequence)
        return super().represent_sequence(tag, sequence, flow_style=not nested)

    def ignore_aliases(self, data: Any) -> bool:
        return True


def to_yaml(data: dict[str, Any]) -> str:
    """Plain data as YAML: one line for a list of numbers or words, else one for each item."""
    return yaml.dump(
        data, Dumper=_Dumper, default_flow_style=False, sort_keys=False, width=10**9,
        allow_unicode=True,
    )  # fmt: skip
