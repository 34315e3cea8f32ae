"""What a page needs to let a robot move itself: equations in JavaScript, and the project's numbers.

The forces of ``NAME_robot.py`` are in live.js, too.  Code of others is in no page.
"""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from urdf2mbs.equations import generate
from urdf2mbs.project import starters
from urdf2mbs.runtime.data import MbsData
from urdf2mbs.runtime.python_code import load, loaded

#: The state at the start, and the arrays that equations read.
ARRAYS = ("q", "qd", "ux", "g", "m", "l", "In", "dpt", "lrod")


class NotLive(Exception):  # noqa: N818
    """The page cannot compute the motion of this model."""


def live(data: MbsData) -> tuple[dict[str, Any], str]:
    """The numbers, and the script.  Raises NotLive, which says why."""
    numbers = _numbers(data)
    loops = ("dirdyna", "cons_hJ", "cons_jdqd") if data.nqv else ()
    made = generate(
        data.mbs, data.model, data.mbs_file.name, language="javascript",
        functions=("accelred", "link", "extforces", *loops),
    )  # fmt: skip
    for why in made.left_out.values():
        raise NotLive(why)
    forces = [
        {"body": body.name, "at": point.coordinates}
        for body in data.mbs.bodies for point in body.points if point.extforce is not None
    ]  # fmt: skip
    values = {
        "arrays": {name: getattr(data, name).tolist() for name in ARRAYS},
        "model": data.user_model,
        "forces": [{"body": None, "at": (0.0, 0.0, 0.0)}, *forces],
        "independent": data.qu[1:].tolist(),
        **numbers,
    }
    head = '"use strict";\nconst equations = {};\nconst {sin, cos, sqrt} = Math;\n'
    own = files("urdf2mbs.report").joinpath("live.js").read_text("utf-8")
    return values, head + b"".join(made.files.values()).decode() + own


def _numbers(data: MbsData) -> dict[str, Any]:
    """Of NAME_robot.py: the tables by joint numbers, the direction up, and the time step (s)."""
    if not data.user_path.is_dir():
        return {"tables": {}, "up": (0.0, 0.0, 1.0), "step": 5e-4}
    own = data.user_path / f"{data.mbs_name}_robot.py"
    if not own.is_file():
        raise NotLive("its project is not in Python")
    for language in ("python", "c"):
        for name, text in starters(language, data.mbs_name).items():
            file = data.project / name
            is_used = name.startswith("userfctR/") and (language == "python" or file.is_file())
            if is_used and not (file.is_file() and file.read_bytes() == text):
                raise NotLive(f"'{file.name}' is not as urdf2mbs wrote it")
    with loaded(data):
        module = load(own)
        found = vars(module.look_up(data))
    if found["joint_laws"] or found["point_laws"]:
        raise NotLive("it has forces of plugins")
    tables = {
        name: list(table.items() if isinstance(table, dict) else table)
        for name, table in found.items() if isinstance(table, (list, dict, set))
    }  # fmt: skip
    return {"tables": tables, "up": module.UP, "step": module.TIME_STEP}
