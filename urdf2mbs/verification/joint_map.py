"""Reads and writes which joints of two robots are the same, as people say."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.load import read_text
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError, nearest, some
from urdf2mbs.proof.urdf_side import FLOATING_ORDER, list_coordinates
from urdf2mbs.urdf.model import Robot

_COMMENT = "# Joints of the first robot: their joints in the second one.\n"
_EXPECTED = "expected a line 'joint of the first robot: joint of the second' for each"


class JointMap(msgspec.Struct):
    """Joints of the first robot, and their joints in the second one."""

    joints: dict[str, tuple[str, ...]]
    file: str | None = None
    lines: dict[str, int] = {}
    """The line of each joint."""

    def invert(self) -> JointMap:
        """Return the map of the second robot's joints, for robots that are exchanged."""
        joints: dict[str, tuple[str, ...]] = {}
        lines: dict[str, int] = {}
        for name, names in self.joints.items():
            for second_name in names:
                joints[second_name] = (*joints.get(second_name, ()), name)
                lines.setdefault(second_name, self.lines.get(name, 1))
        return JointMap(joints, self.file, lines)

    def expand(self, coordinates: Mapping[str, Sequence[str]]) -> None:
        """Take joints of a second URDF for their joints in the .mbs that is made of it.

        Args:
            coordinates: The .mbs joints of each joint of the second URDF.
        """
        for name, names in self.joints.items():
            expanded = (coordinates.get(each, (each,)) for each in names)
            self.joints[name] = tuple(each for group in expanded for each in group)

    def check(self, robot: Robot, mbs: Mbs) -> None:
        """Check that both robots have the joints, with as many coordinates.

        Raises:
            ConfigError: ``map-invalid``.
        """
        moving = {joint.name for joint in robot.joints.values() if joint.moves}
        mbs_joints = mbs.joints().keys()
        used: dict[str, str] = {}
        for name, names in self.joints.items():
            if name not in moving:
                raise self._error(name, f"the first robot has no joint '{name}' that moves", moving)
            for other_name in names:
                if other_name not in mbs_joints:
                    message = f"the second robot has no joint '{other_name}'"
                    raise self._error(name, message, mbs_joints, other_name)
                if other_name in used:
                    message = f"'{other_name}' is the joint of '{used[other_name]}' and of '{name}'"
                    raise self._error(name, message)
                used[other_name] = name
            count = len(list_coordinates(robot.joints[name], FLOATING_ORDER))
            if count != len(names):
                message = f"joint '{name}' has {count} coordinates, and the map {len(names)}"
                raise self._error(name, message)

    def _error(
        self, key: str, message: str, candidates: Iterable[str] = (), wrong: str | None = None
    ) -> ConfigError:
        """Return the error for a line of the map."""
        candidates = sorted(candidates)
        hint = nearest(wrong or key, candidates)
        if hint is None and candidates:
            hint = f"there are: {some(candidates, 8)}"
        line = self.lines.get(key)
        return ConfigError("map-invalid", message, file=self.file, line=line, hint=hint)


def read_joint_map(source: Mapping[str, Any] | str | os.PathLike[str] | None) -> JointMap | None:
    """Read a map from a YAML file, or take it from a call.

    Args:
        source: The file; or the joints, each with the name of its joint, or a list of names if it
            has several coordinates; None for no map.

    Raises:
        ConfigError: The file cannot be read, or is no map.
    """
    if source is None:
        return None
    if isinstance(source, Mapping):
        return JointMap(_read_entries(source, None))
    from urdf2mbs.config.yaml_text import parse_yaml

    path = Path(source)
    data, places = parse_yaml(read_text(path, "map-invalid", "map"), path)
    lines: dict[str, int] = {}
    if isinstance(data, list):  # a list of maps
        entries: dict[str, Any] = {}
        for number, item in enumerate(data):
            for key, value in _require_mapping(item, path).items():
                if key in entries:
                    message = f"'{key}' is there twice"
                    line = places.get((number, key), 1)
                    raise ConfigError("map-invalid", message, file=str(path), line=line)
                entries[key] = value
                lines[str(key)] = places.get((number, key), places.get((number,), 1))
    else:
        entries = dict(_require_mapping(data, path))
        lines = {str(key): places.get((key,), 1) for key in entries}
    return JointMap(_read_entries(entries, path), str(path), lines)


def _require_mapping(data: object, file: Path) -> Mapping[str, Any]:
    """Return data that is a mapping.

    Raises:
        ConfigError: ``map-invalid``, it is something else.
    """
    if not isinstance(data, Mapping):
        message = f"this is no map of joints; {_EXPECTED}"
        raise ConfigError("map-invalid", message, file=str(file))
    return data


def _read_entries(entries: Mapping[Any, Any], file: Path | None) -> dict[str, tuple[str, ...]]:
    """Return the names of each joint as a tuple."""
    joints: dict[str, tuple[str, ...]] = {}
    for key, value in entries.items():
        names = [value] if not isinstance(value, list | tuple) else value
        if value is None or not names or any(isinstance(n, dict | list) for n in names):
            message = f"'{key}': {value!r} is no joint; {_EXPECTED}"
            raise ConfigError("map-invalid", message, file=None if file is None else str(file))
        joints[str(key)] = tuple(map(str, names))
    return joints


def write_joint_map(joints: Mapping[str, tuple[str, ...]]) -> bytes:
    """Return the YAML of a map."""
    import yaml

    data = {name: names[0] if len(names) == 1 else [*names] for name, names in joints.items()}
    text = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=10_000)
    return (_COMMENT + text).encode()
