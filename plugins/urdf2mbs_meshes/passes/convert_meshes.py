"""Convert meshes: make the .wrl files, which the method leaves to the user.

Every mesh that a visual shows becomes a VRML97 file, in metres and z up.  A shape's ``scale`` stays
in the .mbs as absolute values.  A mirrored mesh (negative scale) gets a file of its own with the
faces turned back, since not every viewer can draw a mirrored transform.

A mesh without a colour takes the visual's.  A file has the name of its mesh (the stem that
convert-visuals chose), with ``_mirror_AXES`` for a mirrored mesh and ``_RRGGBB`` for a second
colour of the same mesh.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
from msgspec import Meta

from urdf2mbs.plugin import (
    RGB,
    Conversion,
    Pass,
    Shape,
    counted,
    files,
    free_name,
    is_ours,
    some,
    urdf,
)
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_meshes.missing import name_with_links, warn_of_missing
from urdf2mbs_meshes.model import MeshLimit

if TYPE_CHECKING:  # a robot without meshes has no need of what reads and writes them
    from urdf2mbs_meshes.model import Mesh


class ConvertMeshes(Pass):
    reads = ("robot", "bodies", "shapes")
    writes = ("shapes",)

    up_axis: Literal["apply", "ignore"] = "ignore"
    """COLLADA's ``<up_axis>``: leave the mesh as it lies, as RViz and Gazebo do, for which robots
    are made; or turn it so that z is up."""

    at_most: Annotated[int, Meta(gt=0, le=1_000_000)] = 256
    """MiB of all mesh files of the robot that are read: the meshes beyond are left out."""

    def run(self, conversion: Conversion) -> None:
        conversion.state(MeshLimit).mebibytes = self.at_most
        project = conversion.settings.project
        if project is None:
            if conversion.meshes:
                conversion.note(
                    "mesh-not-converted",
                    f"{counted(len(conversion.meshes), 'mesh file')} not converted: the .mbs "
                    "names .wrl files, which 'output: {project: DIR}' makes",
                )
            warn_of_missing(conversion)
            _tell_moved(conversion)
            return
        folder = project / "animationR" / "vrml"
        meshes = _find_meshes(conversion, folder)
        made: dict[Path, bytes] = {}
        left = self.at_most * 2**20
        for number, mesh in enumerate(meshes, start=1):
            conversion.progress(f"{mesh.filename} ({number} of {len(meshes)})")
            left -= self._convert(mesh, left, made)
        conversion.files.update(made)
        _leave_out(conversion, meshes, made)
        made_by_hand = [mesh.filename for mesh in meshes if mesh.path is None and not mesh.lost]
        warn_of_missing(conversion, ", and left out", made=made_by_hand)
        _warn_of_lost(conversion, meshes, self.at_most)
        _tell_moved(conversion)
        _warn_of_differences(conversion, meshes)
        drawn = [data for path, data in made.items() if path.suffix == ".wrl"]
        conversion.report["convert-meshes"] = {
            "folder": str(folder),
            "converted": len(drawn),
            "bytes": sum(map(len, drawn)),
            "lost": {
                mesh.filename: {"code": mesh.lost, "links": mesh.links, "why": mesh.why}
                for mesh in meshes
                if mesh.lost
            },
        }

    def _convert(self, shown: ShownMesh, left: int, made: dict[Path, bytes]) -> int:
        """Convert a mesh in all its looks into ``made``; gives the bytes that were read."""
        from urdf2mbs_meshes.model import MeshError
        from urdf2mbs_meshes.reader import read_mesh

        others = [t for t in shown.targets if files.is_file(t.path) and not is_ours(t.path)]
        due = [target for target in shown.targets if target not in others]
        for target in others:
            target.show()
        if others and shown.path is not None:
            shown.lose("mesh-not-ours", *(str(target.path) for target in others))
        elif not due:
            shown.lose("")  # the user has made the .wrl
        shown.targets = due  # of a mesh that is lost from here on, the rest is left out
        if not due or shown.path is None:
            return 0
        if files.size(shown.path) > left:
            shown.lose("mesh-too-large")
            return 0
        try:
            mesh = read_mesh(shown.path, up_axis=self.up_axis == "apply")
        except MeshError as error:
            shown.lose("mesh-unreadable", f"{shown.path}: {error}")
            return 0
        for target in due:
            made[target.path] = draw(mesh, target.look)
            target.show()
        for name, image in mesh.textures.items():
            path = due[0].path.with_name(name)
            if not files.is_file(path):
                made[path] = image
        shown.problems = mesh.problems
        shown.without = [name for name, data in mesh.sources.items() if data is None]
        shown.turned_up = mesh.turned_up is not None
        return mesh.size


class Look(msgspec.Struct, frozen=True):
    """A visual's changes of its mesh: each different look needs a file of its own."""

    mirror: str
    """The axes that a negative scale mirrors: of "xyz"."""
    color: RGB
    transparency: float


