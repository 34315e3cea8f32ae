"""The real robots beside the checkout, as pytest parameters."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from support.folders import SHARED
from urdf2mbs import Result

FOLDER = SHARED / "robots"


@dataclass
class RealRobot:
    """``text`` is the file that a reference reads: of an xacro file, the expansion that lies
    beside it, made by xacro itself and not by ``urdf2mbs``."""

    name: str
    source: Path
    text: Path
    packages: dict[str, Path] = field(default_factory=dict)
    args: dict[str, str] = field(default_factory=dict)
    listed: bool = False
    """Whether it is an entry of the manifest."""

    def convert(self, **settings: Any) -> Result:
        from urdf2mbs import convert

        return convert(self.source, packages=self.packages, xacro_args=self.args, **settings)


#: What cannot be converted, by the end of its path, and why.
REFUSED = {
    "atlas_description/dummy.urdf": "no link",
    "multisense_sl_description/dummy.urdf": "no link",
    "bigman_upstream_fails": "a property is used before it is defined",
    **{
        f"atlas_description/urdf/atlas{name}.urdf": "a fragment: it names links it does not have"
        for name in (
            "",
            "_simple_shapes",
            "_v3",
            "_v3_simple_shapes",
            "_v3_with_v1_inertia",
            "_v4_no_wry2_simple_shapes",
            "_v4_simple_shapes",
            "_v5",
            "_v5_simple_shapes",
        )
    },
    "atlas_description/urdf/atlas_v4.urdf": "xacro expressions in what calls itself URDF",
    "atlas_description/urdf/atlas_v4_no_wry2.urdf": "xacro expressions in what calls itself URDF",
}


def _all() -> list[RealRobot]:
    if not FOLDER.is_dir():
        return []
    found: list[RealRobot] = []
    for robot in json.loads((FOLDER / "manifest.json").read_text()):
        folder = FOLDER / robot["robot"]
        for entry in robot["entries"]:
            source = folder / entry["file"]
            text = folder / entry["expanded"] if "expanded" in entry else source
            name = entry.get("name", source.name.split(".")[0])
            if name in {"nao", "model"}:
                name = source.parent.name
            if source.suffix == ".xacro" and name == robot["robot"]:
                name = source.name
            packages = {p: folder / path for p, path in entry.get("package_map", {}).items()}
            found.append(
                RealRobot(
                    f"{robot['robot']}-{name}", source, text, packages, entry.get("args", {}), True
                )
            )
    known = {robot.source for robot in found}
    for path in sorted(FOLDER.rglob("*")):
        plain = path.suffix.lower() == ".urdf" and "expanded" not in path.parts
        if plain and path not in known:
            inside = path.relative_to(FOLDER)
            found.append(RealRobot("-".join((*inside.parts[:2], path.name)), path, path))
    return found


def _refused(robot: RealRobot) -> str | None:
    for end, why in REFUSED.items():
        if robot.source.as_posix().endswith(end) or robot.name.endswith(end):
            return why
    return None


def _params(robots: list[RealRobot]) -> list[Any]:
    names: dict[str, int] = {}
    for robot in robots:
        names[robot.name] = names.get(robot.name, 0) + 1
        if names[robot.name] > 1:
            robot.name += f"-{names[robot.name]}"
    folders = [robot.source.relative_to(FOLDER).parts[0] for robot in robots]
    ends = {folders.index(name) for name in folders}
    ends |= {len(folders) - 1 - folders[::-1].index(name) for name in folders}
    return [
        pytest.param(robot, id=robot.name, marks=() if number in ends else pytest.mark.slow)
        for number, robot in enumerate(robots)
    ]


def or_skipped(params: list[Any]) -> list[Any]:
    """Return parameters; instead of none, one that pytest skips with the reason."""
    reason = f"the real robots are not here: {FOLDER} does not exist"
    return params or [pytest.param(None, id="none", marks=pytest.mark.skip(reason=reason))]


_ROBOTS = _all()
_CONVERTIBLE = _params([robot for robot in _ROBOTS if _refused(robot) is None])
#: Robots that convert: fast tests take the first and the last of each folder, as others are their
#: versions ...
CONVERTIBLE = or_skipped(_CONVERTIBLE)
#: ... and those that must be refused.
BROKEN = or_skipped(_params([robot for robot in _ROBOTS if _refused(robot) is not None]))
#: The robots that convert, without what pytest has to know of them.
REAL_ROBOTS: list[RealRobot] = [param.values[0] for param in _CONVERTIBLE]
