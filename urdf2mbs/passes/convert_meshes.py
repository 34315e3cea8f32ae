"""Convert meshes: the method's "simply needs to be converted (by the user)", done here.

Every mesh that a visual shows becomes a VRML97 file in the project's ``animationR/vrml``.  The
file holds the mesh in metres and z up.  A shape's ``scale`` stays in the .mbs as absolute values.
A mirrored mesh (negative scale) gets a file of its own with the faces turned back, since not every
viewer can draw a mirrored transform.

A mesh without a colour takes the visual's.  A file has the name of its mesh (the stem that
convert-visuals chose), with ``_mirror_AXES`` for a mirrored mesh and ``_RRGGBB`` for a second
colour of the same mesh.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
from msgspec import Meta

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk import files
from urdf2mbs.disk.seal import intact, seal
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import RGB, Shape
from urdf2mbs.mbs.names import free_name
from urdf2mbs.messages.diagnostics import counted, some
from urdf2mbs.urdf import model as urdf

if TYPE_CHECKING:  # a robot without meshes has no need of what reads and writes them
    from urdf2mbs.meshes.model import Mesh

#: Each .wrl holds this number; with a new number, all files are written again.
VERSION = 3

#: Each .wrl begins so; then comes ``Made``.
BEGIN = b"#VRML V2.0 utf8\n# "


class ConvertMeshes(Pass):
    reads = ("robot", "shapes")
    writes = ("shapes",)

    up_axis: Literal["apply", "ignore"] = "ignore"
    """COLLADA's ``<up_axis>``: leave the mesh as it lies, as RViz and Gazebo do, for which robots
    are made; or turn it so that z is up."""

    at_most: Annotated[int, Meta(gt=0, le=1_000_000)] = 256
    """MiB of all mesh files of the robot that are read: the meshes beyond are left out."""

    def run(self, conversion: Conversion) -> None:
        settings = conversion.settings
        if settings.project is None:
            if conversion.meshes:
                conversion.note(
                    "mesh-not-converted",
                    f"{counted(len(conversion.meshes), 'mesh file')} not converted: the .mbs "
                    "names .wrl files, which 'output: {project: DIR}' makes",
                )
            _note_moved(conversion)
            return
        from urdf2mbs.meshes.model import MeshError

        folder = settings.project / "animationR" / "vrml"
        uses = _uses(conversion, folder, self)
        links = _links(conversion)
        shown: dict[str, Made] = {}
        lost = Lost()
        left = self.at_most * 2**20
        counts = {"converted": 0, "kept": 0, "unusable": 0, "bytes": 0}
        ask = _start_conversion(uses, self)
        for number, (filename, use) in enumerate(uses.items(), start=1):
            conversion.progress(f"{filename} ({number} of {len(uses)})")
            mesh: Converted | None = None
            if use.path is None:
                lost.missing[filename] = conversion.packages.places_of(filename)
            elif use.due and files.size(use.path) > left:
                lost.too_large[filename] = f"{files.size(use.path) / 2**20:.3g} MiB"
            elif use.due:
                try:
                    mesh = ask(use)
                    left -= mesh.size
                except MeshError as error:
                    lost.unreadable[filename] = f"{use.path}: {error}"
            counts["unusable"] += use.path is None or (bool(use.due) and mesh is None)
            for target in use.targets:
                if target.foreign:
                    lost.not_ours[filename] = str(target.path)
                elif target.made is not None:
                    counts["kept"] += 1
                    counts["bytes"] += target.size
                    shown[filename] = target.made
                elif mesh is not None and use.path is not None:
                    shown[filename], content = mesh.looks[target.look]
                    conversion.files[target.path] = content
                    counts["converted"] += 1
                    counts["bytes"] += len(content)
                else:
                    continue
                for shape in target.shapes:
                    shape.url = f"{PurePosixPath(shape.url or '').parent}/{target.path.name}"
                    x, y, z = shape.scale
                    shape.scale = (abs(x), abs(y), abs(z))
            for name, image in mesh.textures.items() if mesh is not None else ():
                if not files.is_file(folder / name):
                    conversion.files[folder / name] = image
        _warn_of_lost(conversion, lost, links, self)
        _note_moved(conversion)
        _warn_of_differences(conversion, shown, links)
        conversion.facts["convert-meshes"] = {
            "folder": str(folder), **counts,
            "lost": {
                kind: {name: {"links": links[name], "why": why} for name, why in files.items()}
                for kind, files in msgspec.structs.asdict(lost).items()
            },
        }  # fmt: skip


class Look(msgspec.Struct, frozen=True):
    """A visual's changes of its mesh: each different look needs a file of its own."""

    mirror: str
    """The axes that a negative scale mirrors: of "xyz"."""
    color: RGB
    transparency: float


