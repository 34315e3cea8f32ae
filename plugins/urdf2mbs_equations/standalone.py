"""``mbs_data.h`` of one model, for C without Robotran: plain arrays and the numbers of the .mbs."""

from __future__ import annotations

from collections.abc import Iterable

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations.c import PARAMETERS

#: The functions that need nothing but the data.
DECLARED = "".join(
    f"{'int' if name == 'accelred' else 'void'} mbs_{name}({PARAMETERS[name]});\n"
    for name in ("dirdyna", "invdyna", "accelred", "sensor", "gensensor", "energy", "momentum",
                 "com", "derivatives", "regressor")
)  # fmt: skip


def headers(mbs: Mbs) -> dict[str, str]:
    """The two headers that the equations of a model include."""
    joints = [joint for body in mbs.bodies for joint in body.joints]
    size = len(joints) + 1
    zeros = [0.0] * size
    mass, centre, inertia = zeros[:], [zeros[:] for _ in range(3)], [zeros[:] for _ in range(9)]
    number = 0
    for body in mbs.bodies:
        number += len(body.joints)
        mass[number] = body.mass or 0.0
        xx, xy, xz, yy, yz, zz = body.inertia or (0.0,) * 6
        elements = (xx, xy, xz, xy, yy, yz, xz, yz, zz)
        for rows, values in ((centre, body.com or (0.0,) * 3), (inertia, elements)):
            for row, value in zip(rows, values, strict=True):
                row[number] = value
    points = [point.coordinates for point in mbs.points().values()]
    places = [[0.0, *(point[k] for point in points)] for k in range(3)]
    rods = [0.0, *(cut.length or 0.0 for cut in mbs.cuts if cut.kind == "rod")]
    links = [0.0] * (1 + sum(link.kind == "link" for link in mbs.links))
    numbers = {"m": mass, "lrod": rods, "Z": links, "Zd": links, "Fl": links}
    tables = {"l": centre, "In": inertia, "dpt": places, "frc": [zeros] * 3, "trq": [zeros] * 3}
    start = [0.0, *(joint.q or 0.0 for joint in joints)]
    text = (
        "#ifndef MBS_DATA_h\n#define MBS_DATA_h\n\n"
        "/* All arrays count from 1: their element 0 is not used.  Units are m, kg, s, rad. */\n"
        f"enum {{MBS_JOINTS = {size - 1}}};\n\n"
        "typedef struct MbsData {\n"
        f"    double q[{size}], qd[{size}], qdd[{size}], Qq[{size}], g[4];\n"
        f"    double {', '.join(f'*{name}' for name in numbers)};\n"
        f"    double {', '.join(f'*{name}[{len(rows) + 1}]' for name, rows in tables.items())};\n"
        "    int flag_stop;\n} MbsData;\n\n"
        "typedef struct MbsSensor {\n"
        f"    double P[4], R[4][4], V[4], OM[4], A[4], OMP[4], J[7][{size}];\n}} MbsSensor;\n\n"
        "/* The model as its .mbs has it.  Copies share all that is behind a pointer. */\n"
        "static const MbsData mbs_model = {\n"
        f"    .q = {_list(start)},\n    .g = {_list([0.0, *mbs.base.gravity])},\n"
    )
    for name, row in numbers.items():
        text += f"    .{name} = {_array(row)},\n"
    for name, rows in tables.items():
        inner = "".join(f",\n        {_array(row)}" for row in rows)
        text += f"    .{name} = {{0{inner}}},\n"
    return {
        "mbs_data.h": f"{text}}};\n\n{DECLARED}#endif\n",
        "mbs_sensor.h": '#include "mbs_data.h"\n',
    }


def _list(row: Iterable[float]) -> str:
    return f"{{{', '.join(map(repr, row))}}}"


def _array(row: list[float]) -> str:
    return f"(double[]) {_list(row)}"
