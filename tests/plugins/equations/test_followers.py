"""Joints that follow others (``<mimic>``): equations are those of pinocchio, reduced to leaders."""

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.folders import SHARED
from support.oracle.generated import error
from urdf2mbs import Robot, convert, load_equations
from urdf2mbs.cli import main
from urdf2mbs_simulate.compiler import HERE, compiler
from urdf2mbs_simulate.memory import SharedData, as_c_table, as_c_vector

pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")

PANDA = SHARED / "robots/franka/expanded/fer.urdf"
LINK = """
<link name="{name}"><inertial><origin xyz="0.02 {y} 0.1" rpy="0.1 0.2 0.3"/><mass value="{mass}"/>
<inertia ixx="0.02" ixy="0.001" ixz="0.002" iyy="0.03" iyz="0.003" izz="0.025"/></inertial></link>
"""
JOINT = """
<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0.1 0.02 0.3" rpy="0.3 {pitch} 0.2"/><axis xyz="{axis}"/>
<limit lower="-9" upper="9" effort="9" velocity="9"/>{mimic}</joint>
"""
#: Name, type, parent, child, axis; leader, multiplier and offset of a follower.  One follower is
#: before its leader, and one follows a follower.
JOINTS: list[tuple[Any, ...]] = [
    ("turn", "revolute", "base", "a", "0 0 1"),
    ("lean", "revolute", "a", "b", "0 1 0", "left", -0.7, 0.2),
    ("reach", "prismatic", "b", "c", "1 0 0"),
    ("left", "revolute", "c", "d", "0 1 0"),
    ("right", "revolute", "c", "e", "0.6 0 0.8", "left", -1.25, 0.1),
    ("tip", "prismatic", "e", "f", "0 0 1", "right", 0.5, -0.3),
]
#: Of all joints, by those that lead: q = T u + q0.
RULES = {
    "turn": (0, 1.0, 0.0),
    "lean": (2, -0.7, 0.2),
    "reach": (1, 1.0, 0.0),
    "left": (2, 1.0, 0.0),
    "right": (2, -1.25, 0.1),
    "tip": (2, -0.625, 0.05 - 0.3),
}
LEADERS = ["turn", "reach", "left"]


@pytest.fixture(scope="module")
def gripper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    text = LINK.format(name="base", y=0.0, mass=2.0)
    for k, (name, kind, parent, child, axis, *rule) in enumerate(JOINTS):
        mimic = '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(*rule) if rule else ""
        words = {"name": name, "kind": kind, "parent": parent, "child": child, "axis": axis}
        text += LINK.format(name=child, y=0.01 * k, mass=1.0 + 0.3 * k)
        text += JOINT.format(**words, pitch=0.1 * k, mimic=mimic)
    file = tmp_path_factory.mktemp("gripper") / "gripper.urdf"
    file.write_text(f'<robot name="gripper">{text}</robot>')
    return file


class Reduced:
    """Pinocchio's tree of all joints, reduced to those that lead by T and q0 of this test."""

    def __init__(self, file: Path) -> None:
        self.model = pin.buildModelFromUrdf(str(file))
        self.data = self.model.createData()
        self.T, self.q0 = np.zeros((6, 3)), np.zeros(6)
        for name, (leader, factor, offset) in RULES.items():
            k = self.model.joints[self.model.getJointId(name)].idx_v
            self.T[k, leader], self.q0[k] = factor, offset

    def spread(self, u: Any, *rates: Any) -> list[Any]:
        return [self.T @ u + self.q0, *(self.T @ rate for rate in rates)]

    def force(self, u: Any, *rates: Any) -> Any:
        return self.T.T @ pin.rnea(self.model, self.data, *self.spread(u, *rates))

    def mass_matrix(self, u: Any) -> Any:
        return self.T.T @ pin.crba(self.model, self.data, *self.spread(u)) @ self.T

    def derivatives(self, *state: Any) -> list[Any]:
        all_joints = self.spread(*state)
        by_q, by_qd, _ = pin.computeRNEADerivatives(self.model, self.data, *all_joints)
        tables = (by_q, by_qd, pin.crba(self.model, self.data, all_joints[0]))
        return [self.T.T @ table @ self.T for table in tables]

    def jacobian(self, u: Any, link: str) -> Any:
        frame = self.model.getFrameId(link)
        axes = pin.LOCAL_WORLD_ALIGNED
        (q,) = self.spread(u)
        return pin.computeFrameJacobian(self.model, self.data, q, frame, axes) @ self.T


