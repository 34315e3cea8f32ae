"""The checksum of a model changes if its equations change, and not by other edits."""

import re
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from support.mbs_models import everything
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_equations import equations_fit
from urdf2mbs_equations.equations_fit import check_equations, fingerprint, fits
from urdf2mbs_equations.files import FUNCTIONS, generate
from urdf2mbs_equations.options import EquationOptions


@pytest.fixture(scope="module")
def model() -> bytes:
    return convert_text(base="fixed").data


def code(model: bytes, functions: Iterable[str] = FUNCTIONS, **options: Any) -> tuple[str, bytes]:
    """Return the code of all equations without their heads, and the head of a file."""
    settings = EquationOptions(language="python", **options)
    made = generate(read_mbs(model, "m.mbs"), model, "m.mbs", settings, functions)
    texts = [re.sub(rb"(?m)^#.*\n", b"", text) for text in made.files.values()]
    return b"".join(texts).decode(), next(iter(made.files.values()))


@pytest.mark.parametrize("options", [{}, {"fold": True}])
def test_equations_fit_the_model_that_they_were_made_of(
    model: bytes, options: dict[str, bool]
) -> None:
    assert fits(code(model, **options)[1], model) is True
    assert fits(b"# of another program", model) is None


def test_the_file_may_have_any_encoding_and_unknown_elements(model: bytes) -> None:
    plain, text = fingerprint(model, "tree"), model.decode()
    for data in (
        text.encode("utf-16"),
        b"\xef\xbb\xbf" + model,
        text.replace("UTF-8", "GBK").encode("gbk"),
        text.replace("<inertia>", "<inertia><unit>kg m2</unit><x>t</x>").encode(),
    ):
        read_mbs(data, "m.mbs")
        assert fingerprint(data, "tree") == plain, data[:60]


def test_whatever_changes_the_equations_changes_the_checksum(model: bytes) -> None:
    """Set each number of the model to zero, and to another number."""
    some: Any = {"functions": ("invdyna", "gensensor")}
    plain, head = code(model, **some)
    changed = 0
    for match in re.finditer(rb"<(?:mass|q|x|y|z|I..)>(-?[0-9][0-9.e-]*)<", model):
        before = model[: match.start()]
        if before.count(b"<graphics>") > before.count(b"</graphics>"):
            continue
        for new in (b"0.0", b"0.7625"):
            other = model[: match.start(1)] + new + model[match.end(1) :]
            differs = code(other, **some)[0] != plain
            changed += differs
            assert not (differs and fits(head, other)), (match, new)
    assert changed > 10


