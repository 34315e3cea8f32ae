"""Convert meshes: make the .wrl files, which the method leaves to the user.

Every mesh that a visual shows becomes a VRML97 file, in metres and z up.  A shape's ``scale`` stays
in the .mbs as absolute values.  A mirrored mesh (negative scale) gets a file of its own with the
faces flipped back, since not every viewer can draw a mirrored transform.

A mesh without a colour takes that of the visual.  A file has the name of its mesh (the stem that
convert-visuals chose), with ``_mirror_AXES`` for a mirrored mesh and ``_RRGGBB`` for a second
colour of the same mesh.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

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
from urdf2mbs_meshes.missing import format_mesh, warn_of_missing_meshes
from urdf2mbs_meshes.model import MeshLimit

if TYPE_CHECKING:  # what reads and writes meshes is imported only for a robot that has some
    from urdf2mbs_meshes.model import Mesh


class ConvertMeshes(Pass):
    """Convert meshes: make the .wrl files, which the method leaves to the user."""

    reads = ("robot", "bodies", "shapes")
    writes = ("shapes",)

    up_axis: Literal["apply", "ignore"] = "ignore"
    """COLLADA's ``<up_axis>``: leave the mesh as it lies, as RViz and Gazebo do, for which robots
    are made; or turn it so that z is up."""

    at_most: Annotated[int, Meta(gt=0, le=1_000_000)] = 256
    """MiB of all mesh files of the robot that are read: the meshes beyond are left out."""

    def run(self, conversion: Conversion) -> None:
        """Convert the meshes if the output is a project; warn of those that are lost."""
        conversion.state(MeshLimit).mebibytes = self.at_most
        project = conversion.settings.project
        if project is None:
            if conversion.meshes:
                conversion.note(
                    "mesh-not-converted",
                    f"{counted(len(conversion.meshes), 'mesh file')} not converted: the .mbs "
                    "names .wrl files, which 'output: {project: DIR}' makes",
                )
            warn_of_missing_meshes(conversion)
            _report_moved(conversion)
            return
        folder = project / "animationR" / "vrml"
        meshes = _list_meshes(conversion, folder)
        new_files: dict[Path, bytes] = {}
        bytes_left = self.at_most * 2**20
        for number, mesh in enumerate(meshes, start=1):
            conversion.progress(f"{mesh.filename} ({number} of {len(meshes)})")
            bytes_left -= self._convert(conversion, mesh, bytes_left, new_files)
        conversion.files.update(new_files)
        _remove_shapes_without_file(conversion, meshes, new_files)
        _warn_of_losses(conversion, meshes, self.at_most)
        drawings = [data for path, data in new_files.items() if path.suffix == ".wrl"]
        conversion.report["convert-meshes"] = {
            "folder": str(folder),
            "converted": len(drawings),
            "bytes": sum(map(len, drawings)),
            "lost": {
                mesh.filename: {"code": code, "links": mesh.links, "why": mesh.list_details(code)}
                for mesh in meshes
                if (code := mesh.find_code_of_failure())
            },
        }

    def _convert(
        self, conversion: Conversion, shown: ShownMesh, max_bytes: int, new_files: dict[Path, bytes]
    ) -> int:
        """Convert a mesh in all its looks.

        Args:
            conversion: The conversion.
            shown: The mesh; it gets its losses, and only the targets that are to be written.
            max_bytes: The mesh is left out if its file is larger.
            new_files: The .wrl files and textures are added to these.

        Returns:
            Number of bytes that were read.
        """
        from urdf2mbs_meshes.model import MeshError
        from urdf2mbs_meshes.reader import read_mesh

        edited = [
            target
            for target in shown.targets
            if files.is_file(target.path) and not is_ours(target.path)
        ]
        for target in edited:
            target.show()
        shown.targets = [target for target in shown.targets if target not in edited]
        if shown.path is None:
            if shown.targets:  # else the user has made every .wrl by hand
                remedy = get_mesh_files(conversion).suggest_remedy(shown.filename)
                shown.add_loss("mesh-missing", remedy)
            return 0
        for target in edited:
            shown.add_loss("mesh-not-ours", str(target.path))
        if not shown.targets:
            return 0
        if files.size(shown.path) > max_bytes:
            shown.add_loss("mesh-too-large")
            return 0
        try:
            mesh = read_mesh(shown.path, up_axis=self.up_axis == "apply")
        except MeshError as error:
            shown.add_loss("mesh-unreadable", f"{shown.path}: {error}")
            return 0
        _draw_targets(shown, mesh, new_files)
        shown.add_losses_of(mesh)
        return mesh.size


class Look(msgspec.Struct, frozen=True):
    """A visual's changes of its mesh: each different look needs a file of its own."""

    mirror: str
    """The axes that a negative scale mirrors: of "xyz"."""
    color: RGB
    transparency: float