def list_results(robot: Robot, u: Any, ud: Any, udd: Any, tau: Any) -> dict[str, Any]:
    by_q, by_qd, by_qdd = robot.inverse_dynamics_derivatives(u, ud, udd)
    forward = robot.forward_dynamics_derivatives(u, ud, tau)
    return {
        "M": robot.mass_matrix(u),
        "c": robot.bias(u, ud),
        "tau": robot.inverse_dynamics(u, ud, udd),
        "qdd": robot.forward_dynamics(u, ud, tau),
        "dtau/dq": by_q,
        "dtau/dqd": by_qd,
        "dtau/dqdd": by_qdd,
        "dqdd/dq": forward[0],
        "dqdd/dqd": forward[1],
        "dqdd/dtau": forward[2],
        "J": robot.jacobian("f", u),
    }


def list_expected(reduced: Reduced, u: Any, ud: Any, udd: Any, tau: Any) -> dict[str, Any]:
    mass, bias = reduced.mass_matrix(u), reduced.force(u, ud, 0.0 * u)
    qdd = np.linalg.solve(mass, tau - bias)
    by_q, by_qd, _ = reduced.derivatives(u, ud, qdd)
    names = ("dtau/dq", "dtau/dqd", "dtau/dqdd")
    return {
        "M": mass,
        "c": bias,
        "tau": reduced.force(u, ud, udd),
        "qdd": qdd,
        **dict(zip(names, reduced.derivatives(u, ud, udd), strict=True)),
        "dqdd/dq": -np.linalg.solve(mass, by_q),
        "dqdd/dqd": -np.linalg.solve(mass, by_qd),
        "dqdd/dtau": np.linalg.inv(mass),
        "J": reduced.jacobian(u, "f"),
    }


STATE = np.random.default_rng(1).uniform(-1, 1, (4, 3))


@pytest.mark.parametrize(
    ("language", "pipeline"), [("c", "compact"), ("python", "faithful"), ("python", "compact")]
)
def test_all_is_reduced_as_by_pinocchio(gripper: Path, language: str, pipeline: Any) -> None:
    robot = load_equations(gripper, language=language, base="fixed", moving=True, pipeline=pipeline)
    assert (robot.joints, robot.followers) == (LEADERS, ["lean", "right", "tip"])
    expected = list_expected(Reduced(gripper), *STATE)
    for name, actual in list_results(robot, *STATE).items():
        assert error(actual, expected[name]) <= 1e-9, name


def differentiate(function: Callable[[Any], Any], x: Any) -> Any:
    """Return central differences, extrapolated to a step 0 (Richardson)."""
    columns = []
    for k in range(len(x)):
        by_step = []
        for step in (2e-3, 1e-3, 5e-4):
            moved = step * np.eye(len(x))[k]
            by_step.append((function(x + moved) - function(x - moved)) / (2 * step))
        coarse, fine = ((4 * b - a) / 3 for a, b in pairwise(by_step))
        columns.append((16 * fine - coarse) / 15)
    return np.stack(columns, axis=-1)


def compare_differences(function: Any, derivatives: Any, *state: Any) -> None:
    for k, table in enumerate(derivatives(*state)):

        def vary(x: Any, k: int = k) -> Any:
            return function(*state[:k], x, *state[k + 1 :])

        assert error(table, differentiate(vary, state[k])) <= 1e-9


@pytest.mark.parametrize("language", ["c", "python"])
def test_derivatives_are_differences(gripper: Path, language: str) -> None:
    robot = load_equations(gripper, language=language, base="fixed", moving=True)
    u, ud, udd, tau = STATE
    compare_differences(robot.inverse_dynamics, robot.inverse_dynamics_derivatives, u, ud, udd)
    compare_differences(robot.forward_dynamics, robot.forward_dynamics_derivatives, u, ud, tau)


