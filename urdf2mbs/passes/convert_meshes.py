"""Convert meshes: the method's "simply needs to be converted (by the user)", done here.

Every mesh that a visual shows becomes a VRML97 file in the project's ``animationR/vrml``.  The
file holds the mesh in metres and z up; a shape's ``scale`` stays in the .mbs, except for its
signs: a mirrored mesh gets a file of its own, with the faces turned back, and its shape the
absolute values, so that no viewer has to know how to draw a mirrored transform.

A mesh that has no colour of its own takes the visual's.  A file is named after its mesh (the
stem that convert-visuals chose), ``_mirror_AXES`` where mirrored, ``_RRGGBB`` where another
visual shows the same mesh in another colour.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
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
    from concurrent.futures import Future

    from urdf2mbs.meshes.model import Mesh

#: Stands in every file that is written; a new number makes all files anew.
VERSION = 3

#: How our files begin; then comes what each was made from.
BEGIN = b"#VRML V2.0 utf8\n# "

#: So many bytes of mesh files are worth a process: they take a second or two, and so does a start
#: on a machine that is busy.
WORTH = 48 * 2**20


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
                    f"{counted(len(conversion.meshes), 'mesh file')} left as they are: the .mbs "
                    "names the .wrl files that 'output: {project: DIR}' makes of them",
                )
            return
        from urdf2mbs.meshes.model import MeshError

        folder = settings.project / "animationR" / "vrml"
        uses = _uses(conversion)
        links = _links(conversion)
        names = _name_files(conversion.meshes, uses)
        told: dict[str, Made] = {}
        lost = Lost()
        left = self.at_most * 2**20
        counts = {"converted": 0, "kept": 0, "unusable": 0, "bytes": 0}
        paths = {filename: conversion.packages.resolve(filename) for filename in uses}
        there = _there(uses, names, paths, folder, self)
        made_anew = _made_anew(uses, paths, there, self)
        for number, (filename, looks) in enumerate(uses.items(), start=1):
            conversion.progress(f"{filename} ({number} of {len(uses)})")
            path = paths[filename]
            if path is None:
                counts["unusable"] += 1
                lost.missing[filename] = conversion.packages.looked(filename)
                continue
            mesh: Converted | None = None
            for look, shapes in looks.items():
                target = folder / f"{names[filename, look]}.wrl"
                old = there[filename, look]
                if old is not None and old.made is None:
                    lost.not_ours[filename] = str(target)
                elif old is not None and old.made is not None and old.current:
                    counts["kept"] += 1
                    counts["bytes"] += old.size
                    told[filename] = old.made
                else:
                    if mesh is None:
                        if files.size(path) > left:
                            counts["unusable"] += 1
                            lost.too_large[filename] = f"{files.size(path) / 2**20:.3g} MiB"
                            break
                        try:
                            mesh = made_anew(filename)
                            left -= mesh.size
                        except MeshError as error:
                            counts["unusable"] += 1
                            lost.unreadable[filename] = f"{path}: {error}"
                            break
                    told[filename], content = mesh.looks[look]
                    for name, digest in told[filename].sources.items():
                        files.note(path.parent / name, digest)  # another process may have read it
                    conversion.files[target] = content
                    for name, image in mesh.textures.items():
                        if not files.is_file(folder / name):
                            conversion.files[folder / name] = image
                    counts["converted"] += 1
                    counts["bytes"] += len(content)
                for shape in shapes:
                    shape.url = f"{PurePosixPath(shape.url or '').parent}/{target.name}"
                    x, y, z = shape.scale
                    shape.scale = (abs(x), abs(y), abs(z))
        _tell_lost(conversion, lost, links, self)
        _tell(conversion, told, links)
        conversion.facts["convert-meshes"] = {
            "folder": str(folder), **counts,
            "lost": {
                kind: {name: {"links": links[name], "why": why} for name, why in files.items()}
                for kind, files in msgspec.structs.asdict(lost).items()
            },
        }  # fmt: skip


class Look(msgspec.Struct, frozen=True):
    """What a visual changes of its mesh: each different look needs a file of its own."""

    mirror: str
    """The axes that a negative scale mirrors: of "xyz"."""
    color: RGB
    transparency: float


class Made(msgspec.Struct, omit_defaults=True):
    """What a .wrl was made from: its second line."""

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


class Old(msgspec.Struct):
    """A .wrl that is there already."""

    size: int
    """Bytes."""
    made: Made | None
    """What it was made from; None: it is not ours."""
    current: bool
    """Whether its mesh would give it again."""


class Job(msgspec.Struct, frozen=True):
    """A mesh file, and the looks in which it is shown."""

    path: Path
    looks: tuple[Look, ...]
    options: ConvertMeshes


class Converted(msgspec.Struct):
    """What is made of a mesh file."""

    size: int
    """Bytes of all the files that it was read from."""
    looks: dict[Look, tuple[Made, bytes]]
    textures: dict[str, bytes]


def _uses(conversion: Conversion) -> dict[str, dict[Look, list[Shape]]]:
    """Every mesh that is shown, in each of its looks, and the shapes that show it."""
    filenames = {stem: filename for filename, stem in conversion.meshes.items()}
    uses: dict[str, dict[Look, list[Shape]]] = {}
    for segment in conversion.segments.values():
        for shape in segment.holder.shapes:
            if shape.kind != "inline" or not shape.url:
                continue
            filename = filenames.get(PurePosixPath(shape.url).stem)
            if filename is not None:
                mirror = "".join(a for a, s in zip("xyz", shape.scale, strict=True) if s < 0)
                look = Look(mirror, shape.color, shape.transparency)
                uses.setdefault(filename, {}).setdefault(look, []).append(shape)
    return uses


def _there(
    uses: dict[str, dict[Look, list[Shape]]],
    names: dict[tuple[str, Look], str],
    paths: dict[str, Path | None],
    folder: Path,
    options: ConvertMeshes,
) -> dict[tuple[str, Look], Old | None]:
    """The .wrl files that are there already, for each look of each mesh."""
    from urdf2mbs.meshes.model import read_beside

    there: dict[tuple[str, Look], Old | None] = {}
    for filename, looks in uses.items():
        path = paths[filename]
        for look in looks if path is not None else ():
            target = folder / f"{names[filename, look]}.wrl"
            content = read_beside(target, target.name)
            there[filename, look] = None
            if content is not None:
                made = made_from(content)
                current = (
                    made is not None
                    and path is not None
                    and is_current(made, options, look, path, folder)
                )
                there[filename, look] = Old(len(content), made, current)
    return there


def _made_anew(
    uses: dict[str, dict[Look, list[Shape]]],
    paths: dict[str, Path | None],
    there: dict[tuple[str, Look], Old | None],
    options: ConvertMeshes,
) -> Callable[[str], Converted]:
    """What gives the meshes that are made anew, asked in the order of ``uses``: each file is read
    once, under however many names the URDF has it, and on all cores where that pays."""
    files_of: dict[str, tuple[str, str]] = {}
    first: dict[tuple[str, str], Path] = {}
    wanted: dict[tuple[str, str], dict[Look, None]] = {}
    for filename, looks in uses.items():
        path = paths[filename]
        due = [look for look in looks if path is not None and _is_due(there[filename, look])]
        if path is not None and due:
            # a .wrl says the name of its mesh
            file = files_of[filename] = (os.path.realpath(path), path.name)
            first.setdefault(file, path)
            wanted.setdefault(file, {}).update(dict.fromkeys(due))
    jobs = [Job(first[file], tuple(looks), options) for file, looks in wanted.items()]
    coming = zip(wanted, _results(jobs), strict=True)
    asked = Counter(files_of.values())
    shared: dict[tuple[str, str], Converted] = {}

    def made_anew(filename: str) -> Converted:
        file = files_of[filename]
        if file in shared:
            return shared[file]
        # those before it that nobody asks for are too much
        result = next((result for one, result in coming if one == file), None)
        mesh = make(Job(first[file], tuple(wanted[file]), options)) if result is None else result()
        if asked[file] > 1:
            shared[file] = mesh
        return mesh

    return made_anew


def _is_due(old: Old | None) -> bool:
    """Whether a .wrl is to be made; one that is not ours is left alone."""
    return old is None or (old.made is not None and not old.current)


def _results(jobs: list[Job]) -> Iterator[Callable[[], Converted]]:
    """For each job in turn what gives its meshes, or raises MeshError."""
    from urdf2mbs.machine.processes import cores, each

    count = min(len(jobs), sum(files.size(job.path) for job in jobs) // WORTH)
    if count < 2 or (count := min(count, cores())) < 2:
        yield from (partial(make, job) for job in jobs)
        return
    for job, future in each(make, jobs, count, in_order=True):
        yield partial(_result, job, future)


def _result(job: Job, future: Future[Converted]) -> Converted:
    from urdf2mbs.meshes.model import MeshError

    try:
        return future.result()
    except MeshError:
        raise
    except Exception:  # again here, where it can be told, or there is more memory
        return make(job)


def make(job: Job) -> Converted:
    """A mesh in all its looks; raises MeshError."""
    from urdf2mbs.meshes.reader import read

    mesh = read(job.path, up_axis=job.options.up_axis == "apply")
    looks = {look: convert(mesh, look, job.options) for look in job.looks}
    return Converted(mesh.size, looks, mesh.textures)


def _links(conversion: Conversion) -> dict[str, list[str]]:
    """Which links show each mesh file."""
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


def _shown_by(links: list[str]) -> str:
    return f"link {links[0]}" + (f" and {len(links) - 1} more" if len(links) > 1 else "")


def _tell_lost(
    conversion: Conversion, lost: Lost, links: dict[str, list[str]], options: ConvertMeshes
) -> None:
    """One warning for each reason, which names all meshes that it concerns."""

    def warn(code: str, names: Iterable[str], what: str, hint: str | None = None) -> None:
        files = list(names)
        named = (f"'{name}' ({_shown_by(links[name])})" for name in files)
        conversion.warn(
            code,
            f"{counted(len(files), 'mesh')} {what}: {some(named, 3)}",
            link=links[files[0]][0],
            hint=hint,
        )

    if lost.missing:
        places = dict.fromkeys(place for looked in lost.missing.values() for place in looked)
        warn(
            "mesh-missing", lost.missing, "not found",
            f"looked for {'it' if len(lost.missing) == 1 else 'them'} in: {some(places, 8)}",
        )  # fmt: skip
    if lost.not_ours:
        warn(
            "mesh-not-ours", lost.not_ours,
            "not converted, as a file of the name is there that urdf2mbs did not write, or that "
            "was changed since",
            f"move away: {some(lost.not_ours.values())}",
        )  # fmt: skip
    if lost.too_large:
        warn(
            "mesh-too-large", lost.too_large,
            f"not converted: the files of all meshes are more than {options.at_most} MiB",
            f"'convert-meshes: {{at_most: {4 * options.at_most}}}' under 'passes' reads more, and "
            "takes up to 20 times the largest file's size in memory",
        )  # fmt: skip
    if lost.unreadable:
        warn(
            "mesh-unreadable", lost.unreadable, "cannot be used",
            some(lost.unreadable.values(), 3),
        )  # fmt: skip


def _tell(conversion: Conversion, told: dict[str, Made], links: dict[str, list[str]]) -> None:
    """Warn of what the .wrl files do not show as the meshes do, new files and kept ones."""
    lost: dict[str, list[str]] = {}
    parts: dict[str, list[str]] = {}
    turned_up: list[str] = []
    for filename, made in told.items():
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
        named = (f"'{name}' (of {some(meshes, 3)})" for name, meshes in lost.items())
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


def made_from(content: bytes) -> Made | None:
    """What a .wrl was made from; None: it is not ours, or was changed by someone since."""
    if not content.startswith(BEGIN) or not intact(content):
        return None
    try:
        return msgspec.json.decode(content[len(BEGIN) : content.find(b"\n", len(BEGIN))], type=Made)
    except (msgspec.MsgspecError, ValueError):
        return None


def is_current(made: Made, options: ConvertMeshes, look: Look, path: Path, folder: Path) -> bool:
    """Whether the mesh file at ``path`` would give this .wrl again."""
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