class Made(msgspec.Struct, omit_defaults=True):
    """The sources of a .wrl: its second line."""

    version: int
    up_axis: str
    look: Look
    sources: dict[str, str | None]
    """The sha256 of each file read, by its name in the mesh file; None: it was not there."""
    textures: list[str] = []
    problems: list[str] = []
    turned_up: str | None = None


class Lost(msgspec.Struct):
    """Mesh files that are not converted, by the names that the URDF gives them, and why."""

    missing: dict[str, list[str]] = {}
    not_ours: dict[str, str] = {}
    unreadable: dict[str, str] = {}
    too_large: dict[str, str] = {}


class Target(msgspec.Struct):
    """A .wrl that shows a mesh in one look, and the file that stands in its place already."""

    path: Path
    look: Look
    shapes: list[Shape]
    """The shapes that show the mesh in this look."""
    made: Made | None = None
    """What the file was made from, if the mesh would give the same file again."""
    size: int = 0
    """Bytes of the file."""
    foreign: bool = False
    """True if urdf2mbs did not write the file, or if somebody has changed it since."""


class Use(msgspec.Struct):
    """A mesh that is shown, in each of its looks."""

    path: Path | None
    """None: the mesh was not found."""
    targets: list[Target]

    @property
    def due(self) -> list[Look]:
        """The looks that are to be converted."""
        return [target.look for target in self.targets if not (target.made or target.foreign)]

    @property
    def file(self) -> tuple[str, str]:
        """The mesh file, whatever name the URDF gives it.  A .wrl says the name of its mesh."""
        assert self.path is not None
        return os.path.realpath(self.path), self.path.name


class Job(msgspec.Struct, frozen=True):
    """A mesh file, and the looks in which it is shown."""

    path: Path
    looks: tuple[Look, ...]
    options: ConvertMeshes


class Converted(msgspec.Struct):
    """A mesh file in all its looks."""

    size: int
    """Bytes of all the files that it was read from."""
    looks: dict[Look, tuple[Made, bytes]]
    textures: dict[str, bytes]


def _uses(conversion: Conversion, folder: Path, options: ConvertMeshes) -> dict[str, Use]:
    """Every mesh that is shown, by the name that the URDF gives it."""
    from urdf2mbs.meshes.model import read_beside

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
    uses: dict[str, Use] = {}
    for filename, looks in shapes.items():
        path = conversion.packages.resolve(filename)
        use = uses[filename] = Use(path, [])
        for look in looks if path is not None else ():
            target = Target(folder / f"{names[filename, look]}.wrl", look, looks[look])
            content = read_beside(target.path, target.path.name)
            if content is not None and path is not None:
                made = read_made(content)
                target.size, target.foreign = len(content), made is None
                if made is not None and is_current(made, options, look, path, folder):
                    target.made = made
            use.targets.append(target)
    return uses


def _start_conversion(uses: dict[str, Use], options: ConvertMeshes) -> Callable[[Use], Converted]:
    """A function that converts a mesh, or raises MeshError; it reads each file once."""
    due = [use for use in uses.values() if use.due]
    looks: dict[tuple[str, str], dict[Look, None]] = {}
    for use in due:
        looks.setdefault(use.file, {}).update(dict.fromkeys(use.due))
    jobs = {
        use.file: Job(use.path, tuple(looks[use.file]), options)
        for use in reversed(due)
        if use.path is not None
    }
    converted: dict[tuple[str, str], Converted] = {}

    def ask(use: Use) -> Converted:
        if use.file not in converted:
            converted[use.file] = make(jobs[use.file])
        return converted[use.file]

    return ask


def make(job: Job) -> Converted:
    """A mesh in all its looks; raises MeshError."""
    from urdf2mbs.meshes.reader import read

    mesh = read(job.path, up_axis=job.options.up_axis == "apply")
    looks = {look: convert(mesh, look, job.options) for look in job.looks}
    return Converted(mesh.size, looks, mesh.textures)


def _links(conversion: Conversion) -> dict[str, list[str]]:
    """The links that show each mesh file."""
    links: dict[str, list[str]] = {}
    for link in conversion.robot.links.values():
        for visual in link.visuals:
            if isinstance(visual.geometry, urdf.Mesh):
                links.setdefault(visual.geometry.filename, []).append(link.name)
    return links


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


def _note_moved(conversion: Conversion) -> None:
    """Name the meshes that are elsewhere in the workspace than the URDF says."""
    moved = [
        f"'{name}' at {fitting[0]}"
        for name, fitting in conversion.packages.moved.items()
        if len(fitting) == 1
    ]
    if moved:
        conversion.note(
            "mesh-moved",
            f"{counted(len(moved), 'mesh')} not where the URDF says, but found elsewhere in the "
            f"workspace: {some(moved, 3)}",
        )


