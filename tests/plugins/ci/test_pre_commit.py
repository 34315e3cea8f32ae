"""The hooks for pre-commit are commands that run, and run when a robot's file changes."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

from support.folders import ROOT
from urdf2mbs.cli import main
from urdf2mbs.testing import TINY

HOOKS: dict[str, dict[str, Any]] = {
    hook["id"]: hook for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
}
#: The example of docs/ci.md.
(EXAMPLE,) = re.findall(
    r"^    repos:\n(?:    .*\n)+", (ROOT / "docs" / "ci.md").read_text(), re.MULTILINE
)


def commit(hook: str, arguments: list[str]) -> int:
    """Run a hook as pre-commit does: its entry, and behind it the arguments of the user."""
    program, *words = shlex.split(HOOKS[hook]["entry"])
    assert program == "urdf2mbs"
    return main([*words, *arguments])


def test_each_hook_has_what_pre_commit_requires() -> None:
    assert set(HOOKS) == {"lint", "verify"}
    for hook in HOOKS.values():
        assert {"id", "name", "description", "entry", "language", "files"} <= hook.keys()
        assert hook["language"] == "python"
        # the files that changed are no arguments: one command checks one robot
        assert hook["pass_filenames"] is False


@pytest.mark.parametrize(
    ("file", "hooks"),
    [
        ("urdf/arm.urdf", {"lint", "verify"}),
        ("urdf/macros.urdf.xacro", {"lint", "verify"}),
        ("lab.yaml", {"lint", "verify"}),
        ("our_passes.py", {"lint", "verify"}),
        ("arm.mbs", {"verify"}),
        ("meshes/arm.stl", {"lint"}),
        ("README.md", set()),
    ],
)
def test_a_hook_runs_when_a_file_of_the_robot_changes(file: str, hooks: set[str]) -> None:
    assert {name for name, hook in HOOKS.items() if re.search(hook["files"], file)} == hooks


def test_the_example_of_the_docs_finds_a_change(here: Path) -> None:
    """Its hooks, each with its arguments."""
    (repository,) = yaml.safe_load(EXAMPLE)["repos"]
    hooks = [(hook["id"], hook["args"]) for hook in repository["hooks"]]
    assert {name for name, _ in hooks} == HOOKS.keys()
    files = {word for _, words in hooks for word in words if not word.startswith("-")}
    robot = next(Path(file) for file in files if file.endswith(".urdf"))
    config = next(Path(file) for file in files if file.endswith(".yaml"))
    robot.parent.mkdir(exist_ok=True)
    robot.write_text(TINY)
    config.write_text(f"source: {robot}\noutput: arm.mbs\n")
    assert main(["run", str(config), "-q"]) == 0
    assert [commit(name, words) for name, words in hooks] == [0, 0]
    robot.write_text(TINY.replace('<mass value="2"/>', '<mass value="3"/>'))
    assert [commit(name, words) for name, words in hooks] == [0, 3]
    robot.write_text(TINY.replace('link="arm"', 'link="amr"'))
    assert [commit(name, words) for name, words in hooks] == [1, 1]
