"""The page of an .mbs alone: its own shapes, its own meshes, nothing of a URDF."""

import json
from pathlib import Path

import pytest

from support.meshes import wrl
from support.pages.html import Html
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import (
    Base,
    Body,
    Connection,
    Joint,
    Mbs,
    Parameter,
    Point,
    Sensor,
    Shape,
    UserModel,
)
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY
from urdf2mbs_report.page import Page, make_model_page

TEXTURED = (
    wrl.SQUARE + b" texCoord TextureCoordinate { point [0 0 1 0 1 1 0 1] }",
    b'texture ImageTexture { url "skin.png" }',
)


def slider(*shapes: Shape) -> Mbs:
    """Make a driven slider on a rod that turns, a cut, and a cut that is a draft."""
    rod = Body("rod", None, "pin", [Joint("turn", "R2", q=0.5)], mass=2.0, com=(0.0, 0.0, 0.1))
    rod.points = [Point("tip", (0.0, 0.0, 3.0), sensor=Sensor("gauge", ("Pos",)))]
    rod.shapes = list(shapes)
    mass = Body("mass", "rod", "tip", [Joint("shift", "T3", "driven", q=0.2)], mass=1.0)
    return Mbs(
        "sketch",
        base=Base(points=[Point("pin", (0.0, 0.0, 1.0))]),
        bodies=[rod, mass],
        cuts=[
            Connection("ball", "tied", (None, "pin"), ("mass", None)),
            Connection("ball", "draft", ("", ""), ("mass", None)),
        ],
    )


def test_what_has_no_meaning_is_left_out(tmp_path: Path) -> None:
    html = Html(make_model_page(slider(), tmp_path / "m.mbs").data)
    ids = {given.get("id") for _, given in html.elements}
    assert {"model", "diagram", "joints", "bodies", "around", "tree", "sliders"} <= ids
    assert not ids & {"names", "left-out", "proof", "messages", "agreement", "show-collisions"}
    assert "URDF" not in html.visible
    assert "{{" not in html.visible
    assert "{%" not in html.visible
    assert "3 kg" in html.visible
    assert "not chosen yet" in html.visible
    lines = html.island["marks"]["lines"]
    assert [(kind, a[1], b[0]) for kind, a, b in lines] == [("ball", [0, 0, 1], "mass")]
    assert html.island["size"] == pytest.approx(3.2 * 0.8775825618903728 + 0.0, rel=0.2)


