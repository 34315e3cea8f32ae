"""Estimate inertia: links without any get one from their geometry, if a density or mass is given.

Beyond the method, which neglects such links.  A mesh that is missing, unreadable or flat has no
volume, and the link's other shapes count alone.  Where no shape has a volume, rods of
``rod_radius`` from the link's origin to the joints that it carries stand in for the link, or a ball
if it carries none.  ``repair`` replaces each inertia that no body can have by the nearest possible
inertia (``nearest`` defines the distance).
"""

from __future__ import annotations

from math import hypot, pi, sqrt
from pathlib import Path
from typing import Annotated, Any

import msgspec

from urdf2mbs.plugin import (
    ZERO,
    Box,
    Capsule,
    ConfigError,
    Conversion,
    Cylinder,
    Estimates,
    Geometry,
    Inertial,
    Link,
    Mesh,
    Origin,
    Pass,
    Pose,
    PositiveLength,
    Sphere,
    Sym,
    Vec,
    compose,
    counted,
    inertia,
    lump,
    rotate_inertia,
    some,
    unit,
)
from urdf2mbs.plugin import UrdfJoint as Joint
from urdf2mbs_inertia.nearest import nearest, second_moments
from urdf2mbs_meshes.files import MeshFiles, get_mesh_files

#: A solid of density 1 kg/m^3: its volume (m^3), centre (m) and inertia about it (m^5).
Solid = tuple[float, Vec, Sym]


class Estimate(msgspec.Struct):
    """What the shapes of a link give."""

    solid: Solid
    means: str
    """Where the solid comes from, in words."""
    without: list[str] = []
    """Shapes without a volume, beside others that have one."""


class EstimateInertia(Pass):
    reads = ("robot",)
    writes = ("robot",)

    density: Annotated[float, msgspec.Meta(gt=0.0, le=1e6)] | None = None
    """kg/m^3 of every link that has no inertia of its own."""
    total_mass: Annotated[float, msgspec.Meta(gt=0.0, le=1e9)] | None = None
    """kg of the whole robot: what its own inertias leave is shared out by volume."""
    rod_radius: PositiveLength = 0.05
    """m; of the rods that stand in for meshes that cannot be read."""
    repair: bool = False
    """Replace inertias that no body can have by the nearest ones."""

    def run(self, conversion: Conversion) -> None:
        if self.repair:
            _repair(conversion)
        _estimate(conversion, self)


#: The reader's warnings about an inertia that no body can have.
IMPOSSIBLE = ("inertia-indefinite", "inertia-triangle", "mass-negative")


def _repair(conversion: Conversion) -> None:
    repaired: dict[str, dict[str, Any]] = {}
    for link in conversion.robot.links.values():
        old = link.inertial
        if old is None or (old.mass >= 0.0 and inertia.find_fault(old.inertia, old.mass) is None):
            continue
        link.inertial, moved = nearest(old)
        size = sqrt(sum(value * value for value in second_moments(old.inertia)))
        repaired[link.name] = {
            "mass": [old.mass, link.inertial.mass],
            "inertia": [old.inertia, link.inertial.inertia],
            "principal_moments": [
                inertia.moments(old.inertia), inertia.moments(link.inertial.inertia),
            ],
            "moved": moved,
            "moved_relative": moved / size if size else 0.0,
        }  # fmt: skip
    if not repaired:
        return
    # the warnings about these inertias no longer hold
    for code in IMPOSSIBLE:
        conversion.settle(code)
    listed = some(
        f"link '{name}' by {link['moved']:.3g} kg m^2 ({100 * link['moved_relative']:.3g} %)"
        + (f" and from {link['mass'][0]:.6g} kg to 0" if link["mass"][0] < 0.0 else "")
        for name, link in repaired.items()
    )
    conversion.warn(
        "inertia-repaired",
        f"{counted(len(repaired), 'inertia')} that no body can have moved to the nearest possible "
        f"one: {listed}",
        link=next(iter(repaired)),
    )
    conversion.report["inertia-repair"] = repaired


