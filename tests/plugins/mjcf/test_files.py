"""An MJCF is data: MuJoCo reads no file outside of its folder, and a crash is an error in words."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from random import Random
from typing import Any

import pytest

from support.mjcf import ARM, with_parts
from urdf2mbs import convert
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_mjcf import process

pytest.importorskip("mujoco")

SECRET = '<mujoco><worldbody><body name="secret"><geom size="1"/></body></worldbody></mujoco>'
CUBE = """v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a model, beside files that are none of its business."""
    outside, model = tmp_path / "outside", tmp_path / "model"
    outside.mkdir()
    model.mkdir()
    (outside / "secret.xml").write_text(SECRET)
    (outside / "cube.obj").write_text(CUBE)
    (model / ".hidden.xml").write_text(SECRET)
    (model / "link.xml").symlink_to(outside / "secret.xml")
    (model / "cube.obj").write_text(CUBE)
    monkeypatch.chdir(model)
    return model


def make(text: str, **fields: Any) -> Any:
    Path("robot.xml").write_text(text)
    return convert("robot.xml", **fields)


def fail(text: str | bytes, **fields: Any) -> ConversionError:
    Path("robot.xml").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ConversionError) as caught:
        convert("robot.xml", **fields)
    return caught.value


def with_mesh(file: str, compiler: str = "") -> str:
    asset = f'{compiler}<asset><mesh name="m" file="{file}"/></asset>'
    text = with_parts().replace("<worldbody>", f"{asset}<worldbody>")
    return text.replace('<geom name="gb" type="box"', '<geom name="gb" type="mesh" mesh="m"')


@pytest.mark.parametrize(
    "part",
    [
        '<include file="../outside/secret.xml"/>',
        '<include file="OUTSIDE/secret.xml"/>',
        '<include file="/etc/passwd"/>',
        '<include file=".hidden.xml"/>',
        '<include file="link.xml"/>',
        '<include file="..&#47;outside/secret.xml"/>',
        '<asset><model name="s" file="../outside/secret.xml"/></asset>',
        '<asset><mesh file="../outside/cube.obj"/></asset>',
        '<asset><hfield name="h" file="../outside/cube.obj"/></asset>',
        '<asset><texture type="cube" fileup="../outside/cube.obj"/></asset>',
        '<asset><skin file="../outside/cube.obj"/></asset>',
        '<compiler meshdir="../outside"/><asset><mesh file="cube.obj"/></asset>',
        '<compiler assetdir="../outside"/><asset><texture file="cube.obj"/></asset>',
        '<asset><mesh file="https:cube.obj"/></asset>',
    ],
)
def test_a_file_outside_is_refused(folder: Path, part: str) -> None:
    part = part.replace("OUTSIDE", str(folder.parent / "outside"))
    error = fail(with_parts(option=part))
    assert error.code == "mjcf-file"
    assert (error.file, error.line) == (str(folder / "robot.xml"), 3)
    assert "--trust-xacro" in (error.hint or "")


def test_an_included_file_is_held_to_the_same_rule(folder: Path) -> None:
    (folder / "part.xml").write_text('<mujoco>\n<include file="../outside/secret.xml"/></mujoco>')
    error = fail(with_parts(option='<include file="part.xml"/>'))
    assert (error.code, error.file) == ("mjcf-file", str(folder / "part.xml"))


def test_with_trust_or_as_a_package_a_file_is_read(folder: Path) -> None:
    text = with_parts(option='<include file="../outside/secret.xml"/>')
    assert "secret" in make(text, trust_xacro=True).robot.links
    assert "secret" in make(text, packages={"outside": "../outside"}).robot.links
    (folder.parent / "__init__.py").touch()  # a Python package, as most models come in
    assert "secret" in make(text).robot.links


def test_files_of_the_model_are_read(folder: Path) -> None:
    (folder / "parts").mkdir()
    (folder / "parts" / "part.xml").write_text(SECRET)
    result = make(with_parts(option='<include file="parts/part.xml"/>'))
    assert "secret" in result.robot.links
    assert [Path(name).name for name in result.conversion.input.expansion.files] == [
        "robot.xml",
        "part.xml",
    ]
    (folder / "meshes").mkdir()
    shutil.copy("cube.obj", "meshes/far.obj")
    (visual,) = make(with_mesh("far.obj", '<compiler meshdir="meshes"/>')).robot.links["b"].visuals
    assert visual.geometry.filename == "meshes/far.obj"


@pytest.mark.parametrize("file", ["robot.mjcf", "robot.XML", "robot"])
def test_a_file_may_have_any_ending(file: str, folder: Path) -> None:
    """MuJoCo reads only .xml by itself; included files and meshes are found all the same."""
    (folder / "parts").mkdir()
    part = (
        '<mujoco><worldbody><body name="part"><joint/><geom size=".1"/></body></worldbody></mujoco>'
    )
    (folder / "parts" / "part.xml").write_text(part)
    text = with_mesh("cube.obj", '<include file="parts/part.xml"/>')
    expected = make(text)
    assert "part" in expected.robot.links
    Path(file).write_text("\ufeff" + text, encoding="utf-8")
    result = convert(file, output="robot.mbs")
    assert result.data == expected.data


def test_a_mesh_is_where_its_file_has_it(folder: Path) -> None:
    """MuJoCo has moved it to its centre, and turned it to its axes."""
    import mujoco

    text = with_mesh("cube.obj").replace('name="m"', 'name="m" scale="1 2 3" refpos=".1 .2 .3"')
    (visual,) = make(text).robot.links["b"].visuals
    model = mujoco.MjModel.from_xml_path("robot.xml")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "gb")
    rotation, position = data.geom_xmat[number].reshape(3, 3), data.geom_xpos[number]
    theirs = model.mesh_vert @ rotation.T + position - data.xpos[2]
    import numpy as np

    pose = visual.origin.pose
    ours = np.array([[x, 2 * y, 3 * z] for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))])
    ours = ours @ np.reshape(pose.rot, (3, 3)).T + np.array(pose.xyz)
    assert ours.min(axis=0) == pytest.approx(theirs.min(axis=0), abs=1e-6)
    assert ours.max(axis=0) == pytest.approx(theirs.max(axis=0), abs=1e-6)


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("<mujoco><worldbody>", "xml-truncated", ""),
        ("<mujoco>\n<worldbody><bodi/></worldbody></mujoco>", "mjcf-invalid", "bodi"),
        (with_parts(option='<include file="robot.xml"/>'), "mjcf-invalid", "already"),
        (with_parts(option='<include file="nothing.xml"/>'), "mjcf-invalid", "nothing.xml"),
        (with_mesh("broken.obj"), "mjcf-invalid", "vertices"),
        (with_mesh("broken.stl"), "mjcf-invalid", "broken.stl"),
        (with_mesh("robot.xml"), "mjcf-invalid", "robot.xml"),
        ('<!DOCTYPE mujoco SYSTEM "secret.dtd"><mujoco/>', "mjcf-invalid", "document type"),
        ('<!DOCTYPE mujoco [<!ENTITY a "b">]><mujoco>&a;</mujoco>', "xml-entity", ""),
        (ARM.encode("utf-8").replace(b"trunk", b"tr\xfcnk"), "mjcf-invalid", "UTF-8"),
        (with_parts().replace(' mass="2"', ' mass="0"'), "mjcf-invalid", "mass"),
        (with_parts(option='<size memory="9999P"/>'), "mjcf-invalid", ""),
        ("<mujoco/>", "no-mass", ""),
    ],
)
def test_a_broken_file_is_an_error_in_words(
    folder: Path, text: str | bytes, code: str, said: str
) -> None:
    (folder / "broken.obj").write_text("v 1 2\nf 1 2 3")
    (folder / "broken.stl").write_bytes(b"\0" * 100)
    if code == "no-mass":  # a world with nothing in it
        Path("robot.xml").write_text(str(text))
        assert code in {said.code for said in convert("robot.xml").diagnostics}
        return
    error = fail(text)
    assert error.code == code
    assert said in error.message


def test_a_file_that_two_readers_read_differently_is_refused(folder: Path) -> None:
    """In UTF-16 or EBCDIC, lxml might see no include where MuJoCo's parser sees one."""
    hidden = '<mujoco><!-- --><include file="../outside/secret.xml"/></mujoco>'
    for encoding in ("utf-16", "utf-7", "cp037"):
        declared = f'<?xml version="1.0" encoding="{encoding}"?>{hidden}'
        assert fail(declared).code in ("mjcf-file", "xml-syntax")
    assert fail(hidden.encode("utf-16")).code != "internal"


