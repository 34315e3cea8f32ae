r"""The recursion of Newton and Euler in LaTeX, for robots whose formulas would fill pages.

The document has the equations of the recursion (Luh, Walker and Paul, 1980) in body frames, and the
numbers of each joint and body that they need.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations.followers import Follower
from urdf2mbs_equations.latex import DOCUMENT, escape, write_table
from urdf2mbs_equations.tree import is_fixed

TEXT = r"""The recursion of Newton and Euler computes
$\tau = M(q)\,\ddot q + c(q, \dot q) + g(q)$: of the joints $i = 1 \dots n$, those nearer to the
base come first, and $\lambda$ is the joint before $i$. All vectors of joint $i$ are in the axes of
its frame. $R_i$ is the rotation by $q_i$ about the axis $e_i$ if the joint turns, else 1; $p_i$ is
the origin of frame $i$ in frame $\lambda$, plus $q_i e_i$ if the joint slides. The mass $m_i$, the
centre of mass $r_i$ and the inertia $I_i$ about it are those of the body that joint $i$ is the last
joint of. $\omega_0 = \dot\omega_0 = 0$, and $a_0 = -g$.

For $i = 1 \dots n$, with $\dot\theta_i = \dot q_i$ if the joint turns, else 0, and
$\dot d_i = \dot q_i$ if it slides, else 0:
\begin{align*}
\omega_i &= R_i^T \omega_\lambda + \dot\theta_i e_i \\
\dot\omega_i &= R_i^T \dot\omega_\lambda + R_i^T \omega_\lambda \times \dot\theta_i e_i
  + \ddot\theta_i e_i \\
a_i &= R_i^T \bigl(a_\lambda + \dot\omega_\lambda \times p_i
  + \omega_\lambda \times (\omega_\lambda \times p_i)\bigr)
  + 2\,\omega_i \times \dot d_i e_i + \ddot d_i e_i
\end{align*}
For $i = n \dots 1$, with the sums over the joints $k$ after $i$:
\begin{align*}
F_i &= m_i \bigl(a_i + \dot\omega_i \times r_i + \omega_i \times (\omega_i \times r_i)\bigr) \\
f_i &= F_i + \textstyle\sum_k R_k f_k \\
n_i &= I_i \dot\omega_i + \omega_i \times I_i \omega_i + r_i \times F_i
  + \textstyle\sum_k (R_k n_k + p_k \times R_k f_k) \\
\tau_i &= e_i \cdot n_i \text{ if the joint turns, else } e_i \cdot f_i
\end{align*}
"""


FOLLOWERS = r"""Joints that follow others have the positions of this table; $\dot q$ and
$\ddot q$ follow likewise, without the offset. The force of the joint that leads is its own $\tau$,
plus that of each follower times its multiplier.
"""


def write_recursion(mbs: Mbs, followers: Sequence[Follower] = ()) -> str:
    """Return a document with the recursion and the numbers of a model, without its head."""
    numbers, points = mbs.numbers(), mbs.points()
    joints = ["$i$ & joint & $\\lambda$ & motion & $p_i$ at $q_i = 0$ (m)"]
    bodies = ["$i$ & body & $m_i$ (kg) & $r_i$ (m) & $I_i$: xx, xy, xz, yy, yz, zz (kg\\,m$^2$)"]
    last_joint: dict[str | None, int] = {None: 0}
    for body in mbs.depth_first():
        parent = last_joint[body.parent]
        point = points.get((body.parent, body.point or ""))
        offset = point.coordinates if point is not None else (0.0, 0.0, 0.0)
        for joint in body.joints:
            verb = "turns about" if joint.type[0] == "R" else "slides along"
            motion = f"{verb} {'xyz'[int(joint.type[1]) - 1]}"
            if is_fixed(joint):
                motion = f"never moves: {motion}, $q_i = {_write_numbers([joint.q or 0.0])}$"
            number = numbers[joint.name]
            joints.append(
                f"{number} & {escape(joint.name)} & {parent} & {motion} & {_write_numbers(offset)}"
            )
            parent, offset = number, (0.0, 0.0, 0.0)
        last_joint[body.name] = parent
        if body.mass or body.inertia:
            bodies.append(
                f"{parent} & {escape(body.name)} & {_write_numbers([body.mass or 0.0])} & "
                f"{_write_numbers(body.com or (0.0,) * 3)} & "
                f"{_write_numbers(body.inertia or (0.0,) * 6)}"
            )
    gravity = f"$g = ({_write_numbers(mbs.base.gravity)})$ m/s$^2$.\n"
    tables = write_table("rlrll", joints) + write_table("rlrll", bodies)
    if followers:
        rows = (
            f"$q_{{{joint}}}$ & = "
            + "".join(f"{k:+.6g} $q_{{{leader}}}$ " for leader, k in factors.items())
            + f"{offset:+.6g}"
            for joint, factors, offset in followers
        )
        tables += FOLLOWERS + write_table("ll", rows)
    return DOCUMENT % (escape(mbs.name), TEXT + gravity + tables)


def _write_numbers(numbers: Iterable[float]) -> str:
    return ", ".join(f"{number:.6g}" for number in numbers)