def test_panda_is_reduced_as_pinocchio_reduces_mimic() -> None:
    """Beside the model that pinocchio makes of ``<mimic>``, and does not differentiate."""
    if not PANDA.is_file():
        pytest.skip("../shared is not here")
    robot = load_equations(PANDA, base="fixed", moving=True)
    model = pin.buildModelFromUrdf(str(PANDA), True)
    data, n = model.createData(), len(robot.joints)
    order = [model.joints[model.getJointId(name)].idx_v for name in robot.joints]
    assert sorted(order) == list(range(model.nv))
    u, ud, udd = theirs = np.random.default_rng(3).uniform(-1, 1, (3, n))
    theirs = np.empty_like(theirs)
    theirs[:, order] = u, ud, udd
    mass = pin.crba(model, data, theirs[0])
    mass = (np.triu(mass) + np.triu(mass, 1).T)[np.ix_(order, order)]
    tau = robot.inverse_dynamics(u, ud, udd)
    assert error(robot.mass_matrix(u), mass) <= 1e-12
    assert error(tau, pin.rnea(model, data, *theirs)[order]) <= 1e-12
    assert error(robot.forward_dynamics(u, ud, tau), udd) <= 1e-9
    by_u, by_ud, by_udd = robot.inverse_dynamics_derivatives(u, ud, udd)

    def force(u: Any, ud: Any) -> Any:
        theirs[:2, order] = u, ud
        return pin.rnea(model, data, *theirs)[order]

    assert error(by_u, differentiate(lambda x: force(x, ud), u)) <= 1e-9
    assert error(by_ud, differentiate(lambda x: force(u, x), ud)) <= 1e-9
    assert error(by_udd, mass) <= 1e-12


#: Octave that sets the state of the joints that lead, and prints what the example returns.
MATLAB = """
s = {name}_data();
q = [{q}]; qd = [{qd}]; tau = [{tau}]; s.q(:) = 7; s.qd(:) = 7;
[~, leading] = ismember({{{joints}}}, s.joints);
fixed = setdiff([s.qc], leading); s.q(fixed) = {name}_data().q(fixed); s.qd(fixed) = 0;
s.q(leading) = q; s.qd(leading) = qd; s.Qq(leading) = tau;
[qdd, M, c] = {name}_example(s);
printf('%.17g ', M(leading,leading), c(leading), qdd(leading), qdd(s.followers));
others = setdiff(1:s.njoint, [leading, s.qc]);
assert(others, sort(s.followers)); assert(all(all(M(others,:) == 0 & M(:,others)' == 0)));
"""


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="GNU Octave is not installed")
@pytest.mark.parametrize("name", ["gripper", "panda"])
def test_matlab(gripper: Path, name: str, tmp_path: Path, capsys: Any) -> None:
    """From the robot: the data have T, and the example reduces M, c and the accelerations."""
    file = tmp_path / f"{name}.urdf"
    if name == "panda" and not PANDA.is_file():
        pytest.skip("../shared is not here")
    file.write_text((PANDA if name == "panda" else gripper).read_text())
    options = ["--base", "fixed", "--language", "matlab", "-o", str(tmp_path)]
    assert main(["equations", str(file), *options]) == 0
    assert f"[qdd, M, c] = {name}_example(s)" in capsys.readouterr().out
    robot = load_equations(file, base="fixed", moving=True)
    q, qd, tau = states = np.random.default_rng(6).uniform(-1, 1, (3, len(robot.joints)))
    rows = [" ".join(map(repr, row)) for row in states.tolist()]
    joints = ", ".join(f"'{joint}'" for joint in robot.joints)
    script = MATLAB.format(name=name, joints=joints, q=rows[0], qd=rows[1], tau=rows[2])
    command = ["octave-cli", "--norc", "--quiet", "--eval", script]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    n = len(robot.joints)
    mass, bias, qdd, following = np.split(
        np.array(ran.stdout.split(), float), np.cumsum([n * n, n, n])
    )
    assert error(mass.reshape(n, n), robot.mass_matrix(q)) <= 1e-14
    assert error(bias, robot.bias(q, qd)) <= 1e-14
    expected = robot.forward_dynamics(q, qd, tau)
    assert error(robot.mass_matrix(q) @ qdd, tau - robot.bias(q, qd)) <= 1e-13
    assert error(qdd, expected) <= 1e-14 * np.linalg.cond(robot.mass_matrix(q))
    if name == "gripper":
        factors = [RULES[follower] for follower in robot.followers]
        assert following == pytest.approx([k * qdd[leader] for leader, k, _ in factors])