class Target(msgspec.Struct):
    """A .wrl that shows a mesh in one look, and the shapes that show the .wrl."""

    path: Path
    look: Look
    shapes: list[Shape]

    def show(self) -> None:
        """Let the shapes show this file, which holds the mirror of their scale."""
        for shape in self.shapes:
            shape.url = f"{PurePosixPath(shape.url or '').parent}/{self.path.name}"
            x, y, z = shape.scale
            shape.scale = (abs(x), abs(y), abs(z))


class ShownMesh(msgspec.Struct):
    """A mesh file that visuals show, and what becomes of it."""

    filename: str
    """As the URDF names it."""
    path: Path | None
    """None: the mesh was not found."""
    links: list[str]
    targets: list[Target]
    lost: str = ""
    """The code of the warning that says why the mesh, or a look of it, is not converted."""
    why: list[str] = []
    """The places or the error that belong to the warning."""
    problems: list[str] = []
    """Parts of the mesh that cannot be shown."""
    without: list[str] = []
    """Files that the mesh names and that are not there."""
    turned_up: bool = False

    def lose(self, code: str, *why: str) -> None:
        self.lost, self.why = code, list(why)


def _find_meshes(conversion: Conversion, folder: Path) -> list[ShownMesh]:
    """Every mesh that is shown, in the order of the shapes."""
    filenames = {stem: filename for filename, stem in conversion.meshes.items()}
    shapes: dict[str, dict[Look, list[Shape]]] = {}
    for segment in conversion.segments.values():
        for shape in segment.holder.shapes:
            if shape.kind != "inline" or not shape.url:
                continue
            filename = filenames.get(PurePosixPath(shape.url).stem)
            if filename is not None:
                mirror = "".join(a for a, s in zip("xyz", shape.scale, strict=True) if s < 0)
                look = Look(mirror, shape.color, shape.transparency)
                shapes.setdefault(filename, {}).setdefault(look, []).append(shape)
    names = _name_files(conversion.meshes, shapes)
    links: dict[str, list[str]] = {}
    for link in conversion.robot.links.values():
        for visual in link.visuals:
            if isinstance(visual.geometry, urdf.Mesh):
                links.setdefault(visual.geometry.filename, []).append(link.name)
    meshes, files = [], get_mesh_files(conversion)
    for filename, looks in shapes.items():
        targets = [
            Target(folder / f"{names[filename, look]}.wrl", look, looks[look]) for look in looks
        ]
        path = files.find(filename)
        mesh = ShownMesh(filename, path, links[filename], targets)
        if path is None:
            mesh.lose("mesh-missing", files.suggest_remedy(filename))
        meshes.append(mesh)
    return meshes


def _name_files(
    stems: dict[str, str], uses: dict[str, dict[Look, list[Shape]]]
) -> dict[tuple[str, Look], str]:
    """A file name (without .wrl) for each look of each mesh, unique in small letters."""
    taken = {stem.lower() for stem in stems.values()}
    names: dict[tuple[str, Look], str] = {}
    for filename, looks in uses.items():
        mirrors: set[str] = set()
        for look in looks:
            name = stems[filename] + (f"_mirror_{look.mirror}" if look.mirror else "")
            if look.mirror in mirrors:
                name += "_{:02x}{:02x}{:02x}".format(*look.color)
                if look.transparency:
                    name += f"_t{round(100 * look.transparency)}"
            if name != stems[filename]:
                name = free_name(name, taken, str.lower)
            mirrors.add(look.mirror)
            taken.add(name.lower())
            names[filename, look] = name
    return names


def _leave_out(conversion: Conversion, meshes: list[ShownMesh], made: dict[Path, bytes]) -> None:
    """Leave out the shapes whose .wrl is not there: MBSysPad stops at each."""
    targets = [target for mesh in meshes for target in mesh.targets if target.path not in made]
    gone = {id(shape) for target in targets for shape in target.shapes}
    for segment in conversion.segments.values() if gone else ():
        shapes = segment.holder.shapes
        shapes[:] = [shape for shape in shapes if id(shape) not in gone]


