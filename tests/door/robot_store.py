"""Find robots by name, as lab:NAME, in the folder of our lab: $LAB_ROBOTS."""

import os
from pathlib import Path

from urdf2mbs.plugin import ConfigError, Located, hookimpl, nearest, some


@hookimpl
def urdf2mbs_locate(source: str) -> Located | None:
    kind, _, name = source.partition(":")
    if kind != "lab":
        return None
    folder = os.environ.get("LAB_ROBOTS")
    if not folder:
        raise ConfigError("lab-store", "$LAB_ROBOTS is not set", hint="export LAB_ROBOTS=FOLDER")
    robots = {file.stem: file for file in sorted(Path(folder).rglob("*.urdf"))}
    if name not in robots:
        hint = nearest(name, robots) or f"there are: {some(robots) or 'none'}"
        raise ConfigError("lab-robot", f"'{folder}' has no robot '{name}'", hint=hint)
    return Located(robots[name], packages={"lab": Path(folder)}, xacro_args={})
