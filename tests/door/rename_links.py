"""Rename links and joints by a table, and all that refers to them."""

from urdf2mbs.plugin import Conversion, Pass, hookimpl, rename_elements


class RenameLinks(Pass):
    """Rename links and joints by a table, and all that refers to them."""

    writes = ("robot",)

    links: dict[str, str] = {}
    """The new name of each link that gets one."""
    joints: dict[str, str] = {}
    """The new name of each joint that gets one."""

    def run(self, conversion: Conversion) -> None:
        rename_elements(conversion.robot, self.links, self.joints)
        number = len(self.links) + len(self.joints)
        conversion.note("renamed", f"{number} links and joints are renamed")


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [RenameLinks]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    return {"renamed": "note: links and joints are renamed."}
