"""A fuzzer of all inputs: good files changed by a grammar of slips, each by a seed.

``python tests/fuzz/fuzzer.py --minutes 10`` tries as many as it can; each finding is one line with
the kind and the seed, and ``--one KIND SEED`` shows it.  What may come out is a result, or an error
of ours that is not ``internal``.
"""

from __future__ import annotations

import argparse
import io
import logging
import random
import re
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from copy import deepcopy
from pathlib import Path
from typing import Any

import yaml
from lxml import etree

from urdf2mbs.api import convert
from urdf2mbs.cli import main as command_line
from urdf2mbs.diagram.draw import draw
from urdf2mbs.engine.config import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.equations import generate
from urdf2mbs.mbs.reader import read, validate
from urdf2mbs.mbs.writer import write
from urdf2mbs.meshes import reader as meshes
from urdf2mbs.meshes import vrml, vrml_reader
from urdf2mbs.meshes.model import MeshError
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

PAGE = Path(__file__).resolve().parents[2] / "docs" / "diagnostics.md"
#: All codes of errors, warnings and notes.
CATALOGUE = set(re.findall(r"^\| `([a-z0-9-]+)`", PAGE.read_text("utf-8"), re.MULTILINE))

#: One input may take so many seconds.
PATIENCE = 20

XACRO = """<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="n" default="2"/><xacro:property name="m" value="${2 * pi}"/>
  <xacro:macro name="leg" params="side *origin mass:=1"><link name="${side}_leg"><inertial>
    <xacro:insert_block name="origin"/><mass value="${mass}"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <joint name="${side}" type="continuous"><parent link="trunk"/><child link="${side}_leg"/>
    <axis xyz="0 1 0"/></joint></xacro:macro>
  <link name="trunk"/>
  <xacro:leg side="left" mass="${m}"><origin xyz="0 $(arg n) 0"/></xacro:leg>
  <xacro:if value="${m > 1}"><xacro:leg side="right"><origin xyz="0 -1 0"/></xacro:leg></xacro:if>
</robot>
"""
#: Includes the fuzzed file, or takes its numbers from it.
OUTER = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="fuzzed.inc"/></robot>
"""
BY_YAML = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="a" value="${xacro.load_yaml('fuzzed.inc')}"/>
  <link name="${a['name']}"><inertial><mass value="${a['arm']['mass']}"/>
  <origin xyz="${' '.join(str(x) for x in a['arm']['at'])}"/>
  <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>
"""
NUMBERS = "name: trunk\narm: {mass: 2.5, at: [0, 0, !degrees 1]}\n"
#: A robot with a mesh, each kind of shape and each kind of joint.
SHAPES = "".join(
    f'<visual><origin xyz="0 0 1" rpy="0 1 0"/><geometry>{shape}</geometry>'
    '<material name="m"><color rgba="1 0 0 1"/></material></visual>'
    f"<collision><geometry>{shape}</geometry></collision>"
    for shape in (
        '<box size="1 2 3"/>', '<cylinder radius="1" length="2"/>', '<sphere radius="1"/>',
        '<mesh filename="good.stl" scale="1 -1 2"/>', '<mesh filename="package://p/a.dae"/>',
    )
)  # fmt: skip
MANY = (
    f'<robot name="many"><link name="a">{SHAPES}</link>'
    + "".join(
        f'<joint name="j{n}" type="{kind}"><origin xyz="0 0 1" rpy="0 1.5707963 0"/>'
        f'<parent link="{parent}"/><child link="l{n}"/><axis xyz="0 0.6 0.8"/>'
        f'<limit lower="-1" upper="1" effort="5" velocity="2"/></joint><link name="l{n}">'
        '<inertial><origin xyz="0 0 1" rpy="0 1 0"/><mass value="1"/><inertia ixx="1" ixy="0.1"'
        ' ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        for n, (kind, parent) in enumerate(
            [("revolute", "a"), ("prismatic", "l0"), ("continuous", "l1"), ("planar", "a"),
             ("floating", "l3"), ("fixed", "l2"), ("revolute", "l5")]
        )
    )
    + "</robot>"
)  # fmt: skip
#: Adds to the config below what else an .mbs can hold.
CLOSED = """source: tiny.urdf
output: {project: closed}
passes:
  contacts: {links: [hand], points: {hand: [[0, 0, 1]]}}
  forces:
    wrenches: {push: {link: hand, at: [0, 0, 1], force: [1, 0, 0]}}
    springs: {s: {ends: [{link: hand}, {link: body, at: [0, 0, 1]}], stiffness: 10}}
  loops: {cuts: {c: {ends: [{link: hand}, {link: body}], kind: rod, length: 1}}}
  sensors: {links: [hand]}
"""
CONFIG = """# a robot
source: tiny.urdf
output: {project: out, language: both}
base: floating
gravity: [0, 0, -9.81]
packages: {p: .}
xacro_args: {hand: false, mass: 1.50}
pipeline: compact
passes:
  posture: {joints: {shoulder: 0.5}, srdf: r.srdf, state: home,
            hold: {joints: ["*"], stiffness: 1, damping: 2}}
  contacts: {links: [hand], stiffness: 1.0e+5, points: {hand: [[0, 0, 1]]}}
  expand: {}
  forces:
    wrenches: {push: {link: hand, at: [0, 0, 1], force: [1, 0, 0], start: 0.1}}
    springs: {s: {ends: [{link: hand}, {link: body, at: [0, 0, 1]}], stiffness: 10}}
  loops: {cuts: {c: {ends: [{link: hand}, {link: body}], kind: rod, length: 1}}}
  sensors: {links: [hand]}
  layout: {style: tree}
  align-frames: {}
  joint-parameters: {}
diagnostics: {mesh-missing: ignore, base: warning}
strict: false
"""
SRDF = """<?xml version="1.0"?>
<robot name="tiny"><group name="all"><joint name="shoulder"/></group>
<group_state name="home" group="all"><joint name="shoulder" value="0.3"/></group_state></robot>
"""
OBJ = """mtllib a.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vn 0 0 1
usemtl red
f 1/1/1 2/1/1 3/1/1
f 1 3 4
f -1 -2 -3 -4
"""
#: What stands in the place of a word.
WORDS = [
    '"', "'", "<", ">", "/>", "&amp;", "&x;", "&#0;", "<!--", "-->", "<![CDATA[", "]]>", "<?",
    "?>", "${", "}", "$(", ")", "nan", "inf", "-inf", "1e999", "-1", "0", "0x1", "1e308",
    "99999999999999999999", "1_0", "../..", "/dev/null", "http://127.0.0.1:9/x", ":", "-", "[",
    "]", "{", "}", "|", "!", "*", "&", "#", "@", ",", "true", "null", "~", ".inf",
    "!!python/object:os.system", "xmlns=", "xacro:", "é", "🦾", "<link/>", "<joint/>", "<robot>",
    "</robot>", "float(int)", "2**99", "1e-320", "-1e200", "0,5", "world", "base", "origin", "int",
    "*.x", "fixed", "floating", "planar",
    "", " ", "0 0 0", "1 2 3", "0 0 1e308", "1 2", "\n", "\t", "\r", "\0", "\u202e", "\x01",
    "a" * 300, "<a>" * 300, "[" * 300, "(" * 300, "{a: " * 300,
]  # fmt: skip
TOKEN = re.compile(rb'"[^"\n]*"|[-+\w.]+|[<>{}\[\]:,]')


