"""The config: typed data, errors with file, line, key and the nearest known name; its schema."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import msgspec
import pytest
import yaml
from jsonschema import Draft202012Validator

import urdf2mbs
from urdf2mbs import convert
from urdf2mbs.commands import parse as read_words
from urdf2mbs.commands import parser
from urdf2mbs.commands.schema import schema
from urdf2mbs.commands.settings import ALONE, FLAGS, RUNNING, choose_fields, field_docs
from urdf2mbs.engine.config import Config, Lines, config_of, load, parse, typed
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.yaml_text import word
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY

ROOT = Path(__file__).resolve().parents[2]
FILE = Path("robot.yaml")


def test_all_keys() -> None:
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
    ("text", "said"),
    [
        ("", r"config-type\]: a config is a list of 'key: value' lines"),
        ("- a", r"robot.yaml:1: error\[config-type\]"),
        ("a", r"robot.yaml:1: error\[config-type\]"),
        ("output: x", r"config-key-missing\]: 'source' must be given\n  add 'source: "),
        (
            "base: fixed\nsorce: x",
            r"robot.yaml:2: .*unknown key 'sorce'\n  did you mean",
        ),
        (
            "source: x\ndiagnostics:\n  base: eror",
            r"robot.yaml:3: .*'diagnostics.base': 'eror' is not one of its values\n"
            "  it is one of: error, ignore, note, warning",
        ),
        ("source: x\nstrict: 1", r"'strict': true or false is wanted, and this is 1"),
        (
            "source: x\n\noutptu: y",
            r"robot.yaml:3: error\[unknown-key\]: unknown key 'outptu'\n  did you mean 'output'\?",
        ),
        ("source: x\nzzz: 1", r"robot.yaml:2: .*unknown key 'zzz'\n  known: source, output"),
        (
            "source: 3",
            r"robot.yaml:1: error\[config-type\]: 'source': a word is wanted, and this is 3",
        ),
        (
            "source: x\nbase: float",
            r"robot.yaml:2: .*'base': 'float' is not one of its values\n  it is one of: auto, fix",
        ),
        ("source: x\ngravity: [1, 2]", r"robot.yaml:2: .*'gravity': a list of 3 is wanted"),
        ("source: x\ngravity: [0, 0, down]", r"robot.yaml:2: .*'gravity.2': a number is wanted"),
        ("source: x\npackages:\n  a: 1\n", r"robot.yaml:3: .*'packages.a': a word is wanted"),
        (
            "source: x\npasses:\n  a: b\n",
            r"robot.yaml:3: .*'passes.a': a block of 'key: value' lines is wanted",
        ),
        (
            "source: x\noutput: {projekt: y}",
            r"robot.yaml:2: .*unknown key 'output.projekt'\n  did you mean 'project'\?",
        ),
        (
            "source: x\nsource: y",
            r"robot.yaml:2: error\[config-key-doubled\]: 'source' is there tw",
        ),
        ("passes:\n  a: {b: 1,\n    b: 2}", r"robot.yaml:3: .*'passes.a.b' is there twice"),
        (
            "source: [",
            r"robot.yaml:2: error\[config-yaml\]: this is not YAML: a bracket is not closed",
        ),
        ("source: x\n\tbase: y", r"robot.yaml:2: error\[config-yaml\].*tab character"),
        ("source: *x", r"robot.yaml:1: error\[config-yaml\].*a word begins with '\*'"),
        (
            "source: !!python/object:a.b {}",
            r"robot.yaml:1: error\[config-yaml\].*a value begins with '!'",
        ),
        ("source: 'a\x07'", r"robot.yaml: error\[config-yaml\]"),
        ("a: 1\n---\nb: 2", r"robot.yaml:2: error\[config-yaml\].*a line '---'"),
        (
            "source: x\noutput: {project: ''}",
            r"robot.yaml:2: error\[config-type\]: 'output.project': this is empty: write the name",
        ),
        ("source: ''", r"robot.yaml:1: .*'source': this is empty: write"),
        ("source: x\noutput: ''", r"robot.yaml:2: .*'output': this is empty: write"),
        ("source: x\nplugins: ['']", r"robot.yaml:2: .*'plugins.0': this is empty: write"),
        ("source: x\npackages: {p: ''}", r"robot.yaml:2: .*'packages.p': this is empty: write"),
        ("source: x\npackages: {'': p}", r"robot.yaml:2: .*'packages': a key is empty"),
        ("source: x\nxacro_args: {'': p}", r"robot.yaml:2: .*'xacro_args': a key is empty"),
    ],
)
def test_what_is_wrong_and_where(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(text, FILE)[1].check()
    assert re.search(said, str(caught.value)), str(caught.value)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00x"])
def test_a_file_that_cannot_be_read(content: bytes | None, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / "c.yaml").write_bytes(content)
    with pytest.raises(ConfigError, match=r"c.yaml: error\[config-unreadable\]: cannot read"):
        load(tmp_path / "c.yaml")


class Rule(msgspec.Struct, forbid_unknown_fields=True):
    name: str
    weight: float = 1.0


class Options(msgspec.Struct, forbid_unknown_fields=True):
    must: int
    words: list[str] = []
    rules: list[Rule] = []
    table: dict[str, Rule] = {}


@pytest.mark.parametrize(
    ("options", "line", "said"),
    [
        ("{words: a}", 3, r"'passes.p.must' must be given\n  add 'must: ...' under 'passes.p'"),
        ("{must: 1.5}", 3, r"'passes.p.must': a whole number is wanted, and this is 1.5"),
        ("{must: 1, wods: a}", 3, r"unknown key 'passes.p.wods'\n  did you mean 'words'\?"),
        ("\n    must: 1\n    rules:\n      - name: 1", 6, r"'passes.p.rules.0.name': a word is w"),
        ("\n    must: 1\n    rules:\n      - nam: a", 6, r"unknown key 'passes.p.rules.0.nam'"),
        (
            "\n    must: 1\n    table:\n      x: {}",
            6,
            r"'passes.p.table.x.name' must be given",
        ),
        ("[]", 3, r"'passes.p' wants 'key: value' lines, not \[\]"),
    ],
)
def test_options_of_a_pass(options: str, line: int, said: str) -> None:
    data = yaml.safe_load(f"source: x\npasses:\n  p: {options}")
    lines = parse(f"source: x\npasses:\n  p: {'{}' if options == '[]' else options}", FILE)[1]
    with pytest.raises(ConfigError) as caught:
        typed(Options, data["passes"]["p"], lines, ("passes", "p"))
    assert re.search(said, str(caught.value)), str(caught.value)
    assert caught.value.line == line


@pytest.mark.parametrize("number", ["1e1", "1E+1", "-2e-3", "+5e0", "1.0e+1"])
def test_a_number_with_an_exponent_is_one(number: str) -> None:
    config, _ = parse(f"source: a.urdf\ngravity: [0, 0, {number}]\nxacro_args: {{a: 1e1}}\n", None)
    assert config.gravity[2] == float(number)
    assert config.xacro_args == {"a": "1e1"}, "arguments are as they are written"
    assert word(number) == float(number)
    assert [word(text) for text in ("e1", "1e", "1e1x", "a1e1")] == ["e1", "1e", "1e1x", "a1e1"]


def test_one_word_is_a_list_of_one() -> None:
    assert typed(Options, {"must": 1, "words": "a"}, Lines()).words == ["a"]


def test_words_of_the_command_line() -> None:
    assert [word(text) for text in ("1.5", "[a, b]", "a b", "{", "true", "*")] == [
        1.5, ["a", "b"], "a b", "{", True, "*",
    ]  # fmt: skip


# --- the schema ------------------------------------------------------------------------------


#: The codes of what a schema can see.
SEEN = {"config-type", "unknown-key", "value-range", "unknown-pass", "unknown-preset"}


def good(text: str, whole: dict[str, Any]) -> bool:
    return Draft202012Validator(whole).is_valid(yaml.safe_load(text))


@pytest.fixture(scope="module")
def ours() -> dict[str, Any]:
    return schema(Plugins(installed=False))


@pytest.mark.parametrize("file", sorted((ROOT / "configs").glob("*.yaml")), ids=lambda f: f.name)
def test_our_configs_agree_with_it(file: Path, ours: dict[str, Any]) -> None:
    assert good(file.read_text(), ours)


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("output: {project: x}", True),
        ("output: {project: ''}", False),
        ("output: ''", False),
        ("plugins: ''", False),
        ("output: {project: x, more: 1}", False),
        ("outptu: x", False),
        ("base: floating", True),
        ("base: flying", False),
        ("gravity: [0, 0, 1]", True),
        ("gravity: [0, 0]", False),
        ("gravity: [0, 0, 1.0e+300]", False),
        ("passes: {check: {tolerance: 1.0e-6}}", True),
        ("passes: {check: {tolerance: 0.8}}", False),
        ("passes: {check: {tolerance: 0}}", False),
        ("xacro_args: {a: 1, b: true, c: x}", True),
        ("plugins: a.py", True),
        ("plugins: [a.py, 1]", False),
        ("pipeline: faithful", True),
        ("pipeline: faithless", False),
        ("pipeline: [expand, emit]", True),
        ("pipeline: [expand, emitt]", False),
        ("after: {expand: [check]}", True),
        ("after: {xpand: check}", False),
        ("swap: {emit: mine}", True),
        ("swap: {emitt: mine}", False),
        ("passes: {prune-massless: {keep: '*'}}", True),
        ("passes: {prune-massless: {keep: ['a', 'b']}}", True),
        ("passes: {prune-massless: {kep: '*'}}", False),
        ("passes: {prune-massless: {keep: 3}}", False),
        ("passes: {prune: {}}", False),
        ("passes: {layout: {}}", True),
        ("passes: {layout: {x: 1}}", False),
    ],
)
def test_the_schema_and_the_reader_know_good_from_bad(
    text: str, right: bool, ours: dict[str, Any]
) -> None:
    assert good(f"source: x\n{text}", ours) == right
    assert not good(text, ours), "there is no source"
    try:
        Pipeline(*parse(f"source: x\n{text}", FILE), installed_plugins=False)
        read = True
    except ConfigError as error:
        read = error.code not in SEEN
    assert read == right


def test_every_key_of_a_config_is_described(ours: dict[str, Any]) -> None:
    assert set(ours["properties"]) == set(Config.__struct_fields__)
    assert all(one["description"] for one in ours["properties"].values())
    for name, definition in ours["$defs"].items():
        if "." in name:  # of a pass
            for field, one in definition.get("properties", {}).items():
                assert one.get("description"), f"{name}.{field} has no docstring"


def test_a_plugins_options_are_in_the_schema() -> None:
    whole = schema(Plugins([ROOT / "plugins" / "rename_links.py"], installed=False))
    text = "source: x\nafter: {expand: rename-links}\npasses: {rename-links: {links: {a: b}}}"
    assert good(text, whole)
    assert not good(text.replace("a: b", "a: 1"), whole)
    assert not good(text.replace("{links", "{lnks"), whole)
    rules = whole["$defs"]["rename-links.rename_links.RenameLinks"]["properties"]
    assert rules["links"]["description"] == "Link: its new name."


class Together(msgspec.Struct):
    low: float = 0.0
    high: float = 1.0

    def __post_init__(self) -> None:
        if self.low > self.high:
            raise ValueError("low is above high")


def test_a_class_refuses_its_values() -> None:
    with pytest.raises(ConfigError, match=r"'passes.p': low is above high"):
        typed(Together, {"low": 2}, Lines(), ("passes", "p"))


class Inner(msgspec.Struct, rename="kebab"):
    by_link: dict[str, float] = {}


class Kebab(msgspec.Struct, rename="kebab", forbid_unknown_fields=True):
    max_mass: float = 1.0
    by_link: dict[str, float] | None = None
    for_each: dict[str, Inner] = {}
    listed: list[Inner] = []
    by_number: dict[int, float] = {}
    deep_words: dict[str, list[dict[str, int]]] = {}


@pytest.mark.parametrize(
    ("given", "key", "said"),
    [
        ("{max-mass: x}", "max-mass", "a number is wanted, and this is 'x'"),
        ("{by-link: 3}", "by-link", "lines or nothing is wanted"),
        ("{by-link: {a: 1, b: x}}", "by-link.b", "a number is wanted, and this is 'x'"),
        ("{by-link: {a: 1, '...': x}}", "by-link....", "a number is wanted, and this is 'x'"),
        ("{for-each: {a: {}, b: 3}}", "for-each.b", "lines is wanted, and this is 3"),
        ("{for-each: {a: {by-link: {c: 1, d: x}}}}", "for-each.a.by-link.d", "and this is 'x'"),
        ("{listed: [{}, {by-link: {c: x}}]}", "listed.1.by-link.c", "and this is 'x'"),
        ("{deep-words: {a.b: [{}, {k: 1, l: x}]}}", "deep-words.a.b.1.l", "and this is 'x'"),
    ],
)
def test_a_wrong_value_below_a_key_that_is_spelt_otherwise(given: str, key: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        typed(Kebab, yaml.safe_load(given), Lines(), ("passes", "p"))
    assert caught.value.message.startswith(f"'passes.p.{key}': ")
    assert said in caught.value.message


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
    with pytest.raises(ConfigError, match="holds no such thing: <object"):
        convert(config, strict=object())


def test_python_takes_a_config_file_and_changes_it(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    file = tmp_path / "tiny.yaml"
    file.write_text("source: tiny.urdf\nbase: fixed\ndiagnostics: {collision: warning}\n"
                    "passes: {layout: {style: tree}, check: {tolerance: 1.0e-8}}\n")  # fmt: skip
    config, lines = config_of(
        file, base="floating", diagnostics={"limit": "note"}, passes={"layout": {"keep": False}}
    )
    assert (config.base, lines.folder) == ("floating", tmp_path)
    assert config.diagnostics == {"collision": "warning", "limit": "note"}
    assert config.passes == {
        "layout": {"style": "tree", "keep": False}, "check": {"tolerance": 1e-8},
    }  # fmt: skip
    assert convert(file).mbs.base.gravity == (0.0, 0.0, -9.81)


@pytest.mark.parametrize("call", [urdf2mbs.convert, urdf2mbs.simulate, urdf2mbs.load_equations])
def test_a_keyword_of_an_earlier_version(call: Any) -> None:
    for words, new in (({"options": {}}, "passes="), ({"project": "a"}, "output={'project'")):
        with pytest.raises(ConfigError, match="no longer a keyword") as caught:
            call("tiny.urdf", **words)
        assert new in str(caught.value.hint)


def test_a_flag_says_what_its_field_says() -> None:
    command = parser(["convert"]).parse_args(["convert", "r.urdf"]).parser
    known = {flag: action.help for action in command._actions for flag in action.option_strings}
    docs = field_docs(Config)
    assert FLAGS.keys() == {*RUNNING, *ALONE}
    for field, flag in FLAGS.items():
        assert known[flag.flag] == docs[field]


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
    arguments = parser(["convert"]).parse_args(["convert", "r.urdf", *words])
    assert choose_fields(arguments) == {field: value}
