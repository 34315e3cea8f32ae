"""The motion of a simulated robot as an animated GIF, drawn without a browser and a screen."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.model import Mbs, Shape
from urdf2mbs.meshes import reader, vrml_reader
from urdf2mbs.meshes.model import MeshError, Part
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.report.scene import lookup, path_of
from urdf2mbs.runtime.results import Results
from urdf2mbs.spatial import from_turns

#: Frames a second, and the longer side of the picture (pixels).
RATE, SIDE = 20, 480
#: Only the largest triangles of a robot are drawn.
MOST = 20_000
#: From where one looks (the x of the robot comes forward), and where the light comes from.
EYE, LIGHT = np.array([0.82, 0.5, 0.28]), np.array([0.5, -0.3, 0.8])


def movie(results: Results) -> bytes:
    """The GIF; raises ConfigError if the model has no shapes to draw."""
    from PIL import Image, ImageDraw

    model, project = results.data.mbs, results.data.project
    read = cache(lambda url: _parts(url, project))  # several shapes may show one mesh
    shapes: dict[str | None, list[Shape]] = {None: model.base.shapes}
    shapes |= {body.name: body.shapes for body in model.bodies}
    drawn = {
        body: [solid for shape in given for solid in _solids(shape, read)]
        for body, given in shapes.items()
    }
    owners = [body for body, solids in drawn.items() for triangles, _ in solids for _ in triangles]
    if not owners:
        raise ConfigError("usage", "a movie needs shapes: none of the model's can be drawn")
    triangles = np.concatenate([t for solids in drawn.values() for t, _ in solids if len(t)])
    colors = np.concatenate([np.tile(c, (len(t), 1)) for s in drawn.values() for t, c in s])
    largest = np.sort(np.argsort(-_normals(triangles)[1], kind="stable")[:MOST])
    triangles, colors, owners = triangles[largest], colors[largest], [owners[k] for k in largest]
    frames = [_moved(model, results, row, triangles, owners) for row in _rows(results)]
    right = np.cross([0.0, 0.0, 1.0], EYE)
    right /= np.linalg.norm(right)
    ahead = EYE / np.linalg.norm(EYE)
    view = np.array([right, -np.cross(ahead, right), ahead])  # right, down, towards the eye
    seen = [points @ view.T for points in frames]
    low, high = (f([f(s[..., :2], axis=(0, 1)) for s in seen], axis=0) for f in (np.min, np.max))
    scale = (SIDE - 20) / max(high - low)
    width, height = ((high - low) * scale + 20).astype(int)
    pictures = []
    for points, flat in zip(frames, seen, strict=True):
        picture = Image.new("RGB", (width, height), "white")
        draw = ImageDraw.Draw(picture)
        normals, _ = _normals(points)
        shade = 0.55 + 0.45 * np.abs(normals @ LIGHT / np.linalg.norm(LIGHT))
        corners = (flat[..., :2] - low) * scale + 10
        for k in np.argsort(flat[..., 2].mean(axis=1), kind="stable"):
            color = tuple(int(c) for c in colors[k] * shade[k])
            draw.polygon([(x, y) for x, y in corners[k].tolist()], fill=color)
        pictures.append(picture.quantize(64))
    out = io.BytesIO()
    pictures[0].save(
        out, "GIF", save_all=True, append_images=pictures[1:], duration=1000 // RATE, loop=0
    )
    return out.getvalue()


def _rows(results: Results) -> list[int]:
    """The frames that are shown."""
    times = np.arange(results.time[0], results.time[-1], 1.0 / RATE)
    return [int(np.searchsorted(results.time, time - 1e-9)) for time in times] or [0]


def _moved(model: Mbs, results: Results, row: int, triangles: Any, owners: list[str | None]) -> Any:
    """The triangles (n, 3, 3) in the axes of the base, at a frame of the results (m)."""
    values = {name: float(results.q[row, k]) for name, k in results.data.joint_id.items()}
    poses = place(model, values).bodies
    turns = np.array([poses[owner].rot for owner in owners]).reshape(-1, 3, 3)
    return triangles @ turns.transpose(0, 2, 1) + np.array([poses[o].xyz for o in owners])[:, None]


def _normals(triangles: Any) -> tuple[Any, Any]:
    """(n, 3) and (n,): the directions of triangles, and twice their areas (m^2)."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    twice = np.linalg.norm(across, axis=1)
    return across / np.where(twice > 0.0, twice, 1.0)[:, None], twice


def _solids(shape: Shape, read: Callable[[str], list[Part]]) -> list[tuple[Any, Any]]:
    """Triangles (n, 3, 3) in the body's frame (m), and their colour (0 to 255); a shape that cannot
    be read has none."""
    if shape.url is not None:
        found = [(part.points[part.triangles], _color(part, shape)) for part in read(shape.url)]
    else:
        sizes = (shape.radius or 0.0, shape.height or 0.0, shape.size)
        points, faces = vrml_reader.primitive(shape.kind, *sizes)
        found = [(points[faces], np.array(shape.color))]
    turn = np.array(from_turns(tuple(zip((1, 2, 3), shape.rotation, strict=True)))).reshape(3, 3)
    return [(t * shape.scale @ turn.T + np.array(shape.position), color) for t, color in found]


def _color(part: Part, shape: Shape) -> Any:
    """(3,) 0 to 255: that of the mesh, whose own is 0 to 1; else that of the shape."""
    diffuse = part.material.diffuse
    return 255 * np.array(diffuse) if diffuse else np.array(shape.color)


def _parts(url: str, project: Path) -> list[Part]:
    """What a mesh file holds; nothing if it cannot be read."""
    path = path_of(url, project)
    try:
        if path.suffix.lower() in reader.FORMATS:
            return reader.read(path, up_axis=False).parts
        return vrml_reader.read(lookup({}, project)(url) or b"").parts
    except (MeshError, ConversionError):
        return []