def test_a_project_alone_does_not_state_the_rules(
    gripper: Path, tmp_path: Path, capsys: Any
) -> None:
    convert(gripper, base="fixed", output={"project": str(tmp_path / "gripper")}).write()
    options = ["--language", "matlab"]
    assert main(["equations", str(tmp_path / "gripper"), *options]) == 0
    text = capsys.readouterr().out
    assert "user constraints 'lean_mimic', 'right_mimic', 'tip_mimic' are not called" in text
    example = tmp_path / "gripper" / "symbolicR" / "gripper_example.m"
    assert "% User constraints are not called" in example.read_text()
    assert main(["equations", str(gripper), "-o", str(tmp_path / "other"), *options]) == 0
    text = capsys.readouterr().out
    assert "followers: 'lean', 'right', 'tip'; gripper_example.m reduces M and c" in text
    assert "user constraints" not in text


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
def test_c_files(gripper: Path, tmp_path: Path) -> None:
    """What the files in C reduce is what Python reduces."""
    options = ["--base", "fixed", "--language", "c", "-o", str(tmp_path)]
    assert main(["equations", str(gripper), *options]) == 0
    library = tmp_path / "followers.so"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    headers = f"-I{HERE / 'mbsysc'}"
    source = tmp_path / "mbs_followers_gripper.c"
    subprocess.run(["gcc", *flags, headers, str(source), "-o", str(library)], check=True)
    functions = ctypes.CDLL(str(library))
    robot = load_equations(gripper, base="fixed", language="python")
    selection, data = robot.selection, robot.data
    rng, n = np.random.default_rng(8), data.njoint + 1
    for name in ("q", "qd", "qdd"):
        getattr(data, name)[:] = rng.uniform(-1, 1, n)
    states = [getattr(data, name)[selection.numbers] for name in ("q", "qd", "qdd")]
    shared_data = SharedData(data)
    functions.mbs_followers(ctypes.byref(shared_data.struct))
    for values, name in zip(states, ("q", "qd", "qdd"), strict=True):
        expected = np.zeros(n)
        selection.spread(values, expected, selection.q0 if name == "q" else None)
        assert getattr(data, name)[1:] == pytest.approx(expected[1:], rel=1e-15)
    matrix, jacobian, vector = (rng.uniform(-1, 1, size) for size in ((n, n), (7, n), n))
    for array, axes, call in (
        (matrix, (0, 1), lambda x: functions.mbs_reduce_matrix(as_c_table(x))),
        (jacobian, (1,), lambda x: functions.mbs_reduce_columns(as_c_table(x), 6)),
        (vector, (0,), lambda x: functions.mbs_reduce_vector(as_c_vector(x))),
    ):
        expected = selection.reduce(array.copy(), axes)
        call(array)
        reduced = array[
            np.ix_(*(selection.numbers if k in axes else range(1, 7) for k in range(array.ndim)))
        ]
        assert error(reduced, expected) <= 1e-15


@pytest.mark.slow  # it compiles the user functions of a project
@pytest.mark.skipif(compiler() is None, reason="there is no C compiler")
def test_constraints_in_c_alone(gripper: Path, tmp_path: Path) -> None:
    output = {"project": str(tmp_path / "gripper"), "language": "c"}
    convert(gripper, base="fixed", output=output).write()
    robot = load_equations(tmp_path / "gripper", moving=True)
    assert robot.joints == LEADERS
    u = STATE[0]
    assert error(robot.mass_matrix(u), Reduced(gripper).mass_matrix(u)) <= 1e-12


