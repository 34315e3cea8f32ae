"""The checksum of what equations rely on: it changes when they do, and not by an edit beside."""

import re
from pathlib import Path
from typing import Any

import pytest

from mbs.models import everything
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_equations.equations_fit import check_equations, fingerprint, fits
from urdf2mbs_equations.files import generate


@pytest.fixture(scope="module")
def model() -> bytes:
    return convert_text(base="fixed").data


def code(model: bytes, **options: Any) -> tuple[str, bytes]:
    """The code of all equations without what stands above it, and the head of a file."""
    made = generate(read(model, "m.mbs"), model, "m.mbs", **options)
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
        text.encode("utf-16"), b"\xef\xbb\xbf" + model,
        text.replace("UTF-8", "GBK").encode("gbk"),
        text.replace("<inertia>", "<inertia><unit>kg m2</unit><x>t</x>").encode(),
    ):  # fmt: skip
        read(data, "m.mbs")
        assert fingerprint(data, "tree") == plain, data[:60]


def test_whatever_changes_the_equations_changes_the_checksum(model: bytes) -> None:
    """Each number of the model in turn, made zero and made another."""
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
    ("another end", "<pointname>rail</pointname>\n      </endpoint2>",
     "<pointname>origin</pointname>\n      </endpoint2>"): "tree",
    ("another body's end", "<bodyname>leg</bodyname>\n        <pointname>origin</pointname>\n"
     "      </endpoint2>\n      <length>", "<bodyname>arm</bodyname>\n        <pointname>origin"
     "</pointname>\n      </endpoint2>\n      <length>"): "tree",
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
    ("a driven joint that moves", "<q/>\n        </symbols>",
     "<q/><qd/>\n        </symbols>"): "tree",
    ("another axis", "<type>R3<", "<type>R2<"): "tree",
    ("another nature", "<nature>independent<", "<nature>driven<"): "tree",
    ("no mass", "<mass>0.140625</mass>", ""): "tree",
    ("other line ends", "\n", "\r\n"): "",
    ("moved in the diagram", "<position>", "<position><x>77.0</x>"): "",
    ("another name", "<mbsname>machine<", "<mbsname>robot<"): "tree",
    ("the other parent point", "shoulder</pointname>\n      </parent>",
     "handle</pointname>\n      </parent>"): "tree",
}  # fmt: skip


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
