"""What the report's 3D view draws, as plain data: an .mbs file, a URDF, and their meshes.

The two sides know nothing of each other.  The .mbs's shapes are what its .wrl files hold; the
URDF's are its own mesh files.  Triangles that both sides have are stored once.
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import msgspec

from urdf2mbs.plugin import ConversionError, add, is_file, mbs, rotate, size, urdf
from urdf2mbs.plugin import compute_placement as place
from urdf2mbs.plugin import read_bytes as read
from urdf2mbs_meshes import reader as meshes
from urdf2mbs_meshes import vrml_reader
from urdf2mbs_meshes.model import Mesh, MeshError, MeshLimit, Part, find_distinct_rows

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

IMAGES = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"GIF8": "image/gif"}

#: Gives a file by its url or name; None: it is not there.
Fetch = Callable[[str], bytes | None]


class Store:
    """The meshes of one page: each mesh a list of parts, each array stored once.

    At most ``mebibytes`` of a URDF's mesh files are read.
    """

    def __init__(self, mebibytes: int = MeshLimit().mebibytes) -> None:
        self.meshes: list[list[dict[str, Any]]] = []
        self.textures: list[str] = []
        self.missing: dict[str, str] = {}
        """Meshes that cannot be drawn, and why."""
        self.in_part: dict[str, str] = {}
        """The meshes that are drawn in part, and what is left out."""
        self._arrays: dict[bytes, int] = {}
        self._known: dict[tuple[str, str], tuple[int | None, str]] = {}
        """The number of each file's mesh, and what is left out, or why there is none."""
        self._offset = 0
        self._mebibytes = mebibytes
        self._left = mebibytes * 2**20

    def wrl(self, url: str, fetch: Fetch, path: Path | None = None) -> int | None:
        """The number of the mesh that an .mbs's ``url`` shows, None where it cannot be drawn.

        A file of another format than .wrl is read from its ``path``.
        """
        if path is not None and path.suffix.lower() in meshes.FORMATS:
            return self.source(url, path)
        return self._once(url, ("wrl", url), partial(self._read_wrl, url, fetch))

    def source(self, filename: str, path: Path | None) -> int | None:
        """Return the same for a URDF's mesh file, drawn as RViz draws it."""
        file = ("source", filename if path is None else str(path))  # it may have several names
        return self._once(filename, file, partial(self._read_source, path))

    def _once(
        self, name: str, file: tuple[str, str], make: Callable[[], tuple[Mesh, Fetch]]
    ) -> int | None:
        """Return the number of a file's mesh, which is made when the file is first asked for."""
        if file not in self._known:
            try:
                mesh, fetch = make()
                self.meshes.append([self._part(part, fetch) for part in _joined(mesh.parts)])
                problems = "; ".join(dict.fromkeys(mesh.problems))
                self._known[file] = (len(self.meshes) - 1, problems)
            except MeshError as error:
                self._known[file] = (None, str(error))
        number, reason = self._known[file]
        if reason:
            (self.missing if number is None else self.in_part)[name] = reason
        return number

    def _read_wrl(self, url: str, fetch: Fetch) -> tuple[Mesh, Fetch]:
        data = fetch(url)
        if data is None:
            raise MeshError("the .wrl is not there ('output: {project: DIR}' makes it)")
        folder = PurePosixPath(url.replace("\\", "/")).parent
        return vrml_reader.read_vrml(data), lambda name: fetch(str(folder / name))

    def _read_source(self, path: Path | None) -> tuple[Mesh, Fetch]:
        if path is None:
            raise MeshError("the mesh file is not there")
        if size(path) > self._left:
            raise MeshError(
                f"the files of all meshes are more than {self._mebibytes} MiB, "
                "'at_most' of convert-meshes"
            )
        try:
            mesh = meshes.read_mesh(path, up_axis=False)
            self._left -= mesh.size
        except ConversionError as error:
            raise MeshError(f"{error.message}; {error.hint}") from None
        return mesh, mesh.textures.get

    def _part(self, part: Part, fetch: Fetch) -> dict[str, Any]:
        import numpy as np

        corners = part.points.astype(np.float32)[part.triangles].reshape(-1, 3) + np.float32(0.0)
        points, triangles = find_distinct_rows(corners)
        low, step, places = _in_steps(points)
        look = part.material
        out: dict[str, Any] = {
            "low": low,
            "step": step,
            "points": self._array(places),
            "triangles": self._array(_back_from_newest(triangles)),
            "color": look.diffuse,
            "transparency": look.transparency,
        }
        if look.texture and part.uv is not None:
            texture = fetch(look.texture) or b""
            kind = next((IMAGES[start] for start in IMAGES if texture.startswith(start)), None)
            if kind is not None:
                out["texture"] = self._texture(texture, kind)
                out["uv"] = self._array(part.uv.astype(np.float32).reshape(-1, 2).view(np.uint32))
        if part.colors is not None:
            colors = np.asarray(part.colors)
            if colors.ndim == 2:
                colors = np.repeat(colors[:, None, :], 3, axis=1)
            if colors.shape[-1] == 4 and look.transparency is None:
                out["transparency"] = 1.0 - float(colors[..., 3].mean()) / 255
            rgba = np.full((len(corners), 4), 255, np.uint8)
            rgba[:, :3] = colors[..., :3].reshape(-1, 3)
            out["colors"] = self._array(rgba.view("<u4"))
        return out

    def _array(self, values: NDArray[np.uint32]) -> tuple[int, int]:
        """Keep an array of 32-bit words; gives its place (bytes) and its length (words).

        The lowest bytes of all words come first, then the next: so they pack best.
        """
        import numpy as np

        data = values.astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes()
        if data not in self._arrays:
            self._arrays[data] = self._offset
            self._offset += len(data)
        return self._arrays[data], values.size

    def _texture(self, data: bytes, kind: str) -> int:
        url = f"data:{kind};base64,{base64.b64encode(data).decode()}"
        if url not in self.textures:
            self.textures.append(url)
        return self.textures.index(url)

    def packed(self) -> str:
        """All arrays, for the page to unpack: gzip, then base64."""
        return base64.b64encode(gzip.compress(b"".join(self._arrays), 9, mtime=0)).decode()