def _estimate(conversion: Conversion, options: EstimateInertia) -> None:
    if options.density is None and options.total_mass is None:
        return
    if options.density is not None and options.total_mass is not None:
        what = "estimate-inertia has both a density and a total_mass: give one"
        raise ConfigError("estimate-inertia", what)
    estimates: dict[str, Estimate] = {}
    children = conversion.robot.children()
    for link in conversion.robot.links.values():
        if link.massless and (link.collisions or link.visuals):
            estimate = _solid(link, children[link.name], get_mesh_files(conversion), options)
            if estimate.solid[0] > 0.0:
                estimates[link.name] = estimate
    if not estimates:
        conversion.state(Estimates).links = []
        conversion.report["estimate-inertia"] = {"links": {}}
        conversion.warn(
            "nothing-estimated",
            "no link got an inertia: no link without one has a shape with a volume",
        )
        return
    density = options.density or _density(conversion, estimates, options.total_mass or 0.0)
    links: dict[str, dict[str, Any]] = {}
    for name, estimate in estimates.items():
        volume, centre, tensor = estimate.solid
        xx, xy, xz, yy, yz, zz = moments = [density * c for c in tensor]
        mass = density * volume
        inertial = Inertial(mass, (xx, xy, xz, yy, yz, zz), Origin(centre))
        conversion.robot.links[name].inertial = inertial
        links[name] = {
            "from": estimate.means,
            "mass": mass,
            "centre": centre,
            "inertia": moments,
        }
    listed = some(f"{n} {link['mass']:.4g} kg ({link['from']})" for n, link in links.items())
    conversion.warn(
        "inertia-estimated",
        f"{counted(len(links), 'link')} got an inertia, estimated at {density:.6g} kg/m^3: "
        f"{listed}",
    )
    _warn_of_partial_estimates(conversion, estimates)
    conversion.state(Estimates).links = list(links)
    conversion.report["estimate-inertia"] = {"density": density, "links": links}


def _warn_of_partial_estimates(conversion: Conversion, estimates: dict[str, Estimate]) -> None:
    """Name the links some of whose shapes have no volume."""
    partial = [name for name, estimate in estimates.items() if estimate.without]
    if partial:
        named = [f"link '{name}' without '{some(estimates[name].without, 1)}'" for name in partial]
        message = (
            f"{counted(len(partial), 'inertia')} estimated without meshes that are missing, "
            f"unreadable or flat: {some(named, 3)}"
        )
        conversion.warn("inertia-partial", message, link=partial[0])


def _density(conversion: Conversion, estimates: dict[str, Estimate], total_mass: float) -> float:
    links = conversion.robot.links.values()
    known = sum(link.inertial.mass for link in links if link.inertial and not link.massless)
    if known >= total_mass:
        raise ConfigError(
            "estimate-inertia",
            f"estimate-inertia: total_mass is {total_mass} kg, but the links that have a mass "
            f"already weigh {known:.6g} kg",
        )
    return (total_mass - known) / sum(estimate.solid[0] for estimate in estimates.values())


def _solid(link: Link, onward: list[Joint], files: MeshFiles, options: EstimateInertia) -> Estimate:
    """Return a link's geometry as one solid in the link's frame."""
    means = "collision geometry" if link.collisions else "visual geometry"
    solids: list[Solid] = []
    without: list[str] = []
    for shape in link.collisions or link.visuals:
        found = _of_geometry(shape.geometry, files)
        if found is None:
            geometry = shape.geometry
            without.append(geometry.filename if isinstance(geometry, Mesh) else "a shape")
            continue
        (volume, centre, tensor), how = found
        pose = shape.origin.pose
        at = compose(pose, Pose(centre)).xyz
        solids.append((volume, at, rotate_inertia(pose.rot, tensor)))
        means = how or means
    if not solids:
        rods, kind = _rods(onward, options.rod_radius)
        return Estimate(rods, f"{kind}: {without[0]} gives no volume")
    if without:
        means += f", without {some(without, 2)}"
    return Estimate(lump(solids), means, without)


