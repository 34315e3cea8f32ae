"""xacro without ROS: what it can do, how it fails, and that it leaves nothing behind."""

import re
import shutil
import subprocess
import sys
import threading
import warnings
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest
import xacro
import yaml
from xacro import substitution_args

from support.folders import CONFIGS
from support.plugin_files import read_robot
from urdf2mbs import cli
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, Diagnostic
from urdf2mbs.urdf.model import Mesh, Robot
from urdf2mbs.urdf.packages import Packages
from urdf2mbs_xacro.xacro import REQUIRED_NAMES, Expansion, expand

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'


def write(folder: Path, main: str, **files: str) -> Path:
    """Write the main file, and others by name: ``sub__leg`` is ``sub/leg.xacro``."""
    source = folder / "main.urdf.xacro"
    source.write_text(f"{HEAD}{main}</robot>\n")
    for name, text in files.items():
        path = folder / (name.replace("__", "/") + ("" if name.endswith("yaml") else ".xacro"))
        path = path.with_name(path.name.replace("_yaml", ".yaml"))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text if name.endswith("yaml") else f"{HEAD}{text}</robot>\n")
    return source


def run(source: Path, table: dict[str, Path] | None = None, **args: str) -> Expansion:
    return expand(source, Packages(table or {}, source), args)


def links(source: Path, table: dict[str, Path] | None = None, **args: str) -> list[str]:
    return list(read(source, table, **args)[0].links)


def read(
    source: Path, table: dict[str, Path] | None = None, **args: str
) -> tuple[Robot, list[Diagnostic]]:
    return read_robot(source, Packages(table or {}, source), args)


def failure(source: Path, table: dict[str, Path] | None = None, **args: str) -> ConversionError:
    with pytest.raises(ConversionError) as caught:
        run(source, table, **args)
    return caught.value


