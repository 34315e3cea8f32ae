"""The documentation is true: its code runs, its tables are complete, nothing in it is stale."""

import ast
import importlib.util
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import isclose
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from lxml import etree

from support.codes import CATALOGUE, TABLES, list_asserted_codes
from support.folders import ROOT, TESTS
from support.installed import install_file
from support.plugin_files import passes_of
from support.real_robots import FOLDER
from urdf2mbs import hookspecs
from urdf2mbs.cli import main
from urdf2mbs.commands import list_commands
from urdf2mbs.config.load import load, parse
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine import sections
from urdf2mbs.engine.output import write_files
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.hookspecs import Pass, hookimpl
from urdf2mbs.testing import TINY
from urdf2mbs.urdf.elements import ELEMENTS
from urdf2mbs_many.sweep import list_members
from urdf2mbs_setup.dump import make_state

DOCS = ROOT / "docs"
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(DOCS.rglob("*.md")),
    ROOT / "urdf2mbs" / "README.md",
    *sorted(ROOT.glob("plugins/*/*.md")),
]
#: The plugin that is installed while the pages are followed.
INSTALLED = ROOT / "tests" / "door" / "list_masses.py"
BUILT_IN: dict[str, type[Pass]] = {
    name: found[0].load() for name, found in Plugins(installed=False).passes.items()
}


@dataclass
class Block:
    """A fenced block of a page: its language, the words after it, its text."""

    language: str
    info: list[str]
    text: str
    line: int

    @property
    def file(self) -> str | None:
        return next((word[5:] for word in self.info if word.startswith("file=")), None)


def blocks(page: Path) -> Iterator[Block]:
    text = page.read_text()
    assert len(re.findall("^```", text, re.M)) % 2 == 0, f"{page}: a block without an end"
    for found in re.finditer(r"^```(.*)\n((?s:.*?))^```", text, re.M):
        language, *info = found[1].split()
        yield Block(language, info, found[2], text.count("\n", 0, found.start()) + 1)


# --- code blocks -----------------------------------------------------------------------------


#: How this Python runs a command of the pages.
OURS = {
    "pytest": f"{sys.executable} -m pytest -p no:cacheprovider",
    "urdf2mbs": f"{sys.executable} -m urdf2mbs.cli",
}


