"""The config: typed data, errors with file, line, key and the nearest known name; its schema."""

import re
from pathlib import Path
from typing import Any

import msgspec
import pytest
import yaml

from support.presets import PRESETS
from urdf2mbs import convert
from urdf2mbs.commands import parse as read_words
from urdf2mbs.commands import parser
from urdf2mbs.commands.settings import ALONE, FLAGS, RUNNING, choose_fields, field_docs
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import config_of, load, parse, typed
from urdf2mbs.config.model import Config
from urdf2mbs.config.paths import expand
from urdf2mbs.config.yaml_text import parse_value
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY

FILE = Path("robot.yaml")


def test_all_keys_of_a_config_are_read() -> None:
    config, lines = parse(
        """
source: a.urdf.xacro
output: {project: out}
base: fixed
gravity: [0, 0, -1.62]
packages: {a: ../a}
xacro_args: {hand: false, mass: 1.50, name: x, on: on}
plugins: one.py
pipeline: [expand, emit]
after: {expand: x, emit: [y, z]}
swap: {layout: mine}
passes: {check: {tolerance: 1e-6}}
""",
        FILE,
    )
    assert config.gravity == (0, 0, -1.62)
    assert config.xacro_args == {"hand": "false", "mass": "1.50", "name": "x", "on": "on"}
    assert config.plugins == ["one.py"]
    assert config.after == {"expand": "x", "emit": ["y", "z"]}
    assert lines.error("c", "m", ("after", "emit", 1)).line == 10


