"""Whatever is wrong with a plugin, one message names it, and there is no traceback.

The exit code is 2, or 1 if the plugin failed on a robot.
"""

import re
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY, convert_text, run_pass

HOOKS = "from support.plugin_files import hookimpl, make\n"
CLASS = "from urdf2mbs.plugin import Pass, hookimpl\nclass A(Pass):\n"
LIST = "@hookimpl\ndef urdf2mbs_passes(): return "
PASS = HOOKS + "def run(conversion, options): pass\n" + LIST


def write(folder: Path, does: str) -> Path:
    """A plugin with the pass ``a``; ``does`` is the body of its function."""
    file = folder / "mine.py"
    file.write_text(f"{HOOKS}def run(conversion, options):\n  {does}\n{LIST}[make('a', run)]\n")
    return file


def run_config(folder: Path, plugin: str | None, capsys: Any, config: str = "") -> tuple[int, str]:
    (folder / "tiny.urdf").write_text(TINY)
    if plugin is not None:
        (folder / "mine.py").write_text(plugin)
    (folder / "robot.yaml").write_text(f"source: tiny.urdf\nplugins: [mine.py]\n{config}")
    code = main(["run", str(folder / "robot.yaml")])
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert len(re.findall(r"error\[", said.err)) == 1
    assert not (folder / "tiny.mbs").exists()
    return code, said.err


@pytest.mark.parametrize(
    ("plugin", "said"),
    [
        (None, r"robot.yaml:2: error\[plugin-missing\]"),
        ("x = 1\ndef f(:\n", r"mine.py:2: error\[plugin-broken\].*SyntaxError"),
        ("import nosuch\n", r"mine.py:1: .*No module named 'nosuch'\n.*install it"),
        ("x = 1\n1 / 0\n", r"mine.py:2: .*ZeroDivisionError"),
        ("import sys\nsys.exit(0)\n", r"mine.py:2: .*SystemExit: 0"),
        ("", r"plugin-empty\].*\n.*@hookimpl"),
        ("\0", r"plugin-broken\].*null bytes"),
        (
            HOOKS + "@hookimpl\ndef urdf2mbs_pass(): pass\n",
            r"mine.py: .*unknown hook 'urdf2mbs_pass'.*\n.*the hooks are: urdf2mbs_passes\(\),",
        ),
        (
            HOOKS + "@hookimpl\ndef urdf2mbs_before_pass(robot): pass\n",
            r"mine.py: .*\{'robot'\}.*\n.*before_pass\(pass_, conversion\)",
        ),
        (PASS + "None\n", r"urdf2mbs_passes returned nothing; expected a list\n.*of the classes"),
        (PASS + "['a']\n", r"returned 'a'; expected a subclass of Pass"),
        (PASS + "[][0]\n", r"mine.py:4: .*urdf2mbs_passes failed: IndexError"),
        (PASS + "[make('', run)]\n", r"pass '': its name"),
        (CLASS + "  pass\n" + LIST + "[A]\n", r"no method 'run'\n.*run\(self, conversion\)"),
        (
            CLASS + "  def run(self, conversion, options): pass\n" + LIST + "[A]\n",
            r"its 'run' cannot be called\b.*\n.*self, conversion",
        ),
        (PASS + "[make('a', run, reads=('robot'))]\n", r"'reads' is 'robot'\n.*\('robot',\)"),
        (
            "from __future__ import annotations\n" + CLASS + "  at: re.Pattern = None\n"
            "  def run(self, conversion): pass\n" + LIST + "[A]\n",
            r"plugin-broken\].*NameError",
        ),
        (
            "from pathlib import Path\n" + CLASS + "  at: Path = Path()\n"
            "  def run(self, conversion): pass\n" + LIST + "[A]\n",
            r"options cannot be read from",
        ),
        (PASS + "[make('a', run)] * 2\n", r"two passes 'a'"),
    ],
)
def test_a_broken_plugin_is_one_message(
    plugin: str | None, said: str, tmp_path: Path, capsys: Any
) -> None:
    code, err = run_config(tmp_path, plugin, capsys)
    assert code == 2
    assert re.search(said, err), err
    assert "mine" in err


