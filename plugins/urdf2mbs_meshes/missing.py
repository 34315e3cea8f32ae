"""Warns of the meshes of a robot whose files do not exist.  No mesh is read."""

from __future__ import annotations

from collections.abc import Collection

from urdf2mbs.plugin import Collision, Conversion, Mesh, Robot, Visual, counted, some
from urdf2mbs_meshes.files import get_mesh_files


def list_links_of_meshes(robot: Robot) -> dict[str, list[str]]:
    """Return the mesh files of visuals and collisions, each with the links that show it."""
    links: dict[str, dict[str, None]] = {}
    for link in robot.links.values():
        shapes: list[Visual | Collision] = [*link.visuals, *link.collisions]
        for shape in shapes:
            if isinstance(shape.geometry, Mesh):
                links.setdefault(shape.geometry.filename, {})[link.name] = None
    return {filename: [*link_names] for filename, link_names in links.items()}


def warn_of_missing_meshes(
    conversion: Conversion, consequence: str = "", *, made_by_hand: Collection[str] = ()
) -> None:
    """Warn once of all meshes that are not found, with their links.

    Args:
        conversion: The conversion, whose robot has been read.
        consequence: What the conversion does without the meshes, for the message.
        made_by_hand: Meshes that need no file, since the user made their .wrl.
    """
    files = get_mesh_files(conversion)
    missing = {
        filename: links
        for filename, links in list_links_of_meshes(conversion.robot).items()
        if filename not in made_by_hand and files.find(filename) is None
    }
    if not missing:
        return
    meshes = [format_mesh(filename, links) for filename, links in missing.items()]
    remedies = list(dict.fromkeys(map(files.suggest_remedy, missing)))
    message = f"{counted(len(missing), 'mesh')} not found{consequence}: {some(meshes, 3)}"
    first_link = next(iter(missing.values()))[0]
    conversion.warn("mesh-missing", message, link=first_link, hint=some(remedies, 2))


def format_mesh(filename: str, links: list[str]) -> str:
    """Return a mesh and its links for a message: ``'arm.stl' (link arm and 2 more)``."""
    more = f" and {len(links) - 1} more" if len(links) > 1 else ""
    return f"'{filename}' (link {links[0]}{more})"
