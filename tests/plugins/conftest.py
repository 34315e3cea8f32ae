from __future__ import annotations

from pathlib import Path

import pytest

PLUGINS = Path(__file__).resolve().parents[2] / "plugins"


@pytest.fixture
def foot_contacts_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The installable plugin as pip would leave it: its module and what its pyproject says."""
    project = PLUGINS / "urdf2mbs-foot-contacts"
    monkeypatch.syspath_prepend(_install(project, tmp_path / "site-packages"))


def _install(project: Path, site: Path) -> Path:
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