class Page:
    """A page being followed, block by block, in a folder of its own."""

    def __init__(self, folder: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self.capsys = capsys
        self.monkeypatch = monkeypatch
        self.said = ""
        self.globals: dict[str, Any] = {"__name__": "docs"}
        (folder / "tiny.urdf").write_text(TINY)
        (folder / "tiny.yaml").write_text("source: tiny.urdf\n")
        shutil.copytree(ROOT / "configs", folder / "configs")
        shutil.copytree(ROOT / "plugins", folder / "plugins")

    def follow(self, block: Block) -> None:
        file = self.folder / (block.file or "")
        if block.language == "text" and file.is_file():
            assert block.text in file.read_text(), f"{block.file} says something else"
        elif block.file:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text)
        getattr(self, block.language)(block)

    def python(self, block: Block) -> None:
        """Run a block, unless it needs a package that is not installed (``needs=sympy``)."""
        needed = [word[6:] for word in block.info if word.startswith("needs=")]
        if not all(map(importlib.util.find_spec, needed)):
            return
        code = compile(block.text, block.file or f"line {block.line}", "exec")
        if not block.file:
            exec(code, self.globals)

    def c(self, block: Block) -> None:
        """A file, which a command compiles."""

    def matlab(self, block: Block) -> None:
        """Commands in the folder of an example, which GNU Octave runs where it is installed."""
        (example,) = self.folder.rglob("*_example.m")
        (example.parent / "commands.m").write_text(block.text)
        if shutil.which("octave-cli"):
            code, self.said = self.run(f"cd {example.parent} && octave-cli --norc -q commands.m")
            assert code == 0, self.said

    def yaml(self, block: Block) -> None:
        if block.file:
            config, lines = load(self.folder / block.file)
            for member in list_members(config, lines):
                Pipeline(member.config, lines)
        elif not {"before", "after"} & set(block.info):
            text = block.text if "source:" in block.text else f"source: tiny.urdf\n{block.text}"
            Pipeline(*parse(text, self.folder / "part.yaml"))

    def xml(self, block: Block) -> None:
        etree.fromstring(block.text if "<robot" in block.text else f"<x>{block.text}</x>")

    def json(self, block: Block) -> None:
        json.loads(block.text)

    def toml(self, block: Block) -> None:
        assert INSTALLED.stem in block.text

    def sh(self, block: Block) -> None:
        if block.info and block.info[0] in ("install", "test", "setup"):
            return  # what CI runs, or a download
        wanted = next((int(word[5:]) for word in block.info if word.startswith("exit=")), 0)
        self.said = ""
        for line in block.text.splitlines():
            words = shlex.split(line, comments=True)
            if not words:
                continue
            if words[0] == "export":
                name, _, value = words[1].partition("=")
                self.monkeypatch.setenv(name, value)
                continue
            if words[0] == "urdf2mbs" and ">" not in words:
                code = main(words[1:])
                self.said += "".join(self.capsys.readouterr())
            elif words[0] in ("gcc", "./fall"):
                for compiler in filter(shutil.which, ("clang", "gcc")):
                    command = line.replace("gcc", f"{compiler} -std=c99 -Wall -Werror", 1)
                    code, self.said = self.run(command)
                    assert not code, f"{command}: {self.said}"
            elif words[0] in ("pytest", "diff", "urdf2mbs"):
                code, said = self.run(line.replace(words[0], OURS.get(words[0], "diff"), 1))
                self.said += said
                code = 0 if words[0] == "diff" and code == 1 else code
            else:
                assert words[0] == "pip", line
                continue
            assert code == wanted, f"{line}: {code}\n{self.said}"

    def run(self, command: str) -> tuple[int, str]:
        """The exit code of a command in the folder, and what it said."""
        done = subprocess.run(
            command, shell=True, check=False, capture_output=True, text=True, cwd=self.folder
        )
        return done.returncode, done.stdout + done.stderr

    def text(self, block: Block) -> None:
        """All that was printed last; ``part``: lines of it, in their order.

        What varies from run to run is not compared: times and messages of progress.
        A block with ``file=`` is a part of that file.
        """
        if block.file:
            return
        printed = plain_lines(self.said.replace(f"{self.folder}/", ""))
        shown = plain_lines(block.text)
        if "part" in block.info:
            remaining = iter(printed)
            for line in shown:
                found = any(agree(line, other) for other in remaining)
                assert found, f"{line!r} was not printed, or not in this order:\n{self.said}"
        else:
            same = len(shown) == len(printed) and all(map(agree, shown, printed))
            assert same, f"this was printed:\n{self.said}"


def agree(shown: str, printed: str) -> bool:
    """Return whether two lines have the same words, and the same numbers to 1 %."""
    numbers = r"(?<![\w.])\d+\.\d+(?:e[+-]\d+)?"
    if re.split(numbers, shown) != re.split(numbers, printed):
        return False
    pairs = zip(re.findall(numbers, shown), re.findall(numbers, printed), strict=True)
    return all(isclose(float(a), float(b), rel_tol=0.01) for a, b in pairs)


def plain_lines(text: str) -> list[str]:
    """Return the lines of an output, without what varies from run to run."""
    lines = [" ".join(line.split()) for line in text.splitlines() if not line.startswith("... ")]
    return [re.sub(r"\b(in|after) [\d.]+ s\b", r"\1 1 s", line) for line in lines if line]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_code_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.syspath_prepend(install_file(tmp_path / "site-packages", INSTALLED))
    monkeypatch.delitem(sys.modules, INSTALLED.stem, raising=False)
    # to compile C's own library for a page takes a minute; test_live.py tests such pages
    monkeypatch.setattr("urdf2mbs_simulate.live.find_zig", lambda: None)
    folder = tmp_path / "robots"
    folder.mkdir()
    monkeypatch.chdir(folder)
    followed = Page(folder, capsys, monkeypatch)
    for block in blocks(page):
        try:
            followed.follow(block)
        except BaseException as error:
            raise AssertionError(f"{page}:{block.line}: {error}") from error


