"""What commands may do with a broken file, and what not.

A finding is an exception that is not ours, a traceback or control characters in what is printed,
files that are left where a command failed, a model that is not the robot, equations that are not
those of Newton and Euler, more than 20 seconds.
"""

import io
import re
import shutil
import time
import warnings
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np

from support.folders import TESTS
from support.oracle.mbs import Evaluator
from support.oracle.multibody import State
from urdf2mbs import convert, load_equations
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

CORPUS = TESTS / "corpus"
PATIENCE = 20.0
"""s"""
CONVERT = (
    "lint {}",
    "convert {} -o out/",
    "report {} -o out/page.html",
    "verify {} tiny.mbs",
    "convert {} -o out/ --pipeline compact --set snap.angle=0.01",
)
MODEL = (
    "diagram {} -o out/a.svg",
    "verify tiny.urdf {}",
    "diff tiny.mbs {}",
    "equations {} -o out/ --language c --energy --derivatives",
)
MESHES = ("stl", "obj", "ply", "dae", "glb", "gltf", "wrl")
#: Each kind of file: its name, and the commands that read it.
KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "urdf": ("broken.urdf", CONVERT),
    "xacro": ("broken.xacro", CONVERT),
    "include": ("broken.inc", ("convert include.xacro -o out/",)),
    "numbers": ("broken.inc", ("convert numbers.xacro -o out/",)),
    "config": ("broken.yaml", ("run {}", "explain {}")),
    "srdf": (
        "broken.srdf",
        ("convert tiny.urdf -o out/ --set posture.srdf={} --set posture.state=home",),
    ),
    "mbs": ("broken.mbs", MODEL),
    **{kind: (f"broken.{kind}", (f"convert {kind}.urdf -o out/",)) for kind in MESHES},
    "certificate": ("p/dataR/p.proof.json", ("verify tiny.urdf p",)),
}
#: Good files that ``prepare`` makes.
MADE = {"mbs": ("tiny.mbs", "closed/dataR/closed.mbs"), "certificate": ("p/dataR/p.proof.json",)}
MESHED = (
    '<robot name="r"><link name="a"><visual><geometry><mesh filename="broken.{}"/></geometry>'
    "</visual></link></robot>"
)


class Finding(Exception):  # noqa: N818
    """What a broken file must not do."""


def prepare() -> None:
    """The files that broken ones are used with, in the working folder."""
    for file in (CORPUS / "around").iterdir():
        shutil.copy(file, ".")
    shutil.copy(CORPUS / "srdf" / "good", "r.srdf")
    for kind in MESHES:
        Path(f"{kind}.urdf").write_text(MESHED.format(kind))
    Path("tiny.urdf").write_text(TINY)
    Path("tiny.mbs").write_bytes(convert("tiny.urdf").data)
    convert("tiny.urdf", output={"project": "p"}).write()
    shutil.copy(CORPUS / "config" / "good-closed", "closed.yaml")
    carry_out("run closed.yaml")


def files_of(kind: str) -> list[Path]:
    """The files that the fuzzer starts from: those of the corpus, and those that are made."""
    return [*sorted((CORPUS / kind).glob("*")), *map(Path, MADE.get(kind, ()))]


def attempt(kind: str, data: bytes) -> list[str]:
    """Carry out all commands of a kind in the working folder; gives the code of each one's error,
    or ''.  Raises what must not be."""
    name, commands = KINDS[kind]
    before, codes = {*Path().iterdir()}, []
    for command in commands:
        begin = time.monotonic()
        Path(name).write_bytes(data)
        try:
            codes.append(carry_out(command.format(name)))
            left = {*Path().iterdir()} - before - {Path(name), Path("cache")}
            if codes[-1] and left:
                raise Finding(f"{command} fails, and leaves {left}")
            if command.startswith("equations") and not codes[-1]:
                compare_equations(name)
        finally:
            for path in {*Path().iterdir()} - before:
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        if time.monotonic() - begin > PATIENCE:
            raise Finding(f"{command} takes {time.monotonic() - begin:.0f} s")
    return codes


def carry_out(command: str) -> str:
    """The code of the command's error, or ''."""
    said, code, status = io.StringIO(), "", 0
    with redirect_stdout(said), redirect_stderr(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            status = main([*command.split(), "--debug"])
        except ConversionError as error:
            code = error.code
            print(error)
            if code in ("internal", "plugin-failed"):
                raise
    if status == 3 and not command.startswith("verify"):
        raise Finding(f"{command}: {said.getvalue()}")
    if re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]|Traceback \(most", said.getvalue()):
        raise Finding(f"{command} prints {said.getvalue()!r}")
    return code


def compare_equations(model: str) -> None:
    """Mass matrix and bias of the generated Python must be those of Newton and Euler's laws."""
    try:
        robot = load_equations(model, language="python")
    except ConversionError:  # of what equations do not read
        return
    data, chance = robot.data, np.random.default_rng(1)
    moves = np.zeros(data.njoint + 1)
    moves[[*data.qu[1:], *data.qv[1:]]] = 1.0
    with np.errstate(all="ignore"):
        q, qd = data.q0 + moves * chance.uniform(-1.0, 1.0, len(moves)), moves * chance.random()
        try:
            state = State(Evaluator(data._run.source).system, q, qd)
        except ValueError:  # what Robotran would drop in silence
            return
        mass, bias = state.equations()
        given = robot.mass_matrix(q[1:]), robot.bias(q[1:], qd[1:])
        reach = 1.0 + float(np.abs(state.frames[:, :3, 3]).sum())
        parts = [part for _, part in state.system.matter]
        size = sum(abs(part.mass) * reach**2 + np.abs(part.tensor).sum() for part in parts)
        size *= len(moves) ** 2 + max(map(abs, data._run.mbs.base.gravity))
        off = [*np.ravel(given[0] - mass[1:, 1:]), *(given[1] - bias[1:])]
    if np.isfinite(size) and not all(abs(value) <= 1e-9 * size for value in off):
        raise Finding(f"the equations are not those of the laws: {given}, {mass}, {bias}")
