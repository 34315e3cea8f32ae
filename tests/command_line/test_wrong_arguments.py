"""Wrong command lines and configs: exit code, the code of the error, and nothing is written."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.config.load import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

LONG = "z" * 5000
SWEEP = "source: tiny.urdf\noutput: '{a}.mbs'\nsweep: {xacro_args: {a: [1, 2]}}\n"
MACROS = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="a"/>'


@pytest.fixture
def lab(here: Path) -> Path:
    """A folder with a robot, its .mbs, configs and folders, which is where we are."""
    assert main(["convert", "tiny.urdf", "-q"]) == 0
    files = {
        "tiny.yaml": "source: tiny.urdf\n",
        "short.yaml": "source: tiny.urdf\npipeline: [expand]\n",
        "robot.yaml": TINY,
        "sweep.yaml": SWEEP,
        "blank.urdf": " ",
        "no.urdf": "<robot/>",
        "macros.xacro": f"{MACROS}</robot>",
        "calls.xacro": f"{MACROS}<xacro:a/></robot>",
    }
    for name, text in files.items():
        (here / name).write_text(text)
    for name in ("d", "d.mbs", "p", "p/workR", "r"):
        (here / name).mkdir()
    (here / "r" / "tiny.urdf").write_text(TINY)
    (here / "p" / "dataR").touch()
    return here


#: A command line, its exit code, and the code of its error, perhaps with what the message has.
COMMANDS = [
    ("convert tiny.urdf -o ''", 2, "usage"),
    ("convert ''", 2, "usage"),
    ("convert tiny.urdf -o a.mbs --language c", 2, "usage.*project"),
    ("convert tiny.urdf -o tiny.urdf", 2, "usage.*-o tiny.mbs"),
    ("convert tiny.urdf -o p/", 2, "output-unwritable"),
    (f"convert tiny.urdf -o {LONG}", 2, "path-invalid"),
    (f"convert {LONG}", 2, "path-invalid"),
    ("convert tiny.urdf --set check=1", 2, "usage.*--set PASS.OPTION=VALUE"),
    ("convert tiny.urdf --set check.tolerance", 2, "usage.*--set PASS.OPTION=VALUE"),
    ("convert tiny.urdf --set chek.tolerance=1", 2, "unknown-pass.*'check'"),
    ("convert tiny.urdf --set check.tolerance=x", 2, "config-type.*'passes.check.tolerance'"),
    ("convert tiny.urdf --arg a=1", 2, "usage.*--arg NAME:=VALUE"),
    ("convert tiny.urdf --package a", 2, "usage.*--package NAME=DIR"),
    ("convert tiny.urdf --package a=nowhere", 2, "package-missing"),
    ("convert tiny.urdf --after emit", 2, "usage.*--after PASS=NEW"),
    ("convert tiny.urdf --after emit=nosuch", 2, "unknown-pass"),
    ("convert tiny.urdf --plugin nosuch.py", 2, "plugin-missing"),
    ("convert tiny.urdf --pipeline nosuch", 2, "unknown-preset"),
    ("convert tiny.urdf --level x", 2, "usage.*--level CODE=LEVEL"),
    ("convert tiny.urdf --level limit=loud", 2, "config-type.*error, ignore, note, warning"),
    ("convert tiny.urdf --level unknown-elemnt=note", 2, "unknown-code.*'unknown-element'"),
    ("convert tiny.urdf --level two-parents=note", 2, "unknown-code"),
    ("convert tiny.urdf --dump tiny.mbs", 2, "output-unwritable"),
    ("convert tiny.urdf -o - --json", 2, "usage"),
    ("convert no.urdf", 1, "no-links"),
    ("convert macros.xacro", 1, "no-links.*'a' and calls none"),
    ("convert calls.xacro", 1, "no-links: the robot has no links\n"),
    ("convert /dev/zero", 1, "file-unreadable"),
    ("convert d", 2, "folder-empty"),
    ("convert r", 2, "usage.*urdf2mbs convert r -o models/"),
    ("convert r -o tiny.yaml", 2, "usage.*urdf2mbs convert r -o models/"),
    ("convert r -o r.mbs", 2, "usage.*urdf2mbs convert r -o models/"),
    ("convert tiny.urdf -o tiny.txt", 2, "usage.*-o tiny.mbs"),
    ("convert d -o out", 2, "folder-empty"),
    ("convert tiny.urdf --workers 2", 2, "usage.*many"),
    ("run sweep.yaml --workers 0", 2, "usage"),
    ("run sweep.yaml --stop-after expand", 2, "usage.*one robot"),
    ("run sweep.yaml --dump e", 2, "usage.*one robot"),
    ("report sweep.yaml", 2, "sweep-many"),
    ("run tiny.yaml --stop-after lay", 2, "unknown-pass"),
    ("run tiny.yaml --set check.tolerances=1", 2, "unknown-key.*'tolerance'"),
    ("run d", 2, "usage.*name another folder"),
    (f"run {LONG}", 2, "config-unreadable"),
    ("run robot.yaml", 2, "usage.*urdf2mbs convert robot.yaml"),
    ("explain none.yaml", 2, "config-unreadable"),
    ("explain none.urdf", 1, "file-not-found"),
    ("explain blank.urdf", 1, "file-empty"),
    ("report short.yaml", 2, "no-mbs"),
    ("report d", 2, "usage.*name another folder"),
    ("report tiny.urdf -o tiny.mbs", 2, "usage.*-o tiny.html"),
    ("report tiny.mbs --arg a:=1", 2, "usage.*is an .mbs already"),
    ("report tiny.yaml --base fixed", 2, "usage.*--base"),
    ("verify d tiny.mbs", 2, "usage"),
    ("verify tiny.urdf d", 2, "usage"),
    (f"verify tiny.urdf {LONG}", 2, "model-unreadable"),
    ("verify tiny.urdf none.mbs", 2, "model-unreadable"),
    ("verify none.yaml", 2, "config-unreadable"),
    ("verify none.yaml none.mbs", 2, "config-unreadable"),
    ("diagram d", 2, "usage.*name another folder"),
    ("diagram tiny.mbs -o tiny.mbs", 2, "usage.*-o tiny.svg"),
    ("diagram tiny.mbs --base fixed", 2, "usage.*is an .mbs already"),
    ("simulate tiny.urdf -o tiny.yaml", 2, "usage.*-o tiny.html"),
    ("modes tiny.urdf -o tiny.yaml", 2, "usage.*-o tiny.html"),
    ("diff tiny.urdf tiny.mbs", 2, "usage.*urdf2mbs verify tiny.urdf tiny.mbs"),
    ("run tny.yaml", 2, "config-unreadable.*'tiny.yaml'"),
    ("diagram tny.mbs", 2, "model-unreadable.*'tiny.mbs'"),
    ("diagram none.mbs", 2, "model-unreadable"),
    ("diagram tiny.mbs -o d", 2, "output-unwritable"),
    ("diagram tiny.mbs -o - --json", 2, "usage"),
    ("equations none.mbs", 2, "model-unreadable"),
    ("init -", 2, "usage"),
    ("new-pass a-b -o tiny.urdf", 2, "output-unwritable"),
    ("new-pass -- CountLinks", 2, "pass-name.*new-pass count-links"),
    ("new-pass -- ../evil", 2, "pass-name.*new-pass evil"),
    ("new-pass -- 1st", 2, "pass-name.*new-pass st"),
    ("new-pass -- ''", 2, "pass-name.*new-pass my-pass"),
    ("new-pass -- emit", 2, "pass-name.*choose another"),
    ("new-pass -- random", 2, "pass-name.*new-pass random-links"),
    ("new-pass -- urdf2mbs", 2, "pass-name.*new-pass urdf2mbs-links"),
]


@pytest.mark.parametrize(("line", "exit_code", "code"), COMMANDS, ids=lambda v: str(v)[:50])
def test_a_wrong_command_line(line: str, exit_code: int, code: str, lab: Path, capsys: Any) -> None:
    before = sorted(filter(Path.is_file, lab.rglob("*")))
    assert main(shlex.split(line)) == exit_code
    err = capsys.readouterr().err
    assert err.count("error[") == 1
    code, _, words = code.partition(".*")
    assert re.search(rf"error\[(?:{code.partition(':')[0]})\](?s:.*){re.escape(words)}", err), err
    assert sorted(filter(Path.is_file, lab.rglob("*"))) == before
    assert (lab / "tiny.urdf").read_text() == TINY


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("nosuch", "there is no command"),
        ("run", "required: CONFIG.yaml"),
        ("covert tiny.urdf", "did you mean 'convert'?"),
        ("convert tiny.urdf --outptu=a.mbs", "did you mean '--output'?"),
        ("convert tiny.urdf --base floatig", "did you mean 'floating'?"),
        ("convert tiny.urdf --dump ''", "the name is empty"),
        ("run ''", "the name is empty"),
        ("verify tiny.urdf ''", "the name is empty"),
        ("new-pass swing -o ''", "the name is empty"),
    ],
)
def test_words_that_argparse_refuses(line: str, said: str, lab: Path, capsys: Any) -> None:
    before = sorted(lab.iterdir())
    with pytest.raises(SystemExit) as caught:
        main(shlex.split(line))
    assert caught.value.code == 2
    assert said in capsys.readouterr().err
    assert sorted(lab.iterdir()) == before


#: What follows ``source: tiny.urdf`` in a config, the code of an error, and its line.
CONFIGS = [
    ("output: tiny.urdf", "output-is-source", 2),
    ("output: link.urdf", "output-is-source", 2),
    ("output: .", "output-is-folder", 2),
    (f"output: {LONG}", "path-invalid", None),
    ('output: "a\\0b"', "path-invalid", None),
    ("diagnostics: {mesh-mising: ignore}", "unknown-code", 2),
    ("without: [chekc]", "unknown-pass", 2),
    ("before: {nosuch: check}", "unknown-pass", 2),
    ("swap: {layuot: x}", "unknown-pass", 2),
    ("swap: {layout: urdf3mbs}", "unknown-plugin", 2),
    (
        "passes: {posture: {hold: {joints: [nobody], stiffness: 1, damping: 1}}}",
        "posture-hold",
        None,
    ),
    (
        "passes: {loops: {cuts: {c: {ends: [{link: hand}, {link: body}]}}, "
        "dependent: [wrist_roll]}}",
        "loops-dependent",
        None,
    ),
    ("passes: {forces: {wrenches: {w: {link: nobody}}}}", "forces-link", None),
    ("passes: {forces: {wrenches: {1w: {link: hand}}}}", "forces-name", None),
    (
        "passes: {forces: {springs: {s: {ends: [{link: hand}, {link: hand}], stiffness: 1}}}}",
        "forces-spring",
        None,
    ),
    ("sweep: {xacro_arg: {a: [1]}}", "unknown-key", 2),
    ("passes: {contacts: {zz: 1}, equations: {langage: c}}", "unknown-key", 2),
    ("passes: {posture: {hold: {jonts: [a]}}}", "unknown-key", 2),
]


@pytest.mark.parametrize(("more", "code", "line"), CONFIGS, ids=lambda v: str(v)[:40])
def test_a_wrong_config(more: str, code: str, line: int | None, tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "link.urdf").symlink_to("tiny.urdf")
    (tmp_path / "c.yaml").write_text(f"source: tiny.urdf\n{more}\n")
    with pytest.raises(ConversionError) as caught:
        Pipeline(*load(tmp_path / "c.yaml"), installed_plugins=False).run()
    found = {one.code: one for one in (*caught.value.earlier, caught.value)}
    assert code in found
    assert line is None or found[code].line == line
    assert code != "unknown-key" or found[code].hint


def test_all_faults_of_a_config_are_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(
        "source: tiny.urdf\noutput: {proyect: x}\npipelin: compact\nbase: floatin\n"
        "pipeline: compct\nequations: {}\npackages: {arm: nowhere}\n"
        "diagnostics: {mesh-mising: ignore}\n"
    )
    with pytest.raises(ConversionError) as caught:
        Pipeline(*load(tmp_path / "c.yaml"), installed_plugins=False)
    faults = [*caught.value.earlier, caught.value]
    assert [(fault.line, (fault.hint or "").partition("did you mean ")[2]) for fault in faults] == [
        (2, "'project'?"),
        (3, "'pipeline'?"),
        (4, "'floating'?"),
        (5, "'compact'?"),
        (6, "'passes: {equations: {}}'?"),
        (7, ""),
        (8, "'mesh-missing'?"),
    ]