def test_meshes_come_from_the_project(tmp_path: Path) -> None:
    folder = tmp_path / "animationR"
    folder.mkdir()
    (folder / "a.wrl").write_bytes(wrl.of(*TEXTURED))
    (folder / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "bad.wrl").write_bytes(b"#VRML V2.0 utf8\nShape {")
    urls = (
        "PRJPATH/animationR/a.wrl",
        "PRJPATH\\animationR\\a.wrl",
        f"PRJPATH/{tmp_path.name}/animationR/a.wrl",
        "PRJPATH/animationR/t.obj",
        "PRJPATH/animationR/bad.wrl",
        "C:\\Users\\x\\gone.obj",
    )
    shapes = [Shape("inline", f"s{n}", url=url) for n, url in enumerate(urls)]
    for picture, textures in ((b"\x89PNG\r\n and so on", 1), (b"root:x:0:0", 0)):
        (folder / "skin.png").write_bytes(picture)
        page = make_model_page(slider(*shapes), tmp_path / "dataR" / "m.mbs")
        drawn = Html(page.data).island
        numbers = [shape["mesh"] for shape in drawn["mbs"]["bodies"][0]["shapes"]]
        assert numbers == [0, 1, 2, 3, None, None]
        assert len(drawn["textures"]) == textures, "what is no picture stays out of the page"
        assert page.missing == list(urls[4:])
        assert "2 meshes cannot be drawn" in Html(page.data).visible


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / "sketch.mbs"
    model.write_bytes(write(slider()))
    assert main(["report", str(model)]) == 0
    assert (tmp_path / "sketch.html").exists()
    output = capsys.readouterr().out
    assert "page of the model" in output
    assert "the same robot" not in output
    assert main(["report", str(model), "-o", str(tmp_path / "x.html"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["missing"] == []
    assert main(["report", str(model), "--base", "fixed"]) == 2
    assert "--base" in capsys.readouterr().err


def test_the_meshes_of_a_bare_urdf_are_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    visual = '<visual><geometry><mesh filename="t.obj"/></geometry></visual>'
    source = tmp_path / "tiny.urdf"
    source.write_text(TINY.replace("<inertial>", f"{visual}<inertial>", 1))
    assert main(["report", str(source), "-o", str(tmp_path / "page.html")]) == 0
    assert "not drawn" not in capsys.readouterr().out
    html = Html((tmp_path / "page.html").read_bytes())
    assert "no .wrl file is there yet" in html.visible
    shapes = [s for body in html.island["mbs"]["bodies"] for s in body["shapes"]]
    shapes += html.island["mbs"]["base"]["shapes"]
    assert [s["mesh"] for s in shapes if s["kind"] == "inline"] == [0]


@pytest.mark.slow
def test_all_samples_have_a_page(shared: Path) -> None:
    from urdf2mbs.mbs.reader import read_mbs

    for file in sorted((shared / "mbs-samples").glob("*.mbs")):
        model = read_mbs(file.read_bytes(), str(file))
        bodies = Html(make_model_page(model, file).data).island["mbs"]["bodies"]
        assert len(bodies) == len(model.bodies), file.name


@pytest.mark.parametrize("word", ["low", "1,5"])
def test_a_limit_that_is_no_number_is_told(
    word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "sketch.mbs"
    robot = slider()
    robot.user_models = [
        UserModel(
            "q_min", [Parameter("turn", "scalar", (word,)), Parameter("shift", "scalar", ("-1",))]
        ),
        UserModel("q_max", [Parameter("turn", "scalar", ("2",)), Parameter("none", "x", ("y",))]),
    ]
    page = make_model_page(robot, model)
    assert dict(Html(page.data).island["marks"]["stops"]) == {
        "turn": [None, 2.0],
        "shift": [-1.0, None],
    }
    model.write_bytes(write(robot))
    assert main(["report", str(model)]) == 0
    err = capsys.readouterr().err
    assert f"sketch.mbs: warning[limit-unreadable]: joint 'turn': q_min is '{word}'" in err
    assert err.count("expected a number") == 1


def results(folder: Path, text: str) -> Page:
    """Make the page of a project whose results are this text."""
    (folder / "resultsR").mkdir()
    (folder / "resultsR" / "dirdyn.csv").write_text(text, "utf-8")
    return make_model_page(slider(), folder / "dataR" / "m.mbs")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("q.turn,q.shift\n1,2\n", "it has no column 'time'"),
        ("time,q.turn\n0,1\n", "its joints are not those of the model"),
        ("time,q.turn,q.shift\n0,1,low\n", "could not convert string to float: 'low'"),
        ("time,q.turn,q.shift\n0,1\n", "not as many numbers as the first one has names"),
        ("time,q.turn,q.shift\n", "it has no rows"),
        ("", "it has no rows"),
        ("time,q.turn,q.shift\nnan,1,2\n", "a time is not a finite number"),
        (
            "time,q.turn,q.shift,push1.rod.Fx\n0,1,2,3\n",
            "it has no column 'push1.rod.Fy', 'push1.rod.Fz', 'push1.rod.dx' and 2 more",
        ),
    ],
)
def test_results_that_cannot_be_played_are_told(text: str, why: str, tmp_path: Path) -> None:
    page = results(tmp_path, text)
    (diagnostic,) = page.diagnostics
    assert (diagnostic.code, diagnostic.level) == ("motion-unreadable", "warning")
    assert diagnostic.file == str(tmp_path / "resultsR" / "dirdyn.csv")
    assert diagnostic.message.startswith("the page plays no motion: ")
    assert why in diagnostic.message
    assert Html(page.data).island["motion"] is None


def test_results_that_can_be_played_and_none(tmp_path: Path) -> None:
    assert make_model_page(slider(), tmp_path / "dataR" / "m.mbs").diagnostics == []
    page = results(tmp_path, "q.turn,time,q.shift\n1,0,2\n")
    assert page.diagnostics == []
    assert Html(page.data).island["motion"]["joints"] == ["turn", "shift"]
