"""The report as a file: self-contained, honest, safe with any name, the same every time."""

import gzip
import json
import re
import subprocess
import sys
from base64 import b64decode
from pathlib import Path
from typing import Any

import pytest
from lxml.html import document_fromstring

from support.build import SOLID, joint, link, robot
from support.oracle.mbs import Evaluator
from support.pages.html import Html
from support.pages.shown import EVIL, HOSTILE, SHOWN, data, edit, run, shown
from support.plugin_files import write_plugin
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.testing import TINY
from urdf2mbs_report import script
from urdf2mbs_report.page import make_robot_page
from urdf2mbs_report.tables import format_cell


@pytest.mark.parametrize("name", SHOWN)
def test_nothing_is_loaded_from_anywhere(shared: Path, tmp_path: Path, name: str) -> None:
    html = Html(make_robot_page(shown(name, tmp_path)).data)
    for tag, attributes in html.elements:
        assert tag not in {"iframe", "object", "embed", "base"}
        for key in ("src", "href", "action", "poster", "srcset", "xlink:href"):
            if key in attributes:
                assert attributes[key].startswith(("#", "data:")), (tag, attributes)
    assert "url(" not in html.style
    assert "@import" not in html.style
    policy = next(a["content"] for t, a in html.elements if t == "meta" and "content" in a)
    assert policy.startswith("default-src 'none';")
    assert "http" not in policy
    assert "connect-src" not in policy


def test_the_page_shows_the_file_and_not_our_intention(tiny: Path, tmp_path: Path) -> None:
    conversion = run(tiny, tmp_path / "p")
    edit(conversion, "<mass>0.5</mass>", "<mass>0.625</mass>")
    html = Html(make_robot_page(conversion).data)
    masses = {body["name"]: body["mass"] for body in html.island["mbs"]["bodies"]}
    assert masses["arm"] == 0.625
    assert "0.625" in html.visible


def test_tables_hold_numbers_types_and_masses(tmp_path: Path) -> None:
    conversion = shown("biped", tmp_path)
    html = Html(make_robot_page(conversion).data)
    evaluator = Evaluator(data(conversion))
    assert f"{evaluator.total_mass():.6g} kg" in html.visible
    rows = re.findall(
        r'<tr class="(\w+)" data-joint="(\w+)"><td class=n>q(\d+)</td><td>\w+</td><td>(\w+)</td>',
        make_robot_page(conversion).data.decode(),
    )
    expected = [
        (joint.nature, joint.name, str(number), joint.type)
        for number, joint in enumerate(evaluator.joints.values(), start=1)
    ]
    assert rows == expected
    for link_name in conversion.robot.links:
        assert link_name in html.visible


def test_the_proof_is_shown(tiny: Path, tmp_path: Path) -> None:
    conversion = run(tiny, tmp_path / "p")
    html = Html(make_robot_page(conversion).data)
    assert "the same robot" in html.visible
    assert conversion.checked.proof is not None
    for kind in conversion.checked.proof.largest:
        assert kind in html.visible
    conversion.checked.proof.same = False
    conversion.checked.proof.differences = [Difference("mass", "link 'arm': mass is 2 <kg>")]
    html = Html(make_robot_page(conversion).data)
    assert "NOT the same robot" in html.visible
    assert "mass is 2 <kg>" in html.visible
    conversion.checked.proof = None
    assert "NOT CHECKED" in Html(make_robot_page(conversion).data).visible


def test_every_message_is_there_and_losses_have_a_place_of_their_own(
    tiny: Path, tmp_path: Path
) -> None:
    conversion = run(tiny, tmp_path / "p")
    for code, message in (("collision", "no <shapes>"), ("mesh-not-found", "another")):
        conversion.note(code, message)
    page = make_robot_page(conversion).data
    html = Html(page)
    for diagnostic in conversion.diagnostics:
        assert diagnostic.code in html.visible
        assert diagnostic.message in html.visible
    section = page.decode().partition('<section id="left-out">')[2].partition("</section>")[0]
    assert "<li>no &lt;shapes&gt;</li></ul>" in section
    assert "another" not in section