def shaken(root: Any, chance: random.Random) -> None:
    """One to four changes of an XML tree, which stays well-formed."""
    for _ in range(chance.choice([1, 1, 1, 2, 2, 3, 4])):
        elements = list(root.iter(etree.Element))
        one, other = chance.choice(elements), chance.choice(elements)
        how, word = chance.randrange(9), chance.choice(WORDS)
        parent = one.getparent()
        with suppress(ValueError):  # what XML cannot hold
            if how <= 2 and one.attrib:
                one.set(chance.choice(sorted(one.attrib)), word)
            elif how <= 3:
                one.text = word
            elif how == 4 and one.attrib:
                del one.attrib[chance.choice(sorted(one.attrib))]
            elif how == 5 and parent is not None:
                parent.remove(one)
            elif how == 6 and parent is not None:
                parent.insert(chance.randrange(len(parent) + 1), deepcopy(one))
            elif how == 7 and other not in one.iter():
                other.append(one)
            elif how == 8 and other.attrib and one.attrib:
                one.set(chance.choice(sorted(one.attrib)), other.get(sorted(other.attrib)[0]))


def stirred(data: Any, chance: random.Random) -> Any:
    """Plain data with one to three of its values, keys or items changed."""
    for _ in range(chance.choice([1, 1, 2, 3])):
        places: list[tuple[Any, Any]] = []
        todo = [data]
        while todo:
            inner = todo.pop()
            if isinstance(inner, (dict, list)):
                keys = list(inner) if isinstance(inner, dict) else range(len(inner))
                places += [(inner, key) for key in keys]
                todo += [inner[key] for key in keys]
        holder, key = chance.choice(places)
        value = holder[key]
        how = chance.randrange(5)
        if how <= 1:
            holder[key] = chance.choice([*WORDS, 0, -1, 1e308, float("nan"), None, True, [], {},
                                         10**30, ["a"], {"a": "b"}, {1: 2}])  # fmt: skip
        elif how == 2:
            del holder[key]
        elif how == 3 and isinstance(holder, dict):
            holder[chance.choice(WORDS)] = value
        else:
            other, place = chance.choice(places)
            with suppress(IndexError, KeyError):
                holder[key] = deepcopy(other[place])
        if not data:
            break
    return data


