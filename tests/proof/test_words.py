"""The verdict of `verify` on an .mbs with a planted fault.

It is: the same; the same, but for ...; not compared: ...; or NOT the same.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from support.planted import (
    MIMIC,
    NATURE_FAULTS,
    WORLD,
    Plant,
    add_cut,
    add_force,
    constrain_follower,
    do_nothing,
    find_joint,
)
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Connection, UserConstraint, UserModel, UserVariable
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs.verification import verify

#: The URDF, the base of its .mbs, a change, and words that are then in the verdict.
VERDICTS: dict[str, tuple[str, str, Plant, str]] = {
    "a follower that is free": (
        MIMIC,
        "auto",
        do_nothing,
        "but for joint 'wrist_pitch' (free here, coupled by <mimic> in the URDF)",
    ),
    "a follower that the user functions hold": (
        MIMIC,
        "auto",
        constrain_follower,
        "not compared: <mimic> of joint 'wrist_pitch' (held by the user functions",
    ),
    "a cut that the URDF does not have": (
        TINY,
        "fixed",
        add_cut("rod", "dependent", "wrist_roll"),
        "but for cut 'tie' (rod) (not in the robot's file)",
    ),
    "a force": (TINY, "auto", add_force, "force 'push' (left to the user functions)"),
    "a link": (
        TINY,
        "auto",
        lambda mbs: mbs.links.append(Connection("link", "spring", ("hand", None), (None, None))),
        "link 'spring' (link) (left to the user functions)",
    ),
    "a user constraint": (
        TINY,
        "auto",
        lambda mbs: mbs.user_constraints.append(UserConstraint("c", ())),
        "user constraint 'c' (held by the user functions",
    ),
    "a user model": (
        TINY,
        "auto",
        lambda mbs: mbs.user_models.append(UserModel("mine")),
        "user model 'mine'",
    ),
    "a user variable": (
        TINY,
        "auto",
        lambda mbs: mbs.user_variables.append(UserVariable("v", "in", "1")),
        "user variable 'v'",
    ),
    "a position at start": (
        TINY,
        "auto",
        lambda mbs: setattr(find_joint(mbs, "shoulder"), "q", 0.3),
        "start of 1 joint (a URDF has none)",
    ),
    "no damping": (
        TINY,
        "auto",
        lambda mbs: mbs.user_models.clear(),
        "but for damping of 1 joint, ",
    ),
}


def planted(tmp_path: Path, text: str, base: str, plant: Plant) -> tuple[Path, Path]:
    """The URDF, and its .mbs with a fault."""
    source, model = tmp_path / "tiny.urdf", tmp_path / "tiny.mbs"
    source.write_text(text)
    mbs = read_mbs(convert(source, base=base).data, "tiny.mbs")
    plant(mbs)
    model.write_bytes(write(mbs))
    return source, model


@pytest.mark.parametrize("fault", NATURE_FAULTS)
def test_a_planted_fault_is_a_difference(fault: str, tmp_path: Path, capsys: Any) -> None:
    text, base, plant, kind = NATURE_FAULTS[fault]
    source, model = planted(tmp_path, text, base, plant)
    verdict = verify(source, model)
    assert kind in {difference.kind for difference in verdict.differences}
    assert verdict.verdict == "NOT the same robot"
    assert main(["verify", str(source), str(model)]) == 3
    assert capsys.readouterr().out.endswith("NOT the same robot\n")


@pytest.mark.parametrize("fault", VERDICTS)
def test_a_known_deviation_is_in_the_verdict(fault: str, tmp_path: Path, capsys: Any) -> None:
    text, base, plant, words = VERDICTS[fault]
    source, model = planted(tmp_path, text, base, plant)
    verdict = verify(source, model)
    assert verdict.same
    assert words in verdict.verdict
    assert main(["verify", str(source), str(model)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == verdict.verdict
    assert main(["verify", str(source), str(model), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == verdict.verdict


def test_an_unchanged_model_is_the_same(tmp_path: Path) -> None:
    source, model = planted(tmp_path, TINY, "auto", do_nothing)
    verdict = verify(source, model)
    assert verdict.verdict == "the same robot"
    assert verdict.but_for == {}


def test_a_base_that_floats_on_purpose_is_no_difference(tmp_path: Path) -> None:
    source, model = planted(tmp_path, WORLD, "floating", do_nothing)
    assert verify(source, model, base="floating").same
    assert not verify(source, model, base="fixed").same
    fixed = tmp_path / "fixed.mbs"
    fixed.write_bytes(convert(source).data)
    assert verify(source, fixed).same
    assert not verify(source, fixed, base="floating").same


# --- not checked, and by whom -------------------------------------------------------------------


def test_every_output_tells_that_nothing_was_checked(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    config = tmp_path / "tiny.yaml"
    config.write_text("source: tiny.urdf\nwithout: [check]\n")
    assert main(["run", str(config)]) == 0
    assert "\n  NOT CHECKED; 1 warning" in capsys.readouterr().out
    data = (tmp_path / "tiny.mbs").read_bytes()
    assert b"\n<!-- NOT CHECKED: the pass 'check' was not in the pipeline -->\n" in data
    assert read_mbs(data, "tiny.mbs").bodies  # and it is still read
    assert main(["run", str(config), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["verdict"], found["proof"]) == ("NOT CHECKED", None)
    assert b"NOT CHECKED" not in convert_text().data


def test_the_words_are_alike_on_the_terminal_and_in_json(tmp_path: Path, capsys: Any) -> None:
    source = tmp_path / "tiny.urdf"
    source.write_text(MIMIC)
    result = convert(source)
    words = result.report.verdict
    assert words.startswith("the same robot, but for joint 'wrist_pitch'")
    assert main(["convert", str(source), "-o", str(tmp_path / "tiny.mbs")]) == 0
    assert f"\n  {words}; 2 warnings, " in capsys.readouterr().out
    assert main(["convert", str(source), "-o", str(tmp_path / "tiny.mbs"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == words


OVERREACH = {
    "the verdict": "conversion.checked.proof = None",
    "what the verdict says": "conversion.checked.proof.largest.clear()",
    "the settings": "conversion.settings = msgspec.structs.replace("
    "conversion.settings, output=conversion.settings.source)",
    "the list of changes": "conversion.checked.changed.append(None)",
    "where a rejected file goes": "conversion.checked.rejected = conversion.settings.output",
    "the bytes that were checked": "conversion.checked.proven = b''",
}


@pytest.mark.parametrize("how", ["pass", "hook"])
@pytest.mark.parametrize("what", OVERREACH)
def test_a_plugin_cannot_set(what: str, how: str, tmp_path: Path) -> None:
    plugin = tmp_path / "reach.py"
    head = "import msgspec\nfrom support.plugin_files import hookimpl, make\n"
    if how == "pass":
        plugin.write_text(
            f"{head}def run(conversion, options):\n    {OVERREACH[what]}\n"
            "@hookimpl\ndef urdf2mbs_passes():\n    return [make('reach', run)]\n"
        )
    else:
        plugin.write_text(
            f"{head}@hookimpl\ndef urdf2mbs_after_pass(pass_, conversion):\n"
            f"    if pass_.name == 'check':\n        {OVERREACH[what]}\n"
        )
    after: Any = {"after": {"check": "reach"}} if how == "pass" else {}
    with pytest.raises(ConversionError, match="of plugin 'reach' changes") as refused:
        convert_text(plugins=[plugin], **after)
    assert refused.value.code == "plugin-verdict"