def test_find_in_the_table_and_around(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    source = write(
        tmp_path / "a",
        '<xacro:include filename="$(find arm)/part.xacro"/>'
        '<xacro:include filename="$(find hand)/part.xacro"/>'
        '<joint name="j" type="fixed"><parent link="arm"/><child link="hand"/></joint>',
        part='<link name="arm"/>',
    )
    write(tmp_path, "", hand__part='<link name="hand"/>')
    (tmp_path / "hand" / "package.xml").write_text("<package><name>hand</name></package>")
    assert links(source, {"arm": tmp_path / "a"}) == ["arm", "hand"]


def test_find_within_a_property(tmp_path: Path) -> None:
    source = write(tmp_path, '<xacro:property name="p" value="$(find p)"/><link name="${p}"/>')
    assert links(source, {"p": tmp_path}) == [str(tmp_path)]


def test_arguments_have_defaults_and_may_be_given(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<xacro:arg name="side" default="left"/><xacro:arg name="n" default="1"/>'
        '<xacro:property name="n" value="$(arg n)"/>'
        "<link name=\"$(arg side)_${n + 1}_${xacro.arg('side')}\"/>",
    )
    assert links(source) == ["left_2_left"]
    args = {"side": "right"}
    assert links(source, **args, n="41") == ["right_42_right"]
    assert args == {"side": "right"}
    assert links(source) == ["left_2_left"]


def test_arguments_are_text(tmp_path: Path) -> None:
    source = write(tmp_path, '<xacro:arg name="n" default="1"/><link name="$(arg n)"/>')
    args: dict[str, str] = {"n": 2}  # type: ignore[dict-item]
    assert b'"2"' in expand(source, Packages({}, source), args).text
    assert args == {"n": 2}


def test_dirname_is_that_of_the_file_being_read(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<xacro:include filename="$(dirname)/sub/leg.xacro"/><link name="$(dirname)"/>'
        '<joint name="j" type="fixed"><parent link="$(dirname)"/><child link="$(dirname)/sub"/>'
        "</joint>",
        sub__leg='<xacro:include filename="$(dirname)/foot.xacro"/>',
        sub__foot='<link name="$(dirname)"/>',
    )
    assert links(source) == [str(tmp_path / "sub"), str(tmp_path)]


def test_relative_sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(
        tmp_path, '<xacro:include filename="sub/leg.xacro"/>', sub__leg='<link name="$(dirname)"/>'
    )
    monkeypatch.chdir(tmp_path)
    assert links(Path("main.urdf.xacro")) == [str(tmp_path / "sub")]


def test_load_yaml_and_macros(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<xacro:property name="y" value="${xacro.load_yaml(\'sizes.yaml\')}"/>'
        '<xacro:macro name="leg" params="name *block"><link name="${name}_${y[\'leg\'].n}">'
        '<xacro:insert_block name="block"/></link></xacro:macro>'
        '<xacro:leg name="l"><visual><geometry><sphere radius="1"/></geometry></visual>'
        "</xacro:leg>",
        sizes_yaml="leg: {n: 7}\n",
    )
    robot, diagnostics = read(source)
    assert list(robot.links) == ["l_7"]
    assert len(robot.links["l_7"].visuals) == 1
    assert diagnostics == []


def test_the_text_is_what_the_command_prints(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<!-- kept -->\n<xacro:property name="x" value="1"/>\n<xacro:include filename="sub.xacro"/>'
        '<link name="é${x}"/>',
        sub='\n<gazebo reference="a"><x>  y </x></gazebo>\n',
    )
    command = "import sys, xacro; sys.argv[0] = 'xacro'; xacro.main()"
    done = subprocess.run(
        [sys.executable, "-c", command, str(source)],
        capture_output=True,
        check=True,
        env={"PYTHONUTF8": "1"},
    )
    assert run(source).text == done.stdout


def test_all_files_that_were_read_are_named(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<xacro:include filename="leg.xacro"/><xacro:include filename="leg.xacro"/>'
        '<xacro:include filename="no.xacro" optional="true"/>'
        '<xacro:property name="y" value="${xacro.load_yaml(\'sizes.yaml\')}"/>'
        '<link name="${y.n}"/>',
        leg="",
        sizes_yaml="n: a\n",
    )
    names = ("main.urdf.xacro", "leg.xacro", "sizes.yaml")
    assert run(source).files == [str(tmp_path / name) for name in names]


def test_what_xacro_says_is_kept_and_not_printed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    source = write(
        tmp_path,
        '<link name="a"/><xacro:include filename="sub.xacro"/>${xacro.load_yaml("no.yaml")}'
        '${xacro.message("hello")}',
        sub='<xacro:property name="x" value="1" colour="2"/>'
        '${xacro.warning("low")}${xacro.error("high")}<a b="${\'\\d\'}"/>',
        no_yaml="a: 1",
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # whatever the program shows of Python's warnings
        messages = run(source).warnings
    reported = [
        (diagnostic.level, diagnostic.code, diagnostic.message, diagnostic.file)
        for diagnostic in messages
    ]
    sub, main = str(tmp_path / "sub.xacro"), str(source)
    assert reported[:4] == [
        ("warning", "xacro-warning", "xacro:property: unknown attribute(s): colour", sub),
        ("warning", "xacro-warning", "low", sub),
        ("warning", "xacro-warning", "high", sub),
        ("note", "xacro-message", "hello", main),
    ]
    (python,) = reported[4:]  # whose words differ from version to version
    assert "Warning: invalid escape sequence" in python[2] or "is an invalid" in python[2]
    with pytest.raises(ConversionError):
        run(write(tmp_path, "${nothing}"))
    assert capfd.readouterr() == ("", "")


def test_an_argument_without_effect(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<xacro:arg name="side" default="left"/><link name="$(arg side)$(arg undeclared)"/>',
    )
    reported = run(source, side="a", undeclared="b").warnings
    assert reported == []
    (diagnostic,) = run(source, undeclared="b", sidee="right").warnings
    assert (diagnostic.code, diagnostic.hint) == ("xacro-unused-arg", "did you mean 'side'?")
    assert "'sidee'" in diagnostic.message


#: name: main, code, file, line, words of the message
BAD: dict[str, tuple[str, str, str, int | None, tuple[str, ...]]] = {
    "property": ('\n<link name="${x}"/>', "xacro", "main.urdf", 3, ("'x' is not defined",)),
    "division": ('<link name="${1/0}"/>', "xacro", "main.urdf", 2, ("division by zero",)),
    "syntax": ('<link name="${1 +}"/>', "xacro", "main.urdf", 2, ("1 +",)),
    "parameter": (
        '<xacro:macro name="leg" params="a b"/><xacro:leg a="1"/>',
        "xacro",
        "main.urdf",
        2,
        ("[b]", "in the macro 'leg'"),
    ),
    "in a macro": (
        '<xacro:macro name="leg" params="a">\n<link name="${a / 0}"/></xacro:macro>\n'
        '<xacro:macro name="legs"><xacro:leg a="1"/></xacro:macro>\n<xacro:legs/>',
        "xacro",
        "main.urdf",
        3,
        ("division by zero", "in the macro 'leg'"),
    ),
    "macro without an end": (
        '<xacro:macro name="leg"><xacro:leg/></xacro:macro><xacro:leg/>',
        "xacro",
        "main.urdf",
        2,
        ("without an end", "in the macro 'leg'"),
    ),
    "include without an end": (
        '<xacro:include filename="main.urdf.xacro"/>',
        "xacro",
        "main.urdf",
        None,
        ("without an end",),
    ),
    "circle of properties": (
        '<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/>${a}',
        "xacro",
        "main.urdf",
        2,
        ("circular", "a -> b -> a"),
    ),
    "condition": ('<xacro:if value="maybe"/>', "xacro", "main.urdf", 2, ("maybe",)),
    "fatal": ('${xacro.fatal("stop")}', "xacro", "main.urdf", 2, ("stop",)),
    "include": ('\n<xacro:include filename="no.xacro"/>', "xacro", "main.urdf", 3, ("no.xacro",)),
    "include a folder": (
        '<xacro:include filename="."/>',
        "xacro",
        "main.urdf",
        None,
        ("irectory",),
    ),
    "include of an include": (
        '\n<xacro:include filename="deep.xacro"/>',
        "xacro",
        "deep",
        4,
        ("no.xacro",),
    ),
    "include of what the main file has, too": (
        '<xacro:include filename="part.xacro"/>\n\n<link name="${x}"/>',
        "xacro",
        "part",
        2,
        ("'x' is not defined", "part.xacro"),
    ),
    "what a macro of an include has, too": (
        '<xacro:include filename="macro.xacro"/>\n<link name="${x}"/>',
        "xacro",
        "main.urdf",
        3,
        ("'x' is not defined",),
    ),
    "malformed": ("<link>\n</lonk>", "xml-syntax", "main.urdf", 3, ("</lonk>",)),
    "malformed include": (
        '<xacro:include filename="bad.xacro"/>',
        "xml-syntax",
        "bad",
        2,
        ("</b>",),
    ),
    "yaml": (
        "${xacro.load_yaml('no.yaml')}",
        "xacro",
        "main.urdf",
        2,
        ("no.yaml",),
    ),
    "malformed yaml": ("${xacro.load_yaml('bad.yaml')}", "xacro", "main.urdf", 2, ("bad.yaml",)),
    "environment": ('<a b="$(env URDF2MBS_NO)"/>', "xacro", "main.urdf", 2, ("URDF2MBS_NO",)),
    "command": ('<a b="$(frob x)"/>', "xacro", "main.urdf", 2, ("frob",)),
    "not text": (
        "<link name=\"${'\\ud800'}\"/>",
        "xacro",
        "main.urdf",
        None,
        ("UnicodeEncodeError: ", "surrogate"),
    ),
    "argument": (
        '<material name="side"/>\n<link name="$(arg side)"/>',
        "xacro-arg",
        "main.urdf",
        3,
        ("'side'",),
    ),
    "argument too early": (
        '<link name="$(arg side)"/><xacro:arg name="side" default="1"/>',
        "xacro-arg",
        "main.urdf",
        2,
        ("'side' is used before its <xacro:arg>",),
    ),
    "argument asked": (
        "\n<link name=\"${xacro.arg('side')}\"/>",
        "xacro-arg",
        "main.urdf",
        3,
        ("'side'",),
    ),
    "package": (
        '\n<xacro:include filename="$(find no_such_pkg)/a.xacro"/>',
        "package-not-found",
        "main.urdf",
        3,
        ("no_such_pkg", "looked in"),
    ),
    "package of ROS": (
        '\n<xacro:include filename="package://arm/urdf/a.xacro"/>',
        "xacro",
        "main.urdf",
        3,
        ("write $(find arm)/urdf/a.xacro",),
    ),
    "package in a property": (
        '<xacro:property name="p" value="$(find no_such_pkg)"/>\n'
        '<xacro:include filename="${p}/a.xacro"/>',
        "package-not-found",
        "main.urdf",
        2,
        ("no_such_pkg",),
    ),
    "package in a pattern": (
        '<xacro:include filename="$(find no_such_pkg)/*.xacro"/>',
        "package-not-found",
        "main.urdf",
        2,
        ("no_such_pkg",),
    ),
    "package in yaml": (
        "${xacro.load_yaml('$(find no_such_pkg)/a.yaml')}",
        "package-not-found",
        "main.urdf",
        2,
        ("no_such_pkg",),
    ),
    "legacy": (
        '\n<property name="x" value="1"/>\n<link name="${x}"/>',
        "xacro-legacy",
        "main.urdf",
        3,
        ("<property>",),
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_every_failure_is_one_error(tmp_path: Path, name: str) -> None:
    main, code, file, line, words = BAD[name]
    deep = '\n\n<xacro:include filename="no.xacro"/>'
    link = '<link name="${x}"/>'
    macro = f'<xacro:macro name="m">{link}</xacro:macro>'
    source = write(tmp_path, main, deep=deep, bad="<a></b>", part=link, macro=macro)
    (tmp_path / "bad.yaml").write_text("a: [1\n")
    error = failure(source)
    assert (error.code, error.file) == (code, str(tmp_path / f"{file}.xacro")), str(error)
    assert error.line == line, str(error)
    for word in words:
        assert word in str(error)
    assert "Error'>" not in error.message
    assert len(error.message) < 2500


def test_an_error_in_a_macro_of_an_include_names_its_file_and_line(tmp_path: Path) -> None:
    main = '<xacro:include filename="part.xacro"/>\n<xacro:m/>'
    macro = '<xacro:macro name="m">\n<link name="${1/0}"/></xacro:macro>'
    error = failure(write(tmp_path, main, part=macro))
    assert (error.file, error.line) == (str(tmp_path / "part.xacro"), 3)
    assert error.message == ("division by zero when evaluating expression '1/0', in the macro 'm'")


def test_an_error_in_a_macro_of_the_file_itself_names_its_line(tmp_path: Path) -> None:
    macro = '<xacro:macro name="m">\n<link name="${1/0}"/></xacro:macro>'
    source = write(tmp_path, f"{macro}<xacro:m/>")
    error = failure(source)
    assert (error.file, error.line) == (str(source), 3)
    assert error.message == ("division by zero when evaluating expression '1/0', in the macro 'm'")


def test_no_line_is_given_where_it_could_be_one_of_two(tmp_path: Path) -> None:
    error = failure(write(tmp_path, '<link name="${x}"/>\n<link name="${x}"/>'))
    assert (error.file, error.line) == (str(tmp_path / "main.urdf.xacro"), None)


def test_an_undefined_argument_says_how_to_give_it(tmp_path: Path) -> None:
    error = failure(
        write(
            tmp_path,
            '<xacro:arg name="side" default="1"/><xacro:include filename="sub.xacro"/>'
            '<link name="$(arg sid)"/>',
            sub="<xacro:arg default='2' name='size'/>",
        )
    )
    assert error.hint == (
        "say `--arg sid:=VALUE`, or `xacro_args: {sid: VALUE}` in a config; did you mean 'side'?"
    )


def test_the_error_of_an_argument_names_all_that_lack_a_value(tmp_path: Path) -> None:
    declared = '<xacro:arg name="size" default="1"/>'
    used = '<link name="$(arg b)$(arg size)"/><link name="$(arg leg)$(arg b)$(arg given)"/>'
    source = write(tmp_path, f"<!-- $(arg old) -->{declared}{used}")
    error = failure(source, {}, given="1")
    assert "`--arg b:=VALUE --arg leg:=VALUE`" in (error.hint or "")


def test_an_argument_without_a_default_has_a_line(tmp_path: Path) -> None:
    """As in ROS, xacro refuses it, whether its value is given or not."""
    declared = '<!-- <xacro:arg name="old"/> -->\n<xacro:arg name="size" default="1"/>\n'
    source = write(tmp_path, f'{declared}<xacro:arg\n  name="side"/><link name="$(arg side)"/>')
    for given in ({}, {"side": "left"}):
        error = failure(source, {}, **given)
        assert (error.file, error.line) == (str(source), 4)
        assert (
            error.message == "<xacro:arg> 'side' has no attribute 'default', which xacro requires"
        )
        assert error.hint == 'write default="...", the value without --arg side:=VALUE'
    error = failure(write(tmp_path, '\n<xacro:property value="1"/>'))
    assert (error.line, error.hint) == (3, 'write name="..."')


#: A robot that reads the file of its kind, in the folder of its size.
OF_A_KIND = (
    '<xacro:arg name="kind" default="arm"/><xacro:arg name="size" default="xl"/>\n'
    '<xacro:property name="folder" value="sizes/$(arg size)"/>\n'
    '<xacro:include filename="${folder}/the_$(arg kind).xacro"/>'
)


@pytest.mark.parametrize(
    ("given", "reason", "values"),
    [
        ({}, "'xl' is the default of the argument 'size' (MAIN:2), and 'xl'", "large"),
        ({"size": "smal"}, "'smal' is the value of the argument 'size', and 'smal'", "large"),
        (
            {"size": "small"},
            "'arm' is the default of the argument 'kind' (MAIN:2), and 'the_arm.xacro'",
            "hand, leg",
        ),
        (
            {"size": "large", "kind": "legs"},
            "'legs' is the value of the argument 'kind', and 'the_legs.xacro'",
            "arm",
        ),
    ],
)
def test_a_file_that_is_missing_since_an_argument_has_a_wrong_value(
    given: dict[str, str], reason: str, values: str, tmp_path: Path
) -> None:
    robots = {
        "sizes__small__the_leg": "",
        "sizes__small__the_hand": "",
        "sizes__large__the_arm": "",
    }
    source = write(tmp_path, OF_A_KIND, sizes__readme_yaml="", **robots)
    (tmp_path / "sizes" / "small" / "the_arms").mkdir()
    error = failure(source, {}, **given)
    assert f"{reason.replace('MAIN', str(source))} does not exist" in error.message
    argument = "kind" if "kind" in reason else "size"
    assert error.hint == (
        f"say `--arg {argument}:=VALUE`, or `xacro_args: {{{argument}: VALUE}}` in a config; "
        f"the values there are: {values}"
    )


def test_a_missing_file_is_no_fault_of_an_argument_that_is_part_of_a_word(tmp_path: Path) -> None:
    declared = '<xacro:arg name="n" default="1"/><xacro:arg name="none" default=""/>'
    error = failure(write(tmp_path, f'{declared}<xacro:include filename="ur10.xacro"/>'))
    assert error.hint == "correct the name of the file, or put the file there"
    assert error.message.endswith("ur10.xacro: No such file or directory")


def test_a_prefix_that_is_not_declared(tmp_path: Path) -> None:
    source = tmp_path / "a.xacro"
    source.write_text('<robot name="r">\n<xacro:leg/></robot>')
    error = failure(source)
    assert (error.line, "xmlns:xacro" in (error.hint or "")) == (2, True)


def test_a_folder_of_the_table_that_does_not_exist_is_the_configs_fault(tmp_path: Path) -> None:
    source = write(tmp_path, '<xacro:include filename="$(find arm)/a.xacro"/>')
    error = failure(source, {"arm": tmp_path / "gone"})
    assert isinstance(error, ConfigError)
    assert error.exit_code == 2


def test_a_source_that_is_not_there(tmp_path: Path) -> None:
    assert failure(tmp_path / "no.xacro").code == "xacro"


@pytest.mark.parametrize("name", ["robot.xacro", "robot.urdf.xacro", "ROBOT.XACRO"])
def test_faults_of_the_expanded_text_say_so(tmp_path: Path, name: str) -> None:
    main = '<link name="a"><visual/></link>\n<link name="${\'a\'}"/>'
    source = write(tmp_path, main).rename(tmp_path / name)
    with pytest.raises(ConversionError) as caught:
        read(source)
    error = caught.value
    assert (error.code, error.file) == ("name-doubled", f"{source} (expanded)")
    lines = run(source).text.splitlines()
    assert error.line is not None
    assert lines[error.line - 1].strip() == b'<link name="a"/>'


def test_faults_of_the_expanded_text_name_the_file_and_line_that_was_written(
    tmp_path: Path,
) -> None:
    sub = (
        "<!-- <joint type='' name='neck'> -->\n<link name='head'/>\n"
        "<joint\n type='fix' name = 'neck'><parent link='a'/><child link='head'/></joint>"
    )
    source = write(tmp_path, '<link name="a"/>\n<xacro:include filename="sub.xacro"/>', sub=sub)
    with pytest.raises(ConversionError) as caught:
        read(source)
    assert caught.value.code == "joint-type-unknown"
    assert "DIR/expanded.urdf" in (caught.value.hint or "")
    assert "sub.xacro:" not in (caught.value.hint or ""), "the comment has the name, too"
    text = (tmp_path / "sub.xacro").read_text().replace("<!-- <joint type='' name='neck'> -->", "")
    (tmp_path / "sub.xacro").write_text(text)
    with pytest.raises(ConversionError) as caught:
        read(source)
    line = text[: text.index("<joint")].count("\n") + 1
    assert f"joint 'neck' is in {tmp_path / 'sub.xacro'}:{line};" in (caught.value.hint or "")


def test_legacy_elements_that_xacro_copies(tmp_path: Path) -> None:
    source = write(tmp_path, '<link name="a"/><macro name="m"/><property name="p" value="1"/>')
    _, (macro, unused) = read(source)
    assert (macro.level, macro.code) == ("error", "xacro-legacy")
    assert "<xacro:macro ...>" in (macro.hint or "")
    assert (unused.level, unused.code) == ("warning", "property-unused")


def test_macros_that_nobody_defines_are_left_out_and_listed(tmp_path: Path) -> None:
    """Each is an error that the user may lower; so all are told, and what is left is read."""
    source = write(
        tmp_path,
        '<xacro:macro name="leg" params="*block"><xacro:hip/><link name="a">'
        '<xacro:insert_block name="block"/></link></xacro:macro>\n'
        '<xacro:leg><visual/></xacro:leg>\n<xacro:foot><link name="b"/></xacro:foot>',
    )
    robot, (hip, foot, _) = read(source)
    assert list(robot.links) == ["a"]
    assert {(diagnostic.level, diagnostic.code) for diagnostic in (hip, foot)} == {
        ("error", "xacro-macro-unknown")
    }
    assert ("'hip'" in hip.message, hip.line) == (True, 2)
    assert ("'foot'" in foot.message, foot.line) == (True, 4)


def test_a_package_that_only_file_names_need(tmp_path: Path) -> None:
    source = write(
        tmp_path,
        '<link name="a"><visual><geometry><mesh filename="file://$(find gone)/m.stl"/></geometry>'
        '</visual></link><gazebo><material name="$(find gone)"/></gazebo>',
    )
    robot, (diagnostic,) = read(source)
    assert robot.links["a"].visuals[0].geometry == Mesh("package://gone/m.stl")
    assert (diagnostic.level, diagnostic.code) == ("warning", "package-unresolved")


def test_a_file_with_xacro_in_it_is_expanded_whatever_its_name(tmp_path: Path) -> None:
    source = tmp_path / "robot.urdf"
    for text, expected in (
        (HEAD + '<xacro:property name="w" value="2"/><link name="a${w}"/></robot>', "a2"),
        ('<robot name="r"><link name="a${1 + 1}"/></robot>', "a2"),
        ('<robot name="r" xmlns:x="http://ros.org/wiki/xacro"><link name="a"/></robot>', "a"),
        (
            '<robot name="r"><link name="a"/><gazebo><material>${no}</material></gazebo></robot>',
            "a",
        ),
    ):
        source.write_text(text)
        robot, diagnostics = read(source)
        assert (list(robot.links), diagnostics) == ([expected], [])


def test_slips_of_xml_in_xacro_files(tmp_path: Path) -> None:
    source = write(tmp_path, '<xacro:include filename="part.xacro"/>')
    (tmp_path / "part.xacro").write_text(f'\n<?xml version="1.0"?>\n{HEAD}<link name="a"/></robot>')
    robot, (diagnostic,) = read(source)
    assert list(robot.links) == ["a"]
    assert (diagnostic.code, diagnostic.file, diagnostic.line) == (
        "xml-mended",
        str(tmp_path / "part.xacro"),
        2,
    )
    (tmp_path / "part.xacro").write_text(f'{HEAD}<<<<<<< HEAD\n<link name="a"/></robot>')
    error = failure(source)
    assert (error.code, error.file, error.line) == (
        "merge-conflict",
        str(tmp_path / "part.xacro"),
        2,
    )


def test_an_empty_file_is_an_error(tmp_path: Path) -> None:
    source = tmp_path / "a.xacro"
    source.touch()
    with pytest.raises(ConversionError) as caught:
        read(source)
    assert caught.value.code == "file-empty"


def state() -> list[object]:
    modules = (xacro, substitution_args)
    tables = (xacro._global_symbols["xacro"], substitution_args._eval_dict)
    return [{**vars(module)} for module in modules] + [{**table} for table in tables]


def test_nothing_is_left_behind(tmp_path: Path) -> None:
    """xacro's module, which other programs use, stays as it was; so does PyYAML's loader."""
    before = state()
    constructors = {**yaml.SafeLoader.yaml_constructors}
    good = write(
        tmp_path,
        '<xacro:arg name="a" default="1"/><link name="a$(arg a)$(eval 1 + a)"/>'
        "<link name=\"${xacro.load_yaml('good.yaml')['a']}\"/>",
        good_yaml="a: !degrees 90",
    )
    expected = run(good)
    for main, *_ in BAD.values():
        (tmp_path / "bad").mkdir(exist_ok=True)
        failure(write(tmp_path / "bad", main, deep='<xacro:include filename="no"/>', bad="<a></b>"))
        assert run(good) == expected
    assert state() == before
    assert yaml.SafeLoader.yaml_constructors == constructors


def test_macros_and_properties_do_not_leak(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    first = write(
        tmp_path / "one",
        '<xacro:property name="x" value="a" scope="global"/><xacro:macro name="m">'
        '<link name="${x}"/></xacro:macro><xacro:arg name="g" default="h"/><xacro:m/>',
    )
    assert links(first) == ["a"]
    (leaked,) = run(write(tmp_path / "two", "<xacro:m/>")).warnings
    assert leaked.code == "xacro-macro-unknown"
    assert failure(write(tmp_path / "two", '<link name="${x}"/>')).code == "xacro"
    assert failure(write(tmp_path / "two", '<link name="$(arg g)"/>')).code == "xacro-arg"


def test_two_at_once(tmp_path: Path) -> None:
    """Each finds its own package, whichever runs first."""
    results: dict[str, list[list[str]]] = {"one": [], "two": []}

    def work(name: str) -> None:
        folder = tmp_path / name
        for _ in range(20):
            results[name].append(links(folder / "main.urdf.xacro", {"p": folder}, a=name))

    for name in results:
        (tmp_path / name).mkdir()
        write(
            tmp_path / name,
            '<xacro:arg name="a" default=""/><xacro:include filename="$(find p)/part.xacro"/>',
            part=f'<link name="{name}_$(arg a)"/>',
        )
    threads = [threading.Thread(target=work, args=(name,)) for name in results]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    assert results == {name: [[f"{name}_{name}"]] * 20 for name in results}


@pytest.mark.parametrize(
    "command",
    [
        "convert biped.urdf.xacro",
        "init biped.urdf.xacro",
        pytest.param("simulate biped.urdf.xacro --time 1e-3", marks=pytest.mark.slow),
        "verify biped.urdf.xacro biped.mbs",
    ],
)
def test_a_robot_is_expanded_once(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it is converted again, with the feet or the start pose that were found."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(CONFIGS / "biped.urdf.xacro", ".")
    if command.startswith("verify"):
        cli.main(["convert", "biped.urdf.xacro"])
    sources: list[Path] = []

    def counted(source: Path, *args: Any, **more: Any) -> Expansion:
        sources.append(source)
        return expand(source, *args, **more)

    monkeypatch.setattr("urdf2mbs_xacro.xacro.expand", counted)
    assert cli.main([*command.split(), "-q"]) == 0
    assert len(sources) == 1


@pytest.mark.parametrize(
    ("module", "name"),
    [
        (module, name)
        for module, names in REQUIRED_NAMES.items()
        for name in names
        if name in ("_eval_dict", "_global_symbols", "safe_eval", "macrostack")
    ],
)
def test_a_xacro_without_a_name_that_is_replaced_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, name: str
) -> None:
    """Its expressions would run as Python if ``safe_eval`` were replaced without an effect."""

    def find_stand_in(wanted: str) -> ModuleSpec | None:
        spec = find_spec(wanted)
        if wanted != module:
            return spec
        assert spec is not None
        assert spec.origin is not None
        text = Path(spec.origin).read_text()
        assert re.search(rf"\b{name}\b", text)
        stand_in = tmp_path / "stand_in.py"
        stand_in.write_text(re.sub(rf"\b{name}\b", "renamed", text))
        folders = spec.submodule_search_locations
        return spec_from_file_location(wanted, stand_in, submodule_search_locations=folders)

    source = write(tmp_path, '<link name="${1 + 1}"/>')
    assert links(source) == ["2"]
    monkeypatch.setattr("urdf2mbs_xacro.xacro.find_spec", find_stand_in)
    with pytest.raises(ConversionError) as error:
        links(source)
    assert error.value.code == "xacro-incompatible"
    assert f" has no {module}.{name}" in error.value.message
    assert "pip install 'xacro==" in (error.value.hint or "")