class Target(msgspec.Struct):
    """A .wrl that shows a mesh in a look, and the shapes that show the .wrl."""

    path: Path
    look: Look
    shapes: list[Shape]

    def show(self) -> None:
        """Make the shapes show this file, which holds the mirror of their scale."""
        for shape in self.shapes:
            shape.url = f"{PurePosixPath(shape.url or '').parent}/{self.path.name}"
            x, y, z = shape.scale
            shape.scale = (abs(x), abs(y), abs(z))


class Loss(msgspec.Struct, frozen=True):
    """What of a mesh is not shown as in the URDF."""

    code: str
    """The code of the warning."""
    detail: str = ""
    """The file or the error that belongs to the warning."""


class ShownMesh(msgspec.Struct):
    """A mesh file that visuals show."""

    filename: str
    """As the URDF names it."""
    path: Path | None
    """None if the mesh was not found."""
    links: list[str]
    targets: list[Target]
    losses: list[Loss] = []

    def add_loss(self, code: str, detail: str = "") -> None:
        """Add a loss by the code of its warning."""
        self.losses.append(Loss(code, detail))

    def add_losses_of(self, mesh: Mesh) -> None:
        """Add the losses of the mesh file, once it has been read."""
        for problem in mesh.problems:
            self.add_loss("mesh-part", problem)
        if mesh.applied_up_axis is not None:
            self.add_loss("mesh-up-axis")
        for name, data in mesh.sources.items():
            if data is None:
                self.add_loss("mesh-file-missing", name)

    def list_details(self, code: str) -> list[str]:
        """Return the details of the losses with a code."""
        return [loss.detail for loss in self.losses if loss.code == code and loss.detail]

    def find_code_of_failure(self) -> str:
        """Return the last code that says why the mesh, or a look of it, is not converted."""
        codes = [loss.code for loss in self.losses if loss.code in FAILURES]
        return codes[-1] if codes else ""


def _list_meshes(conversion: Conversion, folder: Path) -> list[ShownMesh]:
    """Return every mesh that is shown, in the order of the shapes; .wrl files are in a folder."""
    shapes = _list_shapes_of_meshes(conversion)
    names = _name_files(conversion.meshes, shapes)
    links: dict[str, list[str]] = {}
    for link in conversion.robot.links.values():
        for visual in link.visuals:
            if isinstance(visual.geometry, urdf.Mesh):
                links.setdefault(visual.geometry.filename, []).append(link.name)
    mesh_files = get_mesh_files(conversion)
    meshes = []
    for filename, looks in shapes.items():
        targets = [
            Target(folder / f"{names[filename, look]}.wrl", look, shapes_of_look)
            for look, shapes_of_look in looks.items()
        ]
        meshes.append(ShownMesh(filename, mesh_files.find(filename), links[filename], targets))
    return meshes