def changed(data: bytes, chance: random.Random, kind: str) -> bytes:
    """A change that keeps the file's grammar, mostly; else one of its bytes."""
    if (
        chance.random() < 0.75
        and kind in ("urdf", "xacro", "srdf", "mbs", "robot", "model")
        and data.startswith(b"<")
    ):
        root = etree.fromstring(data)
        shaken(root, chance)
        return etree.tostring(root)
    if chance.random() < 0.75 and kind == "config":
        text = yaml.safe_dump(stirred(yaml.safe_load(data), chance), sort_keys=False)
        return text.encode("utf-8", "surrogatepass")
    return broken(data, chance)


def broken(data: bytes, chance: random.Random) -> bytes:
    """One to four slips: a word replaced, doubled, dropped or moved; bytes cut, flipped, put in."""
    for _ in range(chance.choice([1, 1, 1, 2, 2, 3, 4])):
        tokens = list(TOKEN.finditer(data))
        how = chance.randrange(8)
        at = chance.randrange(len(data) + 1)
        if how <= 3 and tokens:
            one = chance.choice(tokens)
            new = chance.choice(WORDS).encode("utf-8", "surrogatepass")
            if how == 1:
                new = chance.choice(tokens)[0]
            elif how == 2:
                new = b""
            elif how == 3 and one[0].startswith(b'"'):
                new = b'"' + new + b'"'
            data = data[: one.start()] + new + data[one.end() :]
        elif how == 4:
            end = at + chance.randrange(1, 60)
            data = data[:at] + data[end:]
        elif how == 5:
            end = at + chance.randrange(1, 200)
            data = data[:end] + data[at:end] * chance.choice([1, 1, 2, 50]) + data[end:]
        elif how == 6 and data:
            array = bytearray(data)
            for _ in range(chance.randrange(1, 6)):
                array[chance.randrange(len(data))] = chance.choice([0, 255, 128, 127, 32, 60])
            data = bytes(array)
        elif how == 7:
            data = data[:at]
    return data