@pytest.mark.slow  # it compiles
def test_the_dog_of_the_tutorial_jumps_and_lands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    dog = FOLDER / "solo12" / "expanded" / "solo12.urdf"
    if not dog.is_file():
        pytest.skip("the real robots are not beside the checkout")
    monkeypatch.chdir(tmp_path)
    lines = re.findall("^    (urdf2mbs .*)$", (DOCS / "tutorial.md").read_text(), re.M)
    made, simulated = map(shlex.split, lines)
    Path(made[2]).parent.mkdir(parents=True)
    shutil.copy(dog, made[2])
    assert main(made[1:]) == 0
    assert "feet: FL_FOOT, FR_FOOT, HL_FOOT, HR_FOOT" in capsys.readouterr().out
    assert main(simulated[1:]) == 0
    assert "solo12 stands: " in capsys.readouterr().out
    assert (tmp_path / "solo12.html").is_file()
    longer = [word.replace("..0.6", "..0.7") for word in simulated[1:]]
    assert main(longer) == 0
    assert re.search("solo12 fell: .* hit the ground", capsys.readouterr().out)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text()):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{page}: {target}"


#: Pages that say all in words and tables.
WITHOUT_PICTURE = (
    "install",
    "questions",
    "limits",
    "glossary",
    "mapping",
    "mjcf",
    "xacro",
    "simulate-reference",
    "how-simulation-works",
    "how-equations-are-made",
    "beside-robotran",
    "diff",
    "diagnostics",
    "codes",
    "config",
    "certificate",
    "ci",
)


def test_every_page_of_a_task_has_a_picture_and_every_picture_its_page() -> None:
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text().replace("!ENV", ""))
    parts = {title: one for part in nav["nav"] for title, one in part.items()}
    tasks = ("Start", "Convert", "Simulate", "Equations", "Edit and merge", "Check")
    pages = [name for task in tasks for entry in parts[task] for name in entry.values()]
    for name in pages:
        if name.removesuffix(".md") not in WITHOUT_PICTURE:
            found = re.search(r"!\[[^\]]+\]\([\w/-]+\.(png|svg)\)", (DOCS / name).read_text())
            assert found, name
    text = "".join(page.read_text() for page in PAGES)
    for picture in (DOCS / "pictures").iterdir():
        assert f"pictures/{picture.name})" in text, picture
        assert picture.stat().st_size < 100_000, picture


# --- a page for every built-in pass ----------------------------------------------------------


def test_every_pass_has_its_page_and_every_page_its_pass() -> None:
    pages = {page.stem for page in (DOCS / "passes").glob("*.md")}
    assert pages == set(BUILT_IN)
    listed = re.findall(r"\(passes/([a-z-]+)\.md\)", (DOCS / "passes.md").read_text())
    assert set(listed) == set(BUILT_IN)


class Around:
    """The state before and after one pass."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.before: Any = None
        self.after: Any = None

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass, conversion: Conversion) -> None:
        if pass_.name == self.name:
            self.before = plain(conversion)

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Conversion) -> None:
        if pass_.name == self.name:
            self.after = plain(conversion)


def plain(conversion: Conversion) -> Any:
    return json.loads(json.dumps(make_state(conversion)))


def holds(part: Any, whole: Any) -> bool:
    """Whether all that ``part`` says is in ``whole``: keys of mappings, items of lists."""
    if isinstance(part, dict):
        return isinstance(whole, dict) and all(
            key in whole and holds(value, whole[key]) for key, value in part.items()
        )
    if isinstance(part, list) and part and isinstance(part[0], dict):
        rest = iter(whole if isinstance(whole, list) else [])
        return all(any(holds(item, other) for other in rest) for item in part)
    if isinstance(part, list):
        return (
            isinstance(whole, list)
            and len(part) == len(whole)
            and all(holds(a, b) for a, b in zip(part, whole, strict=True))
        )
    if isinstance(part, float) and isinstance(whole, (int, float)):
        return isclose(part, whole, rel_tol=1e-4, abs_tol=1e-12)
    return bool(part == whole)


#: The package without which a pass has no work on its page.
NEEDS = {"compare-mujoco": "mujoco"}


@pytest.mark.parametrize("name", BUILT_IN)
def test_before_and_after(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the tiny robot, or on the page's own; by the page's config, if it has one."""
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    config = "source: tiny.urdf\n"
    told: dict[str, Any] = {}
    for block in blocks(DOCS / "passes" / f"{name}.md"):
        if block.file:
            (tmp_path / block.file).write_text(block.text)
        elif block.language == "yaml" and block.info:
            told[block.info[0]] = yaml.safe_load(block.text)
        elif block.language == "yaml":
            config = f"source: tiny.urdf\n{block.text}"
    if "pipeline" not in config and name not in passes_of("faithful"):
        config += "pipeline: compact\n"
    pipeline = Pipeline(*parse(config, tmp_path / "tiny.yaml"))
    around = Around(name)
    pipeline.watch(around)
    write_files(pipeline.run().files)
    assert set(told) == {"before", "after"}
    assert holds(told["before"], around.before)
    assert holds(told["after"], around.after)
    assert not holds(told["after"], around.before), "it shows no change"