def test_a_relative_path_names_the_line_too(here: Path, capsys: Any) -> None:
    Path("c.yaml").write_text("source: r.urdf\nplugins: mine.py\n")
    for plugin, line in (("x = 1\ndef f(:\n", 2), ("x = 1\n\n1 / 0\n", 3)):
        Path("mine.py").write_text(plugin)
        assert main(["explain", "c.yaml"]) == 2
        assert f"mine.py:{line}: error[plugin-broken]" in capsys.readouterr().err
    Path("passes.txt").touch()
    assert main(["explain", "--plugin", "passes.txt"]) == 2
    assert "is not a Python file (.py)" in capsys.readouterr().err


def test_files_of_one_name_do_not_mix(tmp_path: Path, capsys: Any) -> None:
    files = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        files.append(write(tmp_path / folder, f"conversion.robot.name = '{folder}'"))
        files[-1].write_text(f'"""{folder}."""\n{files[-1].read_text()}')
    for file in (*files, files[0]):
        assert run_pass("a", file).robot.name == file.parent.name
        (found,) = Plugins([file], installed=False).passes["a"]
        assert (found.load().summary(), found.file) == (f"{file.parent.name}.", str(file))
    assert main(["explain", "--plugin", str(files[0]), "--plugin", str(files[1])]) == 2
    assert re.search(r"plugin-doubled\].*one/mine.py and .*two/mine.py", capsys.readouterr().err)


@pytest.mark.parametrize(
    ("does", "code", "line", "said"),
    [
        ("conversion.robot.links['x']", "plugin-failed", 3, "on robot 'tiny': KeyError: 'x'"),
        ("import sys; sys.exit('enough')", "plugin-failed", 3, "SystemExit: enough"),
        # the line is in the plugin, and not in what the plugin calls
        ("import json\n  json.loads('{')", "plugin-failed", 4, "JSONDecodeError"),
        (
            "from urdf2mbs.plugin import ConversionError as E; raise E('own', 'no legs')",
            "own",
            None,
            "no legs",
        ),
        ("conversion.robot = None", "plugin-failed", None, ""),
        ("conversion.robot.links['arm'] = None", "plugin-failed", None, ""),
        # a robot that is no tree: the next pass would stumble over it, or drop half of it
        (
            "conversion.robot.links.clear(); conversion.robot.joints.clear()",
            "plugin-robot-broken",
            None,
            "",
        ),
        ("del conversion.robot.links['tool']", "plugin-robot-broken", None, "names 'tool'"),
        ("del conversion.robot.joints['shoulder']", "plugin-robot-broken", None, "body, arm"),
        ("conversion.robot.links['arm'].name = 'x'", "plugin-robot-broken", None, "called 'x'"),
        ("conversion.robot.joints['shoulder'].name = 'x'", "plugin-robot-broken", None, "'x'"),
        (
            "conversion.robot.joints['tool_mount'].child = 'arm'",
            "plugin-robot-broken",
            None,
            "child of the joints 'shoulder' and",
        ),
        ("conversion.robot.joints['shoulder'].parent = 'tool'", "plugin-robot-broken", None, ""),
        ("conversion.files['a'] = b''", "plugin-output-broken", None, "'a': bytes"),
        ("conversion.files[conversion.settings.output] = ''", "plugin-output-broken", None, ""),
    ],
)
def test_what_a_pass_does_wrong(
    does: str, code: str, line: int | None, said: str, tmp_path: Path
) -> None:
    file = write(tmp_path, does)
    with pytest.raises(ConversionError) as caught:
        run_pass("a", file)
    assert caught.value.code == code
    assert said in caught.value.message
    if code != "own":
        assert "pass 'a' of plugin 'mine'" in caught.value.message
    if line is not None:
        assert (caught.value.file, caught.value.line) == (str(file), line)


def test_a_built_in_pass_that_stumbles_after_a_plugins_says_so(tmp_path: Path) -> None:
    with pytest.raises(ConversionError) as caught:
        run_pass("a", write(tmp_path, "conversion.segments.clear()"), after="prune-massless")
    assert caught.value.code == "internal"
    assert "'a' (mine)" in (caught.value.hint or "")