def test_names_cannot_break_out(tmp_path: Path) -> None:
    source = tmp_path / "evil.urdf"
    source.write_text(HOSTILE)
    text = make_robot_page(run(source, tmp_path / "p")).data
    html = Html(text)
    assert "img" not in {tag for tag, _ in html.elements}
    assert text.count(b"</script>") == 4
    assert EVIL in html.visible
    assert EVIL in {link["name"] for link in html.island["urdf"]["links"]}


def test_a_plain_conversion_does_not_import_the_template_engine(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    code = "import sys, urdf2mbs; urdf2mbs.convert('tiny.urdf'); assert 'jinja2' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True)


def test_same_input_same_bytes(tmp_path: Path) -> None:
    first = make_robot_page(shown("biped", tmp_path / "a" / "biped")).data
    second = make_robot_page(shown("biped", tmp_path / "b" / "biped")).data
    assert first == second
    assert str(tmp_path).encode() not in first


def test_sizes_and_the_licence_of_the_viewer_are_stated(tiny: Path, tmp_path: Path) -> None:
    made = make_robot_page(run(tiny, tmp_path / "p"))
    visible = Html(made.data).visible
    assert made.sizes["viewer"] < made.sizes["all"] < made.sizes["viewer"] + 200_000
    assert f"three.js {made.sizes['viewer'] / 1e6:.2f} MB" in visible
    assert "three.js authors" in visible.lower()


def write_viewer_package(folder: Path, version: str, files: dict[str, str]) -> None:
    """Write an installed jupyter-threejs-sage with these files of ``static``."""
    for name, text in files.items():
        file = folder / "jupyter_threejs_sage" / "static" / name
        file.parent.mkdir(parents=True)
        file.write_text(text)
    information = folder / f"jupyter_threejs_sage-{version}.dist-info" / "METADATA"
    information.parent.mkdir()
    information.write_text(f"Name: jupyter-threejs-sage\nVersion: {version}\n")


@pytest.mark.parametrize(
    ("revisions", "expected"),
    [
        ((122, 123, 130), 130),  # the release of 2024
        ((122, 130, 149), 149),
        ((130, 152), 130),
        ((131,), 131),
        ((130, 135, 160), 135),
    ],
)
def test_the_newest_three_js_that_fits_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, revisions: tuple[int, ...], expected: int
) -> None:
    files = {f"r{revision}/three.min.js": f"three {revision}" for revision in revisions}
    write_viewer_package(tmp_path, str(revisions[-1]), files)
    monkeypatch.syspath_prepend(tmp_path)
    packed = b64decode(script.pack_viewer())
    assert gzip.decompress(packed).decode() == f"three {expected}"


@pytest.mark.parametrize(
    "files",
    [
        ["r122/three.min.js", "r123/three.min.js"],  # too old
        ["r150/three.min.js", "r160/three.min.js"],  # warns; other colours
        ["r180/three.module.min.js"],
        ["r130/three.module.min.js"],
        [],
    ],
)
def test_a_package_without_a_three_js_that_fits_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: list[str]
) -> None:
    write_viewer_package(tmp_path, "180", dict.fromkeys(files, "three"))
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ConfigError, match=r"has no three\.js of revision 130 to 149") as error:
        script.pack_viewer()
    assert error.value.code == "viewer-missing"
    assert "jupyter-threejs-sage 180 " in error.value.message
    assert error.value.hint == "pip install 'jupyter-threejs-sage==130'"