def _of_geometry(geometry: Geometry, files: MeshFiles) -> tuple[Solid, str | None] | None:
    if isinstance(geometry, Box):
        return _box(geometry.size), None
    if isinstance(geometry, Cylinder):
        return _cylinder(geometry.radius, geometry.length), None
    if isinstance(geometry, Capsule):
        return _capsule(geometry.radius, geometry.length), None
    if isinstance(geometry, Sphere):
        return _ball(geometry.radius), None
    path = files.find(geometry.filename)
    return None if path is None else _of_mesh(path, geometry.scale)


def _box(size: Vec) -> Solid:
    x, y, z = size
    v = x * y * z
    tensor = (v * (y * y + z * z) / 12, 0.0, 0.0, v * (x * x + z * z) / 12, 0.0,
              v * (x * x + y * y) / 12)  # fmt: skip
    return v, ZERO, tensor


def _cylinder(r: float, h: float) -> Solid:
    v = pi * r * r * h
    across = v * (3 * r * r + h * h) / 12
    return v, ZERO, (across, 0.0, 0.0, across, 0.0, v * r * r / 2)


def _capsule(r: float, h: float) -> Solid:
    """Return a cylinder of the radius r and the length h (m) with two hemispheres.

    The centre of a hemisphere is 3/8 r from its plane, about which its moment across is 2/5 m r^2:
    the same as a half of that of the ball.
    """
    cylinder, (_, _, ball) = _cylinder(r, h), _ball(r)
    volume = 4 / 3 * pi * r**3  # of both hemispheres
    shift = volume * (h * h / 4 + 3 / 8 * r * h)
    across, along = cylinder[2][0] + ball[0] + shift, cylinder[2][5] + ball[5]
    return cylinder[0] + volume, ZERO, (across, 0.0, 0.0, across, 0.0, along)


def _ball(r: float) -> Solid:
    v = 4 / 3 * pi * r**3
    return v, ZERO, (0.4 * v * r * r, 0.0, 0.0, 0.4 * v * r * r, 0.0, 0.4 * v * r * r)


def _of_mesh(path: Path, scale: Vec) -> tuple[Solid, str | None] | None:
    """By the divergence theorem over the triangles (trimesh's ``mass_properties``)."""
    from urdf2mbs_meshes.model import MeshError
    from urdf2mbs_meshes.reader import read_mesh

    try:
        mesh = read_mesh(path)
    except MeshError:
        return None
    import numpy as np
    import trimesh

    corners = np.concatenate([part.points[part.triangles] for part in mesh.parts])
    surface = trimesh.Trimesh(**trimesh.triangles.to_kwargs(corners * np.asarray(scale)))  # type: ignore[no-untyped-call]
    surface.merge_vertices()
    surface.update_faces(surface.nondegenerate_faces())
    triangles, how = surface.triangles, None
    if not (surface.is_watertight and surface.is_winding_consistent):
        triangles, how = _convex_hull(surface.vertices), f"convex hull of {path.name}"
        if triangles is None:
            return None
    with np.errstate(all="ignore"):  # what is flat has no centre
        properties: Any = trimesh.triangles.mass_properties(triangles)
        if properties.volume < 0.0:  # inside out, or mirrored by its scale
            properties = trimesh.triangles.mass_properties(triangles[:, ::-1])
    if not properties.volume > 0.0:
        return None
    x, y, z = properties.center_mass.tolist()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = properties.inertia.tolist()
    return (float(properties.volume), (x, y, z), (xx, xy, xz, yy, yz, zz)), how


def _convex_hull(points: Any) -> Any:
    """The triangles (n, 3, 3) round points (n, 3), outward; None where all lie in a plane."""
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    triangles = points[hull.simplices]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = (normals * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def _rods(joints: list[Joint], radius: float) -> tuple[Solid, str]:
    ends = [joint.origin.xyz for joint in joints if hypot(*joint.origin.xyz) > radius]
    rods: list[Solid] = []
    for x, y, z in ends:
        volume, _, (across, _, _, _, _, along) = _cylinder(radius, hypot(x, y, z))
        u, v, w = unit((x, y, z))
        d = along - across
        tensor = (
            across + d * u * u, d * u * v, d * u * w, across + d * v * v, d * v * w,
            across + d * w * w,
        )  # fmt: skip
        rods.append((volume, (x / 2, y / 2, z / 2), tensor))
    return (lump(rods), "rods") if rods else (_ball(radius), "a ball")