@pytest.mark.parametrize("when", ["before", "after"])
def test_an_exception_in_a_hook(
    when: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    plugin = HOOKS + (
        f"@hookimpl\ndef urdf2mbs_{when}_pass(pass_, conversion):\n"
        "  if pass_.name == 'insert-base':\n    assert not pass_, 'no mimic'\n"
    )
    code, err = run_config(Path(), plugin, capsys)
    assert code == 1
    assert re.search(
        rf"mine.py:5: error\[plugin-failed\]: hook 'urdf2mbs_{when}_pass' of plugin 'mine', called "
        rf"{when} pass 'insert-base', failed on robot 'tiny': AssertionError: no mimic",
        err,
    ), err


@pytest.mark.parametrize(
    "hook", ["urdf2mbs_extension(elements)", "urdf2mbs_read(source)", "urdf2mbs_progress(text)"]
)
def test_an_exception_in_a_hook_that_a_pass_calls(hook: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    text = f"{HOOKS}from urdf2mbs.plugin import *\n@hookimpl\ndef {hook}:\n  raise KeyError('no')\n"
    if "progress" in hook:
        file.with_name("theirs.py").write_text(text)
        write(tmp_path, "conversion.progress('at work')")
        plugins, by, line = [file, file.with_name("theirs.py")], "pass 'a' of plugin 'mine'", None
        more: dict[str, Any] = {"after": {"expand": "a"}}
    else:
        file.write_text(text)
        plugins, by, line, more = [file], "plugin 'mine', called by pass 'expand',", 5, {}
    with pytest.raises(ConversionError, match=re.escape(by)) as caught:
        convert_text(plugins=plugins, **more)
    assert caught.value.code == "plugin-failed"
    assert "KeyError: 'no'" in caught.value.message
    assert line is None or (caught.value.file, caught.value.line) == (str(file), line)


def test_an_exception_in_the_hook_that_locates_a_robot(tmp_path: Path, capsys: Any) -> None:
    plugin = f"{HOOKS}@hookimpl\ndef urdf2mbs_locate(source):\n  raise KeyError('no')\n"
    (tmp_path / "mine.py").write_text(plugin)
    (tmp_path / "c.yaml").write_text(
        "source: robot_descriptions:none\noutput: x.mbs\nplugins: [mine.py]\n"
    )
    assert main(["run", str(tmp_path / "c.yaml")]) == 2
    err = capsys.readouterr().err
    assert "mine.py:4: error[plugin-failed]: hook 'urdf2mbs_locate' of plugin 'mine'" in err


@pytest.mark.parametrize(
    ("does", "line", "said"),
    [
        ("raise KeyError('no')", 5, "KeyError: 'no'"),
        ("import sys; sys.exit('enough')", 5, "SystemExit: enough"),
        ("return 3", None, "AttributeError: 'int' object has no attribute 'lines'"),
        ("return Summary(lines=[3])", None, "ValidationError: Expected `str`, got `int`"),
    ],
)
def test_a_summary_that_fails_is_a_warning(
    does: str, line: int | None, said: str, tmp_path: Path, capsys: Any
) -> None:
    """The conversion is done, and keeps what it has made."""
    plugin = (
        f"{HOOKS}from urdf2mbs.plugin import Summary\n@hookimpl\n"
        f"def urdf2mbs_summary(conversion):\n  {does}\n"
    )
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "mine.py").write_text(plugin)
    (tmp_path / "c.yaml").write_text("source: tiny.urdf\nplugins: [mine.py]\n")
    assert main(["run", str(tmp_path / "c.yaml")]) == 0
    err = capsys.readouterr().err
    place = f"mine.py:{line}" if line else "mine.py"
    assert (
        f"{place}: warning[plugin-summary]: plugin 'mine': urdf2mbs_summary failed: {said}" in err
    )
    assert err.count("plugin-summary") == 1


def test_an_idle_plugin_is_told(tmp_path: Path) -> None:
    file = write(tmp_path, "pass")
    assert "plugin-idle" in [said.code for said in convert_text(plugins=[file]).diagnostics]
    file.write_text(file.read_text() + "@hookimpl\ndef urdf2mbs_before_pass(): pass\n")
    assert "plugin-idle" not in [said.code for said in convert_text(plugins=[file]).diagnostics]