def test_a_crash_and_a_long_run_are_errors_in_words(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = folder / "compiler.py"
    monkeypatch.setattr(process, "_SCRIPT", script)
    script.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    error = fail(with_parts())
    assert error.code == "mjcf-crash"
    assert "Segmentation fault" in error.message
    script.write_text("raise SystemExit('the end')\n")
    assert "the end" in fail(with_parts()).message
    script.write_text("import sys\nsys.stdin.read()\n")  # no result
    assert fail(with_parts()).code == "mjcf-crash"
    script.write_text("while True:\n    pass\n")
    monkeypatch.setattr(process, "MAX_SECONDS", 0.2)
    error = fail(with_parts())
    assert (error.code, "0.2 s" in error.message) == ("mjcf-too-large", True)


def test_nothing_is_left_behind(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    # an unstable model, of which MuJoCo writes a log file
    make(with_parts())
    fail(with_parts(option="<bodi/>"))
    assert list(scratch.iterdir()) == []
    assert sorted(path.name for path in folder.iterdir()) == [
        ".hidden.xml",
        "cube.obj",
        "link.xml",
        "robot.xml",
    ]


def test_mutated_files_are_read_or_refused(folder: Path) -> None:
    """Each ends in a robot or in an error with a code; none crashes, or leaves a file."""
    choice = Random(3)
    texts = [ARM, with_mesh("cube.obj")]
    count = int(os.environ.get("URDF2MBS_MUTATIONS", "8"))
    for _ in range(count):
        text = choice.choice(texts)
        for _ in range(choice.randint(1, 3)):
            start = choice.randrange(len(text))
            end = start + choice.randint(0, 8)
            inserted = choice.choice(
                ["", "0", "nan", "-1", "1e308", '"', "<", "/>", "\0", text[: choice.randint(0, 40)]]
            )
            text = text[:start] + inserted + text[end:]
        Path("robot.xml").write_text(text)
        code = ""
        try:
            convert("robot.xml")
        except ConversionError as error:
            code = error.code
        assert code not in ("internal", "plugin-failed", "mjcf-crash"), text
    assert sorted(path.name for path in folder.iterdir()) == [
        ".hidden.xml",
        "cube.obj",
        "link.xml",
        "robot.xml",
    ]


@pytest.mark.skipif(shutil.which("strace") is None, reason="strace is not installed")
def test_mujoco_opens_no_file_outside(folder: Path) -> None:
    Path("robot.xml").write_text(with_mesh("cube.obj"))
    command = ["strace", "-f", "-e", "trace=openat", "-o", "opened", sys.executable, "-m"]
    subprocess.run([*command, "urdf2mbs", "convert", "robot.xml"], check=True, capture_output=True)
    assert "outside" not in Path("opened").read_text()
