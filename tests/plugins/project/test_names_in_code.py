"""Names stay names in the .mbs, in generated code and in files."""

import ast
import re
import shutil
import subprocess
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest

from support.folders import ROOT
from urdf2mbs.api import convert
from urdf2mbs.mbs.reader import read_mbs

pytestmark = pytest.mark.slow

HEADERS = ROOT / "plugins" / "urdf2mbs_simulate" / "mbsysc"

#: Names that XML permits and that something else may stumble on.
NAMES = {
    "Python keywords": ["lambda", "import", "None", "print", "__import__", "class"],
    "C keywords": ["int", "void", "double", "static", "asm", "typeof"],
    "C macros": ["NULL", "EOF", "linux", "unix", "errno", "assert"],
    "later C": ["bool", "true", "nullptr", "constexpr", "static_assert", "alignas"],
    "our own": ["base", "origin", "mbs_data", "user_model", "damping", "hold"],
    "quotes": ["a'b", 'a"b', "a`b", '"""', "'''", "a\\"],
    "backslashes": ["\\n", "a\\", "\\x41", "\\u0041", "\\N{BULLET}", "\\\\"],
    "comments": ["*/ int x; /*", "// x", "# x", "/* x", "--> <!--", "??/"],
    "newlines": ["a\nimport os", "a\r\nb", "a\tb", "\nb", "a\r", "a\n#b"],
    "separators": ["a\u2028b", "a\u2029b", "a\x85b", "a\x9b2Jb", "a\u202eb", "a\ufeffb"],
    "paths": ["../a", "/etc/passwd", "..", "C:\\a", "a/b/c", "~/.bashrc"],
    "script": [
        "<script>alert(1)</script>",
        "</script><img src=x onerror=alert(1)>",
        "' onclick='alert(1)",
        "javascript:alert(1)",
        "&lt;b&gt;",
        "{{7*7}}",
    ],
    "shells": ["$HOME", "`reboot`", "; rm -rf x", "%s%n", "!!", "a|b"],
    "scripts of the world": ["腕", "рука", "ذراع", "हाथ", "🦾", "e\u0301"],
    "equal when sanitised": ["a b", "a-b", "a.b", "a:b", "a_b", "a/b"],
    "equal but for case": ["Arm", "arm", "ARM", "aRm", "arM", "ARm"],
    "long": ["x" * 500, "x" * 499 + "y", "ж" * 500, "y" * 500, "x" * 501, "z" * 5000],
    "numbers": ["1", "1e5", "-1", "0x1", "nan", "1_000"],
    "Windows": ["con", "aux", "NUL", "com1", "LPT9", "prn.txt"],
}
PLAIN = ["n0", "n1", "n2", "n3", "n4", "n5"]


def robot_of(names: list[str]) -> str:
    """Six links with visuals, meshes and materials, five joints, a sensor, all called by names."""

    def q(name: str) -> str:
        escaped = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
        return quoteattr(name, escaped)

    out = [f"<robot name={q(names[0])}>"]
    for n, name in enumerate(names):
        out.append(
            f'<link name={q(name)}><inertial><origin xyz="0.1 0 0.2"/><mass value="{n + 1}"/>'
            '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
            f"<visual name={q(name)}><geometry><mesh filename={q(name + '.stl')}/></geometry>"
            f'<material name={q(name)}><color rgba="1 0 0 1"/></material></visual>'
            f'<collision name={q(name)}><geometry><sphere radius="0.1"/></geometry></collision>'
            "</link>"
        )
    for n, name in enumerate(names[1:]):
        mimic = f"<mimic joint={q(names[1])} multiplier='2'/>" if n == 3 else ""
        out.append(
            f'<joint name={q(name)} type="revolute"><parent link={q(names[n])}/>'
            f'<child link={q(name)}/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>'
            '<limit lower="-1" upper="1" effort="5" velocity="2"/>'
            f'<dynamics damping="0.1" friction="0.2"/>{mimic}</joint>'
        )
    out += [
        f'<gazebo reference={q(names[-1])}><sensor name={q(name)} type="imu"/></gazebo>'
        for name in names
    ]
    out.append("</robot>")
    return "\n".join(out)


def project(folder: Path, names: list[str]) -> Path:
    """Convert into a project with all code in Python and C."""
    folder.mkdir(parents=True)
    file = folder / "robot.urdf"
    file.write_text(robot_of(names), "utf-8")
    result = convert(file, output={"project": folder / "p", "language": "both"}, base="fixed")
    result.write()
    return folder / "p"


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return project(tmp_path_factory.mktemp("plain") / "x", PLAIN)


def shape(file: Path) -> str:
    """Python code with every string replaced: what it does, whatever things are called."""
    tree = ast.parse(file.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            node.value = "s"
    return ast.dump(tree)


def files(folder: Path) -> dict[str, Path]:
    return {
        re.sub(r"[a-z_]*\.wrl$", ".wrl", file.relative_to(folder).as_posix()): file
        for file in folder.rglob("*")
        if file.is_file()
    }


@pytest.mark.parametrize("kind", NAMES)
def test_generated_code_means_the_same(kind: str, plain: Path, tmp_path: Path) -> None:
    made = project(tmp_path / "x", NAMES[kind])
    there = {name: file for name, file in files(made).items() if file.suffix != ".wrl"}
    assert set(there) == {name for name in files(plain) if not name.endswith(".wrl")}
    assert not [file for file in tmp_path.rglob("*") if not file.is_relative_to(tmp_path / "x")]
    for name, file in there.items():
        if file.suffix == ".py":
            assert shape(file) == shape(plain / name), name
    mbs = read_mbs((made / "dataR" / "p.mbs").read_bytes(), "p.mbs")
    names = [joint.name for body in mbs.bodies for joint in body.joints]
    assert len(set(names)) == len(names)
    if shutil.which("gcc") is not None:
        check_c(made)


def check_c(made: Path) -> None:
    """Strict C of two standards, without a word from the compiler."""
    sources = [str(file) for file in sorted((made / "userfctR").glob("*.c"))]
    for standard in ("gnu11", "gnu2x"):
        command = [
            "gcc",
            f"-std={standard}",
            "-fsyntax-only",
            "-Wall",
            "-Werror",
            "-Wno-comment",
            "-Wno-unused-variable",
            "-Wno-strict-prototypes",
            f"-I{HEADERS}",
            f"-I{made / 'userfctR'}",
            *sources,
        ]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
