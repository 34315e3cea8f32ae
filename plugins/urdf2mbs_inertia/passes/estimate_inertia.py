"""Estimate inertia: links without any get one from their geometry, if a density or mass is given.

Beyond the method, which neglects such links.  The geometry is that of collisions, or that of
visuals if no collision shape has a volume.  A mesh that is missing, unreadable or flat has no
volume: the estimate is that of the link's other shapes, and a link without others gets none.

``repair`` replaces each inertia that no body can have by the nearest possible inertia
(``urdf2mbs_inertia.nearest`` defines the distance).
"""

from __future__ import annotations

from collections.abc import Container
from math import sqrt
from typing import Annotated, Any

import msgspec

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    Estimates,
    Inertial,
    Link,
    Mesh,
    Origin,
    Pass,
    counted,
    inertia,
    lump,
    some,
)
from urdf2mbs_inertia.nearest import compute_second_moments, find_nearest_inertia
from urdf2mbs_inertia.solids import Solid, compute_solid, move_solid
from urdf2mbs_meshes.files import MeshFiles, get_mesh_files

#: The reader's warnings about an inertia that no body can have.
IMPOSSIBLE = ("inertia-indefinite", "inertia-triangle", "mass-negative")


class EstimateInertia(Pass):
    """Give links without inertia the inertia of their geometry, and repair impossible ones."""

    reads = ("robot",)
    writes = ("robot",)

    density: Annotated[float, msgspec.Meta(gt=0.0, le=1e6)] | None = None
    """kg/m^3 of every link that has no inertia of its own."""
    total_mass: Annotated[float, msgspec.Meta(gt=0.0, le=1e9)] | None = None
    """kg of the whole robot: what its own inertias leave is shared out by volume."""
    repair: bool = False
    """Replace inertias that no body can have by the nearest ones."""

    def run(self, conversion: Conversion) -> None:
        """Repair the inertias that the robot has, then estimate those that it lacks."""
        if self.density is not None and self.total_mass is not None:
            message = "estimate-inertia has both a density and a total_mass: give one"
            raise ConfigError("estimate-inertia", message)
        if self.repair:
            _repair(conversion)
        if self.density is not None or self.total_mass is not None:
            _estimate(conversion, self)


# --- repair ---


def _repair(conversion: Conversion) -> None:
    """Replace impossible inertias by the nearest possible ones, and report each change."""
    changes: dict[str, dict[str, Any]] = {}
    for link in conversion.robot.links.values():
        stated = link.inertial
        if stated is None:
            continue
        if stated.mass >= 0.0 and inertia.find_fault(stated.inertia, stated.mass) is None:
            continue
        link.inertial, change = find_nearest_inertia(stated)
        changes[link.name] = _describe_repair(stated, link.inertial, change)
    if not changes:
        return
    for code in IMPOSSIBLE:
        conversion.settle(code)  # the warnings about the stated inertias no longer hold
    listed = some(
        f"link '{name}' by {link['moved']:.3g} kg m^2 ({100 * link['moved_relative']:.3g} %)"
        + (f" and from {link['mass'][0]:.6g} kg to 0" if link["mass"][0] < 0.0 else "")
        for name, link in changes.items()
    )
    conversion.warn(
        "inertia-repaired",
        f"{counted(len(changes), 'inertia')} that no body can have moved to the nearest possible "
        f"one: {listed}",
        link=next(iter(changes)),
    )
    conversion.report["inertia-repair"] = changes


def _describe_repair(stated: Inertial, repaired: Inertial, change: float) -> dict[str, Any]:
    """Return the entry of a repaired link in the report: stated and repaired numbers.

    Args:
        stated: The inertia that no body can have.
        repaired: The nearest possible one.
        change: The Frobenius norm of the change of the second moment (kg m^2).
    """
    norm = sqrt(sum(value * value for value in compute_second_moments(stated.inertia)))
    return {
        "mass": [stated.mass, repaired.mass],
        "inertia": [stated.inertia, repaired.inertia],
        "principal_moments": [inertia.moments(stated.inertia), inertia.moments(repaired.inertia)],
        "moved": change,
        "moved_relative": change / norm if norm else 0.0,
    }


# --- estimate ---


class Estimate(msgspec.Struct):
    """The solid that the shapes of a link make."""

    solid: Solid | None
    """None if no shape has a volume."""
    source: str
    """Where the solid comes from, for messages."""
    skipped: list[str]
    """Names of the shapes without a volume."""


