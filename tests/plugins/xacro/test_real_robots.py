"""Every entry of the collection of real robots: read, and compared with xacro's own text."""

import json
from pathlib import Path
from typing import Any

import pytest

from support.folders import SHARED
from support.plugin_files import read_robot
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.reader import parse_urdf

ROBOTS = SHARED / "robots"
MANIFEST = ROBOTS / "manifest.json"
ENTRIES: list[tuple[str, dict[str, Any]]] = [
    (robot["robot"], entry)
    for robot in (json.loads(MANIFEST.read_text()) if MANIFEST.is_file() else [])
    for entry in robot["entries"]
]
NAMES = [f"{robot}-{entry.get('name') or Path(entry['file']).name}" for robot, entry in ENTRIES]
#: Files that are broken as they were published.
BROKEN = {
    "atlas_description/urdf/atlas_v5.urdf": ("link-unknown", "'head'"),
    "bigman_urdf/urdf/bigman.urdf.xacro": ("xacro", "mmTom"),
}


@pytest.mark.parametrize("table", [True, False], ids=["table", "found"])
@pytest.mark.parametrize(("robot", "entry"), ENTRIES, ids=NAMES)
def test_real_robot(shared: Path, robot: str, entry: dict[str, Any], table: bool) -> None:
    folder = shared / "robots" / robot
    source = folder / entry["file"]
    given = entry.get("package_map", {}) if table else {}
    packages = Packages({name: folder / path for name, path in given.items()}, source)
    if entry["file"] in BROKEN:
        code, word = BROKEN[entry["file"]]
        with pytest.raises(ConversionError, match=word) as caught:
            read_robot(source, packages, entry.get("args", {}))
        assert caught.value.code == code
        assert caught.value.line
        return
    read, diagnostics = read_robot(source, packages, entry.get("args", {}))
    assert f"links {len(read.links)} joints {len(read.joints)}" == entry["result"]
    assert len(read.depth_first()) == len(read.joints)
    assert not [message for message in diagnostics if message.code.startswith("xacro")]
    assert len(diagnostics) < 12
    if "expanded" in entry:
        expected, _ = parse_urdf((folder / entry["expanded"]).read_bytes(), "")
        assert plain(read) == plain(expected)


def plain(robot: Robot) -> tuple[object, ...]:
    """Return a robot without its lines, and with the files of meshes by their last name only."""
    for link in robot.links.values():
        link.line = None
        for part in (*link.visuals, *link.collisions):
            part.line = None
            if hasattr(part.geometry, "filename"):
                part.geometry.filename = part.geometry.filename.rpartition("/")[2]
    for joint in robot.joints.values():
        joint.line = None
    materials = {
        name: (material.color, material.texture and material.texture.rpartition("/")[2])
        for name, material in robot.materials.items()
    }
    kept = [(extension.tag, extension.reference) for extension in robot.extensions]
    return (robot.name, robot.links, robot.joints, materials, kept)