def _in_steps(points: NDArray[np.float32]) -> tuple[list[float], float, NDArray[np.uint32]]:
    """The lowest corner of the box around points, a 65,535th of its longest side, and each
    coordinate in such steps from there, less that of the point before; all x come first."""
    import numpy as np

    if not len(points):
        return [0.0, 0.0, 0.0], 1.0, np.zeros(0, np.uint32)
    low = points.min(axis=0).astype(float)
    step = float((points - low).max()) / 65535 or 1.0
    places = np.rint((points - low) / step).astype(np.int64)
    return low.tolist(), step, (np.diff(places, axis=0, prepend=0).T.ravel() & 65535).astype("<u4")


def _back_from_newest(triangles: NDArray[np.int32]) -> NDArray[np.uint32]:
    """How far each corner's point is behind the next new one; points come in their order."""
    import numpy as np

    flat = triangles.ravel()
    newest = np.maximum.accumulate(flat) if len(flat) else flat
    return (np.concatenate([[-1], newest])[: len(flat)] + 1 - flat).astype("<u4")


def _joined(parts: list[Part]) -> list[Part]:
    """The parts, those that look the same as one: a browser draws few large ones faster."""
    import numpy as np

    alike: dict[Any, list[Part]] = {}
    for number, part in enumerate(parts):
        plain = part.uv is None and part.colors is None
        alike.setdefault((part.material, part.smooth) if plain else number, []).append(part)
    joined = []
    for group in alike.values():
        starts = np.cumsum([0, *(len(part.points) for part in group)])
        triangles = [part.triangles + start for part, start in zip(group, starts, strict=False)]
        points = np.concatenate([part.points for part in group])
        whole = msgspec.structs.replace(
            group[0], points=points, triangles=np.concatenate(triangles)
        )
        joined.append(whole if len(group) > 1 else group[0])
    return joined