def _estimate(conversion: Conversion, options: EstimateInertia) -> None:
    """Give each link without inertia that of its shapes, at one density."""
    files = get_mesh_files(conversion)
    estimates = {
        link.name: _estimate_link(link, files)
        for link in conversion.robot.links.values()
        if link.massless and (link.collisions or link.visuals)
    }
    solids = {
        name: estimate.solid
        for name, estimate in estimates.items()
        if estimate.solid is not None and estimate.solid.volume > 0.0
    }
    if not solids:
        conversion.state(Estimates).links = []
        conversion.report["estimate-inertia"] = {"links": {}}
        conversion.warn(
            "nothing-estimated",
            "no link got an inertia: no link without one has a shape with a volume",
        )
        return
    density = options.density or _compute_density(conversion, solids, options.total_mass or 0.0)
    links: dict[str, dict[str, Any]] = {}
    for name, solid in solids.items():
        xx, xy, xz, yy, yz, zz = tensor = [density * component for component in solid.inertia]
        mass = density * solid.volume
        inertial = Inertial(mass, (xx, xy, xz, yy, yz, zz), Origin(solid.centre))
        conversion.robot.links[name].inertial = inertial
        links[name] = {
            "from": estimates[name].source,
            "mass": mass,
            "centre": solid.centre,
            "inertia": tensor,
        }
    listed = some(f"{name} {link['mass']:.4g} kg ({link['from']})" for name, link in links.items())
    conversion.warn(
        "inertia-estimated",
        f"{counted(len(links), 'link')} got an inertia, estimated at {density:.6g} kg/m^3: "
        f"{listed}",
    )
    _warn_of_skipped_shapes(conversion, estimates, links)
    conversion.state(Estimates).links = list(links)
    conversion.report["estimate-inertia"] = {"density": density, "links": links}


def _estimate_link(link: Link, files: MeshFiles) -> Estimate:
    """Return the geometry of a link as one solid, in the link's frame."""
    skipped: list[str] = []
    for source, shapes in (
        ("collision geometry", link.collisions),
        ("visual geometry", link.visuals),
    ):
        solids: list[Solid] = []
        for shape in shapes:
            geometry = shape.geometry
            result = compute_solid(geometry, files)
            if result is None:
                skipped.append(geometry.filename if isinstance(geometry, Mesh) else "a shape")
                continue
            solids.append(move_solid(result.solid, shape.origin.pose))
            if result.hull_of:
                source = f"convex hull of {result.hull_of}"
        if solids:
            if skipped:
                source += f", without {some(skipped, 2)}"
            return Estimate(Solid(*lump([*solids])), source, skipped)
    return Estimate(None, "", skipped)


def _compute_density(conversion: Conversion, solids: dict[str, Solid], total_mass: float) -> float:
    """Compute the density (kg/m^3) at which the robot has a total mass (kg)."""
    links = conversion.robot.links.values()
    stated_mass = sum(link.inertial.mass for link in links if link.inertial and not link.massless)
    if stated_mass >= total_mass:
        raise ConfigError(
            "estimate-inertia",
            f"estimate-inertia: total_mass is {total_mass} kg, but the links that have a mass "
            f"already weigh {stated_mass:.6g} kg",
        )
    return (total_mass - stated_mass) / sum(solid.volume for solid in solids.values())


def _warn_of_skipped_shapes(
    conversion: Conversion, estimates: dict[str, Estimate], estimated_links: Container[str]
) -> None:
    """Warn of links some of whose shapes have no volume, and of links that got no inertia."""
    skipped = {name: link.skipped for name, link in estimates.items() if link.skipped}
    partial = [name for name in skipped if name in estimated_links]
    if partial:
        listed = some([f"link '{name}' without '{some(skipped[name], 1)}'" for name in partial], 3)
        conversion.warn(
            "inertia-partial",
            f"{counted(len(partial), 'inertia')} estimated without meshes that are missing, "
            f"unreadable or flat: {listed}",
            link=partial[0],
        )
    empty = [name for name in skipped if name not in estimated_links]
    if empty:
        listed = some([f"link '{name}' ('{some(skipped[name], 1)}')" for name in empty], 3)
        conversion.warn(
            "inertia-partial",
            f"{counted(len(empty), 'link')} got no inertia, as meshes are missing, unreadable or "
            f"flat: {listed}",
            link=empty[0],
        )
