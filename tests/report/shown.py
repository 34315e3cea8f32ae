"""The robots whose reports are tested, and a robot whose names want to break out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from conftest import SHARED
from proving import SOLID, joint, link, robot

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.config import Config, Lines, typed
from urdf2mbs.engine.pipeline import Pipeline

ROBOTS = SHARED / "robots"
CONFIGS = Path(__file__).resolve().parents[2] / "configs"

#: Name: source, base, packages.
SHOWN: dict[str, tuple[Path, str, dict[str, Path]]] = {
    "biped": (CONFIGS / "biped.urdf.xacro", "floating", {}),
    "atlas": (
        ROBOTS / "atlas/atlas_description/robots/atlas_v5.urdf.xacro",
        "floating",
        {
            name: ROBOTS / "atlas" / name
            for name in ("atlas_description", "multisense_sl_description")
        },
    ),
    "nao": (
        ROBOTS / "nao/nao_description/urdf/naoV50_generated_urdf/nao.urdf",
        "floating",
        {"nao_description": ROBOTS / "nao/nao_description"},
    ),
    "leo": (
        ROBOTS / "leo_rover/leo_description/urdf/leo.urdf.xacro",
        "auto",
        {"leo_description": ROBOTS / "leo_rover/leo_description"},
    ),
    "r2d2": (
        ROBOTS / "urdf_tutorial_r2d2/urdf_tutorial/urdf/07-physics.urdf",
        "fixed",
        {"urdf_tutorial": ROBOTS / "urdf_tutorial_r2d2/urdf_tutorial"},
    ),
}


def run(
    source: Path,
    project: Path,
    *,
    base: str = "auto",
    packages: Mapping[str, Path] | None = None,
    **more: Any,
) -> Conversion:
    """Convert into a project folder, writing nothing."""
    given = {
        "source": str(source),
        "output": {"project": str(project)},
        "base": base,
        "packages": {name: str(path) for name, path in (packages or {}).items()},
        **more,
    }
    lines = Lines()
    return Pipeline(typed(Config, given, lines), lines, installed_plugins=False).run()


def shown(name: str, project: Path) -> Conversion:
    source, base, packages = SHOWN[name]
    return run(source, project, base=base, packages=packages)


def data(conversion: Conversion) -> bytes:
    """The .mbs file."""
    return conversion.files[conversion.rejected or conversion.settings.output]


EVIL = "</script><img src=x onerror='window.hacked=1'>&amp;\"<!--"

#: A robot with such names everywhere, in XML's own writing.
SHAPE = (
    '<visual name="{0}"><geometry><mesh filename="package://nowhere/{0}.stl"/></geometry></visual>'
)
HOSTILE = robot(
    link("{0}"), link("b{0}", SOLID, SHAPE), joint("{0}", "b{0}", "revolute", name="j{0}")
).replace('"r"', '"{0}"').replace(
    "{0}", EVIL.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
)  # fmt: skip
