"""``<link>`` and its ``<inertial>``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.spatial import NO_INERTIA
from urdf2mbs.urdf import inertia
from urdf2mbs.urdf.elements import ELEMENTS, MOMENTS
from urdf2mbs.urdf.model import Inertial, Link
from urdf2mbs.urdf.shapes import read_collision, read_visual

if TYPE_CHECKING:
    from urdf2mbs.spatial import Sym
    from urdf2mbs.urdf.model import Collision, Visual
    from urdf2mbs.urdf.values import Reading

HINT_REPAIR = "estimate-inertia: {repair: true} takes the nearest that a body can have"


def read_link(reading: Reading, element: Any, links: dict[str, Link]) -> None:
    """Add the inertial, visuals and collisions of a ``<link>`` to ``links``.

    Args:
        reading: The file being read.
        element: The element of lxml.
        links: The links that were read before, by name.

    Raises:
        ConversionError: The link has no name, the name of another link, or no readable inertial.
    """
    link_name = reading.name(element, "link", links)
    if link_name is None:
        return
    if len(element.attrib) != 1:
        reading.unknown_attributes(element)
    inertial_element: Any = None
    visuals: list[Visual] = []
    collisions: list[Collision] = []
    unknown_children: list[Any] = []
    for child in element[:]:
        child_tag = child.tag
        if child_tag == "visual":
            read_visual(reading, child, visuals)
        elif child_tag == "collision":
            read_collision(reading, child, collisions)
        elif child_tag == "inertial" and inertial_element is not None:
            reading.warn_of_double("link", child)
        elif child_tag == "inertial":
            inertial_element = child
        elif child_tag != "contact":  # of Bullet, which plugins read
            unknown_children.append(child)
    if unknown_children:
        reading.unknown_children("link", unknown_children, ELEMENTS["link"].children)
    inertial = None if inertial_element is None else read_inertial(reading, inertial_element)
    links[link_name] = Link(link_name, inertial, visuals, collisions, element.sourceline)


def read_inertial(reading: Reading, element: Any) -> Inertial | None:
    """Return an ``<inertial>``: mass (kg), and inertia (kg m^2) about the origin, in its axes.

    Returns:
        None, after a warning, if the element has no mass.

    Raises:
        ConversionError: A number is missing, or cannot be read.
    """
    reading.values(element)
    children = reading.parts(element)
    origin = reading.origin(children.get("origin"))
    mass_element, inertia_element = children.get("mass"), children.get("inertia")
    inertial_line = element.sourceline
    if mass_element is None:
        message = "<inertial> without <mass> is not used, as in ROS: no mass, no inertia"
        reading.warn("inertial-incomplete", message, inertial_line)
        return None
    mass: float = reading.values(mass_element)["value"]
    if mass < 0.0:
        message = "no body has a mass below zero; it is kept"
        detail, mass_line = f"{mass!r} kg", mass_element.sourceline
        reading.warn("mass-negative", message, mass_line, detail=detail, hint=HINT_REPAIR)
    if inertia_element is None or not inertia_element.attrib:
        if inertia_element is not None:
            reading.unknown_children("inertia", inertia_element, ())
        missing_part = "<inertia>" if inertia_element is None else "the attributes of <inertia>"
        message = f"<inertial> without {missing_part}: mass, but no inertia, as in ROS"
        reading.warn("inertial-incomplete", message, inertial_line)
        return Inertial(mass, NO_INERTIA, origin)
    tensor = read_inertia(reading, inertia_element)
    if tensor != NO_INERTIA:
        check_inertia(reading, tensor, mass, inertia_element)
        if mass == 0.0:
            reading.warn("inertia-without-mass", "inertia, but no mass; it is kept", inertial_line)
    elif mass > 0.0:
        reading.warn("mass-without-inertia", "mass, but no inertia", inertial_line, level="note")
    return Inertial(mass, tensor, origin)


def read_inertia(reading: Reading, element: Any) -> Sym:
    """Return an inertia (kg m^2); products that are missing are zero, with a warning."""
    values = reading.values(element)
    missing_products = [
        moment_name for moment_name in ("ixy", "ixz", "iyz") if moment_name not in values
    ]
    if missing_products:
        message = "<inertia> has not all products of inertia; those missing are zero"
        detail = ", ".join(missing_products)
        reading.warn("inertia-incomplete", message, element.sourceline, detail=detail)
    xx, xy, xz, yy, yz, zz = (values.get(moment_name, 0.0) for moment_name in MOMENTS)
    return (xx, xy, xz, yy, yz, zz)


def check_inertia(reading: Reading, tensor: Sym, mass: float, element: Any) -> None:
    """Warn of an inertia (kg m^2, about the centre of mass) that no body has."""
    fault = inertia.find_fault(tensor, mass)
    if fault is None:
        return
    reason = "one principal moment exceeds the sum of the others"
    if fault.code == "inertia-indefinite":
        reason = "a principal moment is below zero"
    moments = ", ".join(f"{moment:.6g}" for moment in fault.moments)
    reading.warn(
        fault.code,
        f"no body has this inertia, as {reason}; it is kept",
        element.sourceline,
        detail=f"principal moments {moments} kg m^2",
        hint=f"check that it is about the centre of mass, and its signs; {HINT_REPAIR}",
    )