#: An edit of the model that has everything, and the first of the checksums that it changes.
EDITS = {
    ("sensor of other measures", '<sensor name="imu" Pos="true"', '<sensor name="imu"'): "tree",
    ("force of other measures", '"push" Pos="true"', '"push"'): "tree",
    ("no sensor", '<sensor name="touch"/>', ""): "tree",
    ("renamed sensor", '"imu"', '"eye"'): "",
    ("renamed point", "tip</pointname>", "end</pointname>"): "",
    ("renamed body", "arm</bodyname>", "limb</bodyname>"): "",
    ("renamed joint", "swing</jointname>", "sway</jointname>"): "",
    (
        "another end",
        "<pointname>rail</pointname>\n      </endpoint2>",
        "<pointname>origin</pointname>\n      </endpoint2>",
    ): "tree",
    (
        "another body's end",
        "<bodyname>leg</bodyname>\n        <pointname>origin</pointname>\n"
        "      </endpoint2>\n      <length>",
        "<bodyname>arm</bodyname>\n        <pointname>origin"
        "</pointname>\n      </endpoint2>\n      <length>",
    ): "tree",
    ("another kind of link", "link3D>", "link>"): "tree",
    ("no length", "<length>2.765625<", "<length>0.0<"): "tree",
    ("another length", "<length>2.765625<", "<length>2.5<"): "numbers",
    ("another mass", "<mass>0.140625<", "<mass>0.25<"): "numbers",
    ("another centre", "<x>0.15625<", "<x>0.25<"): "numbers",
    ("no centre", "<x>0.15625<", "<x>0.0<"): "tree",
    ("a centre that rounding left", "<x>0.15625<", "<x>1e-17<"): "tree",
    ("another inertia", "<Ixy>0.21875<", "<Ixy>0.25<"): "numbers",
    ("no gravity along x", "<x>2.171875<", "<x>0.0<"): "tree",
    ("a point at zero", "<x>0.375<", "<x>0.0<"): "tree",
    ("a driven joint that starts elsewhere", "<q>0.09375<", "<q>0.5<"): "fixed",
    ("a free joint that starts elsewhere", "<q>0.015625<", "<q>0.5<"): "",
    (
        "a driven joint that moves",
        "<q/>\n        </symbols>",
        "<q/><qd/>\n        </symbols>",
    ): "tree",
    ("another axis", "<type>R3<", "<type>R2<"): "tree",
    ("another nature", "<nature>independent<", "<nature>driven<"): "tree",
    ("no mass", "<mass>0.140625</mass>", ""): "tree",
    ("other line ends", "\n", "\r\n"): "",
    ("moved in the diagram", "<position>", "<position><x>77.0</x>"): "",
    ("another name", "<mbsname>machine<", "<mbsname>robot<"): "tree",
    (
        "the other parent point",
        "shoulder</pointname>\n      </parent>",
        "handle</pointname>\n      </parent>",
    ): "tree",
}


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit[0])
def test_each_part_of_a_model_counts_as_far_as_the_equations_rely_on_it(
    edit: tuple[str, str, str],
) -> None:
    _, old, new = edit
    text = write(everything()).decode()
    assert old in text
    counts = [
        fingerprint(text.encode(), parts) != fingerprint(text.replace(old, new).encode(), parts)
        for parts in ("tree", "tree, fixed", "tree, numbers")
    ]
    first = ("tree", "fixed", "numbers", "").index(EDITS[edit])
    assert counts == [False] * first + [True] * (3 - first)


PARTS = ("tree", "tree, fixed", "tree, numbers")
PROGRAM = """
#include "equations_fit.h"
int main(int count, char **words)
{
    return !check_equations(words[count - 1]);
}
"""


