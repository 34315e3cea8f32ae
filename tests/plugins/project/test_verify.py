"""`verify` of a config that makes a project: its robot is compared, its code is named."""

from pathlib import Path

import pytest

from urdf2mbs import convert, verify

SNAP = "passes: {snap: {angle: 1.0e-3}, contacts: {links: [hand]}}"


@pytest.mark.parametrize("language", ["python", "c"])
def test_the_project_of_a_config(here: Path, language: str) -> None:
    text = (here / "tiny.urdf").read_text()
    turned = text.replace('xyz="0 0 0.3"', 'xyz="0 0 0.3" rpy="0.0001 0 0"')
    assert turned != text
    (here / "tiny.urdf").write_text(turned)
    output = f"{{project: p, language: {language}}}"
    (here / "tiny.yaml").write_text(f"source: tiny.urdf\noutput: {output}\n{SNAP}\n")
    convert("tiny.yaml").write()
    for model in (None, "p", "p/dataR/p.mbs"):
        verdict = verify("tiny.yaml", model)
        same, _, left_out = verdict.verdict.partition("; not compared: ")
        assert same == "the same robot, but for what snap changed: 2 origins"
        assert left_out.startswith("force 'hand_contact_force'")
    assert not verify("tiny.yaml", passes={"snap": {"angle": 1e-6}}).same


def test_followers_that_the_project_drives(here: Path) -> None:
    text = (here / "tiny.urdf").read_text()
    mimic = '<axis xyz="0 1 1"/><mimic joint="wrist_roll" multiplier="2"/>'
    (here / "tiny.urdf").write_text(text.replace('<axis xyz="0 1 1"/>', mimic))
    options = "passes: {mimic: {joints: {'*': driven}}}"
    config = f"source: tiny.urdf\noutput: {{project: p}}\n{options}\n"
    (here / "tiny.yaml").write_text(config)
    result = convert("tiny.yaml")
    result.write()
    assert "driven" in {joint.nature for joint in result.mbs.joints().values()}
    assert result.report.proof is not None
    assert result.report.proof.same
    (here / "p" / "dataR" / "p.proof.json").unlink()  # the config says it all
    assert verify("tiny.yaml").same
