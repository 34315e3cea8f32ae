"""Facts of a robot that its config is written from: its files, its feet, its start position."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree

from urdf2mbs.plugin import Conversion, Mesh, Robot, files, read_text, safe_parser
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_project.feet import list_geometries
from urdf2mbs_project.stance import Stance, find_stance

#: The controller that holds the start position (Hz).
HOLD_OPTIONS = {"frequency": 10, "damping_ratio": 0.3}


class RobotFacts(NamedTuple):
    """What can be found out about a robot before it is converted."""

    robot: Robot
    packages: dict[str, Path]
    """The packages whose files the robot uses."""
    packages_missing: list[str]
    """The packages that meshes name, and that were not found."""
    arguments: dict[str, str]
    """The arguments that its xacro files declare, and their defaults as they are written."""
    meshes: int
    """The number of mesh files that the robot names."""
    meshes_missing: list[str]
    meshes_remedy: str
    """What to do about the first missing mesh; empty if none is missing."""
    feet: list[str]
    """The links on which the robot stands."""
    why_no_feet: str
    """Empty if it has feet, or if its base is fixed."""
    passes: dict[str, Any]
    """The options of passes: a start position, the ground, and a controller."""


def find_robot_facts(conversion: Conversion) -> RobotFacts:
    """Find the facts of the robot of a conversion."""
    source, config = conversion.settings.source, conversion.settings.config
    expansion = conversion.input.expansion
    robot, _ = read_text(source, conversion.input.data, expansion, config.xacro_args)
    geometries = [shape for link in robot.links.values() for shape in list_geometries(link)]
    meshes = {shape.filename for shape in geometries if isinstance(shape, Mesh)}
    mesh_files = get_mesh_files(conversion)
    missing = sorted(name for name in meshes if mesh_files.find(name) is None)
    packages = conversion.packages.list_found()
    urls = (re.match(r"(?:package|model)://([^/]+)", name) for name in missing)
    packages_missing = {url[1] for url in urls if url} - packages.keys()
    bent_positions = conversion.report.get("posture-limit", {}).get("middle", {})
    stance = find_stance(conversion, bent_positions)
    return RobotFacts(
        robot=robot,
        packages=packages,
        packages_missing=sorted(packages_missing),
        arguments=_read_xacro_arguments(expansion.files if expansion else []),
        meshes=len(meshes),
        meshes_missing=missing,
        meshes_remedy=mesh_files.suggest_remedy(missing[0]) if missing else "",
        feet=stance.feet,
        why_no_feet=stance.why_no_feet,
        passes=_choose_pass_options(conversion, stance),
    )


def _choose_pass_options(conversion: Conversion, stance: Stance) -> dict[str, Any]:
    """Choose options of passes: the start position, and all that a robot needs to stand."""
    posture: dict[str, Any] = {}
    if stance.start_positions:
        posture["joints"] = stance.start_positions
    touches_ground = bool(stance.feet) or stance.rests_on_ground
    stands = touches_ground and any(body.mass for body in conversion.mbs.bodies)
    joints = [joint for _, joint in conversion.single_coordinates()]
    if stands and any(joint.nature == "independent" for joint in joints):
        posture["hold"] = HOLD_OPTIONS
    passes: dict[str, Any] = {}
    if posture:
        passes["posture"] = posture
    if stands:
        passes["contacts"] = {"links": ["*"]}
        if stance.sole_corners:
            passes["contacts"]["points"] = {
                link: [[*corner] for corner in corners]
                for link, corners in stance.sole_corners.items()
            }
    return passes


def _read_xacro_arguments(file_names: Iterable[str]) -> dict[str, str]:
    """Read the arguments that xacro files declare, and their defaults."""
    defaults: dict[str, str] = {}
    for file_name in file_names:
        try:
            root = etree.fromstring(files.read_bytes(Path(file_name)), safe_parser(recover=True))
        except (OSError, etree.XMLSyntaxError):
            continue
        for element in () if root is None else root.iter("{*}arg"):
            if "xacro" in str(etree.QName(element).namespace):
                defaults.setdefault(element.get("name") or "", element.get("default") or "")
    defaults.pop("", None)
    return defaults