def _list_shapes_of_meshes(conversion: Conversion) -> dict[str, dict[Look, list[Shape]]]:
    """Return the shapes that show each mesh file, by their looks."""
    filenames = {stem: filename for filename, stem in conversion.meshes.items()}
    shapes: dict[str, dict[Look, list[Shape]]] = {}
    for segment in conversion.segments.values():
        for shape in segment.holder.shapes:
            if shape.kind != "inline" or not shape.url:
                continue
            filename = filenames.get(PurePosixPath(shape.url).stem)
            if filename is not None:
                axes = zip("xyz", shape.scale, strict=True)
                mirror = "".join(axis for axis, factor in axes if factor < 0)
                look = Look(mirror, shape.color, shape.transparency)
                shapes.setdefault(filename, {}).setdefault(look, []).append(shape)
    return shapes


def _name_files(
    stems: dict[str, str], shapes: dict[str, dict[Look, list[Shape]]]
) -> dict[tuple[str, Look], str]:
    """Choose a file name for each look of each mesh.

    Args:
        stems: The stem that convert-visuals chose for each mesh file.
        shapes: The shapes that show each mesh file, by their looks.

    Returns:
        Names without .wrl by mesh file and look, unique also in small letters.
    """
    used_names = {stem.lower() for stem in stems.values()}
    names: dict[tuple[str, Look], str] = {}
    for filename, looks in shapes.items():
        mirrors: set[str] = set()
        for look in looks:
            name = stems[filename] + (f"_mirror_{look.mirror}" if look.mirror else "")
            if look.mirror in mirrors:
                name += "_{:02x}{:02x}{:02x}".format(*look.color)
                if look.transparency:
                    name += f"_t{round(100 * look.transparency)}"
            if name != stems[filename]:
                name = free_name(name, used_names, str.lower)
            mirrors.add(look.mirror)
            used_names.add(name.lower())
            names[filename, look] = name
    return names


def _draw_targets(shown: ShownMesh, mesh: Mesh, new_files: dict[Path, bytes]) -> None:
    """Write a mesh in all its looks, and its textures, to ``new_files``."""
    for target in shown.targets:
        new_files[target.path] = draw(mesh, target.look)
        target.show()
    for name, image in mesh.textures.items():
        path = shown.targets[0].path.with_name(name)
        if not files.is_file(path):
            new_files[path] = image


def draw(mesh: Mesh, look: Look) -> bytes:
    """Return the .wrl that shows a mesh in a look."""
    from urdf2mbs_meshes.model import flip_faces
    from urdf2mbs_meshes.vrml import write_vrml

    parts = mesh.parts
    if look.mirror:
        import numpy as np

        signs = np.array([-1.0 if axis in look.mirror else 1.0 for axis in "xyz"])
        parts = [msgspec.structs.replace(part, points=part.points * signs) for part in parts]
        if len(look.mirror) % 2:
            parts = [flip_faces(part) for part in parts]
    red, green, blue = (value / 255 for value in look.color)
    stream = BytesIO()  # its value is not a copy of the pieces
    stream.writelines(write_vrml(parts, (red, green, blue), look.transparency))
    return stream.getvalue()


def _remove_shapes_without_file(
    conversion: Conversion, meshes: list[ShownMesh], new_files: dict[Path, bytes]
) -> None:
    """Remove the shapes whose .wrl does not exist: MBSysPad stops at each."""
    targets = [target for mesh in meshes for target in mesh.targets if target.path not in new_files]
    removed = {id(shape) for target in targets for shape in target.shapes}
    for segment in conversion.segments.values() if removed else ():
        shapes = segment.holder.shapes
        shapes[:] = [shape for shape in shapes if id(shape) not in removed]


# --- messages ---


class LossWarning(NamedTuple):
    """The words of the warning of a loss.

    Words in braces are filled in: ``count`` of the meshes, their ``names``, the ``links`` that
    show them, the ``details`` of the losses, the ``files`` that are missing, and the limit
    ``at_most`` (MiB).
    """

    message: str
    hint: str | None = None
    is_one_per_detail: bool = False
    """True: meshes with different details are different warnings."""
    has_link: bool = True


#: The losses that let a mesh, or a look of it, be left out.
FAILURES = ("mesh-missing", "mesh-not-ours", "mesh-too-large", "mesh-unreadable")