def _warn_of_lost(
    conversion: Conversion, lost: Lost, links: dict[str, list[str]], options: ConvertMeshes
) -> None:
    """Warn once for each reason, with the names of the meshes."""
    places = dict.fromkeys(place for places in lost.missing.values() for place in places)
    for code, meshes, what, hint in (
        (
            "mesh-missing", lost.missing, "not found",
            f"looked for {'it' if len(lost.missing) == 1 else 'them'} in: {some(places, 2)}",
        ),
        (
            "mesh-not-ours", lost.not_ours,
            "not converted, as a file of the name is there that urdf2mbs did not write, or that "
            "was changed since",
            f"move away: {some(lost.not_ours.values())}",
        ),
        (
            "mesh-too-large", lost.too_large,
            f"not converted: the files of all meshes are more than {options.at_most} MiB",
            f"'convert-meshes: {{at_most: {4 * options.at_most}}}' under 'passes' reads more, and "
            "takes up to 20 times the largest file's size in memory",
        ),
        (
            "mesh-unreadable", lost.unreadable, "cannot be used",
            some(lost.unreadable.values(), 3),
        ),
    ):  # fmt: skip
        if meshes:
            names = list(meshes)
            named = [
                f"'{name}' (link {links[name][0]}"
                + (f" and {len(links[name]) - 1} more)" if len(links[name]) > 1 else ")")
                for name in names
            ]
            text = f"{counted(len(names), 'mesh')} {what}: {some(named, 3)}"
            conversion.warn(code, text, link=links[names[0]][0], hint=hint)


def _warn_of_differences(
    conversion: Conversion, shown: dict[str, Made], links: dict[str, list[str]]
) -> None:
    """Warn of what the .wrl files, new or kept, do not show as the meshes do."""
    lost: dict[str, list[str]] = {}
    parts: dict[str, list[str]] = {}
    turned_up: list[str] = []
    for filename, made in shown.items():
        for problem in made.problems:
            parts.setdefault(problem, []).append(filename)
        for name, digest in made.sources.items():
            if digest is None:
                lost.setdefault(name, []).append(filename)
        if made.turned_up:
            turned_up.append(filename)
    for problem, meshes in parts.items():
        conversion.warn("mesh-part", f"{problem}: mesh {some(meshes)}", link=links[meshes[0]][0])
    if turned_up:
        conversion.warn(
            "mesh-up-axis",
            f"{counted(len(turned_up), 'mesh')} turned so that z is up, as asked; "
            f"RViz and Gazebo draw them unturned: {some(turned_up)}",
            link=links[turned_up[0]][0],
            hint="leave out 'up_axis: apply' to do as they do",
        )
    if lost:
        named = (f"'{name}' (of {some(meshes, 1)})" for name, meshes in lost.items())
        conversion.warn(
            "mesh-file-missing",
            f"{counted(len(lost), 'file')} that meshes name not found, relative to the mesh; "
            f"shown without: {some(named, 3)}",
        )


def convert(mesh: Mesh, look: Look, options: ConvertMeshes) -> tuple[Made, bytes]:
    """The whole .wrl, and what it was made from."""
    from urdf2mbs.meshes import vrml
    from urdf2mbs.meshes.model import turned

    parts = mesh.parts
    if look.mirror:
        import numpy as np

        signs = np.array([-1.0 if axis in look.mirror else 1.0 for axis in "xyz"])
        parts = [msgspec.structs.replace(part, points=part.points * signs) for part in parts]
        if len(look.mirror) % 2:
            parts = [turned(part) for part in parts]
    made = Made(
        VERSION, options.up_axis, look,
        {name: _digest(data) for name, data in mesh.sources.items()},
        list(mesh.textures), mesh.problems, mesh.turned_up,
    )  # fmt: skip
    r, g, b = (c / 255 for c in look.color)
    out = BytesIO()  # whose value is no copy of what is written
    out.write(BEGIN + msgspec.json.encode(made) + b"\n")
    out.writelines(vrml.write(parts, (r, g, b), look.transparency))
    return made, seal(Path("mesh.wrl"), out.getvalue())


def read_made(content: bytes) -> Made | None:
    """The sources of a .wrl; None if it is not ours, or if somebody has changed it since."""
    if not content.startswith(BEGIN) or not intact(content):
        return None
    try:
        return msgspec.json.decode(content[len(BEGIN) : content.find(b"\n", len(BEGIN))], type=Made)
    except (msgspec.MsgspecError, ValueError):
        return None


def is_current(made: Made, options: ConvertMeshes, look: Look, path: Path, folder: Path) -> bool:
    """True if the mesh file at ``path`` would give this .wrl again."""
    from urdf2mbs.meshes.model import read_beside

    return (
        (made.version, made.up_axis, made.look) == (VERSION, options.up_axis, look)
        and path.name in made.sources
        and all(digest == _digest(read_beside(path, name)) for name, digest in made.sources.items())
        and all(files.is_file(folder / name) for name in made.textures)
    )


def _digest(data: bytes | None) -> str | None:
    from hashlib import sha256  # its library takes as long to load as all our passes

    return None if data is None else sha256(data).hexdigest()
