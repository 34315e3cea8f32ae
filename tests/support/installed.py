"""A plugin of door/ as pip would leave it when installed, without pip."""

from pathlib import Path

from support.folders import TESTS

PLUGIN = TESTS / "door" / "rename_links.py"


def install(site: Path, text: str | None = None) -> Path:
    """Put the package ``renaming`` 0.1.0 with the plugin ``rename`` into a folder.

    ``text`` takes the place of the code of rename_links.py.
    """
    info = site / "renaming-0.1.0.dist-info"
    info.mkdir(parents=True)
    (site / "renaming.py").write_text(PLUGIN.read_text() if text is None else text)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: renaming\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text("[urdf2mbs]\nrename = renaming\n")
    return site


def install_file(site: Path, file: Path) -> Path:
    """Put a package of one file, which is the plugin of its name, into a folder."""
    name = file.stem
    info = site / f"{name}-0.1.0.dist-info"
    info.mkdir(parents=True)
    (site / file.name).write_text(file.read_text())
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text(f"[urdf2mbs]\n{name} = {name}\n")
    return site
