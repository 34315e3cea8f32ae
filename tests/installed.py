"""The installable plugin of plugins/ as pip would leave it, without pip."""

from __future__ import annotations

from pathlib import Path

FOOT_CONTACTS = Path(__file__).resolve().parents[1] / "plugins" / "urdf2mbs-foot-contacts"


def install(project: Path, site: Path) -> Path:
    """Put a project's modules, and the entry points of its pyproject, into a folder."""
    text = (project / "pyproject.toml").read_text()
    section = text.partition("[project.entry-points.urdf2mbs]")[2].partition("[")[0]
    info = site / "urdf2mbs_foot_contacts-0.1.0.dist-info"
    info.mkdir(parents=True)
    for module in project.glob("*.py"):
        (site / module.name).write_text(module.read_text())
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: urdf2mbs-foot-contacts\nVersion: 0.1.0\n"
    )
    (info / "entry_points.txt").write_text(f"[urdf2mbs]\n{section.replace(chr(34), '')}")
    return site
