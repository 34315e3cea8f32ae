"""Write the state after every pass as YAML, to read and to compare, and the URDF from xacro.

Default values and the paths of this machine are left out.
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

#: File name of the URDF from xacro.
EXPANDED = "expanded.urdf"
#: Fields that are left out: those that are also elsewhere in the state, and paths.
_SKIPPED_FIELDS: dict[type, tuple[str, ...]] = {
    Segment: ("holder",),
    Diagnostic: ("file",),
    Robot: ("file",),
}


class Dump:
    """An observer of a pipeline that writes ``NN-PASS.yaml`` after every pass."""

    def __init__(self, folder: Path, *, force: bool = False) -> None:
        self._folder = folder
        self._force = force
        self._pass_count = 0
        self._conversion: Conversion | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for dumped_file in (*folder.glob("[0-9]*-*.yaml"), *folder.glob(EXPANDED)):
                if dumped_file.is_file() and is_ours(dumped_file):
                    dumped_file.unlink()
        except (OSError, ValueError) as error:
            raise ConfigError("output-unwritable", f"cannot write in '{folder}': {error}") from None

    @hookimpl
    def urdf2mbs_before_pass(self, conversion: Conversion) -> None:
        """Remember the conversion."""
        self._conversion = conversion

    @hookimpl(trylast=True)
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Conversion) -> None:
        """Write the state."""
        self._pass_count += 1
        pass_name = re.sub(r"[^A-Za-z0-9_.-]", "_", pass_.name)
        state_yaml = yaml.dump(
            make_state(conversion),
            Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper),
            allow_unicode=True,
            default_flow_style=None,  # lists and objects of plain values on one line
            sort_keys=False,
            width=10**9,
        )
        file_content = f"# urdf2mbs, the state after pass '{pass_.name}'\n{state_yaml}".encode()
        self._write(f"{self._pass_count:02}-{pass_name}.yaml", file_content)

    def finish(self) -> None:
        """Write the URDF from xacro, even if it could not be read."""
        if self._conversion is not None and self._conversion.expanded is not None:
            self._write(EXPANDED, self._conversion.expanded)

    def _write(self, file_name: str, file_content: bytes) -> None:
        write_files({self._folder / file_name: file_content}, force=self._force)


def make_state(conversion: Conversion) -> dict[str, Any]:
    """Return the state of a conversion as plain data without default values."""
    checked = conversion.checked
    state = {
        "robot": conversion.robot,
        "floating": conversion.base.floating,
        "segments": conversion.segments,
        "mbs": conversion.mbs,
        "names": conversion.names,
        "frames": conversion.frames,
        "frozen": conversion.frozen,
        "meshes": conversion.meshes,
        "files": {
            # the name of a file may contain bytes that are not text
            file_path.name.encode(
                "utf-8", "backslashreplace"
            ).decode(): f"{len(file_content)} bytes"
            for file_path, file_content in conversion.files_of("ours", "base").items()
        },
        "changed": checked.changed,
        "proof": checked.proof,
        "report": conversion.report,
        "diagnostics": conversion.diagnostics,
    }
    plain_state = {
        section_name: _make_plain(section_value) for section_name, section_value in state.items()
    }
    return {
        section_name: section_value
        for section_name, section_value in plain_state.items()
        if section_value
    }


def _make_plain(value: Any) -> Any:
    """Return a value as lists, dicts, numbers and texts."""
    if isinstance(value, Step):  # its joints are part of the robot and of the body
        joint_lists = {"joints": value.joints, "coordinates": value.coordinates}
        joint_names = {
            field_name: [joint.name for joint in joints]
            for field_name, joints in joint_lists.items()
        }
        return {
            "joint": value.joint.name,
            **_list_fields(value, ("joint", *joint_lists)),
            **joint_names,
        }
    if isinstance(value, msgspec.Struct):
        return _list_fields(value, _SKIPPED_FIELDS.get(type(value), ()))
    if isinstance(value, Pose):
        return {"xyz": list(value.xyz)} | ({} if value.rot == IDENTITY else {"rot": value.rot})
    if isinstance(value, dict):
        return {str(key): _make_plain(element) for key, element in value.items()}
    if isinstance(value, (list, tuple)):
        return [_make_plain(element) for element in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return str(value)


def _list_fields(struct: msgspec.Struct, skipped: tuple[str, ...]) -> dict[str, Any]:
    """Return the fields of a struct that are not skipped and have no default value."""
    tag = struct.__struct_config__.tag
    field_values = {} if tag is None else {"kind": tag}
    for field in msgspec.structs.fields(struct):
        field_value, default = getattr(struct, field.name), field.default
        if field.default_factory is not msgspec.NODEFAULT:
            default = field.default_factory()
        if field_value != default and field.name not in skipped:
            field_values[field.name] = _make_plain(field_value)
    return field_values
