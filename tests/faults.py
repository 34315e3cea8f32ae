"""Plant faults in the code, one at a time: do the tests of the same room find each?

Run by hand, for it takes hours:

    python tests/faults.py --count 300 --seed 1 [--only urdf2mbs/passes/decompose_joints.py]

A fault changes one operator, sign, number, comparison or word of a condition, or drops one
statement.  It is found if a test of its room that reaches its line fails, or if a conversion of our
example robots fails or is rejected.  A table at the end counts the faults.

Left out is what no result depends on: words of messages, types, ``__slots__``, sizes of caches,
branches for other platforms, and the numbers of pictures in ``report``.  The tests run once
under coverage.py, which imports this file as a plugin of pytest.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import coverage
import pytest

ROOT = Path(__file__).resolve().parents[1]
#: Other tests that must find a fault in the files of a room, besides those in its own folder.
ALSO = {
    "passes": ["tests/config"],
    "commands": ["tests/engine", "tests/strangers"],
    "engine": ["tests/disk", "tests/strangers"],
    "disk": ["tests/hostile"],
    "mbs": ["tests/passes/test_emit.py"],
    "messages": ["tests/engine/test_levels.py"],
    "xml": ["tests/urdf", "tests/mbs", "tests/hostile"],
    "plugins/project": ["tests/plugins/simulate", "tests/plugins/equations/test_callable.py"],
    "plugins/simulate": ["tests/plugins/project", "tests/plugins/equations/test_callable.py"],
    "plugins/equations": ["tests/plugins/project/test_c.py"],
    "": ["tests/test_spatial.py", "tests/proof", "tests/passes", "tests/commands"],
}
#: Functions that write a message or a part of one, and calls that name a type or make a cache.
SAYS = {
    "warn", "note", "fail", "progress", "ConfigError", "ConversionError", "TypeVar", "lru_cache",
    "_called", "_causes", "_count", "_find_words", "_grouped", "_in_words", "_lost", "_meaning",
    "_quote", "_remarks", "_sentence", "_short", "_some", "base_in_words", "describe", "in_words",
    "message", "places", "places_of", "quote", "some", "where", "words", "__repr__", "__str__",
}  # fmt: skip
#: Robots whose conversion must go on and be proven.
ROBOTS = ("biped.urdf.xacro", "hexapod.urdf.xacro", "arm.urdf.xacro", "lamp.urdf")
OPPOSITE: dict[type[ast.AST], Any] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


class Fault(NamedTuple):
    """A change of one place of a file."""

    file: str
    line: int
    before: str
    after: str
    text: str
    """The whole file with the fault."""


def faults_of(file: Path) -> Iterator[Fault]:
    """All faults that can be planted in a file."""
    data = file.read_bytes()
    lines = data.splitlines(keepends=True)
    starts = [sum(map(len, lines[:number])) for number in range(len(lines))]
    name = file.relative_to(ROOT).as_posix()
    for node, other in changes(ast.parse(data)):
        if isinstance(node, ast.Constant) and "urdf2mbs_report" in file.parts:
            continue
        begin = starts[node.lineno - 1] + node.col_offset
        end = starts[(node.end_lineno or 1) - 1] + (node.end_col_offset or 0)
        changed = "pass" if isinstance(other, ast.Pass) else f"({ast.unparse(other)})"
        text = (data[:begin] + changed.encode() + data[end:]).decode()
        yield Fault(name, node.lineno, data[begin:end].decode(), changed, text)


def changes(tree: ast.AST) -> Iterator[tuple[ast.stmt | ast.expr, ast.AST]]:
    """Each place of a program that can have a fault, and what stands there then."""
    todo: list[ast.AST] = [tree]
    while todo:
        node = todo.pop()
        if left_out(node):
            continue
        todo += ast.iter_child_nodes(node)
        match node:
            case ast.BinOp(left, op, right) if type(op) in OPPOSITE:
                yield node, ast.BinOp(left, OPPOSITE[type(op)](), right)
            case ast.BoolOp(op, values):
                yield node, ast.BoolOp(OPPOSITE[type(op)](), values)
            case ast.Compare(left, [op], right):
                yield node, ast.Compare(left, [OPPOSITE[type(op)]()], right)
            case ast.UnaryOp(ast.USub() | ast.Not(), operand):
                yield node, operand
            case ast.Constant(value) if type(value) in (int, float):
                yield node, ast.Constant(value + 1 if type(value) is int else 2 * value + 0.5)
            case ast.AugAssign() | ast.Expr(ast.Call()):
                yield node, ast.Pass()


def left_out(node: ast.AST) -> bool:
    """True if no result depends on a part of a program: see the head of this file."""
    match node:
        case ast.JoinedStr() | ast.Raise() | ast.Assign(targets=[ast.Name(id="__slots__")]):
            return True
        case ast.Call(ast.Name(name) | ast.Attribute(_, name)) | ast.FunctionDef(name):
            return name in SAYS
        case ast.If(test=test):
            return ast.unparse(test).startswith(("sys.platform", "TYPE_CHECKING"))
    return False


def room_of(file: str) -> str:
    """The room of the core, such as ``passes``, or the plugin, such as ``plugins/project``."""
    room = Path(file).parts[1] if file.count("/") > 1 else ""
    return f"plugins/{room.partition('_')[2]}" if file.startswith("plugins/") else room


def tests_of(file: str) -> list[str]:
    """The tests of a file's room, as far as they exist."""
    room = room_of(file)
    tests = [f"tests/{room}" if room else "", *ALSO.get(room, [])]
    return [test for test in tests if test and (ROOT / test).exists()]


