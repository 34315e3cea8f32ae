"""The data of the 3D model, for the script of the page: an .mbs file, a URDF, and their meshes.

The two sides do not use each other.  The shapes of the .mbs are those of its .wrl files; the
shapes of the URDF are its own mesh files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    Conversion,
    add,
    compute_placement,
    is_file,
    mbs,
    read_bytes,
    rotate,
    urdf,
)
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_report.mesh_store import FileReader, MeshStore


def describe_mbs(
    model: mbs.Mbs,
    store: MeshStore,
    read_file: FileReader,
    find_file: Callable[[str], Path | None] = lambda url: None,
) -> dict[str, Any]:
    """Describe the bodies, joints and shapes of an .mbs.

    Args:
        model: The model.
        store: Its meshes are added to this.
        read_file: Reads a .wrl and its textures by url.
        find_file: Finds the file of a url that is not a .wrl.

    Returns:
        The base and the bodies, as ``js/basics.js`` lists them.
    """

    def describe_shape(shape: mbs.Shape) -> dict[str, Any]:
        description = {**msgspec.structs.asdict(shape), "origin": None}
        if shape.url is not None:
            description["mesh"] = store.add_mbs_mesh(shape.url, read_file, find_file(shape.url))
        return description

    model_points = model.points()

    def describe_body(body: mbs.Body) -> dict[str, Any]:
        origin = (0.0, 0.0, 0.0)
        if body.point is not None:
            origin = model_points[body.parent, body.point].coordinates or origin
        return _pick(body, "name", "parent", "mass", "com", "inertia") | {
            "at": origin,
            "joints": [_pick(joint, "name", "type", "nature", "q") for joint in body.joints],
            "shapes": [describe_shape(shape) for shape in body.shapes],
        }

    base_shapes = [describe_shape(shape) for shape in model.base.shapes]
    return {
        "base": {"name": model.base.name, "shapes": base_shapes},
        "bodies": [describe_body(body) for body in model.bodies],
    }


def describe_urdf(
    robot: urdf.Robot, store: MeshStore, find_file: Callable[[str], Path | None]
) -> dict[str, Any]:
    """Describe the links and joints of a URDF, the joints from the root on.

    Args:
        robot: The robot.
        store: Its meshes are added to this.
        find_file: Finds a mesh file by its name in the URDF.

    Returns:
        The root, the links and the joints, as ``js/basics.js`` lists them.
    """

    def describe_shape(shape: urdf.Visual | urdf.Collision) -> dict[str, Any]:
        return _describe_shape(shape, store, find_file)

    def describe_visual(visual: urdf.Visual) -> dict[str, Any]:
        material = visual.material
        if material is not None and material.color is None:
            material = robot.materials.get(material.name)
        return {**describe_shape(visual), "color": material and material.color}

    links = [
        {
            "name": link.name,
            "visuals": [describe_visual(visual) for visual in link.visuals],
            "collisions": [describe_shape(collision) for collision in link.collisions],
        }
        for link in robot.links.values()
    ]
    joints = [_describe_joint(joint) for joint in robot.depth_first()]
    return {"root": robot.root(), "links": links, "joints": joints}


def describe_stand_ins(conversion: Conversion, store: MeshStore) -> list[dict[str, Any]]:
    """Describe the collision shapes of links of whose visuals a mesh is missing.

    Args:
        conversion: A finished conversion.
        store: Meshes of collision shapes are added to this.

    Returns:
        Shapes as those of ``describe_urdf``, each with its link, the link's body in the .mbs, and
        the link's pose in the body's frame: a rotation by rows and the origin (m).
    """
    find_file = get_mesh_files(conversion).find
    stand_ins: list[dict[str, Any]] = []
    for link_name, link in conversion.robot.links.items():
        frame = conversion.frames.get(link_name)
        lacks_visual = any(_lacks_mesh(visual, find_file) for visual in link.visuals)
        if frame is None or frame.joint is not None or not lacks_visual:
            continue
        pose = (*frame.pose.rot, *frame.pose.xyz)
        place = {"link": link_name, "body": frame.body, "pose": pose}
        stand_ins += [
            place | _describe_shape(collision, store, find_file)
            for collision in link.collisions
            if not _lacks_mesh(collision, find_file)
        ]
    return stand_ins


def list_followers(conversion: Conversion) -> list[tuple[str, str, float, float]]:
    """List the joints of the .mbs that follow others, as the URDF's ``<mimic>`` couples them.

    Returns:
        Follower, leader, multiplier and offset (rad or m) of each: the position of the follower is
        multiplier times that of the leader, plus the offset.
    """
    coordinates = conversion.names.coordinates
    return [
        (coordinates[joint_name][0], coordinates[mimic.joint][0], mimic.multiplier, mimic.offset)
        for joint_name, joint in conversion.robot.joints.items()
        if (mimic := joint.mimic) is not None
        and len(coordinates.get(joint_name, ())) == 1
        and coordinates.get(mimic.joint)
    ]


def _lacks_mesh(
    shape: urdf.Visual | urdf.Collision, find_file: Callable[[str], Path | None]
) -> bool:
    """Return True if a shape is a mesh whose file does not exist."""
    if not isinstance(shape.geometry, urdf.Mesh):
        return False
    mesh_file = find_file(shape.geometry.filename)
    return mesh_file is None or not is_file(mesh_file)


def _describe_shape(
    shape: urdf.Visual | urdf.Collision,
    store: MeshStore,
    find_file: Callable[[str], Path | None],
) -> dict[str, Any]:
    """Describe the pose and the geometry of a shape; its mesh is added to the store."""
    description = _pick(shape.origin, "xyz", "rpy") | {"geometry": shape.geometry}
    if isinstance(shape.geometry, urdf.Mesh):
        filename = shape.geometry.filename
        description["mesh"] = store.add_urdf_mesh(filename, find_file(filename))
    return description


def _describe_joint(joint: urdf.Joint) -> dict[str, Any]:
    """Describe a joint of a URDF; a limit counts only if both of its ends are known."""
    limit = joint.limit
    is_limited = limit is not None and None not in (limit.lower, limit.upper)
    return {
        **_pick(joint, "name", "type", "parent", "child", "axis"),
        **_pick(joint.origin, "xyz", "rpy"),
        "limit": (limit.lower, limit.upper) if limit and is_limited else None,
    }


def _pick(element: Any, *attribute_names: str) -> dict[str, Any]:
    """Return some attributes of an object by their names."""
    return {attribute_name: getattr(element, attribute_name) for attribute_name in attribute_names}


def find_url(url: str, project: Path) -> Path:
    """Return the file of a url in which ``PRJPATH`` is the project's folder.

    The folder around the project is tried, too, since some models name their project after
    ``PRJPATH``.
    """
    plain_url = url.replace("\\", "/")
    path_inside = Path(plain_url.replace("PRJPATH", str(project), 1))
    path_around = Path(plain_url.replace("PRJPATH", str(project.absolute().parent), 1))
    return path_around if not is_file(path_inside) and is_file(path_around) else path_inside


def make_file_reader(files: Mapping[Path, bytes], project: Path) -> FileReader:
    """Make a reader of urls with ``PRJPATH``.

    Args:
        files: Files that are about to be written; they come before those on the disk.
        project: The project's folder.
    """

    def read_file(url: str) -> bytes | None:
        file_path = find_url(url, project)
        if file_path in files:
            return files[file_path]
        try:
            return read_bytes(file_path)
        except (OSError, ValueError):
            return None

    return read_file


def compute_extent(model: mbs.Mbs) -> float:
    """Compute the longest side (m) of the box around all frames, points and shapes.

    The model is in its initial position; a model without extent has 1 m.
    """
    body_poses = compute_placement(model).bodies
    positions = [point.coordinates for point in model.base.points]
    for body in model.bodies:
        body_pose = body_poses[body.name]
        points_in_body = [(0.0, 0.0, 0.0), *(point.coordinates for point in body.points)]
        points_in_body += [shape.position for shape in body.shapes]
        positions += [add(body_pose.xyz, rotate(body_pose.rot, point)) for point in points_in_body]
    side_lengths = [
        max(axis_coordinates) - min(axis_coordinates)
        for axis_coordinates in zip(*positions, strict=True)
    ]
    return max(side_lengths, default=0.0) or 1.0
