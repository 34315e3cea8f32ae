"""`verify` of what was changed on purpose, and of a model that people drew."""

import re
from pathlib import Path
from typing import Any

import pytest

from support.planted import MIMIC
from support.plugin_files import write_plugin
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.testing import TINY, convert_text


def test_a_follower_that_a_project_drives_on_purpose(here: Path, capsys: Any) -> None:
    """The certificate says so; without a certificate that says so, it is a difference."""
    mimic = '<axis xyz="0 1 1"/><mimic joint="wrist_roll"/>'
    (here / "tiny.urdf").write_text(TINY.replace('<axis xyz="0 1 1"/>', mimic))
    drive = {"mimic": {"joints": {"*": "driven"}}}
    convert("tiny.urdf", output={"project": "p"}, passes=drive).write()
    assert main(["verify", "tiny.urdf", "p"]) == 0
    assert "but for joint 'wrist_pitch' (driven, so that 'wrist_roll'" in capsys.readouterr().out
    certificate = here / "p" / "dataR" / "p.proof.json"
    for text in ("{}", "[]", "{", '{"driven": 1}', '{"passes": 1}'):
        certificate.write_text(text)
        assert main(["verify", "tiny.urdf", "p"]) == 3
        assert "is driven; expected dependent: it follows 'wrist_roll'" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("snap", {"angle": 1e-3}),
        ("estimate-inertia", {"density": 1000.0}),
        ("rotors", {"armature": {"wrist_roll": 0.1}}),
    ],
)
def test_what_passes_changed_on_purpose(name: str, options: Any, here: Path, capsys: Any) -> None:
    """The certificate says what was asked of passes; all else is a difference."""
    tilted = TINY.replace("0 0.5 0", "0 0.7854 0")
    if name == "estimate-inertia":
        tilted = re.sub(r'(?s)(<link name="hand">\s*)<inertial>.*?</inertial>', r"\1", tilted)
    (here / "tiny.urdf").write_text(tilted)
    convert("tiny.urdf", output={"project": "p"}, passes={name: options}).write()
    assert main(["verify", "tiny.urdf", "p"]) == 0
    said = capsys.readouterr().out.splitlines()[-1]
    assert f"but for what {name} changed: " in said
    assert "(on purpose, as the certificate says)" in said
    (here / "tiny.urdf").write_text(tilted.replace('<axis xyz="0 1 1"/>', '<axis xyz="0 2 1"/>'))
    assert main(["verify", "tiny.urdf", "p"]) == 3
    (here / "tiny.urdf").write_text(tilted)
    (here / "p" / "dataR" / "p.proof.json").unlink()
    assert main(["verify", "tiny.urdf", "p"]) == 3


def test_a_follower_driven_by_the_config_is_named() -> None:
    result = convert_text(MIMIC, passes={"mimic": {"joints": {"wrist_pitch": "driven"}}})
    words = "but for joint 'wrist_pitch' (driven, so that 'wrist_roll' does not feel it)"
    assert words in result.report.verdict


def test_a_user_model_that_is_not_as_the_passes_made_it_is_a_difference(tmp_path: Path) -> None:
    changes = """
        output = conversion.settings.output
        changed = conversion.files[output].replace(b"<name>ground<", b"<name>grown<")
        conversion.files[output] = changed
    """
    stiff = write_plugin(tmp_path, "stiff", changes, reads=("mbs-file",))
    contacts = {"points": {"hand": [[0.0, 0.0, 0.0]]}}
    result = convert_text(
        TINY, plugins=[stiff], after={"emit": "stiff"}, passes={"contacts": contacts}
    )
    assert result.report.proof is not None
    assert [found.kind for found in result.report.proof.differences] == ["parameter"]


def test_the_walkman_sample_tells_its_story(shared: Path, capsys: Any) -> None:
    urdf = shared / "robots" / "walkman" / "robotran_edu_2017" / "bigman.urdf"
    sample = shared / "mbs-samples" / "walkman_robotran.mbs"
    assert main(["verify", str(urdf), str(sample), "--tolerance", "2e-8"]) == 3
    told = capsys.readouterr().out
    assert "31 joints match by name" in told or "31 of 31 joints match by name" in told
    assert "117.754 kg" in told
    assert "121.208 kg" in told
    assert "rotated by -0.4538 about y" in told
    assert "R1 -0.733, R3 0.349" in told
    assert "R1 0.733, R3 -0.349" in told
    wrong = {word.split("'")[0] for line in told.splitlines() for word in line.split("link '")[1:]}
    # feet, wrists, head, waist and shoulders, and what the turned frames are of; nothing else
    assert {"DWL", "RShp", "LShp", "RFoot", "LFoot"} <= wrong
    assert not wrong & {"DWS", "DWYTorso", "RElb", "LElb", "RForearm", "LForearm", "RThighUpLeg"}