# --- tables that must be complete ------------------------------------------------------------


def test_every_section_is_documented() -> None:
    text = (DOCS / "passes.md").read_text()
    rows = re.findall(r"^\| `([a-z-]+)` \| .* \| (\[.*) \|$", text, re.MULTILINE)
    assert [section for section, _ in rows] == list(sections.SECTIONS)
    for section, passes in rows:
        for name in re.findall(r"\[([a-z-]+)\]", passes):
            assert section in BUILT_IN[name].writes


def test_every_element_and_attribute_of_urdf_is_mapped() -> None:
    text = (DOCS / "mapping.md").read_text()
    rows = re.findall(r"^\| `<(\w+)>` \| (?:`(\w+)`)? ?\|", text, re.MULTILINE)
    wanted = [
        (tag, name) for tag, element in ELEMENTS.items() for name in ("", *element.attributes)
    ]
    assert sorted(rows) == sorted(wanted)
    gaps = re.findall(r"^\|.*\*\*GAP\*\*.*$", text, re.MULTILINE)
    assert gaps
    for row in gaps:
        codes = re.findall(r"\[`([a-z-]+)`\]\(codes\.md\)", row)
        assert codes, f"which warning or note tells of it? {row}"
        assert set(codes) <= CATALOGUE.keys()


#: Where the code of an error, a warning, a note or a difference stands among the arguments.
TAKES_CODE = {
    "failed": 1,
    "choose": 2,
    "ConversionError": 0,
    "ConfigError": 0,
    "Diagnostic": 1,
    "warn": 0,
    "note": 0,
    "fail": 0,
    "error": 0,
    "_failed": 0,
    "SimulationError": 0,
    "Fault": 0,
    "Slip": 0,
    "add_point": 3,
    "fault": 0,
}


@cache
def source_codes() -> tuple[set[str], dict[str, set[str]]]:
    """The codes in calls that say something or given to a variable ``code``; all words of each room
    and plugin.  ``warnings.warn`` says no code.  The Python API says the codes of the commands."""
    said: set[str] = set()
    words: dict[str, set[str]] = {}
    core, plugins = ((ROOT / folder).rglob("*.py") for folder in ("urdf2mbs", "plugins"))
    for file in (*core, *plugins):
        if file.name == "codes.py":
            continue
        room = file.relative_to(ROOT).parts[1].replace("verification.py", "commands")
        for node in ast.walk(ast.parse(file.read_text())):
            words.setdefault(room, set()).update(strings(node))
            if isinstance(node, ast.Call):
                name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                if name == "warn" and ast.unparse(node.func) == "warnings.warn":
                    continue
                at = TAKES_CODE.get(name, len(node.args))
                if name == "fail" and not strings(node.args[0]):
                    at = 1  # where the element comes first
                said |= strings(node.args[at]) if at < len(node.args) else set()
            elif isinstance(node, ast.Assign):
                pairs = zip(parts(node.targets[0]), parts(node.value), strict=False)
                given = (value for target, value in pairs if ast.unparse(target) == "code")
                said |= {word for value in given for word in strings(value)}
    return said, words


def parts(node: ast.expr) -> list[ast.expr]:
    return node.elts if isinstance(node, ast.Tuple) else [node]


def strings(node: ast.AST) -> set[str]:
    """The words that an expression may be."""
    if isinstance(node, ast.IfExp):
        return strings(node.body) | strings(node.orelse)
    found = isinstance(node, ast.Constant) and isinstance(node.value, str) and bool(node.value)
    return {node.value} if found else set()  # type: ignore[attr-defined]


