"""What plugins import, and what a config may do with passes: place them, or leave them out."""

import ast
from pathlib import Path
from typing import Any

import pytest

import urdf2mbs
from support.folders import ROOT
from support.presets import PRESETS
from urdf2mbs import convert, plugin
from urdf2mbs.cli import main
from urdf2mbs.config.load import config_of
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import convert_text


def write(folder: Path, text: str) -> Path:
    file = folder / "lab.py"
    file.write_text(text)
    return file


SCALE = """
from urdf2mbs.plugin import Pass, hookimpl

class Scale(Pass):
    writes = ("robot",)
    link: str = "arm"
    by: float = 2.0

    def run(self, conversion):
        conversion.robot.links[self.link].inertial.mass *= self.by

@hookimpl
def urdf2mbs_passes():
    return [Scale]
"""


def names(**settings: Any) -> list[str]:
    pipeline = Pipeline(*config_of("r.urdf", **settings))
    return [step.pass_.name for step in pipeline.passes]


def test_passes_are_put_before_and_after_others_or_left_out(tmp_path: Path) -> None:
    file = str(write(tmp_path, SCALE))
    usual = names(plugins=[file])
    at = usual.index("insert-base")
    assert names(plugins=[file], before={"insert-base": "scale"}) == [
        *usual[:at],
        "scale",
        *usual[at:],
    ]
    placed = names(
        plugins=[file],
        pipeline=["expand", "prune-massless", "insert-base"],
        without=["insert-base"],
        after={"expand": "scale", "scale": "insert-base"},
    )
    assert placed == ["expand", "scale", "insert-base", "prune-massless"]
    short = ["expand", "check", "layout", "insert-base"]
    assert names(pipeline=short, without=["check", "layout"]) == ["expand", "insert-base"]


def test_a_pass_says_its_place_and_a_config_moves_it(tmp_path: Path) -> None:
    """The place: behind the first pass that it names, and behind the others that are there."""
    usual = names()
    last = usual[usual.index("insert-base") - 1]
    for place, config, before in (
        (("expand",), {}, "expand"),
        (("expand", "nosuch", "insert-base"), {}, "insert-base"),
        (("expand", "insert-base"), {"without": ["insert-base"]}, last),
        (("expand",), {"after": {"layout": "scale"}}, "layout"),
        (("nosuch",), {}, None),
    ):
        text = SCALE.replace('    writes = ("robot",)', f"    after = {place!r}")
        # Python takes a file of one size and second for the file that it has compiled
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        found = names(plugins=[str(write(folder, text))], **config)
        placed = found.index("scale") if "scale" in found else 0
        assert found[placed - 1] == before if before else "scale" not in found
        if not config.get("without"):
            assert [name for name in found if name != "scale"] == usual


@pytest.mark.parametrize(
    ("package", "said"),
    [
        ("nosuch", "plugin 'lab': pass 'idle' cannot"),
        ("lab_idle", "pass 'idle' of plugin 'lab' failed"),
    ],
)
def test_an_entry_that_fails_is_the_plugin_s_fault(
    package: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where its file is, and whether its pass has work."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "lab_idle" / "passes").mkdir(parents=True)
    (tmp_path / "lab_idle" / "passes" / "idle.py").write_text(
        "from urdf2mbs.plugin import Pass\nclass Idle(Pass):\n  def run(self, conversion): pass\n"
    )
    file = write(
        tmp_path,
        "from urdf2mbs.plugin import PassEntry, hookimpl\n"
        "def fails(conversion, given): return 1 / 0\n@hookimpl\n"
        "def urdf2mbs_passes():\n"
        f"    return [PassEntry('idle', '{package}', ('expand',), fails)]\n",
    )
    with pytest.raises(ConversionError, match=said):
        convert_text(plugins=[file])


def test_a_plugin_keeps_a_state_and_tells_it_in_the_summary(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As ours have; what a pass keeps in its state, a summary tells."""
    text = SCALE.replace("import Pass", "import Pass, Summary").replace(
        "        conversion.robot",
        "        conversion.state(Scaled).links.append(self.link)\n        conversion.robot",
    )
    text += """
class Scaled:
    def __init__(self):
        self.links = []

@hookimpl
def urdf2mbs_summary(conversion):
    return Summary([f"scaled: {conversion.state(Scaled).links}"])
"""
    write(here, text)
    assert main(["convert", "tiny.urdf", "--plugin", "lab.py", "--after", "expand=scale"]) == 0
    assert "  scaled: ['arm']\n" in capsys.readouterr().out


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
def test_a_preset_of_a_plugin_extends_compact(tmp_path: Path) -> None:
    name = "ours"
    preset = {name: {"extends": "compact", "after": {"expand": "scale"}}}
    more = f"@hookimpl\ndef urdf2mbs_presets(): return {preset}\n"
    usual = names(pipeline="compact")
    found = names(plugins=[str(write(tmp_path, SCALE + more))], pipeline=name)
    assert found == [usual[0], "scale", *usual[1:]]


@pytest.mark.parametrize(
    ("preset", "said"),
    [
        ("[]", "expected 'key: value' lines"),
        ("{}", "neither 'pipeline' nor 'extends'"),
        ("{'pipeline': [1]}", "expected a word"),
        ("{'pipeline': [], 'pases': {}}", "unknown key 'pases'"),
    ],
)
def test_a_broken_preset_is_told(preset: str, said: str, tmp_path: Path) -> None:
    file = write(
        tmp_path,
        "from urdf2mbs.plugin import hookimpl\n@hookimpl\n"
        f"def urdf2mbs_presets(): return {{'mine': {preset}}}\n",
    )
    with pytest.raises(ConfigError, match="plugin-broken") as wrong:
        convert_text(plugins=[file])
    assert said in wrong.value.message


def test_the_plugin_module_has_the_names_that_it_lists() -> None:
    assert all(hasattr(plugin, name) for name in plugin.__all__)
    assert len(set(plugin.__all__)) == len(plugin.__all__)
    assert plugin.VERSION == 1
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        plugin.nothing  # noqa: B018


def test_the_stub_has_the_names_of_the_plugin_module() -> None:
    """``python docs/make_stub.py`` writes it."""
    text = (ROOT / "urdf2mbs" / "plugin.pyi").read_text()
    module = ast.parse(text)
    names = [
        alias.asname
        for node in module.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    ]
    assert sorted([*names, "VERSION"]) == sorted(plugin.__all__)
    (listed,) = [node for node in module.body if isinstance(node, ast.Assign)]
    assert sorted(ast.literal_eval(listed.value)) == sorted(plugin.__all__)


def test_samples_import_the_plugin_module_alone() -> None:
    for file in ROOT.glob("tests/strangers/samples/*.py"):
        lines = [line for line in file.read_text().splitlines() if "import" in line]
        ours = [line for line in lines if line.startswith(("from urdf2mbs", "import urdf2mbs"))]
        assert all(line.startswith("from urdf2mbs.plugin import") for line in ours), file


def test_a_result_can_be_written(here: Path) -> None:
    moon = (0.0, 0.0, -1.6)
    written = convert("tiny.urdf", output=here / "out.mbs", gravity=moon).write()
    assert read_mbs(written.read_bytes(), "").base.gravity == moon
    for kind in (str, Path):
        packages = {"arm": kind(here)}
        found = urdf2mbs.verify(kind("tiny.urdf"), kind("out.mbs"), packages=packages, gravity=moon)
        assert found.same