def test_only_linear_constraints_make_followers(gripper: Path, tmp_path: Path) -> None:
    """A constraint of the user that is not linear is a loop, beside ``<mimic>``."""
    output = {"project": str(tmp_path / "gripper"), "language": "python"}
    convert(gripper, base="fixed", output=output).write()
    (file,) = tmp_path.glob("gripper/userfctR/user_cons_hJ.py")
    file.write_text(
        file.read_text()
        + """

linear_cons_hJ = user_cons_hJ


def user_cons_hJ(h, Jac, mbs_data, tsim):
    linear_cons_hJ(h, Jac, mbs_data, tsim)
    left, tip = (mbs_data.joint_id[name] for name in ("left", "tip"))
    h[3] = mbs_data.q[tip] - 0.1 * mbs_data.q[left] ** 2
    Jac[3, :] = 0.0
    Jac[3, tip], Jac[3, left] = 1.0, -0.2 * mbs_data.q[left]
"""
    )
    robot = load_equations(tmp_path / "gripper", language="python", moving=True)
    assert robot.followers == ["lean", "right"]
    with pytest.raises(ValueError, match="joint 'tip' depends on others by a constraint that is n"):
        robot.forward_dynamics_derivatives(*np.zeros((3, 4)))
    u, ud, tau = np.random.default_rng(2).uniform(-1, 1, (3, 4))
    udd = robot.forward_dynamics(u, ud, tau)
    left, tip = (robot.joints.index(name) for name in ("left", "tip"))
    assert udd[tip] == pytest.approx(0.2 * u[left] * udd[left])  # its jdqd is 0, as the project has
    assert robot.data.qd[robot.data.joint_id["tip"]] == pytest.approx(0.2 * u[left] * ud[left])


def test_many_states_of_numpy(gripper: Path) -> None:
    options: dict[str, Any] = {"base": "fixed", "moving": True}
    robot, many = (load_equations(gripper, math=math, **options) for math in (None, np))
    states = np.random.default_rng(4).uniform(-1, 1, (4, 3, 5))
    actual = list_results(many, *states)
    for k in range(5):
        for name, expected in list_results(robot, *states[:, :, k]).items():
            assert error(actual[name][..., k], expected) <= 1e-12, name


def test_casadi(gripper: Path) -> None:
    """CasADi's own derivatives of what it is given are ours."""
    casadi = pytest.importorskip("casadi", reason="casadi is not installed")
    robot = load_equations(gripper, math=casadi, base="fixed", moving=True)
    symbols = [casadi.SX.sym(name, 3) for name in ("q", "qd", "qdd", "tau")]
    results = list_results(robot, *symbols)
    for name in ("tau", "qdd"):
        for variable, symbol in zip(("q", "qd"), symbols, strict=False):
            results[f"d{name}/d{variable}, by CasADi"] = casadi.jacobian(results[name], symbol)
    expected = list_expected(Reduced(gripper), *STATE)
    for name, result in results.items():
        actual = np.array(casadi.Function("f", symbols, [result])(*STATE))
        wanted = expected[name.partition(",")[0]]
        assert error(actual.reshape(wanted.shape), wanted) <= 1e-9, name


PLANAR = """
<robot name="planar"><link name="base"/>{links}
<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="9" velocity="9"/></joint>
<joint name="left" type="continuous"><parent link="cart"/><child link="l"/><axis xyz="0 1 0"/>
</joint>
<joint name="right" type="continuous"><parent link="l"/><child link="r"/><axis xyz="0 1 0"/>
<origin xyz="0 0 0.4"/><mimic joint="left" multiplier="-0.5" offset="0.25"/></joint></robot>
"""
PLANAR_LINK = """
<link name="{}"><inertial><origin xyz="0 0 0.2"/><mass value="{}"/>
<inertia ixx="1" iyy="0.5" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
"""


def write_planar(file: Path, rule: str) -> Path:
    links = "".join(PLANAR_LINK.format(*row) for row in (("cart", 2.0), ("l", 1.0), ("r", 0.5)))
    text = PLANAR.format(links=links)
    file.write_text(text.replace('multiplier="-0.5" offset="0.25"', rule))
    return file


