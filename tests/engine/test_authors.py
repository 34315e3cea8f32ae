"""Mistakes of a plugin's author: none is silent, and each message says where and what to do."""

import re
from pathlib import Path
from typing import Any

import pytest

from support.plugin_files import write_plugin
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, Diagnostic
from urdf2mbs.testing import run_pass


def fail(folder: Path, does: str) -> ConversionError:
    """Return the error of a pass that does these lines."""
    with pytest.raises(ConversionError) as caught:
        run_pass("lab", write_plugin(folder, "lab", does))
    return caught.value


def find_message(folder: Path, does: str) -> Diagnostic:
    """Return the message ``heavy-link`` of a pass that does these lines."""
    result = run_pass("lab", write_plugin(folder, "lab", does))
    (message,) = [found for found in result.diagnostics if found.code == "heavy-link"]
    return message


# --- fields of a conversion --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "remedy"),
    [("robto", "did you mean 'robot'?; "), ("xyzzy", ""), ("output_folder", None)],
)
def test_a_field_that_does_not_exist_is_an_error(
    field: str, remedy: str | None, tmp_path: Path
) -> None:
    error = fail(tmp_path, f"pass\nconversion.{field} = conversion.robot")
    assert (error.code, error.file, error.line) == (
        "plugin-failed",
        str(tmp_path / "lab.py"),
        4,
    )
    state = f"conversion.state(Class).{field} keeps data of a plugin"
    expected = f"AttributeError: a Conversion has no field '{field}'; {remedy}{state}"
    assert remedy is None or error.message.endswith(expected)


def test_the_packages_are_searched_once(tmp_path: Path) -> None:
    does = "conversion.report['same'] = conversion.packages is conversion.packages"
    assert run_pass("lab", write_plugin(tmp_path, "lab", does)).conversion.report["same"]


# --- files --------------------------------------------------------------------------------------


