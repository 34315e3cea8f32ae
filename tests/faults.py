"""Plant faults in the code, one at a time: do the tests of the same room find each?

Run by hand, for it takes hours:

    python tests/faults.py --count 300 --seed 1 --workers 2 [--only passes/contacts.py]

A fault changes one operator, sign, number, comparison or word of a condition, or drops one
statement.  It is found if a test of its room fails, or if a conversion of our example robots fails
or is rejected.  The tables at the end count the faults, and name each that lives.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
#: The files of a room, and the tests that must find a fault in them.
ROOMS = {
    "passes/*.py": ["tests/passes/test_{stem}.py"],
    "project/*.py": ["tests/project", "tests/passes/test_time_step.py", "tests/test_project.py"],
    "equations/*.py": ["tests/equations", "tests/project/test_c.py"],
    "proof/*.py": ["tests/proof"],
    "urdf/*.py": ["tests/urdf"],
    "mbs/*.py": ["tests/mbs", "tests/passes/test_emit.py"],
}
#: Robots whose conversion must go on and be proven.
ROBOTS = ("biped.urdf.xacro", "hexapod.urdf.xacro", "arm.urdf.xacro", "lamp.urdf")
OPPOSITE: dict[type[ast.AST], type[ast.AST]] = {
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
    source = file.read_text("utf-8")
    lines = source.encode().splitlines(keepends=True)
    starts = [sum(map(len, lines[:number])) for number in range(len(lines))]
    for node, changed in changes(ast.parse(source)):
        begin = starts[node.lineno - 1] + node.col_offset
        end = starts[(node.end_lineno or 1) - 1] + (node.end_col_offset or 0)
        data = source.encode()
        text = data[:begin] + changed.encode() + data[end:]
        yield Fault(
            file.relative_to(ROOT).as_posix(), node.lineno, data[begin:end].decode(), changed,
            text.decode(),
        )  # fmt: skip


def changes(tree: ast.AST) -> Iterator[tuple[ast.stmt | ast.expr, str]]:
    """Each place of a program that can have a fault, and what stands there then.

    What is said to the user, types and what only names something cannot be wrong in this sense.
    """
    todo: list[ast.AST] = [tree]
    while todo:
        node = todo.pop()
        if isinstance(node, (ast.JoinedStr, ast.Raise, ast.AnnAssign, ast.ImportFrom)):
            continue
        if isinstance(node, ast.Call) and _says(node):
            continue
        todo += ast.iter_child_nodes(node)
        if isinstance(node, (ast.FunctionDef, ast.arguments)):
            todo = [one for one in todo if one not in (getattr(node, "returns", None),)]
        if isinstance(node, (ast.BinOp, ast.BoolOp)) and type(node.op) in OPPOSITE:
            yield node, f"({_swapped(node, 'op')})"
        elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in OPPOSITE:
            yield node, f"({_swapped(node, 'ops')})"
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
            yield node, f"({ast.unparse(node.operand)})"
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            yield node, repr(node.value + 1 if type(node.value) is int else 2 * node.value + 0.5)
        elif isinstance(node, (ast.AugAssign, ast.Expr)) and not (
            isinstance(node, ast.Expr) and isinstance(node.value, (ast.Constant, ast.Yield))
        ):
            yield node, "pass"


def _says(call: ast.Call) -> bool:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    return name in ("warn", "note", "fail", "progress", "ConfigError", "ConversionError", "TypeVar")


def _swapped(node: ast.BinOp | ast.BoolOp | ast.Compare, field: str) -> str:
    copy = ast.parse(ast.unparse(node), mode="eval").body
    old = getattr(copy, field)
    swapped = OPPOSITE[type(old[0] if field == "ops" else old)]()
    setattr(copy, field, [swapped] if field == "ops" else swapped)
    return ast.unparse(copy)


def tests_of(file: str) -> list[str]:
    """The tests of a file's room, as far as there are such."""
    path = Path(file).relative_to("urdf2mbs")
    found = next((tests for glob, tests in ROOMS.items() if path.match(glob)), [])
    whole = [test.format(stem=path.stem) for test in found]
    return [test for test in whole if (ROOT / test).exists()]


