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
            _repair_inertias(conversion)
        if self.density is not None or self.total_mass is not None:
            _estimate_inertias(conversion, self)


# --- repair ---


def _repair_inertias(conversion: Conversion) -> None:
    """Replace impossible inertias by the nearest possible ones, and report each change."""
    changes: dict[str, dict[str, Any]] = {}
    for link in conversion.robot.links.values():
        stated_inertial = link.inertial
        if stated_inertial is None:
            continue
        if (
            stated_inertial.mass >= 0.0
            and inertia.find_fault(stated_inertial.inertia, stated_inertial.mass) is None
        ):
            continue
        link.inertial, change_norm = find_nearest_inertia(stated_inertial)
        changes[link.name] = _describe_repair(stated_inertial, link.inertial, change_norm)
    if not changes:
        return
    for warning_code in IMPOSSIBLE:
        conversion.settle(warning_code)  # the warnings about the stated inertias no longer hold
    repaired_list = some(
        f"link '{link_name}' by {entry['moved']:.3g} kg m^2 ({100 * entry['moved_relative']:.3g} %)"
        + (f" and from {entry['mass'][0]:.6g} kg to 0" if entry["mass"][0] < 0.0 else "")
        for link_name, entry in changes.items()
    )
    conversion.warn(
        "inertia-repaired",
        f"{counted(len(changes), 'inertia')} that no body can have moved to the nearest possible "
        f"one: {repaired_list}",
        link=next(iter(changes)),
    )
    conversion.report["inertia-repair"] = changes


def _describe_repair(
    stated_inertial: Inertial, repaired_inertial: Inertial, change_norm: float
) -> dict[str, Any]:
    """Return the entry of a repaired link in the report: stated and repaired numbers.

    Args:
        stated_inertial: The inertia that no body can have.
        repaired_inertial: The nearest possible one.
        change_norm: The Frobenius norm of the change of the second moment (kg m^2).
    """
    stated_norm = sqrt(
        sum(
            second_moment * second_moment
            for second_moment in compute_second_moments(stated_inertial.inertia)
        )
    )
    return {
        "mass": [stated_inertial.mass, repaired_inertial.mass],
        "inertia": [stated_inertial.inertia, repaired_inertial.inertia],
        "principal_moments": [
            inertia.moments(stated_inertial.inertia),
            inertia.moments(repaired_inertial.inertia),
        ],
        "moved": change_norm,
        "moved_relative": change_norm / stated_norm if stated_norm else 0.0,
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


def _estimate_inertias(conversion: Conversion, options: EstimateInertia) -> None:
    """Give each link without inertia that of its shapes, at one density."""
    mesh_files = get_mesh_files(conversion)
    estimates = {
        link.name: _estimate_link(link, mesh_files)
        for link in conversion.robot.links.values()
        if link.massless and (link.collisions or link.visuals)
    }
    solid_by_link = {
        link_name: estimate.solid
        for link_name, estimate in estimates.items()
        if estimate.solid is not None and estimate.solid.volume > 0.0
    }
    if not solid_by_link:
        conversion.state(Estimates).links = []
        conversion.report["estimate-inertia"] = {"links": {}}
        conversion.warn(
            "nothing-estimated",
            "no link got an inertia: no link without one has a shape with a volume",
        )
        return
    density = options.density or _compute_density(
        conversion, solid_by_link, options.total_mass or 0.0
    )
    link_reports: dict[str, dict[str, Any]] = {}
    for link_name, solid in solid_by_link.items():
        xx, xy, xz, yy, yz, zz = inertia_tensor = [
            density * component for component in solid.inertia
        ]
        mass = density * solid.volume
        inertial = Inertial(mass, (xx, xy, xz, yy, yz, zz), Origin(solid.centre))
        conversion.robot.links[link_name].inertial = inertial
        link_reports[link_name] = {
            "from": estimates[link_name].source,
            "mass": mass,
            "centre": solid.centre,
            "inertia": inertia_tensor,
        }
    estimated_list = some(
        f"{link_name} {entry['mass']:.4g} kg ({entry['from']})"
        for link_name, entry in link_reports.items()
    )
    conversion.warn(
        "inertia-estimated",
        f"{counted(len(link_reports), 'link')} got an inertia, estimated at {density:.6g} kg/m^3: "
        f"{estimated_list}",
    )
    _warn_of_skipped_shapes(conversion, estimates, link_reports)
    conversion.state(Estimates).links = list(link_reports)
    conversion.report["estimate-inertia"] = {"density": density, "links": link_reports}


def _estimate_link(link: Link, mesh_files: MeshFiles) -> Estimate:
    """Return the geometry of a link as one solid, in the link's frame."""
    skipped_shapes: list[str] = []
    for source, shapes in (
        ("collision geometry", link.collisions),
        ("visual geometry", link.visuals),
    ):
        solids: list[Solid] = []
        for shape in shapes:
            geometry = shape.geometry
            shape_solid = compute_solid(geometry, mesh_files)
            if shape_solid is None:
                skipped_shapes.append(
                    geometry.filename if isinstance(geometry, Mesh) else "a shape"
                )
                continue
            solids.append(move_solid(shape_solid.solid, shape.origin.pose))
            if shape_solid.hull_of:
                source = f"convex hull of {shape_solid.hull_of}"
        if solids:
            if skipped_shapes:
                source += f", without {some(skipped_shapes, 2)}"
            return Estimate(Solid(*lump([*solids])), source, skipped_shapes)
    return Estimate(None, "", skipped_shapes)


def _compute_density(
    conversion: Conversion, solid_by_link: dict[str, Solid], total_mass: float
) -> float:
    """Compute the density (kg/m^3) at which the robot has a total mass (kg)."""
    links = conversion.robot.links.values()
    stated_mass = sum(link.inertial.mass for link in links if link.inertial and not link.massless)
    if stated_mass >= total_mass:
        raise ConfigError(
            "estimate-inertia",
            f"estimate-inertia: total_mass is {total_mass} kg, but the links that have a mass "
            f"already weigh {stated_mass:.6g} kg",
        )
    return (total_mass - stated_mass) / sum(solid.volume for solid in solid_by_link.values())


def _warn_of_skipped_shapes(
    conversion: Conversion, estimates: dict[str, Estimate], estimated_links: Container[str]
) -> None:
    """Warn of links some of whose shapes have no volume, and of links that got no inertia."""
    skipped_by_link = {
        link_name: estimate.skipped for link_name, estimate in estimates.items() if estimate.skipped
    }
    partial_links = [link_name for link_name in skipped_by_link if link_name in estimated_links]
    if partial_links:
        partial_list = some(
            [
                f"link '{link_name}' without '{some(skipped_by_link[link_name], 1)}'"
                for link_name in partial_links
            ],
            3,
        )
        conversion.warn(
            "inertia-partial",
            f"{counted(len(partial_links), 'inertia')} estimated without meshes that are missing, "
            f"unreadable or flat: {partial_list}",
            link=partial_links[0],
        )
    empty_links = [link_name for link_name in skipped_by_link if link_name not in estimated_links]
    if empty_links:
        empty_list = some(
            [
                f"link '{link_name}' ('{some(skipped_by_link[link_name], 1)}')"
                for link_name in empty_links
            ],
            3,
        )
        conversion.warn(
            "inertia-partial",
            f"{counted(len(empty_links), 'link')} got no inertia, as meshes are missing, "
            f"unreadable or flat: {empty_list}",
            link=empty_links[0],
        )
