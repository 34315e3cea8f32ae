"""A conversion of a robot that is nothing but mesh visuals, up to and with convert-meshes."""

from pathlib import Path

from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion, Segment, Settings
from urdf2mbs.engine.output import write_files
from urdf2mbs.mbs.model import Body
from urdf2mbs.passes import convert_visuals
from urdf2mbs.spatial import HERE
from urdf2mbs.urdf.model import Link, Material, Mesh, Robot, Visual
from urdf2mbs_meshes.passes import convert_meshes


def visual(
    filename: str | Path,
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0),
    color: tuple[float, float, float, float] | None = None,
) -> Visual:
    return Visual(Mesh(str(filename), scale), material=Material(color=color))


def convert(
    folder: Path,
    *links: list[Visual],
    packages: dict[str, Path] | None = None,
    options: convert_meshes.ConvertMeshes | None = None,
    project: bool = True,
) -> Conversion:
    """Link n is called ``link{n}`` and has the visuals ``links[n]``; nothing is written."""
    root = folder / "project"
    settings = Settings(
        source=folder / "robot.urdf",
        output=root / "dataR" / "robot.mbs",
        config=Config(source="robot.urdf"),
        packages=packages or {},
        project=root if project else None,
    )
    conversion = Conversion(settings)
    robot = {f"link{n}": Link(f"link{n}", visuals=visuals) for n, visuals in enumerate(links)}
    conversion.robot = Robot("robot", robot)
    body = Body("ground")
    conversion.segments["ground"] = Segment("ground", None, [], dict.fromkeys(robot, HERE), body)
    convert_visuals.ConvertVisuals().run(conversion)
    (options or convert_meshes.ConvertMeshes()).run(conversion)
    return conversion


def write(conversion: Conversion) -> list[Path]:
    """Write the files of a conversion, as the command line does at the end."""
    write_files(conversion.files)
    return list(conversion.files)


def codes(conversion: Conversion) -> list[str]:
    return [
        diagnostic.code for diagnostic in conversion.diagnostics if diagnostic.level == "warning"
    ]