@pytest.mark.parametrize(
    ("rule", "relation"),
    [
        ('multiplier="-0.5" offset="0.25"', "q_3 &= -\\tfrac{1}{2} q_2 + b_3"),
        ('multiplier="-1"', "q_3 &= -q_2\n"),
        ('multiplier="2"', "q_3 &= 2 q_2\n"),
        ('multiplier="0.3" offset="-0.1"', "q_3 &= r_3 q_2 + b_3"),
        ('multiplier="0" offset="0.3"', None),
    ],
)
def test_formulas(rule: str, relation: str | None, tmp_path: Path) -> None:
    """Formulas are those of the joints that lead, in sympy and in the document."""
    sympy = pytest.importorskip("sympy", reason="sympy is not installed")
    file = write_planar(tmp_path / "planar.urdf", rule)
    formulas: Any = load_equations(file, math=sympy, base="fixed")
    robot = load_equations(file, base="fixed", moving=True)
    assert formulas.joints == robot.joints == ["slide", "left"]
    u, ud, udd, _ = np.random.default_rng(1).uniform(-1, 1, (4, 2))
    for name, state in (
        ("mass_matrix", (u,)),
        ("bias", (u, ud)),
        ("inverse_dynamics", (u, ud, udd)),
        ("forward_dynamics", (u, ud, udd)),
    ):
        formula = getattr(formulas, name)(*state).subs(formulas.values)
        expected = getattr(robot, name)(*state)
        actual = np.array(formula.tolist(), float).reshape(expected.shape)
        assert error(actual, expected) <= 1e-14, name
    options = ["--base", "fixed", "--language", "latex", "-o", str(tmp_path)]
    assert main(["equations", str(file), *options]) == 0
    text = (tmp_path / "planar_equations.tex").read_text()
    assert "\nc_3 &=" not in text
    assert "loops" not in text
    if relation is None:
        assert "q_3" not in text
    else:
        assert relation in text
        assert "$q_3$ & right & angle" in text
    if rule == 'multiplier="-1"':  # the second link stays upright: only its mass is felt
        assert "m_2 l_{c2}^2 + I_2 + m_3 l_2^2" in text


@pytest.mark.slow
def test_formulas_of_prismatic_followers(gripper: Path) -> None:
    """The spatial gripper without its oblique axes: with followers that slide, in a chain."""
    sympy = pytest.importorskip("sympy", reason="sympy is not installed")
    text = re.sub(r'rpy="[^"]*"', "", gripper.read_text()).replace("0.6 0 0.8", "0 1 0")
    file = gripper.with_name("straight.urdf")
    file.write_text(text)
    formulas: Any = load_equations(file, math=sympy, base="fixed")
    robot = load_equations(file, base="fixed", moving=True)
    assert formulas.joints == robot.joints == LEADERS
    u, ud, _, _ = STATE
    mass = formulas.mass_matrix(u).subs(formulas.values)
    assert error(np.array(mass.tolist(), float), robot.mass_matrix(u)) <= 1e-13
    bias = formulas.bias(u, ud).subs(formulas.values)
    assert error(np.array(bias.tolist(), float)[:, 0], robot.bias(u, ud)) <= 1e-13


def test_the_recursion_has_the_rules(gripper: Path, tmp_path: Path, capsys: Any) -> None:
    """Oblique axes make formulas that nobody reads, and that took minutes."""
    options = ["--base", "fixed", "--language", "latex", "-o", str(tmp_path)]
    assert main(["equations", str(gripper), *options]) == 0
    assert "have more than 5000 terms; the file has the recursion" in capsys.readouterr().out
    text = (tmp_path / "gripper_equations.tex").read_text()
    rule = re.search(r"\$q_\{(\d+)\}\$ & = -1.25 \$q_\{(\d+)\}\$ \+0.1 ", text)
    assert rule is not None
    joints = dict(re.findall(r"(?m)^(\d+) & (\w+) & \d+ & (?:turns|slides)", text))
    assert (joints[rule[1]], joints[rule[2]]) == ("right", "left")


@pytest.mark.slow
def test_jax(gripper: Path) -> None:
    """JAX's own derivatives of what it is given are ours."""
    jax = pytest.importorskip("jax", reason="jax is not installed")
    robot = load_equations(gripper, math=jax.numpy, base="fixed", moving=True)
    with jax.enable_x64(True):
        results = list_results(robot, *STATE)
        u, ud, udd, tau = STATE
        results["tau, compiled"] = jax.jit(robot.inverse_dynamics)(u, ud, udd)
        for k, variable in enumerate(("q", "qd")):
            by_jax = jax.jacfwd(robot.inverse_dynamics, k)
            results[f"dtau/d{variable}, by JAX"] = by_jax(u, ud, udd)
        results["dqdd/dq, by JAX"] = jax.jacfwd(robot.forward_dynamics)(u, ud, tau)
    expected = list_expected(Reduced(gripper), *STATE)
    for name, actual in results.items():
        assert error(np.asarray(actual), expected[name.partition(",")[0]]) <= 1e-9, name