def test_every_code_stands_once_and_beside_what_says_it() -> None:
    said, words = source_codes()
    assert sum(map(len, TABLES.values())) == len(CATALOGUE), "a code stands in two tables"
    assert said - CATALOGUE.keys() == set(), "in no codes.py"
    for room, table in TABLES.items():
        assert table.keys() - words[room] == set(), f"in {room}/codes.py, and {room} says them not"
        for code, text in table.items():
            assert re.match(r"(error|error, unless lowered|warning|note): .", text), code
            # one sentence of meaning, and one of what to do; a note leaves nothing to do
            assert text.startswith("note") or re.search(r"\w\W*\. [A-Z].*\.$", text), code


def test_a_test_asserts_every_code() -> None:
    asserted = set()
    for file in TESTS.rglob("test_*.py"):
        asserted |= list_asserted_codes(file.read_text())
    for file in TESTS.glob("whole/snapshots/*.txt"):
        asserted |= {*re.findall(r"^(?:error|warning|note)\[(.*?)\]", file.read_text(), re.M)}
    assert CATALOGUE.keys() - asserted == set()


@pytest.mark.parametrize(
    ("line", "asserted"),
    [
        ("assert error.code == 'two-parents'", True),
        ("assert 'error[loop]: ' in said", True),
        ("with pytest.raises(ConversionError, match='two-parents'): pass", True),
        ("for text, code in ((LOOP, 'loop'),): pass", True),
        ("convert(robot, diagnostics={**more, 'two-parents': 'note'}, without=['loop'])", False),
        ("simulate(['init', 'loop'])", False),
        ("assert calls == ['init', 'loop']", False),
    ],
)
def test_a_code_that_a_test_only_names_is_not_asserted(line: str, asserted: bool) -> None:
    assert bool({"two-parents", "loop"} & list_asserted_codes(line)) is asserted


def test_every_command_is_in_the_readme_or_the_docs() -> None:
    text = "".join(page.read_text() for page in PAGES)
    for command in list_commands():
        assert f"urdf2mbs {command}" in text, command


def test_each_test_file_says_in_one_line_what_it_protects() -> None:
    """In a sentence of its own: two files that protect the same should be one."""
    told: dict[str, Path] = {}
    for file in sorted(TESTS.rglob("test_*.py")):
        line = (ast.get_docstring(ast.parse(file.read_text())) or "").partition("\n")[0]
        assert re.fullmatch(r"(\S+ +){4,}\S+\.", line), f"{file}: {line!r}"
        assert line not in told, f"{file} and {told.get(line)}"
        told[line] = file


def load_script(name: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Import a script of the folder docs."""
    monkeypatch.syspath_prepend(DOCS)
    return importlib.import_module(name)


def test_the_pages_of_codes_and_config_are_up_to_date(monkeypatch: pytest.MonkeyPatch) -> None:
    """``python docs/make_reference.py`` writes them."""
    for name, make in load_script("make_reference", monkeypatch).PAGES.items():
        assert (DOCS / name).read_text("utf-8") == make(), name


def test_the_site_has_every_command_key_pass_and_hook(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its generated pages; that all links lead somewhere is seen when it is built, in CI."""
    module = load_script("build_site", monkeypatch)
    pages = module.pages()
    for command in list_commands():
        assert f"\n## {command}\n" in pages["reference/commands.md"]
    for key in Config.__struct_fields__:
        assert f"\n| `{key}` |" in (DOCS / "config.md").read_text("utf-8")
    for name, kind in BUILT_IN.items():
        assert f"(../passes/{name}.md)" in pages["reference/passes.md"]
        page = SimpleNamespace(file=SimpleNamespace(src_uri=f"passes/{name}.md"))
        text = module.on_page_markdown((DOCS / "passes" / f"{name}.md").read_text(), page)
        rows = re.findall(r"^\| `(\w+)` \| `[^`]*` \| .", text, re.MULTILINE)
        assert rows == list(kind.__struct_fields__)
    for name in vars(hookspecs):
        if name.startswith("urdf2mbs_"):
            assert f"\n## {name}\n" in f"\n{pages['reference/hooks.md']}"
