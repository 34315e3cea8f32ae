"""The robots whose reports are tested, and a robot whose names want to break out."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from support.build import SOLID, joint, link, robot
from support.folders import CONFIGS, SHARED
from urdf2mbs import convert
from urdf2mbs.conversion import Conversion

ROBOTS = SHARED / "robots"

#: Name: source, base, folders of packages.
SHOWN: dict[str, tuple[Path, str, tuple[str, ...]]] = {
    "biped": (CONFIGS / "biped.urdf.xacro", "floating", ()),
    "atlas": (
        ROBOTS / "atlas/atlas_description/robots/atlas_v5.urdf.xacro",
        "floating",
        ("atlas/atlas_description", "atlas/multisense_sl_description"),
    ),
    "nao": (
        ROBOTS / "nao/nao_description/urdf/naoV50_generated_urdf/nao.urdf",
        "floating",
        ("nao/nao_description",),
    ),
    "leo": (
        ROBOTS / "leo_rover/leo_description/urdf/leo.urdf.xacro",
        "auto",
        ("leo_rover/leo_description",),
    ),
    "r2d2": (
        ROBOTS / "urdf_tutorial_r2d2/urdf_tutorial/urdf/07-physics.urdf",
        "fixed",
        ("urdf_tutorial_r2d2/urdf_tutorial",),
    ),
}


def run(source: Path, project: Path, packages: Iterable[str] = (), **more: Any) -> Conversion:
    """Convert into a project folder, writing nothing."""
    folders = {Path(name).name: ROBOTS / name for name in packages}
    return convert(source, output={"project": project}, packages=folders, **more).conversion


def shown(name: str, project: Path) -> Conversion:
    source, base, packages = SHOWN[name]
    return run(source, project, packages, base=base)


def data(conversion: Conversion) -> bytes:
    """Return the .mbs file."""
    return conversion.files[conversion.written]


def edit(conversion: Conversion, old: str, new: str) -> None:
    """Change the .mbs file where it first matches ``was``."""
    text, count = re.subn(old, new, data(conversion).decode(), count=1, flags=re.DOTALL)
    assert count
    conversion.files[conversion.settings.output] = text.encode()


EVIL = "</script><img src=x onerror='window.hacked=1'>&amp;\"<!--"

#: A robot with such names everywhere, in XML's own writing.
SHAPE = (
    '<visual name="{0}"><geometry><mesh filename="package://nowhere/{0}.stl"/></geometry></visual>'
)
HOSTILE = (
    robot(link("{0}"), link("b{0}", SOLID, SHAPE), joint("{0}", "b{0}", "revolute", name="j{0}"))
    .replace('"r"', '"{0}"')
    .replace("{0}", EVIL.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;"))
)