def test_a_missing_package_of_three_js_is_named(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(script, "THREE_PACKAGE", "no-such-package")
    assert main(["report", "tiny.urdf"]) == 2
    told = capsys.readouterr().err
    assert "error[viewer-missing]: no-such-package, which has the viewer three.js, is not" in told
    assert "pip install" in told


def test_the_declared_package_has_a_three_js_that_fits() -> None:
    assert re.search(r"static/r1[34]\d/three\.min\.js$", script.find_viewer().as_posix())


def test_the_modules_of_the_script_fit() -> None:
    """A module imports what another one exports; the page has all in one scope, in this order."""
    folder = Path(script.__file__).with_name("js")
    assert {file.stem for file in folder.glob("*.js")} == set(script.MODULES)
    texts = {name: (folder / f"{name}.js").read_text("utf-8") for name in script.MODULES}
    exports = {
        name: set(re.findall(r"^export (?:async )?(?:const|let|function) (\w+)", text, re.M))
        for name, text in texts.items()
    }
    for text in texts.values():
        for names, name in re.findall(r'^import {(.*?)}\s+from "./(\w+).js";$', text, re.M | re.S):
            assert set(re.split(r",\s+", names)) <= exports[name], name


def test_a_notebook_shows_the_page(tiny: Path, tmp_path: Path) -> None:
    result = convert(tiny)
    frame: Any = document_fromstring(result._repr_html_() or "").xpath("//iframe")[0]
    assert frame.get("srcdoc") == make_robot_page(result.conversion).data.decode()


def test_rounding_is_zero_and_frames_have_their_rotation(tmp_path: Path) -> None:
    assert [format_cell(number) for number in (-1.38778e-17, -0.0, 1e-9)] == ["0", "0", "1e-09"]
    source = tmp_path / "turned.urdf"
    source.write_text(
        robot(
            link("base", SOLID),
            link("tool", SOLID),
            joint("base", "tool", "fixed", xyz="1 0 0", rpy="0 0 1.5707963267948966"),
        )
    )
    conversion = run(source, tmp_path / "p", pipeline="compact")
    rows = re.findall(r'<tr data-link="tool">(.*?)</tr>', make_robot_page(conversion).data.decode())
    assert any("<td>R3 90°</td>" in row for row in rows)


def test_missing_meshes_are_named(shared: Path, tmp_path: Path) -> None:
    made = make_robot_page(shown("nao", tmp_path))
    assert sum("/Torso." in name for name in made.missing) == 1
    assert "small frame" in Html(made.data).visible


def test_without_a_drawing_all_else_is_there(tiny: Path, tmp_path: Path) -> None:
    conversion = run(tiny, tmp_path / "p")
    edit(conversion, r"(</initialvalue>|</nature>)(.{0,400}?)<x2D>.*?</x2D>", r"\1\2")
    html = Html(make_robot_page(conversion).data)
    assert "does not say where in the diagram" in html.visible
    assert html.island["mbs"]["bodies"]


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It writes the page and nothing else, and says when it is another robot."""
    (tmp_path / "tiny.urdf").write_text(TINY)
    file, out = tmp_path / "tiny.yaml", tmp_path / "out"
    file.write_text("source: tiny.urdf\noutput: out/robot.mbs\n")
    assert main(["report", str(file), "-v"]) == 0
    assert [path.name for path in out.glob("[!.]*")] == ["robot.html"]
    size = (out / "robot.html").stat().st_size
    output = capsys.readouterr().out
    assert "robot.html" in output
    assert f"{size / 1e6:.2f} MB" in output
    assert main(["report", str(file), "--json", "-o", str(tmp_path / "my.html")]) == 0
    assert json.loads(capsys.readouterr().out)["sizes"]["all"] == size
    assert (tmp_path / "my.html").read_bytes() == (out / "robot.html").read_bytes()
    heavier = write_plugin(
        tmp_path, "heavier", "conversion.mbs.bodies[-1].mass *= 2", reads=("inertias",)
    )
    plugin = ["--plugin", str(heavier), "--after", "reframe-inertia=heavier"]
    words = ["report", str(tmp_path / "tiny.urdf"), "-o", str(tmp_path / "x.html"), *plugin]
    assert main(words) == 3
    assert "NOT the same robot" in capsys.readouterr().out
    assert b"NOT the same robot" in (tmp_path / "x.html").read_bytes()
