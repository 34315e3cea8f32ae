"""Robots with an oddity each: what converts, what is refused, and what is said of it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.folders import SHARED
from urdf2mbs.cli import main
from urdf2mbs.mbs.reader import read_mbs

#: Exit code, code of the error or warning (None: no warning), and a word of its message; by the
#: number of the file in ../shared/odd-robots.
SHARED_ROBOTS: dict[str, tuple[int, str | None, str]] = {
    "01": (0, None, ""),
    "02": (0, "inertia-indefinite", "-3.53486e-08, 3.50085e-08, 9.08701e-08"),
    "03": (0, "mimic-left-out", "'elsewhere' is no joint, so its followers move freely"),
    "04": (0, "mesh-scale", "taken for all directions: link 'base' (.00254)"),
    "05": (0, "xml-mended", "there are blanks before it"),
    "06": (0, "xml-mended", "no XML version '0.0'"),
    "07": (0, "property-unused", "property 'M_PI'"),
    "08": (0, "xacro-left", "xacro did not expand <xacro:v1_pelvis_sensors_usb>"),
    "09": (0, None, ""),
    "10": (0, "number-commas", "numbers are separated by commas"),
    "11": (0, "number-left-out", "lower of <limit> is '-pi/2'"),
    "12": (0, "no-mass", "NO DYNAMICS"),
    "13": (0, "world-implied", "it is implied"),
    "14": (1, "merge-conflict", "a merge conflict was left in the file"),
    "15": (0, "inertia-incomplete", "(ixy, ixz, iyz)"),
    "16": (0, "number-left-out", "<dynamics> is left out"),
    "17": (0, None, ""),
    "18": (0, "package-unresolved", "'pkg' was not found"),
    "19": (0, "xml-mended", "says no version"),
    "20": (0, "xml-mended", "'--' within a comment"),
}


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Callable[..., Any]:
    """Convert a file; the exit code, what was said, and the .mbs that is there."""
    monkeypatch.chdir(tmp_path)

    def convert(source: Path | str, *words: str) -> tuple[int, str, Path]:
        output = tmp_path / "out.mbs"
        output.unlink(missing_ok=True)
        code = main(["convert", "--no-plugins", str(source), "-o", str(output), *words])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        assert output.exists() == (code == 0)
        assert [file for file in tmp_path.iterdir() if file.name.endswith(".part")] == []
        if code == 0:
            assert "  the same robot" in said.out
            assert read_mbs(output.read_bytes(), "").bodies
        return code, said.out + said.err, output

    return convert


def check(run: Callable[..., Any], source: Path, wanted: tuple[int, str | None, str]) -> None:
    exit_code, code, word = wanted
    for preset in ("faithful", "compact"):
        found, said, _ = run(source, "--pipeline", preset)
        assert found == exit_code, said
        assert word in said
        level = "error" if exit_code else "warning"
        told = [
            line.partition("[")[2].partition("]")[0]
            for line in said.splitlines()
            if f"{level}[" in line
        ]
        # a body that lost its inertia may make the mass matrix singular, too
        told = [one for one in told if one not in ("singular", "base-guessed")]
        if code != "mesh-missing":  # no file has its meshes beside it
            told = [one for one in told if one != "mesh-missing"]
        assert told == ([] if code is None else [code]), said


def shared_file(number: str) -> Path:
    folder = SHARED / "odd-robots"
    if not folder.is_dir():
        pytest.skip(f"the odd robots are not here: {folder} does not exist")
    return next(folder.glob(f"{number}_*.urdf"))


@pytest.mark.parametrize("number", SHARED_ROBOTS)
def test_shared_odd_robot(number: str, run: Callable[..., Any]) -> None:
    check(run, shared_file(number), SHARED_ROBOTS[number])


def test_the_unknown_macro_is_left_out_if_the_user_says_so(run: Callable[..., Any]) -> None:
    source = shared_file("08")
    for level in ("warning", "note", "ignore"):
        code, said, output = run(source, "--level", f"xacro-left={level}")
        assert code == 0
        assert ("warning[xacro-left]" in said) == (level == "warning")
        assert "--level" not in said  # which is set already
        assert [body.name for body in read_mbs(output.read_bytes(), "").bodies] == ["base_body"]
