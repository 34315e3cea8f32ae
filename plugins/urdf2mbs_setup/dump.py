"""The state after every pass, as YAML to read and to compare with ``diff``, and beside it the
URDF that xacro made.

What has its default value is left out, and so are the paths of this machine.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import msgspec
import yaml

from urdf2mbs.plugin import (
    IDENTITY,
    ConfigError,
    Conversion,
    Diagnostic,
    Pass,
    Pose,
    Robot,
    Segment,
    Step,
    hookimpl,
    is_ours,
    write_files,
)

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
                if old.is_file() and is_ours(old):
                    old.unlink()
        except (OSError, ValueError) as error:
            raise ConfigError("output-unwritable", f"cannot write in '{folder}': {error}") from None

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
        # what holds nothing but numbers and words is one line
        style: Any = {"default_flow_style": None, "sort_keys": False, "width": 10**9}
        dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
        text = yaml.dump(state(conversion), Dumper=dumper, allow_unicode=True, **style)
        head = f"# urdf2mbs, the state after pass '{pass_.name}'\n"
        write_files({file: f"{head}{text}".encode()}, force=self._force)


def state(conversion: Conversion) -> dict[str, Any]:
    """All that is known of the robot, as plain data without what has its default value."""
    c = conversion
    files = c.files_of("orphans", "ours", "base")
    everything = {
        "robot": c.robot, "floating": c.base.floating, "segments": c.segments, "mbs": c.mbs,
        "names": c.names, "frames": c.frames, "frozen": c.frozen, "meshes": c.meshes,
        # a name of a file may be no text
        "files": {
            path.name.encode("utf-8", "backslashreplace").decode(): f"{len(data)} bytes"
            for path, data in files.items()
        },
        "changed": c.checked.changed, "proof": c.checked.proof, "report": c.report,
        "diagnostics": c.diagnostics,
    }  # fmt: skip
    return {name: plain for name, value in everything.items() if (plain := _plain(value))}


#: The fields of a class that are left out: what also stands elsewhere, and paths.
_LEFT_OUT: dict[type, tuple[str, ...]] = {
    Segment: ("holder",), Diagnostic: ("file",), Robot: ("file",),
}  # fmt: skip


def _plain(value: Any) -> Any:
    if isinstance(value, Step):  # its joints stand in the robot, and in the body
        lists = {"joints": value.joints, "coordinates": value.coordinates}
        names = {field: [joint.name for joint in joints] for field, joints in lists.items()}
        return {"joint": value.joint.name, **_fields(value, ("joint", *lists)), **names}
    if isinstance(value, msgspec.Struct):
        return _fields(value, _LEFT_OUT.get(type(value), ()))
    if isinstance(value, Pose):
        return {"xyz": list(value.xyz)} | ({} if value.rot == IDENTITY else {"rot": value.rot})
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return str(value)


def _fields(struct: msgspec.Struct, without: tuple[str, ...]) -> dict[str, Any]:
    """The fields of a struct that are not left out, and have no default value."""
    tag = struct.__struct_config__.tag
    found = {} if tag is None else {"kind": tag}
    for field in msgspec.structs.fields(struct):
        value, default = getattr(struct, field.name), field.default
        if field.default_factory is not msgspec.NODEFAULT:
            default = field.default_factory()
        if value != default and field.name not in without:
            found[field.name] = _plain(value)
    return found
