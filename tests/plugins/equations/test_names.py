"""Any names in a model give the same code: names in an .mbs drawn by hand may be hostile."""

from pathlib import Path

import numpy as np
import pytest

from support.oracle.generated import CEquations, PythonEquations, random_state
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Point, Sensor
from urdf2mbs.mbs.writer import write
from urdf2mbs_equations.files import Equations, generate
from urdf2mbs_equations.options import EquationOptions

HOSTILE = {
    "C keyword": ("double", "return", "int", "static"),
    "Python keyword": ("lambda", "def", "None", "import"),
    "our own": ("M", "s", "x1", "w"),
    "comment": ("*/ int x; /*", "// \\", "# \\", "*/"),
    "lines": ("a\nint b = ;", "a\rb", "a\u2028b\x85", "\n#error no"),
    "backslash": ("a\\", "??/", "\\\n", "\\"),
    "quotes": ("\"'", "'''", '"""', "`$(x)`"),
    "long": ("a" * 500, "b" * 500, "c" * 500, "d" * 500),
    "scripts": ("épaule", "肩", "плечо", "🦾"),
    "alike": ("a b", "a-b", "a.b", "a_b"),
    "empty-looking": (" ", "\t", "\u00a0", "\u200b"),
}
PLAIN = ("one", "two", "three", "four")
HOSTILE_MIX = ("*/ a\nb", '"\\', "плечо'''", "//\\\r")


def model(names: tuple[str, ...]) -> Mbs:
    """Make an arm of two links with a joint that never moves, a sensor, forces, and a rod."""
    a, b, c, d = names
    mbs = Mbs("arm")
    mbs.base.gravity = (0.0, 0.0, -9.81)
    mbs.base.points = [Point(a, (0.3, 0.0, 0.4))]
    still = Joint(a, "R1", nature="driven", q=0.3, symbols=("q",))
    one = Body(a + a, None, None, [still, Joint(b, "R2")], mass=1.0, com=(0.1, 0.0, 0.2))
    one.points = [
        Point(c, (0.0, 0.1, 0.3)),
        Point(d, (0.0, 0.0, 0.5), sensor=Sensor(d + c, ("Pos",))),
    ]
    # no matter moves with the last joint, so accelred says its name
    two = Body(b + b, a + a, c, [Joint(c, "R3", nature="dependent"), Joint(d, "T1")])
    two.points = [Point(a, (0.1, 0.0, 0.0), extforce=Sensor(c + d, ("Pos", "Vit")))]
    mbs.bodies = [one, two]
    mbs.cuts = [Connection("rod", b, (None, a), (b + b, a), length=0.2)]
    mbs.links = [Connection("link", c, (None, a), (a + a, d))]
    return mbs


def code(made: Equations) -> dict[str, bytes]:
    """Return the files without their heads."""
    return {name: text.partition(b"\n\n")[2] for name, text in made.files.items()}


@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("language", ["python", "c"])
def test_names_are_no_code(kind: str, language: str) -> None:
    names = HOSTILE[kind]
    plain = generate(model(PLAIN), b"<mbsDescR7/>", "arm.mbs", EquationOptions(language=language))
    made = generate(
        model(names),
        b"<mbsDescR7/>",
        f"{names[0]}.mbs".replace("/", ""),
        EquationOptions(language=language),
    )
    assert code(made) == code(plain)
    mark = "//" if language == "c" else "#"
    for text in made.files.values():
        header = text.decode().partition("\n\n")[0].split("\n")
        assert all(line.startswith(mark) and not line.endswith("\\") for line in header)


@pytest.mark.parametrize("language", ["python", "c"])
def test_files_with_hostile_names_run(language: str, tmp_path: Path) -> None:
    """Also if no mass moves with a joint, whose name is in the file."""
    mbs, run = model(HOSTILE_MIX), CEquations if language == "c" else PythonEquations
    made = generate(mbs, b"<mbsDescR7/>", "*/ \\\n'.mbs", EquationOptions(language=language))
    m, c = run(made, mbs, tmp_path).dirdyna(random_state(mbs, np.random.default_rng(1)))
    assert np.isfinite(m).all()
    assert np.isfinite(c).all()
    mbs.cuts, mbs.bodies[1].joints[0].nature = [], "independent"
    made = generate(mbs, b"<mbsDescR7/>", "arm.mbs", EquationOptions(language=language))
    assert "no matter moves" in made.left_out["accelred"]
    run(made, mbs, tmp_path)


@pytest.mark.parametrize(
    ("name", "code", "says"),
    [
        ("double", 0, ""),
        ("lambda", 0, ""),
        ("a" * 500, 2, "cannot write"),  # no file system takes it
        ("bras_droité", 1, "<mbsname>"),
        ("my robot", 1, "mbsname-no-identifier"),
    ],
)
def test_a_model_whose_name_cannot_be_in_code_is_refused(
    name: str, code: int, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mbs = model(PLAIN)
    mbs.name = name
    path, out = tmp_path / "arm.mbs", tmp_path / "out"
    path.write_bytes(write(mbs))
    assert main(["equations", str(path), "-o", str(out)]) == code
    printed = capsys.readouterr().err
    assert says in printed
    assert "Traceback" not in printed
    assert code == 0 or not list(out.glob("*"))
