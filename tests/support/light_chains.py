"""Chains of light links, which need short time steps."""

from pathlib import Path
from typing import Any

from support.folders import ROOT
from urdf2mbs import Result
from urdf2mbs.testing import convert_text

BIPED = ROOT / "configs" / "biped.urdf.xacro"


def link(name: str, mass: float, inertia: float, x: float = 0.0) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>'
        f'<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )


def joint(name: str, parent: str, child: str, rest: str, axis: str = "0 1 0") -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 -0.1"/><axis xyz="{axis}"/>{rest}</joint>'
    )


WIDE = '<limit lower="-2" upper="2" effort="0" velocity="1"/>'


def convert_project(text: str, folder: Path, **passes: Any) -> Result:
    return convert_text(text, output={"project": folder / "robot"}, passes=passes)


def messages(result: Result) -> dict[str, str]:
    return {diagnostic.code: diagnostic.message for diagnostic in result.diagnostics}