def _tell_moved(conversion: Conversion) -> None:
    """Name the meshes that are elsewhere in the workspace than the URDF says."""
    files = get_mesh_files(conversion)
    found = {name: places[0] for name, places in files.moved.items() if len(places) == 1}
    moved = [f"'{name}' at {at}" for name, at in found.items() if name not in files.borrowed]
    if moved:
        conversion.note(
            "mesh-moved",
            f"{counted(len(moved), 'mesh')} not where the URDF says, but found elsewhere, or "
            f"spelt otherwise: {some(moved, 3)}",
        )
    borrowed = [f"'{name}' at {at}" for name, at in found.items() if name in files.borrowed]
    if borrowed:
        conversion.warn(
            "mesh-borrowed",
            f"{counted(len(borrowed), 'mesh')} found in the folder of another robot only, and "
            f"taken from there: {some(borrowed, 3)}",
            hint="'packages: {NAME: DIR}' says where the right mesh is, if this is another",
        )


#: What the warning says of a mesh that exists and is not converted, and its hint, by its code.
LOST = {
    "mesh-not-ours": (
        "not converted, as the .wrl was edited, or written by another program",
        "move away: {why}",
    ),
    "mesh-too-large": (
        "left out: the files of all meshes are more than {at_most} MiB",
        "'convert-meshes: {{at_most: {more}}}' under 'passes' reads more, and takes up to 20 times "
        "the largest file's size in memory",
    ),
    "mesh-unreadable": (
        "left out, as the file cannot be used",
        "save the mesh anew, as .stl or .obj: {why}",
    ),
}


def _warn_of_lost(conversion: Conversion, meshes: list[ShownMesh], at_most: int) -> None:
    """Warn once for each reason, with the names of the meshes."""
    for code, (words, hints) in LOST.items():
        lost = [mesh for mesh in meshes if mesh.lost == code]
        if not lost:
            continue
        named = [name_with_links(mesh.filename, mesh.links) for mesh in lost]
        why = list(dict.fromkeys(line for mesh in lost for line in mesh.why))
        hint = hints.format(why=some(why, 3), more=4 * at_most)
        text = f"{counted(len(lost), 'mesh')} {words.format(at_most=at_most)}: {some(named, 3)}"
        conversion.warn(code, text, link=lost[0].links[0], hint=hint)


def _warn_of_differences(conversion: Conversion, meshes: list[ShownMesh]) -> None:
    """Warn of what the .wrl files do not show as the meshes do."""
    for problem in dict.fromkeys(problem for mesh in meshes for problem in mesh.problems):
        having = [mesh for mesh in meshes if problem in mesh.problems]
        names = some([mesh.filename for mesh in having])
        what = f"a part of a mesh cannot be shown as it is: {names}: {problem}"
        conversion.warn("mesh-part", what, link=having[0].links[0])
    turned_up = [mesh for mesh in meshes if mesh.turned_up]
    if turned_up:
        conversion.warn(
            "mesh-up-axis",
            f"{counted(len(turned_up), 'mesh')} turned so that z is up, as asked; "
            f"RViz and Gazebo draw them unturned: {some([mesh.filename for mesh in turned_up])}",
            link=turned_up[0].links[0],
            hint="leave out 'up_axis: apply' to draw them unturned, too",
        )
    lost = dict.fromkeys(name for mesh in meshes for name in mesh.without)
    if lost:
        named = (
            f"'{name}' (of {some([m.filename for m in meshes if name in m.without], 1)})"
            for name in lost
        )
        conversion.warn(
            "mesh-file-missing",
            f"meshes name files that were not found, and are shown without: {some(named, 3)}",
        )


def draw(mesh: Mesh, look: Look) -> bytes:
    """The .wrl that shows a mesh in a look."""
    from urdf2mbs_meshes import vrml
    from urdf2mbs_meshes.model import turned

    parts = mesh.parts
    if look.mirror:
        import numpy as np

        signs = np.array([-1.0 if axis in look.mirror else 1.0 for axis in "xyz"])
        parts = [msgspec.structs.replace(part, points=part.points * signs) for part in parts]
        if len(look.mirror) % 2:
            parts = [turned(part) for part in parts]
    r, g, b = (c / 255 for c in look.color)
    out = BytesIO()  # whose value is no copy of what is written
    out.writelines(vrml.write(parts, (r, g, b), look.transparency))
    return out.getvalue()
