"""The equations in MATLAB, run by GNU Octave, beside those in Python."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from support.folders import CONFIGS, SHARED
from support.oracle.generated import TABLES, Data, PythonEquations, error, random_state
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Point, Sensor
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_equations.constraints import count_equations
from urdf2mbs_equations.files import generate
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.tree import is_fixed

needs_octave = pytest.mark.skipif(
    shutil.which("octave-cli") is None, reason="GNU Octave is not installed (octave-cli)"
)

#: What calls a function, as MBsysLab does, and prints all of its results, and what the user's
#: functions were told.
DRIVER = """\
1;
function out = wrench(P, R, V, OM, A, OMP, s, tsim, number)
  global told
  told = [told; P; R(:); V; OM; A; OMP];
  out = number + sin([P; V; A]);
end
function force = pull(Z, Zd, s, tsim, number)
  force = number + 2 * Z + 3 * Zd;
end
function show(x)
  if isstruct(x)
    cellfun(@show, struct2cell(x));
  else
    printf("%.17g\\n", x);
  end
end
global told
told = [];
usrfun = struct('fext', @wrench, 'flink', @pull);
"""


class Received(Data):
    """The same user functions in Python; they record their arguments."""

    def __init__(self, mbs: Mbs) -> None:
        super().__init__(mbs)
        self.told: list[Any] = []

    def user_ExtForces(self, *arguments: Any) -> NDArray[np.float64]:  # noqa: N802
        p, r, v, om, a, omp, _, _, number = arguments
        self.told += [p[1:], r[1:, 1:].T.ravel(), v[1:], om[1:], a[1:], omp[1:]]
        return np.array([0.0, *(number + np.sin([*p[1:], *v[1:], *a[1:]]))])

    def user_LinkForces(self, z: float, zd: float, *arguments: Any) -> float:  # noqa: N802
        return float(arguments[2] + 2 * z + 3 * zd)


def make_complete_model() -> Mbs:
    """Make a model with a loop, links and forces, with all signals or some."""
    signals = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
    mbs = Mbs("everything")
    for k, (parent, kind) in enumerate([(None, "R2"), ("b0", "R1"), (None, "R3"), ("b2", "T1")]):
        body = Body(f"b{k}", parent, None, [Joint(f"j{k}", kind)])
        body.mass, body.com, body.inertia = 2.0, (0.1, 0.0, 0.3), (0.1, 0.01, 0.02, 0.2, 0.03, 0.25)
        body.points = [
            Point("P", (0.3, -0.2, 0.1), sensor=Sensor("", (*signals, "Jac"))),
            Point("Q", (0.0, 0.5, 0.0), extforce=Sensor("", signals[: 6 - k])),
        ]
        mbs.bodies.append(body)
    mbs.cuts = [
        Connection("rod", "rod", ("b1", "P"), ("b3", "Q"), 0.4),
        Connection("ball", "ball", ("b1", "Q"), ("b3", "P")),
    ]
    mbs.links = [
        Connection("link", "one", ("b1", "P"), ("b2", "Q")),
        Connection("link", "two", (None, None), ("b3", "P")),
    ]
    return mbs


def convert_config(name: str) -> Mbs:
    text = (CONFIGS / name).read_text()
    return read_mbs(convert_text(text).data, name, mechanics_only=True)


def convert_driven_arm() -> Mbs:
    """Return an arm with a driven joint whose acceleration is not zero."""
    mbs = convert_config("arm.urdf.xacro")
    moving = [joint for joint in mbs.joints().values() if joint.nature == "independent"]
    moving[1].nature = "driven"
    return mbs


def read_sample(name: str) -> Mbs:
    file = SHARED / "mbs-samples" / name
    if not file.is_file():
        pytest.skip(f"no sample beside the project: {file}")
    return read_mbs(file.read_bytes(), name, mechanics_only=True)


def call_python(eq: PythonEquations, s: Received) -> dict[str, list[Any]]:
    """Call all functions; return their results as Octave prints them, column by column."""
    rows = count_equations(eq.mbs)
    h, jac, jdqd = eq.constraints(s, rows) if rows else (np.zeros(0),) * 3
    out: dict[str, list[Any]] = {
        "dirdyna": list(eq.dirdyna(s)),
        "invdyna": [eq.invdyna(s)],
        "cons_hJ": [h, jac],
        "cons_jdqd": [jdqd],
    }
    points = [point for body in eq.mbs.bodies for point in body.points]
    count = sum(point.sensor is not None for point in points)
    pushed = any(point.extforce for point in points)
    for kind, number in (("sensor", count), ("gensensor", s.njoint)):
        for k in range(1, number + 1):
            sens = eq.sensor(s, k, kind)
            out[f"{kind},{k}"] = [
                sens.P[1:],
                sens.R[1:, 1:],
                *(x[1:] for x in (sens.V, sens.OM, sens.A, sens.OMP)),
                sens.J[1:, 1:],
            ]
    for name, any_load in (("link", bool(eq.mbs.links)), ("extforces", pushed)):
        frc, trq = s.frc.copy(), s.trq.copy()
        if any_load:
            eq.loads(s, name)
        out[name] = [s.frc[1:, 1:].copy(), s.trq[1:, 1:].copy()]
        out[name] += [s.Fl[1:], s.Z[1:], s.Zd[1:]] if name == "link" else s.told
        s.frc[:], s.trq[:] = frc, trq
    square, three = (s.njoint + 1,) * 2, (4,)
    for name, shapes in {
        "energy": [(3,)],
        "momentum": [three, three],
        "com": [three],
        "derivatives": [square] * 3,
        "regressor": [(s.njoint + 1, 10 * len(eq.mbs.bodies) + 1)],
    }.items():
        arrays = [np.zeros(shape) for shape in shapes]
        eq.fill(name, s, *arrays)
        out[name] = [array[(slice(1, None),) * array.ndim] for array in arrays]
    return out


def run_octave(script: str, folder: Path) -> str:
    """Return what a script prints."""
    (folder / "driver.m").write_text(script)
    ran = subprocess.run(
        ["octave-cli", "--norc", "--quiet", "driver.m"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@needs_octave
@pytest.mark.parametrize(
    "make",
    [
        pytest.param(
            lambda: convert_config("biped.urdf.xacro"), id="biped", marks=pytest.mark.slow
        ),
        pytest.param(make_complete_model, id="all"),
        pytest.param(lambda: read_sample("Vhinque-Ankle.mbs"), id="ankle"),
    ],
)
def test_octave_computes_what_python_computes(make: Any, tmp_path: Path) -> None:
    mbs: Mbs = make()
    python, matlab = (
        generate(
            mbs,
            b"<mbsDescR7/>",
            "m.mbs",
            EquationOptions(language=language, energy=True, derivatives=True),
        )
        for language in ("python", "matlab")
    )
    for name, text in matlab.files.items():
        (tmp_path / name).write_bytes(text)
    s = Received(mbs)
    random = random_state(mbs, np.random.default_rng(7), loads=True)
    for name in ("q", "qd", "qdd", "frc", "trq"):
        getattr(s, name)[:] = getattr(random, name)
    expected = call_python(PythonEquations(python, mbs, tmp_path), s)
    script = DRIVER
    for name in ("q", "qd", "qdd", "m", "g", "lrod", *TABLES):
        array = getattr(s, name)[(slice(1, None),) * getattr(s, name).ndim]
        rows = array.reshape(-1, 1) if array.ndim == 1 else array
        script += f"s.{name} = [{';'.join(' '.join(map(repr, row)) for row in rows.tolist())}];\n"
    for call, results in expected.items():
        name, _, number = call.partition(",")
        count = 1 if number else 2 if name == "extforces" else len(results)
        outs = [f"r{k}" for k in range(count)]
        more = f", {number}" if number else ""
        script += f"[{', '.join(outs)}] = mbs_{name}_{mbs.name}(s, 0, usrfun{more});\n"
        script += "".join(f"show({out});\n" for out in outs)
        script += "show(told); printf('\\n');\n" * (name == "extforces") + "printf('end\\n');\n"
    *printed, rest = run_octave(script, tmp_path).split("end\n")
    assert rest == ""
    for (call, results), text in zip(expected.items(), printed, strict=True):
        generated = np.concatenate([np.ravel(result, order="F") for result in results])
        actual = np.array(text.split(), dtype=float)
        assert actual.shape == generated.shape, call
        assert error(actual, generated) < 1e-12, call


@needs_octave
@pytest.mark.parametrize(
    ("make", "tolerance"),
    [
        (lambda: read_mbs(convert_text(TINY).data, "tiny", mechanics_only=True), 1e-14),
        (lambda: convert_config("arm.urdf.xacro"), 1e-14),
        (convert_driven_arm, 1e-14),
        (lambda: convert_config("biped.urdf.xacro"), 1e-14),
        (lambda: read_sample("Vhinque-Ankle.mbs"), 1e-9),  # Newton's method closes its loops
    ],
    ids=["tiny", "arm", "driven", "biped", "ankle"],
)
def test_the_example_computes_accelerations(make: Any, tolerance: float, tmp_path: Path) -> None:
    """From nothing but the generated files: the data of the .mbs are in one of them."""
    mbs: Mbs = make()
    python, matlab = (
        generate(mbs, b"<mbsDescR7/>", "m.mbs", EquationOptions(language=language))
        for language in ("python", "matlab")
    )
    for name, text in matlab.files.items():
        (tmp_path / name).write_bytes(text)
    s = random_state(mbs, np.random.default_rng(3), loads=False)
    for number, joint in enumerate(mbs.joints().values(), start=1):
        s.qdd[number] = 1.5 if joint.nature == "driven" and not is_fixed(joint) else 0.0
    s.Qq[1:] = np.random.default_rng(4).uniform(-10, 10, s.njoint)
    if mbs.cuts:
        s.q[1:] = [joint.q or 0.0 for joint in mbs.joints().values()]
    driven_accelerations = s.qdd.copy()
    eq = PythonEquations(python, mbs, tmp_path)
    assert eq.accelred(s) >= 0
    mass, bias = eq.dirdyna(s)
    script = f"1;\ns = {mbs.name}_data();\n"
    for name, array in (("q", s.q), ("qd", s.qd), ("qdd", driven_accelerations), ("Qq", s.Qq)):
        script += f"s.{name} = [{';'.join(map(repr, array[1:].tolist()))}];\n"
    script += f"[qdd, M, c] = {mbs.name}_example(s);\nprintf('%.17g\\n', qdd, M, c);\n"
    actual = np.array(run_octave(script, tmp_path).split(), dtype=float)
    n = s.njoint
    assert actual.shape == (2 * n + n * n,)
    assert error(actual[n:-n], mass.ravel()) <= 1e-14
    assert error(actual[-n:], bias) <= 1e-14
    assert error(actual[:n], s.qdd[1:]) <= tolerance


def test_the_data_of_matlab_are_those_of_the_file() -> None:
    """Without Octave: names with quotes, empty lists, and the checksums of both files."""
    mbs = make_complete_model()
    mbs.bodies[0].joints[0].name = "the leg's"
    made = generate(mbs, b"<mbsDescR7/>", "m.mbs", EquationOptions(language="matlab"))
    data, example = (made.files[f"everything_{name}.m"].decode() for name in ("data", "example"))
    assert "s.joints = {'the leg''s', 'j1', 'j2', 'j3'};" in data
    assert "s.qc = zeros(1,0);" in data
    assert "s.lrod = [0.4]';" in data
    assert "0.1, 0.01, 0.02, 0.01, 0.2, 0.03, 0.02, 0.03, 0.25" in data
    assert "% Fits (tree, numbers): sha256 " in data
    assert "% Fits (tree, fixed): sha256 " in example


def test_matlab_says_what_it_leaves_out() -> None:
    mbs = make_complete_model()
    made = generate(mbs, b"<mbsDescR7/>", "m.mbs", EquationOptions(language="matlab"))
    assert "link3D" not in made.left_out
    (link,) = (text for name, text in made.files.items() if name.startswith("mbs_link_"))
    assert f"Flink = zeros({len(mbs.links)},1);".encode() in link
    mbs.links[0].kind = "link3D"
    made = generate(mbs, b"<mbsDescR7/>", "m.mbs", EquationOptions(language="matlab"))
    assert "link3D" in made.left_out
    assert not [name for name in made.files if "link3D" in name or "accelred" in name]