class Fuzzer:
    """The good files, and what is done with each kind of changed one, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "tiny.urdf").write_text(TINY)
        (folder / "r.srdf").write_text(SRDF)
        sensor = '<sensor name="s" type="imu"><pose>0 0 1 0 0 0</pose></sensor>'
        loop = '<joint name="l" type="revolute"><parent>hand</parent><child>body</child></joint>'
        rich = TINY.replace("</robot>", f'<gazebo reference="hand">{sensor}</gazebo>'
                            f"<gazebo>{loop}</gazebo></robot>")  # fmt: skip
        more = (
            '<limit lower="-1" upper="1" effort="2" velocity="3"/>'
            '<dynamics damping="1" friction="1"/><mimic joint="elbow"/></joint>'
        )
        rich = rich.replace("</joint>", more, 1)
        mbs = convert(folder / "tiny.urdf").data
        self.good: dict[str, list[bytes]] = {
            "urdf": [TINY.encode(), rich.encode()],
            "xacro": [XACRO.encode(), XACRO.encode(), NUMBERS.encode()],
            "config": [CONFIG.encode(), b"source: tiny.urdf\n"],
            "srdf": [SRDF.encode()],
            "mbs": [mbs, self._closed()],
            "mesh": [],
            "wrl": [],
        }
        self.endings: list[str] = []
        self._meshes()
        self.good["robot"] = [TINY.encode(), rich.encode(), MANY.encode(), XACRO.encode()]
        self.good["model"] = self.good["mbs"]
        (folder / "tiny.mbs").write_bytes(mbs)
        (folder / "outer.xacro").write_text(OUTER)
        (folder / "by_yaml.xacro").write_text(BY_YAML)

    def _closed(self) -> bytes:
        """An .mbs with a cut, a rod, forces, sensors and user models."""
        config = self._put("closed.yaml", CLOSED.encode())
        conversion = Pipeline(*load(config), installed_plugins=False).run()
        return conversion.files[conversion.settings.output]

    def _meshes(self) -> None:
        import trimesh

        box = trimesh.creation.box()
        for ending in (".stl", ".ply", ".glb", ".dae", ".obj"):
            data = box.export(file_type=ending[1:])
            self._mesh(ending, data if isinstance(data, bytes) else data.encode())
        self._mesh(".stl", trimesh.exchange.stl.export_stl_ascii(box).encode())
        self._mesh(".ply", trimesh.exchange.ply.export_ply(box, encoding="ascii"))
        self._mesh(".obj", OBJ.encode())
        files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(box))
        for name, data in files.items():
            (self.folder / name).write_bytes(data)
        self._mesh(".gltf", files["model.gltf"])
        self._put("good.stl", self.good["mesh"][0])
        mesh = meshes.read(self._put("box.obj", OBJ.encode()))
        self.good["wrl"] = [
            b"".join([b"#VRML V2.0 utf8\n", *vrml.write(mesh.parts, (0.5, 0.5, 0.5), 0.0)])
        ]

    def _mesh(self, ending: str, data: bytes) -> None:
        self.endings.append(ending)
        self.good["mesh"].append(data)

    def input(self, kind: str, seed: int) -> tuple[bytes, int]:
        chance = random.Random(f"{kind} {seed}")
        which = chance.randrange(len(self.good[kind]))
        return changed(self.good[kind][which], chance, kind), which

    def try_(self, kind: str, seed: int) -> str:
        """Give a changed file to the library: '' for a result, the code of an error of ours.

        Raises whatever else comes out.
        """
        data, which = self.input(kind, seed)
        run: dict[str, Callable[[bytes, int], Any]] = {
            "urdf": self._urdf, "xacro": self._xacro, "config": self._config, "srdf": self._srdf,
            "mbs": self._mbs, "mesh": self._mesh_read, "wrl": self._wrl,
            "robot": lambda data, which: self._commands(ROBOT_COMMANDS, data, seed),
            "model": lambda data, which: self._commands(MODEL_COMMANDS, data, seed),
        }  # fmt: skip
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                run[kind](data, which)
        except MeshError:
            return "mesh-unreadable"
        except ConversionError as error:
            str(error)
            if error.code in ("internal", "plugin-failed"):
                raise
            return error.code
        return ""

    def _put(self, name: str, data: bytes) -> Path:
        file = self.folder / name
        file.write_bytes(data)
        return file

    def _urdf(self, data: bytes, which: int) -> None:
        file = self._put("fuzzed.urdf", data)
        if which:
            config = self._put("fuzzed.yaml", b"source: fuzzed.urdf\noutput: {project: p}\n")
            Pipeline(*load(config), installed_plugins=False).run()
        else:
            convert(file)

    def _xacro(self, data: bytes, which: int) -> None:
        self._put("fuzzed.inc" if which else "fuzzed.xacro", data)
        convert(self.folder / ("fuzzed.xacro", "outer.xacro", "by_yaml.xacro")[which])

    def _wrl(self, data: bytes, which: int) -> None:
        vrml_reader.read(data)

    def _commands(self, commands: Sequence[str], data: bytes, seed: int) -> None:
        """One command on a fuzzed file; what it says must be a code of ours, and letters."""
        command = commands[seed % len(commands)]
        self._put("fuzzed.robot", data)
        words = [
            f"{self.folder}/{word}" if word.startswith(FILES) else word for word in command.split()
        ]
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            code = command_line(words)
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        (self.folder / "new.yaml").unlink(missing_ok=True)
        said = err.getvalue()
        told = re.findall(r"^(?:.*: )?error\[([a-z-]+)\]: ", said, re.MULTILINE)
        if code == 0:
            return
        if (not told and code != 3) or set(told) - CATALOGUE or "internal" in told:
            raise AssertionError(f"{command} gives {code}: {said}")
        if re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", said + out.getvalue()):
            raise AssertionError(f"{command} prints a control character")
        raise ConversionError(told[-1] if told else "not-the-same", said)

    def _config(self, data: bytes, which: int) -> None:
        Pipeline(*load(self._put("fuzzed.yaml", data)), installed_plugins=False).run()

    def _srdf(self, data: bytes, which: int) -> None:
        self._put("fuzzed.srdf", data)
        convert(
            self.folder / "tiny.urdf",
            options={"posture": {"srdf": str(self.folder / "fuzzed.srdf"), "state": "home"}},
        )

    def _mbs(self, data: bytes, which: int) -> None:
        mbs = read(data, "fuzzed.mbs")
        validate(data, "fuzzed.mbs")
        draw(mbs)
        try:
            write(mbs)
        except ValueError as error:  # what emit tells as mbs-unwritable
            raise ConversionError("mbs-unwritable", str(error)) from None
        generate(mbs, data, "fuzzed.mbs")

    def _mesh_read(self, data: bytes, which: int) -> None:
        mesh = meshes.read(self._put(f"fuzzed{self.endings[which]}", data))
        list(vrml.write(mesh.parts, (0.5, 0.5, 0.5), 0.0))


#: Words that begin so are files in the fuzzer's folder.
FILES = ("fuzzed.", "tiny.", "out", "new.")
ROBOT_COMMANDS = (
    "convert fuzzed.robot -o out.mbs", "report fuzzed.robot -o out.html",
    "init fuzzed.robot -o new.yaml", "verify fuzzed.robot tiny.mbs",
    "convert fuzzed.robot -o out/ --pipeline compact -v",
    "convert fuzzed.robot -o out/ --set layout.style=tree --json",
)  # fmt: skip
MODEL_COMMANDS = (
    "equations fuzzed.robot -o out/",
    "equations fuzzed.robot -o out/ --language c --fold",
    "verify tiny.urdf fuzzed.robot",
    "diagram fuzzed.robot -o out.svg",
    "verify tiny.urdf fuzzed.robot --engine pinocchio --json",
)
KINDS = ("urdf", "xacro", "config", "srdf", "mbs", "mesh", "wrl", "robot", "model")


class TooLongError(Exception):
    """An input that takes longer than ``PATIENCE``."""


@contextmanager
def patience() -> Iterator[None]:
    def late(*_: object) -> None:
        raise TooLongError

    if not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--first", type=int, default=1_000_000, help="the first seed")
    parser.add_argument("--kinds", nargs="+", default=KINDS)
    parser.add_argument("--one", nargs=2, metavar=("KIND", "SEED"))
    arguments = parser.parse_args()
    logging.disable()  # what other packages log
    with tempfile.TemporaryDirectory() as folder:
        fuzzer = Fuzzer(Path(folder))
        if arguments.one:
            kind, seed = arguments.one
            sys.stdout.buffer.write(fuzzer.input(kind, int(seed))[0])
            print("\n", fuzzer.try_(kind, int(seed)))
            return 0
        end = time.monotonic() + 60 * arguments.minutes
        counts: dict[str, dict[str, int]] = {kind: {} for kind in arguments.kinds}
        found: dict[str, str] = {}
        seed = arguments.first
        while time.monotonic() < end:
            for kind in arguments.kinds:
                try:
                    with patience():
                        code = fuzzer.try_(kind, seed)
                except (Exception, SystemExit) as error:
                    code = "CRASH"
                    root = error.__cause__ or error
                    where = traceback.extract_tb(root.__traceback__)[-1:]
                    at = "".join(f"{Path(f.filename).name}:{f.lineno}" for f in where)
                    what = f"{kind} {type(root).__name__} {at}"
                    if what not in found:
                        found[what] = f"{seed}: {' '.join(str(root).split())[:150]}"
                        print(what, found[what], flush=True)
                counts[kind][code] = counts[kind].get(code, 0) + 1
            seed += 1
        for kind, codes in counts.items():
            most = sorted(codes.items(), key=lambda pair: -pair[1])
            print(f"{kind}: {sum(codes.values())} inputs, {len(codes)} outcomes: {dict(most)}")
        print(f"{sum(sum(c.values()) for c in counts.values())} inputs, {len(found)} crashes")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
