"""ROS packages in a folder of a test."""

from pathlib import Path


def package(folder: Path, name: str | None = None) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(
        '<?xml version="1.0"?>\n<!-- <name>wrong</name> -->\n<package format="3">\n'
        f"  <name> {name or folder.name} </name>\n  <maintainer>x</maintainer></package>"
    )
    return folder


def source(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder / "robot.urdf"