@pytest.mark.parametrize(
    ("text", "line", "code", "said"),
    [
        ("", None, "config-type", "'key: value' lines"),
        ("- a", 1, "config-type", ""),
        ("a", 1, "config-type", ""),
        ("output: x", 1, "config-key-missing", "'source'"),
        ("base: fixed\nsorce: x", 2, "unknown-key", "'source'?"),
        ("source: x\nzzz: 1", 2, "unknown-key", "known: source, output"),
        ("source: x\ndiagnostics:\n  base: eror", 3, "config-type", "error, ignore, note, warning"),
        ("source: x\nbase: float", 2, "config-type", "auto, fixed, floating"),
        ("source: x\nstrict: 1", 2, "config-type", "expected true or false, got 1"),
        ("source: 3", 1, "config-type", "'source': expected a word, got 3"),
        ("source: x\ngravity: [1, 2]", 2, "config-type", "'gravity': expected a list of 3"),
        ("source: x\ngravity: [0, 0, down]", 2, "config-type", "'gravity.2': expected a number"),
        (
            "source: x\ngravity: [0, 0, 1.0e+300]",
            2,
            "value-range",
            "'gravity.2': expected a number from -1000 to 1000, got 1e+300",
        ),
        ("source: x\ngravity: [0, 0, .nan]", 2, "config-type", "got nan"),
        ("source: x\npackages:\n  a: 1\n", 3, "config-type", "'packages.a'"),
        ("source: x\npasses:\n  a: b\n", 3, "config-type", "'passes.a'"),
        ("source: x\noutput: {projekt: y}", 2, "unknown-key", "'project'?"),
        ("source: x\noutput: {project: ''}", 2, "config-type", "'output.project': the value is"),
        ("source: ''", 1, "config-type", "'source': the value is empty"),
        ("source: x\nplugins: ['']", 2, "config-type", "'plugins.0': the value is empty"),
        ("source: x\npackages: {'': p}", 2, "config-type", "'packages': a key is empty"),
        ("source: x\nsource: y", 2, "config-key-doubled", "'source'"),
        ("passes:\n  a: {b: 1,\n    b: 2}", 3, "config-key-doubled", "'passes.a.b'"),
        ("source: [", 2, "config-yaml", "a bracket is not closed"),
        ("source: x\n\tbase: y", 2, "config-yaml", "a tab indents this line"),
        ("source: @x", 1, "config-yaml", "begins with '@'"),
        ("passes: {x: {}}}", 1, "config-yaml", "no '}' is expected"),
        ("source: a: b", 1, "config-yaml", "a second ':' in one line"),
        ("source: a\noutput\nbase: fixed", 2, "config-yaml", "no ':'"),
        (
            "base: fixed\n- a",
            2,
            "config-yaml",
            "line 2 ('- a') is an item of a list, and not further in than line 1 ('base'), which "
            "is a key",
        ),
        (
            "a:\n  b: c\n  - d",
            3,
            "config-yaml",
            "line 3 ('- d') is an item of a list, and not further in than line 2 ('b'), which is a "
            "key\n  a block has items or keys",
        ),
        ("a:\n  - b\n  c: d", 3, "config-yaml", "line 3 ('c') is a key, and not further in than"),
        (
            "plugins:\n  - a.py\n - b.py",
            3,
            "config-yaml",
            "line 3 ('- b.py') is further in than line 1 ('plugins'), and not as far as line 2 "
            "('- a.py')\n  indent it as '- a.py'",
        ),
        (
            "plugins:\n- a.py\n  - b.py",
            3,
            "config-yaml",
            "line 3 ('- b.py') is further in than line 2, and so goes on with its value 'a.py'",
        ),
        (
            "source: tiny.urdf  # a comment\n\n output: x.mbs",
            3,
            "config-yaml",
            "line 3 ('output') is further in than line 1 ('source'), which has its value already\n"
            "  indent it as 'source'",
        ),
        (
            "  source: x\nbase: y",
            2,
            "config-yaml",
            "line 1 ('source') is further in than line 2 ('base')\n  indent 'base' as 'source'",
        ),
        (
            "passes:\n  posture:\n    hold: 1\n   # none\n   mimic: {}",
            5,
            "config-yaml",
            "line 5 ('mimic') is further in than line 2 ('posture'), and not as far as line 3 "
            "('hold')\n  indent it as 'hold', or as 'posture'",
        ),
        (
            "a:\n    b:\n      c: 1\n    d: 2\n  e: {}",
            5,
            "config-yaml",
            "line 5 ('e') is further in than line 1 ('a'), and not as far as line 4 ('d')",
        ),
        (
            "a:\n  - b: 1\n   c: 2",
            3,
            "config-yaml",
            "line 3 ('c') is further in than line 2 ('- b'), and not as far as line 2 ('b')",
        ),
        ("source: *x", 1, "config-yaml", "begins with '*'"),
        ("source: !!python/object:a.b {}", 1, "config-yaml", "begins with '!'"),
        ("source: 'a\x07'", None, "config-yaml", ""),
        ("a: 1\n---\nb: 2", 2, "config-yaml", "'---'"),
        ("a: &x\n  - *x", 1, "config-yaml", "lists in one another"),
        ("[" * 5000, 1, "config-yaml", "lists in one another"),
    ],
)
def test_a_fault_of_a_config_is_told_with_its_line(
    text: str, line: int | None, code: str, said: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(text, FILE)[1].check()
    faults = {fault.code: fault for fault in (*caught.value.earlier, caught.value)}
    assert (faults[code].file, faults[code].line) == (str(FILE), line)
    assert said in str(faults[code]) + str(faults[code].hint)


@pytest.mark.parametrize(
    ("path", "expanded"),
    [
        ("$FOO/$FOOBAR/x", "one/two/x"),
        ("$FOOBAR/$FOO", "two/one"),
        ("${FOO}BAR/${FOOBAR}", "oneBAR/two"),
        ("$MONEY/$FOO", "$FOO and ${FOO/one"),
        ("$FOO/~/$/$1/$$", "one/~/$/$1/$$"),
        ("~/$FOO", "/$HOME/one"),
        ("~", "/$HOME"),
        ("~$FOO", "~one"),
        ("$TILDE/x", "~/x"),
        ("{FOO}}", "{FOO}}"),
    ],
)
def test_variables_of_paths_are_filled_in_once(
    path: str, expanded: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = {"FOO": "one", "FOOBAR": "two", "MONEY": "$FOO and ${FOO", "TILDE": "~"}
    for name, value in (values | {"HOME": "/$HOME", "USERPROFILE": "/$HOME"}).items():
        monkeypatch.setenv(name, value)
    assert expand(path, Lines(FILE), ("source",)) == expanded


@pytest.mark.parametrize("path", ["${FOO", "${FOO/x}", "${FOO-x}", "a${}", "${", "$FOO/${FOO $FOO"])
def test_a_variable_that_is_not_closed_is_refused(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FOO", "one")
    lines = Lines(FILE, {("source",): 3})
    with pytest.raises(ConfigError, match=r"has a '\$\{' that does not begin a variable") as caught:
        expand(path, lines, ("source",))
    assert (caught.value.code, caught.value.line) == ("variable-unclosed", 3)


@pytest.mark.parametrize("value", [None, ""])
def test_a_variable_that_is_not_set_is_refused(
    value: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("FOO", raising=False)
    if value is not None:
        monkeypatch.setenv("FOO", value)
    with pytest.raises(ConfigError, match=r"uses \$FOO, which is not set or empty") as caught:
        expand("x/$FOO", Lines(FILE), ("source",))
    assert caught.value.code == "variable-unset"


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00x"])
def test_a_file_that_cannot_be_read_is_named(content: bytes | None, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / "c.yaml").write_bytes(content)
    with pytest.raises(ConfigError, match=r"c.yaml: error\[config-unreadable\]: cannot read"):
        load(tmp_path / "c.yaml")


class Rule(msgspec.Struct, forbid_unknown_fields=True, rename="kebab"):
    name: str = ""
    by_link: dict[str, float] | None = None


class Options(msgspec.Struct, forbid_unknown_fields=True, rename="kebab"):
    must: int
    words: list[str] = []
    rules: list[Rule] = []
    for_each: dict[str, Rule] = {}
    deep_words: dict[str, list[dict[str, int]]] = {}

    def __post_init__(self) -> None:
        if self.must < 0:
            raise ValueError("must is below zero")


@pytest.mark.parametrize(
    ("options", "line", "code", "said"),
    [
        ("{words: a}", 3, "config-key-missing", "'passes.p.must'"),
        ("{must: 1.5}", 3, "config-type", "'passes.p.must': expected a whole number"),
        ("{must: -1}", 3, "config-type", "'passes.p': must is below zero"),
        ("{must: 1, wods: a}", 3, "unknown-key", "'passes.p.wods'"),
        ("\n    must: 1\n    rules:\n      - name: 1", 6, "config-type", "'passes.p.rules.0.name'"),
        ("\n    must: 1\n    rules:\n      - nam: a", 6, "unknown-key", "'passes.p.rules.0.nam'"),
        ("\n    must: 1\n    for-each:\n      x: 3", 6, "config-type", "'passes.p.for-each.x'"),
        (
            "{must: 1, for-each: {a: {}, b: {by-link: {c: 1, '...': x}}}}",
            3,
            "config-type",
            "'passes.p.for-each.b.by-link....': expected a number, got 'x'",
        ),
        ("{must: 1, for-each: {a: {by-link: 3}}}", 3, "config-type", "lines or nothing, got 3"),
        (
            "{must: 1, deep-words: {a.b: [{}, {k: 1, l: x}]}}",
            3,
            "config-type",
            "'passes.p.deep-words.a.b.1.l'",
        ),
        ("[]", 3, "config-type", "'passes.p': expected 'key: value' lines"),
    ],
)
def test_a_fault_in_the_options_of_a_pass_is_told_with_its_line(
    options: str, line: int, code: str, said: str
) -> None:
    text = f"source: x\npasses:\n  p: {options}"
    data = yaml.safe_load(text)["passes"]["p"]
    lines = parse(text.replace("[]", "{}") if options == "[]" else text, FILE)[1]
    with pytest.raises(ConfigError) as caught:
        typed(Options, data, lines, ("passes", "p"))
    assert (caught.value.code, caught.value.line) == (code, line)
    assert said in caught.value.message
    assert typed(Options, {"must": 1, "words": "a"}, Lines()).words == ["a"]


def test_words_of_the_command_line_and_numbers_with_an_exponent() -> None:
    texts = ("1.5", "[a, b]", "a b", "{", "true", "*", "1e", "1e1x", "1e1", "1E+1", "-2e-3")
    assert [parse_value(text) for text in texts] == [
        1.5,
        ["a", "b"],
        "a b",
        "{",
        True,
        "*",
        "1e",
        "1e1x",
        10.0,
        10.0,
        -0.002,
    ]
    config, _ = parse("source: a.urdf\ngravity: [0, 0, 1e1]\nxacro_args: {a: 1e1}\n", None)
    assert config.gravity[2] == 10.0
    assert config.xacro_args == {"a": "1e1"}, "arguments are as they are written"


# --- the schema ------------------------------------------------------------------------------


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
def test_python_takes_the_fields_of_a_config_or_a_config(tmp_path: Path) -> None:
    robot = tmp_path / "tiny.urdf"
    robot.write_text(TINY)
    packages = {"robots": tmp_path}
    by_fields = convert(robot, pipeline="compact", gravity=[0, 0, -1.62], packages=packages)
    config = Config(str(robot), pipeline="compact", gravity=(0.0, 0.0, -1.62))
    assert by_fields.data == convert(config).data != convert(robot).data
    assert by_fields.mbs.base.gravity == (0.0, 0.0, -1.62)
    with pytest.raises(ConfigError, match=r"unknown key 'pipelin'\n.*did you mean 'pipeline'"):
        convert(config, pipelin="faithful")
    with pytest.raises(ConfigError, match="got <object"):
        convert(config, strict=object())


def test_python_takes_a_config_file_and_changes_it(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    file = tmp_path / "tiny.yaml"
    file.write_text(
        "source: tiny.urdf\nbase: fixed\ndiagnostics: {collision: warning}\n"
        "passes: {layout: {style: tree}, check: {tolerance: 1.0e-8}}\n"
    )
    config, lines = config_of(
        file, base="floating", diagnostics={"limit": "note"}, passes={"layout": {"keep": False}}
    )
    assert (config.base, lines.folder) == ("floating", tmp_path)
    assert config.diagnostics == {"collision": "warning", "limit": "note"}
    assert config.passes == {
        "layout": {"style": "tree", "keep": False},
        "check": {"tolerance": 1e-8},
    }
    assert convert(file).mbs.base.gravity == (0.0, 0.0, -9.81)


def test_a_flag_says_what_its_field_says() -> None:
    command = parser(named=["convert"]).parse_args(["convert", "r.urdf"]).parser
    said = " ".join(command.format_help().split())
    docs = field_docs(Config)
    assert FLAGS.keys() == {*RUNNING, *ALONE}
    for field, flag in FLAGS.items():
        assert re.search(rf"{flag.flag}\b[^-]*{re.escape(' '.join(docs[field].split()))}", said)


@pytest.mark.parametrize("word", ["-h", "--help", "--he", "-qh"])
def test_only_help_reads_the_texts_of_the_fields(
    word: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        read_words(["convert", word])
    assert "let the robot's xacro do whatever" in " ".join(capsys.readouterr().out.split())
    monkeypatch.setattr("urdf2mbs.commands.settings.field_docs", lambda _: pytest.fail("read"))
    assert read_words(["convert", "r.urdf", "-o", "r.mbs", "-q"]).quiet


@pytest.mark.parametrize(
    ("words", "field", "value"),
    [
        (["--base", "fixed"], "base", "fixed"),
        (["--arg", "a:=b=c"], "xacro_args", {"a": "b=c"}),
        (["--after", "emit=a", "--after", "emit=b"], "after", {"emit": ["a", "b"]}),
        (["--set", "layout.scale=2"], "passes", {"layout": {"scale": 2}}),
        (["--level", "no-mass=error"], "diagnostics", {"no-mass": "error"}),
        (["--strict"], "strict", True),
    ],
)
def test_a_flag_sets_its_field(words: list[str], field: str, value: Any) -> None:
    arguments = parser(named=["convert"]).parse_args(["convert", "r.urdf", *words])
    assert choose_fields(arguments) == {field: value}