@pytest.fixture(scope="module")
def check_in_c(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return a function that compiles and runs the check in C, for given heads of equations."""
    gcc = shutil.which("gcc") or pytest.skip("gcc is not there")
    folder = tmp_path_factory.mktemp("fit")
    source = Path(equations_fit.__file__).with_suffix(".c")
    (folder / "main.c").write_text(PROGRAM)

    def build(heads: dict[str, tuple[str, str]], *, has_equations: bool = True) -> Path:
        rows = "".join(f'{{"{file}", "{a}", "{b}"}}, ' for file, (a, b) in heads.items())
        (folder / "equations_of_build.h").write_text(
            f"#define HAS_EQUATIONS {int(has_equations)}\n#define EQUATIONS_HEADS {rows}\n"
        )
        program = folder / f"exe{len(list(folder.iterdir()))}"
        command = [
            gcc,
            "-std=c99",
            "-pedantic",
            "-O1",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-fsanitize=address,undefined",
            "-fno-sanitize-recover",
            f"-I{folder}",
            f"-I{source.parent}",
            "-DWITH_EQUATIONS_OF_BUILD",
            '-DBUILD_FOLDER="b"',
            str(folder / "main.c"),
            str(source),
            "-o",
            str(program),
            "-lm",
        ]
        subprocess.run(command, check=True)
        return program

    return build


def run(program: Path, model: bytes) -> str:
    """Return what a program says of a model; nothing where its equations fit."""
    file = program.parent / "model.mbs"
    file.write_bytes(model)
    done = subprocess.run([program, file], check=False, capture_output=True, text=True)
    assert done.returncode == (1 if done.stderr else 0), done.stderr
    return done.stderr


def test_c_finds_the_same_differences_as_python(check_in_c: Any) -> None:
    text = write(everything()).decode()
    sums = {parts: fingerprint(text.encode(), parts) for parts in PARTS}
    programs = {parts: check_in_c({"mbs_x_m.c": (parts, sums[parts])}) for parts in PARTS}
    for title, old, new in [("nothing", "", ""), *EDITS]:
        edited = text.replace(old, new) if old else text
        for parts, program in programs.items():
            differs = fingerprint(edited.encode(), parts) != sums[parts]
            assert bool(run(program, edited.encode())) == differs, (title, parts)


def test_c_reads_other_layouts_as_python_does(check_in_c: Any) -> None:
    """Comments, declarations, quotes, empty elements and blanks do not change the checksum."""
    text = write(everything()).decode()
    other = text.replace("<mass>", "<!-- <mass> > -->\n<mass> ").replace("<q/>", "<q note='>'/>")
    other = "<?xml version='1.0'?><!DOCTYPE mbsDescR7>\n" + other.partition("?>")[2]
    other = re.sub(r'(\w+)="true"', r"\1 = 'true' ", other)
    sums = {parts: (parts, fingerprint(other.encode(), parts)) for parts in PARTS}
    assert [fingerprint(text.encode(), parts) for parts in PARTS] == [s for _, s in sums.values()]
    program = check_in_c(sums)
    assert run(program, text.encode()) == run(program, other.encode()) == ""
    half = len(text) // 2
    for data in (b"", b"<", b"<a", text[:half].encode(), text.encode("utf-16")):
        run(program, data)  # no fault of memory, which the sanitizers would tell
    (program.parent / "model.mbs").unlink()
    subprocess.run([program, program.parent / "model.mbs"], check=True)  # mbs_load says so


def test_c_says_which_commands_to_run(model: bytes, check_in_c: Any) -> None:
    stale = {"mbs_dirdyna_m.c": ("tree", "0" * 64), "mbs_link_m.c": ("tree", "1" * 64)}
    fine = {"mbs_sensor_m.c": ("tree", fingerprint(model, "tree"))}
    message = run(check_in_c({**fine, **stale}), model)
    assert "equations of another model than " in message
    assert "model.mbs: mbs_dirdyna_m.c and 1 more." in message
    assert re.search(r'\n +urdf2mbs equations ".*model\.mbs"\n +cmake --build "b"\n', message)
    message = run(check_in_c({}, has_equations=False), model)
    assert "was built without equations of motion" in message
    assert "urdf2mbs equations" in message


def test_a_turn_that_never_moves_counts(model: bytes) -> None:
    other = convert_text(TINY.replace("0 0.5 0", "0 0.6 0"), base="fixed").data
    assert fingerprint(other, "tree") == fingerprint(model, "tree")
    assert fingerprint(other, "tree, fixed") != fingerprint(model, "tree, fixed")


def test_a_program_ends_where_its_equations_are_of_another_model(
    model: bytes, tmp_path: Path
) -> None:
    for folder in ("dataR", "symbolicR"):
        (tmp_path / folder).mkdir()
    for name in ("mbs_invdyna_m.py", "mbs_sensor_m.py"):
        (tmp_path / "symbolicR" / name).write_bytes(code(model)[1])
    (tmp_path / "symbolicR" / "mbs_invdyna_other.py").write_bytes(
        b"# Fits (tree): sha256 " + b"0" * 64
    )
    (tmp_path / "dataR" / "m.mbs").write_bytes(model)
    check_equations(tmp_path, "m")
    (tmp_path / "dataR" / "m.mbs").write_bytes(model.replace(b"<type>R3<", b"<type>R2<"))
    with pytest.raises(
        SystemExit, match=r"another model than .*m\.mbs: mbs_invdyna_m\.py and 1 more"
    ):
        check_equations(tmp_path, "m")
