"""Chains of light links, which need short time steps."""

from pathlib import Path
from typing import Any

from support.build import joint, limit, link, solid
from support.folders import ROOT
from urdf2mbs import Result
from urdf2mbs.testing import convert_text

BIPED = ROOT / "configs" / "biped.urdf.xacro"


def light_link(name: str, mass: float, moment: float, x: float = 0.0) -> str:
    """Return a link whose centre of mass is at x (kg, kg m^2, m)."""
    return link(name, solid(mass, moment, xyz=f"{x} 0 0"))


def hinge(name: str, parent: str, child: str, content: str, axis: str = "0 1 0") -> str:
    """Return a revolute joint 0.1 m below its parent's frame."""
    return joint(parent, child, "revolute", content, xyz="0 0 -0.1", axis=axis, name=name)


WIDE = limit(-2, 2, effort=0)


def convert_project(text: str, folder: Path, **passes: Any) -> Result:
    return convert_text(text, output={"project": folder / "robot"}, passes=passes)


def messages(result: Result) -> dict[str, str]:
    return {diagnostic.code: diagnostic.message for diagnostic in result.diagnostics}