def test_a_file_is_written_beside_the_mbs(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not into the folder in which the command runs."""
    write_plugin(here, "lab", "conversion.add_file('tables/masses.csv', 'µ,0.5')")
    elsewhere = here / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    words = ["convert", "../tiny.urdf", "-o", "../out/tiny.mbs", "--plugin", "../lab.py"]
    assert main([*words, "--after", "expand=lab"]) == 0
    assert (here / "out" / "tables" / "masses.csv").read_bytes() == "µ,0.5".encode()
    assert list(elsewhere.iterdir()) == []


def test_a_file_of_a_project_is_written_into_its_folder(here: Path) -> None:
    does = "conversion.report['file'] = str(conversion.add_file('notes.txt', b''))"
    plugin = write_plugin(here, "lab", does)
    output = {"project": here / "rover"}
    result = convert("tiny.urdf", plugins=[plugin], after={"expand": "lab"}, output=output)
    assert result.conversion.report["file"] == str(here / "rover" / "notes.txt")
    assert here / "rover" / "notes.txt" in result.conversion.files


@pytest.mark.parametrize(
    ("does", "message"),
    [
        ("conversion.add_file('a.csv', 3)", "TypeError: add_file: the data of 'a.csv' are int;"),
        ("conversion.add_file('/a.csv', b'')", "ValueError: add_file: '/a.csv' is absolute"),
    ],
)
def test_a_file_that_cannot_be_added_names_the_line(
    does: str, message: str, tmp_path: Path
) -> None:
    error = fail(tmp_path, does)
    assert message in error.message
    assert (error.file, error.line) == (str(tmp_path / "lab.py"), 3)


def test_a_path_in_no_folder_is_an_error(tmp_path: Path) -> None:
    does = "from pathlib import Path\nconversion.files[Path('masses.csv')] = b''"
    error = fail(tmp_path, does)
    assert error.code == "plugin-output-broken"
    assert "conversion.files has 'masses.csv', which is in no folder" in error.message
    assert "conversion.add_file(name, data)" in (error.hint or "")


def test_a_report_that_is_no_plain_data_says_so(tmp_path: Path) -> None:
    error = fail(tmp_path, "conversion.report['lab'] = object()")
    assert error.code == "plugin-output-broken"
    assert "conversion.report must be plain data" in (error.hint or "")


# --- messages -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "line"),
    [("link='arm', line=99", 99), ("line=99", 99), ("link='arm'", 21), ("joint='shoulder'", 13)],
)
def test_a_line_that_a_pass_gives_is_kept(place: str, line: int, tmp_path: Path) -> None:
    message = find_message(tmp_path, f"conversion.warn('heavy-link', 'heavy', {place})")
    assert message.line == line


def test_a_code_that_is_not_declared_says_where_to_declare_it(here: Path) -> None:
    plugin = write_plugin(here, "lab", "conversion.warn('heavy-link', 'heavy')")
    settings: Any = {"plugins": [plugin], "after": {"expand": "lab"}}
    settings["diagnostics"] = {"heavy-link": "ignore"}
    with pytest.raises(ConfigError, match="unknown-code") as caught:
        convert("tiny.urdf", **settings)
    assert "plugin 'lab': add \"heavy-link\"" in (caught.value.hint or "")
    assert str(plugin) in (caught.value.hint or "")
    codes = "@hookimpl\ndef urdf2mbs_codes(): return {'heavy-link': 'warning: heavy. Cut it.'}\n"
    declared = here / "declared.py"
    declared.write_text(plugin.read_text() + codes)
    settings["plugins"] = [declared]
    assert "heavy-link" not in [
        found.code for found in convert("tiny.urdf", **settings).diagnostics
    ]


# --- options ------------------------------------------------------------------------------------

OPTIONS = """
from urdf2mbs.plugin import ConfigError, Pass, hookimpl

class Lab(Pass):
    links: list[str] = []
    speed: dict[str, float] = {}
    file: str = ""

    def run(self, conversion):
        raise ConfigError("lab", MESSAGE)

@hookimpl
def urdf2mbs_passes():
    return [Lab]
"""
CONFIG = """\
source: tiny.urdf
plugins: [lab.py]
after: {expand: lab}
passes:
  lab:
    file: poses.csv
    links:
      - arm
      - han
    speed:
      shoulder: 3
"""


@pytest.mark.parametrize(
    ("message", "line"),
    [
        ("no link is called 'han'", 9),
        ("joint 'shoulder' has no speed", 11),
        ("'links' are too many", 7),
        ("'speed.shoulder' is too fast", 11),
        ("there is no file 'poses.csv'", 6),
        ("link 'tool' is too light", 5),
        ("no options fit", 5),
    ],
)
def test_an_error_about_an_option_names_its_line(
    message: str, line: int, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("lab.py").write_text(OPTIONS.replace("MESSAGE", repr(message)))
    Path("lab.yaml").write_text(CONFIG)
    assert main(["run", "lab.yaml"]) == 2
    assert f"lab.yaml:{line}: error[lab]: {message}\n" in capsys.readouterr().err


def test_an_error_about_no_option_of_the_config_has_no_line(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("lab.py").write_text(OPTIONS.replace("MESSAGE", "'no'"))
    Path("lab.yaml").write_text(CONFIG.partition("passes:")[0])
    for words in (["run", "lab.yaml", "--set", "lab.file=a"], ["run", "lab.yaml"]):
        assert main(words) == 2
        assert re.search(r"^error\[lab\]: no$", capsys.readouterr().err, re.MULTILINE)


def test_an_error_with_a_file_keeps_it(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = OPTIONS.replace("MESSAGE", "'no number', file='poses.csv', line=4")
    Path("lab.py").write_text(text)
    Path("lab.yaml").write_text(CONFIG)
    assert main(["run", "lab.yaml"]) == 2
    assert "poses.csv:4: error[lab]: no number" in capsys.readouterr().err