#: The warnings of losses by code; ``missing.py`` has that of ``mesh-missing``.
LOSS_WARNINGS = {
    "mesh-not-ours": LossWarning(
        "{count} not converted, as the .wrl was edited, or written by another program: {links}",
        "move away: {details}",
    ),
    "mesh-too-large": LossWarning(
        "{count} left out: the files of all meshes are more than {at_most} MiB: {links}",
        "'convert-meshes: {{at_most: {larger_limit}}}' under 'passes' reads more, and takes up to "
        "20 times the largest file's size in memory",
    ),
    "mesh-unreadable": LossWarning(
        "{count} left out, as the file cannot be used: {links}",
        "save the mesh anew, as .stl or .obj: {details}",
    ),
    "mesh-part": LossWarning(
        "a part of a mesh cannot be shown as it is: {names}: {details}", is_one_per_detail=True
    ),
    "mesh-up-axis": LossWarning(
        "{count} turned so that z is up, as asked; RViz and Gazebo draw them unturned: {names}",
        "leave out 'up_axis: apply' to draw them unturned, too",
    ),
    "mesh-file-missing": LossWarning(
        "meshes name files that were not found, and are shown without: {files}", has_link=False
    ),
}


def _warn_of_losses(conversion: Conversion, meshes: list[ShownMesh], at_most: int) -> None:
    """Warn of all that the .wrl files do not show as the URDF does."""
    made_by_hand = [mesh.filename for mesh in meshes if mesh.path is None and not mesh.losses]
    warn_of_missing_meshes(conversion, ", and left out", made_by_hand=made_by_hand)
    _report_moved(conversion)
    for code, warning in LOSS_WARNINGS.items():
        details = list(dict.fromkeys(text for mesh in meshes for text in mesh.list_details(code)))
        if warning.is_one_per_detail:
            for detail in details:
                having = [mesh for mesh in meshes if detail in mesh.list_details(code)]
                _warn_of_loss(conversion, code, having, [detail], at_most)
        else:
            having = [mesh for mesh in meshes if any(loss.code == code for loss in mesh.losses)]
            _warn_of_loss(conversion, code, having, details, at_most)


def _warn_of_loss(
    conversion: Conversion, code: str, meshes: list[ShownMesh], details: list[str], at_most: int
) -> None:
    """Warn of meshes with the same loss, if there are any."""
    if not meshes:
        return
    warning = LOSS_WARNINGS[code]
    files_with_meshes = (
        f"'{detail}' (of {some([m.filename for m in meshes if detail in m.list_details(code)], 1)})"
        for detail in details
    )
    words = {
        "count": counted(len(meshes), "mesh"),
        "names": some([mesh.filename for mesh in meshes]),
        "links": some([format_mesh(mesh.filename, mesh.links) for mesh in meshes], 3),
        "details": some(details, 3),
        "files": some(files_with_meshes, 3),
        "at_most": at_most,
        "larger_limit": 4 * at_most,
    }
    conversion.warn(
        code,
        warning.message.format(**words),
        link=meshes[0].links[0] if warning.has_link else None,
        hint=warning.hint and warning.hint.format(**words),
    )


def _report_moved(conversion: Conversion) -> None:
    """Name the meshes that were found elsewhere than the URDF says."""
    files = get_mesh_files(conversion)
    moved: list[str] = []
    borrowed: list[str] = []
    for name, path in files.list_moved().items():
        (borrowed if name in files.borrowed else moved).append(f"'{name}' at {path}")
    if moved:
        conversion.note(
            "mesh-moved",
            f"{counted(len(moved), 'mesh')} not where the URDF says, but found elsewhere, or "
            f"spelt otherwise: {some(moved, 3)}",
        )
    if borrowed:
        conversion.warn(
            "mesh-borrowed",
            f"{counted(len(borrowed), 'mesh')} found in the folder of another robot only, and "
            f"taken from there: {some(borrowed, 3)}",
            hint="'packages: {NAME: DIR}' says where the right mesh is, if this is another",
        )