def choose(only: list[str], count: int, seed: int) -> list[Fault]:
    """As many faults as asked for, at most one of a line, by chance."""
    by_line = {}
    chance = random.Random(seed)
    for glob in only or ("urdf2mbs/**/*.py", "plugins/**/*.py"):
        for file in sorted(ROOT.glob(glob)):
            found = list(faults_of(file))
            chance.shuffle(found)
            by_line.update({(fault.file, fault.line): fault for fault in found})
    chosen = sorted(by_line.values())
    chance.shuffle(chosen)  # so that the first of them are a fair sample
    return chosen[:count]


SECONDS: dict[str, float] = {}  # how long each test takes


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """What the fixtures of a test reach, all tests of its file reach."""
    coverage.Coverage.current().switch_context(item.location[0])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> None:
    coverage.Coverage.current().switch_context(item.nodeid)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    SECONDS[report.nodeid] = SECONDS.get(report.nodeid, 0) + report.duration


def pytest_sessionfinish() -> None:
    Path("seconds.json").write_text(json.dumps(SECONDS), "utf-8")


class Tree:
    """A copy of the project in which one fault at a time is planted."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "tree"
        self.options = ["-q", "-n0", "-m", "not slow", "-p", "no:cacheprovider",
                        "--hypothesis-seed=0", f"--basetemp={folder}/basetemp"]  # fmt: skip
        self.reached: dict[tuple[str, ...], tuple[coverage.CoverageData, dict[str, float]]] = {}
        shutil.copytree(ROOT, self.root, ignore=shutil.ignore_patterns(".*", "node_modules"))
        (folder / "shared").symlink_to((ROOT.parent / "shared").resolve())

    def killer(self, fault: Fault) -> str:
        """What finds a fault; empty: nothing does."""
        tests = self.tests_that_reach(fault)
        file = self.root / fault.file
        before = file.read_text("utf-8")
        file.write_text(fault.text, "utf-8")
        try:
            if tests and self.run(["-m", "pytest", "-x", *self.options, *tests]):
                return "tests"
            convert = ["-m", "urdf2mbs", "convert", "-q", "--force", "-o"]
            wrong = any(self.run([*convert, f"out/{name}/", f"configs/{name}"]) for name in ROBOTS)
            return "conversion" if wrong else ""
        finally:
            file.write_text(before, "utf-8")

    def tests_that_reach(self, fault: Fault) -> list[str]:
        """The tests of the room that reach a line, the quickest first.

        A line that no coverage tells of, such as the second of a statement, is reached as the one
        before.  Lines that an import reaches are reached by all.
        """
        room = tuple(tests_of(fault.file))
        if not room:
            return []
        if room not in self.reached:
            data = coverage.CoverageData(f"{self.root}/coverage.{len(self.reached)}")
            options = ["--rcfile=/dev/null", f"--data-file={data.data_filename()}"]
            source = "--source=urdf2mbs,plugins"
            words = ["-m", "coverage", "run", *options, source, "-m", "pytest"]
            if self.run([*words, "-p", "faults", *self.options, *room]):
                sys.exit(f"these tests fail without a fault: {' '.join(room)}")
            data.read()
            seconds = json.loads((self.root / "seconds.json").read_text("utf-8"))
            self.reached[room] = data, seconds
        data, seconds = self.reached[room]
        lines = data.contexts_by_lineno(str(self.root / fault.file))
        line = max((line for line in lines if line <= fault.line), default=0)
        contexts = set(lines.get(line, [""]))
        parts = {name: {name, name.partition("::")[0]} for name in seconds}
        names = [name for name in seconds if "" in contexts or contexts & parts[name]]
        return sorted(names, key=seconds.__getitem__)

    def run(self, words: list[str]) -> int:
        paths = os.pathsep.join(str(self.root / part) for part in ("", "plugins", "tests"))
        environment = {**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            return subprocess.run(
                [sys.executable, *words], cwd=self.root, env=environment, check=False,
                capture_output=True, timeout=300,
            ).returncode  # fmt: skip
        except subprocess.TimeoutExpired:
            return 1  # a loop without end is found, too


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--only", action="append", default=[], help="urdf2mbs/passes/decompose_joints.py, say"
    )
    given = parser.parse_args()
    chosen = choose(given.only, given.count, given.seed)
    lived: list[Fault] = []
    with tempfile.TemporaryDirectory() as folder:
        tree = Tree(Path(folder))
        for fault in chosen:
            killer = tree.killer(fault)
            if not killer:
                lived.append(fault)
            said = f"{killer or 'LIVED':10} {fault.file}:{fault.line}"
            print(f"{said}: {fault.before[:60]!r} -> {fault.after[:60]!r}", flush=True)
    print("\n| room | faults | found |\n|---|---|---|")
    for room in sorted({room_of(fault.file) for fault in chosen}):
        planted, left = (sum(room_of(f.file) == room for f in fs) for fs in (chosen, lived))
        print(f"| {room or 'urdf2mbs'} | {planted} | {planted - left} |")


if __name__ == "__main__":
    main()