def choose(only: list[str], count: int, seed: int) -> list[Fault]:
    """As many faults as asked for, at most one of a line, by chance."""
    by_line = {}
    chance = random.Random(seed)
    for glob in only or ROOMS:
        for file in sorted((ROOT / "urdf2mbs").glob(glob)):
            found = list(faults_of(file))
            chance.shuffle(found)
            by_line.update({(fault.file, fault.line): fault for fault in found})
    chosen = sorted(by_line.values())
    chance.shuffle(chosen)  # so that the first of them are a fair sample
    return chosen[:count]


class Tree:
    """A copy of the project in which one fault at a time is planted."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "tree"
        for name in ("urdf2mbs", "tests", "configs", "plugins", "docs", "benchmarks"):
            shutil.copytree(ROOT / name, self.root / name)
        for file in ("pyproject.toml", "README.md", "mkdocs.yml"):
            shutil.copy(ROOT / file, self.root)
        shared = ROOT.parent / "shared"
        if shared.exists():
            (folder / "shared").symlink_to(shared.resolve())

    def killer(self, fault: Fault | None, tests: list[str]) -> str:
        """What finds a fault; empty: nothing does."""
        file = self.root / fault.file if fault else None
        before = file.read_text("utf-8") if file else ""
        if file and fault:
            file.write_text(fault.text, "utf-8")
        try:
            words = ["-m", "pytest", "-x", "-q", "-n", "0", "-m", "not slow",
                     "-p", "no:cacheprovider", *tests]  # fmt: skip
            if tests and self.run(words):
                return "tests"
            for robot in ROBOTS:
                words = ["-m", "urdf2mbs", "convert", f"configs/{robot}", "-q", "--force",
                         "-o", f"out/{robot}/"]  # fmt: skip
                if self.run(words):
                    return "conversion"
            return ""
        finally:
            if file:
                file.write_text(before, "utf-8")

    def run(self, words: list[str]) -> int:
        environment = {**os.environ, "PYTHONPATH": str(self.root), "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            return subprocess.run(
                [sys.executable, *words], cwd=self.root, env=environment, check=False,
                capture_output=True, timeout=600,
            ).returncode  # fmt: skip
        except subprocess.TimeoutExpired:
            return 1  # a loop without end is found, too


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--only", action="append", default=[], help="passes/contacts.py, say")
    given = parser.parse_args()
    chosen = choose(given.only, given.count, given.seed)
    lived: list[Fault] = []
    with tempfile.TemporaryDirectory() as folder:
        trees = [Tree(Path(folder, str(number))) for number in range(given.workers)]

        def plant(fault: Fault) -> None:
            tree = trees.pop()
            try:
                killer = tree.killer(fault, tests_of(fault.file))
            finally:
                trees.append(tree)
            if not killer:
                lived.append(fault)
            said = f"{killer or 'LIVED':10} {fault.file}:{fault.line}"
            print(f"{said}: {fault.before[:60]!r} -> {fault.after[:60]!r}", flush=True)

        with ThreadPoolExecutor(given.workers) as pool:
            list(pool.map(plant, chosen))
    print("\n| room | faults | found |\n|---|---|---|")
    for room in sorted({Path(fault.file).parts[1] for fault in chosen}):
        planted, left = (sum(Path(f.file).parts[1] == room for f in fs) for fs in (chosen, lived))
        print(f"| {room} | {planted} | {planted - left} |")
    print("\n| file | a fault that lives |\n|---|---|")
    for fault in sorted(lived):
        change = f"`{fault.before}` -> `{fault.after}`".replace("\n", " ")
        print(f"| {fault.file}:{fault.line} | {change} |")


if __name__ == "__main__":
    main()
