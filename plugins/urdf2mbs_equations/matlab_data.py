"""The data of a model for its functions in MATLAB, and an example that calls them.

The functions read a struct ``s`` with the names and shapes of Robotran's ``mbs_data``.  A column
belongs to a joint, those of ``dpt`` to a point; the numbers of a body are in the column of its last
joint, and columns of other joints are zero.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from urdf2mbs.plugin import Mbs, quoted
from urdf2mbs_equations.followers import Follower

#: The natures of joints, and the names of the lists of their numbers.
NATURES = {"independent": "qu", "dependent": "qv", "driven": "qc"}


def write_data(mbs: Mbs, followers: Sequence[Follower] = ()) -> str:
    """Return the function ``NAME_data``, which fills the struct, without its head."""
    joints, n = list(mbs.joints().values()), len(mbs.joints())
    text = f"function s = {mbs.name}_data()\n"
    text += f"s.njoint = {n};\n% The names of the joints and bodies; a body has the number of its "
    text += "last joint.\n"
    numbers = mbs.numbers()
    owners = {numbers[body.joints[-1].name]: body.name for body in mbs.bodies}
    text += _write_names("joints", mbs.joints())
    text += _write_names("bodies", [owners.get(number, "") for number in range(1, n + 1)])
    text += "% The numbers of independent, dependent and driven joints.\n"
    for nature, name in NATURES.items():
        chosen = [k for k, joint in enumerate(joints, start=1) if joint.nature == nature]
        text += f"s.{name} = {_write_row(chosen)};\n"
    text += "% Positions, velocities and accelerations (rad, m, s), and forces of the joints.\n"
    for name in ("q", "qd", "qdd"):
        values = [getattr(joint, name) or 0.0 for joint in joints]
        text += f"s.{name} = {_write_row(values)}';\n"
    text += f"s.Qq = zeros({n},1);\n"
    text += _write_followers(followers, n)
    text += _write_bodies(mbs, numbers)
    text += "% Anchor points in the frames of their bodies (m): those of the base, then by body.\n"
    points = [point.coordinates for point in mbs.points().values()]
    text += _write_columns("dpt", 3, points)
    rods = [cut.length or 0.0 for cut in mbs.cuts if cut.kind == "rod"]
    text += f"s.lrod = {_write_row(rods)}';  % lengths of rods (m)\n"
    return f"{text}end\n"


def _write_followers(followers: Sequence[Follower], n: int) -> str:
    """Write the matrix T and the offsets of joints that follow others."""
    if not followers:
        return ""
    text = "% Joints that follow others (<mimic>): q = T q + offset.\n"
    text += f"s.followers = {_write_row(follower.joint for follower in followers)};\n"
    text += f"s.T = eye({n});\ns.offset = zeros({n},1);\n"
    for joint, factors, offset in followers:
        text += f"s.T({joint},{joint}) = 0;\n"
        text += "".join(f"s.T({joint},{leader}) = {k!r};\n" for leader, k in factors.items())
        text += f"s.offset({joint}) = {offset!r};\n"
    return text


def _write_bodies(mbs: Mbs, numbers: dict[str, int]) -> str:
    """Write masses, centres of mass, inertias and external forces."""
    n = len(numbers)
    masses, zeros = [0.0] * n, (0.0,) * 9
    centres, inertias = [zeros[:3]] * n, [zeros] * n
    for body in mbs.bodies:
        k = numbers[body.joints[-1].name] - 1
        masses[k] = body.mass or 0.0
        centres[k] = body.com or centres[k]
        if body.inertia is not None:
            xx, xy, xz, yy, yz, zz = body.inertia
            inertias[k] = (xx, xy, xz, xy, yy, yz, xz, yz, zz)
    text = (
        "% Masses (kg), centres of mass in the frames of the bodies (m), and inertias about them\n"
    )
    text += "% (kg m^2): the nine elements of each matrix.\n"
    text += f"s.m = {_write_row(masses)};\n"
    text += _write_columns("l", 3, centres) + _write_columns("In", 9, inertias)
    text += "% External forces (N) and torques (Nm) on each body, at its centre of mass.\n"
    text += f"s.frc = zeros(3,{n});\ns.trq = zeros(3,{n});\n"
    return text + f"s.g = {_write_row(mbs.base.gravity)}';  % m/s^2\n"


def _write_names(field: str, names: Iterable[str]) -> str:
    cells = ", ".join("'" + quoted(name).replace("'", "''") + "'" for name in names)
    return f"s.{field} = {{{cells}}};\n"


def _write_row(numbers: Iterable[float]) -> str:
    row = ", ".join(map(repr, numbers))
    return f"[{row}]" if row else "zeros(1,0)"


def _write_columns(field: str, n_rows: int, columns: Sequence[Sequence[float]]) -> str:
    """Write a matrix of which the columns are given, one of them on each line."""
    lines = "; ...\n".join(f"    {', '.join(map(repr, column))}" for column in columns)
    if not columns:
        return f"s.{field} = zeros({n_rows},0);\n"
    return f"s.{field} = [ ...\n{lines}]';\n"


def write_example(mbs: Mbs, followers: Sequence[Follower] = ()) -> str:
    """Return the function ``NAME_example``, which computes accelerations, without its head."""
    name = mbs.name
    joints = enumerate(mbs.joints().values(), start=1)
    first = next((k for k, joint in joints if joint.nature == "independent"), 1)
    text = f"""\
% M, c and the accelerations of M qdd + c = Qq. Call it as
%   s = {name}_data();  s.q({first}) = 0.1;  qdd = {name}_example(s)
function [qdd, M, c] = {name}_example(s)
if nargin == 0
  s = {name}_data();
end
"""
    if followers:
        text += """\
% Followers move with their leaders, which feel their masses: M, c and Qq are those of the joints
% that lead, and rows and columns of followers are zero.
s.q = s.T * s.q + s.offset;
s.qd = s.T * s.qd;
s.qdd = s.T * s.qdd;
"""
    elif mbs.user_constraints:
        text += "% User constraints are not called: their dependent joints move freely here.\n"
    call = f"_{name}(s, 0, struct())"
    if mbs.links:
        text += f"% Forces of links: [s.frc, s.trq] = mbs_link_{name}(s, 0, usrfun);\n"
    if any(point.extforce for body in mbs.bodies for point in body.points):
        text += f"% External forces: [s.frc, s.trq] = mbs_extforces_{name}(s, 0, usrfun);\n"
    text += f"[M, c] = mbs_dirdyna{call};\n"
    free = "[s.qu, s.qv]"
    if followers:
        text += "M = s.T' * M * s.T;\nc = s.T' * c;\ns.Qq = s.T' * s.Qq;\n"
        free = f"setdiff({free}, s.followers)"
    text += f"""\
free = {free};
qdd = s.qdd;
forces = s.Qq(free) - c(free) - M(free,s.qc) * qdd(s.qc);
"""
    end = "qdd = s.T * qdd;\nend\n" if followers else "end\n"
    if not mbs.cuts:
        return f"{text}qdd(free) = M(free,free) \\ forces;\n{end}"
    text += f"""\
% The loops stay closed: J qdd + Jdqd = 0. They are closed where h = 0.
[h, J] = mbs_cons_hJ{call};
Jdqd = mbs_cons_jdqd{call};
"""
    text += "J = J * s.T;\n" if followers else ""
    return f"""{text}\
n = numel(h);
right = [forces; -Jdqd - J(:,s.qc) * qdd(s.qc)];
solution = [M(free,free), J(:,free)'; J(:,free), zeros(n,n)] \\ right;
qdd(free) = solution(1:numel(free));
{end}"""