def mbs_side(
    model: mbs.Mbs,
    store: Store,
    fetch: Fetch,
    find: Callable[[str], Path | None] = lambda url: None,
) -> dict[str, Any]:
    """The .mbs's own joints and shapes; ``find`` gives the file of a url that is no .wrl."""

    def drawn(shape: mbs.Shape) -> dict[str, Any]:
        out = {**msgspec.structs.asdict(shape), "origin": None}
        if shape.url is not None:
            out["mesh"] = store.wrl(shape.url, fetch, find(shape.url))
        return out

    points = model.points()

    def own(body: mbs.Body) -> dict[str, Any]:
        at = None if body.point is None else points[body.parent, body.point].coordinates
        return _some(body, "name", "parent", "mass", "com", "inertia") | {
            "at": at or (0.0, 0.0, 0.0),
            "joints": [_some(joint, "name", "type", "nature", "q") for joint in body.joints],
            "shapes": [drawn(shape) for shape in body.shapes],
        }

    base = {"name": model.base.name, "shapes": [drawn(shape) for shape in model.base.shapes]}
    return {"base": base, "bodies": [own(body) for body in model.bodies]}


def _some(one: Any, *names: str) -> dict[str, Any]:
    """Some attributes of an object, by their names."""
    return {name: getattr(one, name) for name in names}


def urdf_side(
    robot: urdf.Robot, store: Store, find: Callable[[str], Path | None]
) -> dict[str, Any]:
    """The URDF's links and joints, the joints in an order in which parents come first."""

    def visual(given: urdf.Visual) -> dict[str, Any]:
        material = given.material
        if material is not None and material.color is None:
            material = robot.materials.get(material.name)
        return {**placed(given), "color": material and material.color}

    def placed(given: urdf.Visual | urdf.Collision) -> dict[str, Any]:
        out = _some(given.origin, "xyz", "rpy") | {"geometry": given.geometry}
        if isinstance(given.geometry, urdf.Mesh):
            name = given.geometry.filename
            out["mesh"] = store.source(name, find(name))
        return out

    def moved(joint: urdf.Joint) -> dict[str, Any]:
        limit, mimic = joint.limit, joint.mimic
        known = limit is not None and None not in (limit.lower, limit.upper)
        return {
            **_some(joint, "name", "type", "parent", "child", "axis"),
            **_some(joint.origin, "xyz", "rpy"),
            "limit": (limit.lower, limit.upper) if limit and known else None,
            "mimic": mimic and (mimic.joint, mimic.multiplier, mimic.offset),
        }

    return {
        "root": robot.root(),
        "links": [
            {
                "name": link.name,
                "visuals": [visual(given) for given in link.visuals],
                "collisions": [placed(given) for given in link.collisions],
            }
            for link in robot.links.values()
        ],
        "joints": [moved(joint) for joint in robot.depth_first()],
    }


def path_of(url: str, project: Path) -> Path:
    """The file that a url names: ``PRJPATH`` is the project's folder; the folder around it is
    tried, too, since some models name their project after ``PRJPATH``."""
    plain = url.replace("\\", "/")
    inside = Path(plain.replace("PRJPATH", str(project), 1))
    around = Path(plain.replace("PRJPATH", str(project.absolute().parent), 1))
    return around if not is_file(inside) and is_file(around) else inside


def lookup(files: Mapping[Path, bytes], project: Path) -> Fetch:
    """Fetches what ``PRJPATH`` urls name: what is about to be written, else what lies there."""

    def fetch(url: str) -> bytes | None:
        path = path_of(url, project)
        if path in files:
            return files[path]
        try:
            return read(path)
        except (OSError, ValueError):
            return None

    return fetch


def extent(model: mbs.Mbs) -> float:
    """The longest side of the box around all frames, points and shapes (m); 1 where there is
    no extent."""
    poses = place(model).bodies
    places = [point.coordinates for point in model.base.points]
    for body in model.bodies:
        pose = poses[body.name]
        inside = [(0.0, 0.0, 0.0), *(point.coordinates for point in body.points)]
        inside += [shape.position for shape in body.shapes]
        places += [add(pose.xyz, rotate(pose.rot, xyz)) for xyz in inside]
    sides = [max(column) - min(column) for column in zip(*places, strict=True)]
    return max(sides, default=0.0) or 1.0
