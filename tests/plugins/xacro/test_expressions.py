"""Expressions of xacro are data: what robots use has its value, all else is an error at once."""

import os
import sys
import threading
import time
import warnings
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest

from support.plugin_files import read_robot
from urdf2mbs.api import convert
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.packages import Packages
from urdf2mbs_xacro.limits import Watch
from urdf2mbs_xacro.xacro import Expander, expand

#: What xacro evaluates to the same value, with trust and without.
HARMLESS = (
    "1 + 2 * 3 - 4 / 5 // 6 % 7",
    "2**10 + (1 << 4) | 3 & ~5 ^ 6 >> 1",
    "2**60 % 7 + (1 << 60) % 7",
    "-pi * radians(180) + sin(1)",
    "math.atan2(1, 2)",
    "1 < 2 <= 2 != 3",
    "'a' in 'abc' and not False or True",
    "'left' if pi is None else 'right'",
    "[1, 2.5, 'a'][1:]",
    "'abcdef'[::-2]",
    "(1, 2)[-1]",
    "[x * y for x in [1, 2] for y in [3, 4] if x != y]",
    "[[x + y for x in [1]] for y in [2]]",
    "python.sum(x for x in python.range(5))",
    "dict([(k, len(k)) for k in ['a', 'bb']])['bb']",
    "dict(a=1, b=[1, dict(c=2)])['b'][1]['c']",
    "xacro.dotify(dict(a=dict(b=2))).a.b",
    "'a_b'.split('_')[1].upper().replace('B', 'C').join(['1', '2'])",
    "'a'.ljust(5) + 'b'.zfill(4)",
    "'%s_%03d %.3f %5s' % ('a', 7, 1.5, 'b')",
    "'x_%s' % 1",
    "max(1, 2, min(3, 4))",
    "round(1.23456, 2) + round(7) + round(12.5)",
    "python.sorted([3, 1, 2], reverse=True)",
    "python.max([1, -7], key=python.abs)",
    "list(map(str, [1, 2]))",
    "python.isinstance(1, python.int)",
    "python.isinstance([1], (python.str, python.list))",
    "xacro.tokenize('a,b; c')",
    "python.any([x > 1 for x in [1, 2]])",
    "[*[1, 2], *(3, 4)]",
    "dict(**dict(a=1))",
    "max(*[1, 2])",
    "python.enumerate(['a']) and 1",
    "[i for i, (a, b) in python.list(python.enumerate([(1, 2)]))]",
    "python.set([1, 2, 2]) == python.set([2, 1])",
    "1.5.is_integer()",
    "1.5.real",
    "int('7') + float('1e3') + len('abc') + bool('')",
    "xacro.arg('side') + '$(arg side)'",
    "a.link.mass * a['link']['mass']",
    "a.link.keys()",
    "b[0].c",
    "inner.x + inner.y",
    "a.angle",
    "inner.math.pi",
    "1e-3",
    "f(4)",
)
ROBOT = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="side" default="left"/>
<xacro:property name="a" value="${{xacro.load_yaml('values.yaml')}}"/>
<xacro:property name="b" value="${{a.several}}"/>
<xacro:property name="f" value="${{sqrt}}"/>
<xacro:include filename="inner.xacro" ns="inner"/>
{}
</robot>
"""
INNER = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="x" value="1"/><xacro:property name="y" value="${x + 1}"/></robot>"""
YAML = "link: {mass: 2.5}\nseveral: [{c: 3}]\nangle: !degrees 45*2\n"

#: What is no data.
REFUSED = (
    "(lambda: 1)()",
    "(lambda: ().__class__)()",
    "().__class__",
    "a.__class__",
    "inner._resolve_",
    "inner.__dict__",
    "math.__loader__",
    "xacro.load_yaml.__globals__",
    "sin.__self__",
    "a.link._x",
    "'a'.format(1)",
    "'a'.format_map(dict(a=1))",
    "list(map('a'.format, [1]))",
    "f'a'",
    "1j",
    "(-8) ** 0.5",
    "[list(map(map, [str], [[1]]))]",
    "[i for i, *j in [(1, 2)]]",
    "(x := 5)",
    "...",
    "b'a'",
    "[0 for python.x in [1]]",
    "[0 for math['sin'] in [1]]",
    "__builtins__",
    "__operate('Add', 1, 2)",
    "__import__('os')",
    "python.type('X', (), dict())",
    "python.vars()",
    "math.factorial(10**7)",
    "math.comb(10**7, 10**6)",
    "math.perm(10**7)",
    "math.prod([9] * 9999)",
    "math.lcm(7, 8)",
    "python.sum([[1]], [])",
    "python.vars(math)",
    "sin.real",
    "str.join",
    "xacro.tokenize('a' + 'x' * 60, 'a](x+x+)+y[b')",
    "python.slice(1).indices",
    "[().__class__ for x in [1]]",
    "[x async for x in a]",
)
#: What takes more than any robot needs.
TOO_LARGE = (
    "7**(10**7)",
    "10**10**10",
    "2**a_lot",
    "2**64",
    "1 << 64",
    "1 << 10**15",
    "-1 << a_lot",
    "'x' * 10**10",
    "a_lot * 'x'",
    "[0] * 10**9",
    "([0] * 1000,) * 1000 * 1000",
    "len('a' * 10**13)",
    "python.range(10**10)",
    "list(python.range(10**9))",
    "[x for x in python.range(10**6 - 1)]",
    "[x for x in python.range(9999) for y in python.range(9999)]",
    "python.sum(x * y for x in python.range(9999) for y in python.range(9999))",
    "list(map(list, map(python.range, [99999] * 9999)))",
    "[[x] * 999 for x in [[[['a' * 999] * 999]]]]",
    "[[l.extend(l) for i in python.range(60)] for l in [[1]]]",
    "[l == l for l in [[]] if l.append(l) is None]",
    "[[*l] for l in [[1] * 9999] for x in l]",
    "[l[:] for l in [[1] * 9999] for x in l]",
    "round(5, -10**9)",
    "'a'.ljust(10**10)",
    "'\\t'.expandtabs(10**10)",
    "('a' * 9999).replace('a', 'b' * 9999)",
    "('a' * 9999).join(['b'] * 9999)",
    "('a' * 9999).translate(dict([(97, 'b' * 9999)]))",
    "'%1000000000d' % 1",
    "'%999999999d' % 1",
    "'%*d' % (10**9, 1)",
    "'%.1000000000f' % 1.5",
    "(1).to_bytes(10**10, 'big')",
    "python.hash(((((((1,) * 9,) * 9,) * 9,) * 9,) * 9,) * 99)",
    "[1] * 999 in [[1] * 999] * 999",
    "str([['a' * 999] * 999] * 99)",
    "max(*[python.range(9999)] * 9999)",
    "[[][a:] for a in [1]" + " for a in [(a, a, a, a, a, a, a, a)]" * 8 + "]",
)


def write_robot(folder: Path, inside: str) -> Path:
    (folder / "inner.xacro").write_text(INNER)
    (folder / "values.yaml").write_text(YAML)
    source = folder / "r.urdf.xacro"
    source.write_text(ROBOT.format(inside))
    return source


def link_named(expression: str) -> str:
    return f"<link name={quoteattr('${' + expression + '}')}/>"


def failure(folder: Path, inside: str) -> ConversionError:
    source = write_robot(folder, inside)
    with pytest.raises(ConversionError) as caught:
        expand(source, Packages({}, source), {})
    return caught.value


def test_what_python_tidies_up_is_no_warning_of_a_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = write_robot(tmp_path, link_named("1"))
    expander = Expander(str(source), Packages({}, source), {}, trust=False)
    expand_it = expander.xacro.process_file

    def tidy(*words: Any, **more: Any) -> Any:
        warnings.warn("Implicitly cleaning up", ResourceWarning, stacklevel=1)
        return expand_it(*words, **more)

    monkeypatch.setattr(expander.xacro, "process_file", tidy)
    assert expander.run().warnings == []


@pytest.mark.parametrize("expression", HARMLESS)
def test_what_robots_need_has_the_value_that_xacro_gives(tmp_path: Path, expression: str) -> None:
    source = write_robot(tmp_path, link_named(expression))
    restricted = expand(source, Packages({}, source), {})
    trusted = expand(source, Packages({}, source), {}, trust=True)
    assert restricted == trusted


@pytest.mark.parametrize("expression", REFUSED)
def test_what_is_no_data_is_refused(tmp_path: Path, expression: str) -> None:
    error = failure(tmp_path, "\n" + link_named(expression))
    assert (error.file, error.line) == (str(tmp_path / "r.urdf.xacro"), 8)
    assert error.code == "xacro-expression"
    assert "trust_xacro: true" in (error.hint or "")


@pytest.mark.parametrize("expression", TOO_LARGE)
def test_what_is_too_large_ends_at_once(
    tmp_path: Path, expression: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("urdf2mbs_xacro.limits.MAX_TIME", 0.5)
    error = failure(
        tmp_path, '<xacro:property name="a_lot" value="${10**9}"/>' + link_named(expression)
    )
    assert error.code == "xacro-too-large"


EVIL = "''.__class__"
#: Wherever xacro evaluates something.
PLACES = {
    "text": "<link>${%s}</link>",
    "attribute": '<link name="a${%s}"/>',
    "property": '<xacro:property name="p" value="${%s}"/><link name="${p}"/>',
    "greedy property": '<xacro:property name="p" value="${%s}" lazy_eval="false"/>',
    "name of a property": '<xacro:property name="${%s}" value="1"/>',
    "default of a property": '<xacro:property name="p" default="${%s}"/>${p}',
    "scope": '<xacro:property name="p" value="${%s}" scope="global"/>',
    "condition": '<xacro:if value="${%s}"/>',
    "unless": '<xacro:unless value="${%s}"/>',
    "parameter": '<xacro:macro name="m" params="x"/><xacro:m x="${%s}"/>',
    "default": '<xacro:macro name="m" params="x:=${%s}"/><xacro:m/>',
    "forwarded default": '<xacro:macro name="m" params="x:=^|${%s}"/><xacro:m/>',
    "block": '<xacro:macro name="m" params="*b"><xacro:insert_block name="b"/></xacro:macro>'
    "<xacro:m><link>${%s}</link></xacro:m>",
    "call": '<xacro:call macro="${%s}"/>',
    "element": '<xacro:element xacro:name="${%s}"/>',
    "name of an attribute": '<xacro:attribute name="${%s}" value="1"/>',
    "value of an attribute": '<xacro:attribute name="x" value="${%s}"/>',
    "default of an argument": '<xacro:arg name="x" default="${%s}"/>',
    "include": '<xacro:include filename="${%s}"/>',
    "namespace": '<xacro:include filename="inner.xacro" ns="${%s}"/>',
    "comment": "<!-- xacro:eval-comments --><!-- ${%s} -->",
    "within a substitution": '<link name="$(find ${%s})"/>',
    "text of an argument": '<xacro:arg name="e" default="%s"/><link name="${$(arg e)}"/>',
}


@pytest.mark.parametrize("place", PLACES)
def test_wherever_xacro_evaluates(tmp_path: Path, place: str) -> None:
    assert failure(tmp_path, PLACES[place] % EVIL).code == "xacro-expression"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("lambda: 1", "xacro-expression"),
        ("side.real.__class__", "xacro"),  # the package's own check of names
        ("7**9**9", "xacro-too-large"),
        ("cos.real", "xacro-expression"),
    ],
)
def test_expressions_in_substitutions_are_limited_too(tmp_path: Path, text: str, code: str) -> None:
    error = failure(tmp_path, f'\n<link name="$(eval {text})"/>')
    assert (error.code, error.line) == (code, 8)


def test_functions_of_a_substitution_are_withheld(tmp_path: Path) -> None:
    call = '<xacro:property name="f" value="factorial(3)"/><link name="$(eval ${f})"/>'
    assert failure(tmp_path, call).code == "xacro-expression"


def test_a_substitution_computes(tmp_path: Path) -> None:
    source = write_robot(
        tmp_path,
        '<xacro:arg name="n" default="3"/><link name="$(eval n * 2 + pi)$(eval side)"/>'
        "<link name=\"$(eval 'a' if true else [x for x in [n]])\"/>",
    )
    text = expand(source, Packages({}, source), {"n": "4"}).text
    assert b'"11.141592653589793left"' in text
    assert b'"a"' in text
    assert text == expand(source, Packages({}, source), {"n": "4"}, trust=True).text


def test_a_unit_in_yaml_is_an_expression(tmp_path: Path) -> None:
    (tmp_path / "evil.yaml").write_text(f'a: !degrees "{EVIL}"\n')
    error = failure(tmp_path, link_named("xacro.load_yaml('evil.yaml')"))
    assert error.code == "xacro-expression"


def test_a_plain_urdf_is_as_safe(tmp_path: Path) -> None:
    source = tmp_path / "r.urdf"
    source.write_text(f'<robot name="r"><link name="a${{{EVIL}}}"/></robot>')
    with pytest.raises(ConversionError) as caught:
        read_robot(source, Packages({}, source), {})
    assert caught.value.code == "xacro-expression"


#: YAML that is small and becomes large, or is a program.
BAD_YAML = {
    "alias": "a0: &a0 [1, 2, 3, 4, 5, 6, 7, 8, 9]\n"
    + "".join(f"a{i + 1}: &a{i + 1} [{','.join([f'*a{i}'] * 9)}]\n" for i in range(30)),
    "merge": "a0: &a0 {x: 1, y: 2}\n"
    + "".join(f"a{i + 1}: &a{i + 1} {{<<: [{','.join([f'*a{i}'] * 9)}]}}\n" for i in range(30)),
    "object": "!!python/object/apply:os.system ['exit 1']",
    "merge of itself": "a: &a {<<: *a}",
    "deeper than libyaml goes": "[" * 90_000 + "]" * 90_000,
    "lists in lists": "[" * 900 + "]" * 900,
    "keys in keys": "? [ " * 30_000,
    "items in items": "- " * 90_000 + "1",
    "lines in lines": "".join(" " * i + "a:\n" for i in range(400)),
}


@pytest.mark.parametrize("name", BAD_YAML)
def test_yaml_is_data(tmp_path: Path, name: str) -> None:
    (tmp_path / "bad.yaml").write_text(BAD_YAML[name])
    error = failure(tmp_path, link_named("xacro.load_yaml('bad.yaml')"))
    if name == "deeper than libyaml goes":  # its bound came with PyYAML 6.0.4; ours is lower
        assert error.code in ("xacro", "xacro-too-large")
    else:
        assert error.code == ("xacro" if name == "object" else "xacro-too-large")
    assert error.line == 7


def calls(levels: int, inside: str) -> str:
    """Macros that each call the one below eight times."""
    return f'<xacro:macro name="m0">{inside}</xacro:macro>' + "".join(
        f'<xacro:macro name="m{i + 1}">{f"<xacro:m{i}/>" * 8}</xacro:macro>' for i in range(levels)
    )


def properties(count: int, first: str, text: str) -> str:
    """Properties that are each made from the one before."""
    values = [first, *(text.replace("p", f"p{i}") for i in range(count))]
    return "".join(f'<xacro:property name="p{i}" value="{v}"/>\n' for i, v in enumerate(values))


LOOP = "[0 for x in python.range(9999) for y in python.range(9999) if 0]"
#: What grows outside of any expression, or over many.
BOMBS = {
    "laughs": properties(9, "aaaaaaaa", "${p}" * 16) + '<link name="${p9}"/>',
    "squares": properties(40, "9", "${p*p}") + '<link name="${p40}"/>',
    "lists": properties(40, "${[1]}", "${[p] * 9}") + '<link name="${p40}"/>',
    "sums": properties(60, "aa", "${p+p}") + '<link name="${p60}"/>',
    "blocks": '<xacro:property name="p0"><a/><a/></xacro:property>'
    + "".join(
        f'<xacro:property name="p{i + 1}">{f"""<xacro:insert_block name="p{i}"/>""" * 2}'
        "</xacro:property>"
        for i in range(40)
    )
    + '<xacro:insert_block name="p40"/>',
    "loop": link_named(LOOP),
    "many loops": link_named("[x for x in python.range(9999)]") * 60,
    "doubling macros": '<xacro:macro name="m" params="n"><xacro:if value="${n}">'
    '<xacro:m n="${n - 1}"/><xacro:m n="${n - 1}"/></xacro:if></xacro:macro><xacro:m n="50"/>',
    "elements": calls(9, "<a/><a/><a/><a/><a/><a/><a/>") + "<xacro:m9/>",
    "texts": calls(9, f"<a>{'x' * 999}</a>") + "<xacro:m9/>",
    "neighbours": "<a/>" * 30_000 + '<xacro:property name="a" value="1"/>' * 5000,
    "unknown macros": "".join(f"<xacro:u{i}/>" for i in range(9999)),
    "parameters": '<xacro:macro name="m" params="' + "x:=${ " * 30_000 + '"/>',
    "expressions": "<link>" + "${1}" * 99_999 + "</link>",
    "comments": "<!---->" * 150_000,
}


# an exception that reaches the functions by which Python deletes objects is printed, and sent again
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", BOMBS)
def test_work_has_an_end(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("urdf2mbs_xacro.limits.MAX_TIME", 0.1)
    error = failure(tmp_path, BOMBS[name])
    assert error.code == "xacro-too-large"
    assert error.file in (str(tmp_path / "r.urdf.xacro"), str(tmp_path / "inner.xacro"))
    assert error.line is not None or "m9/>" not in BOMBS[name], "that of a macro"


@pytest.mark.skipif(sys.platform == "win32", reason="the memory is not known")
def test_memory_has_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each value is small, and all are kept."""
    monkeypatch.setattr("urdf2mbs_xacro.limits.MAX_MEMORY", 50 * 2**20)
    monkeypatch.setattr("urdf2mbs_xacro.limits.INTERVAL", 0.005)
    values = (
        f'<xacro:property name="p{i}" value="${{\'a\' * 99000}}" lazy_eval="false"/>'
        for i in range(9999)
    )
    error = failure(tmp_path, "".join(values))
    assert error.code == "xacro-too-large"
    assert "of memory" in error.message


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_work_has_an_end_in_every_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another thread is not interrupted, nor is the same thread afterwards."""
    monkeypatch.setattr("urdf2mbs_xacro.limits.MAX_TIME", 0.1)
    monkeypatch.setattr("urdf2mbs_xacro.limits.RETRY", 0.01)
    codes: list[str] = []

    def run(name: str) -> None:
        (tmp_path / name).mkdir()
        codes.append(failure(tmp_path / name, BOMBS["doubling macros"]).code)
        sum(range(10**7))

    threads = [threading.Thread(target=run, args=(name,)) for name in ("a", "b", "c")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert codes == ["xacro-too-large"] * 3


def test_the_watch_ends_with_the_thread_that_it_watches(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock of a thread that has ended cannot be read."""
    monkeypatch.setattr("urdf2mbs_xacro.limits.INTERVAL", 1e-5)
    failures: list[object] = []
    monkeypatch.setattr(threading, "excepthook", failures.append)

    def expand_nothing() -> None:
        with Watch():
            pass

    for _ in range(1000):
        thread = threading.Thread(target=expand_nothing)
        thread.start()
        thread.join()
    assert failures == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", ["texts", "blocks"])
def test_work_ends_within_ten_seconds(tmp_path: Path, name: str) -> None:
    start = time.thread_time()
    assert failure(tmp_path, BOMBS[name]).code == "xacro-too-large"
    assert time.thread_time() - start < 10.0


#: Where a robot can name a file.
NAMED = {
    "include": '<xacro:include filename="pipe"/>',
    "pattern": '<xacro:include filename="pip*"/>',
    "yaml": link_named("xacro.load_yaml('pipe')"),
    "mesh": '<link name="a"><visual><geometry><mesh filename="pipe"/></geometry></visual></link>',
}


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
@pytest.mark.parametrize("name", [*NAMED, "source"])
def test_a_pipe_is_no_file(tmp_path: Path, name: str) -> None:
    """Nobody writes into it, and nobody waits for it."""
    os.mkfifo(tmp_path / "pipe")
    source = tmp_path / "pipe" if name == "source" else write_robot(tmp_path, NAMED[name])
    messages: list[str] = []

    def run() -> None:
        try:
            messages.extend(map(str, convert(source).diagnostics))
        except ConversionError as error:
            messages.append(str(error))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(60)
    assert not thread.is_alive()
    assert any("pipe" in message for message in messages)


def test_a_quote_that_is_not_closed_in_parameters(tmp_path: Path) -> None:
    """xacro's own pattern takes a time that doubles with each letter."""
    robot_of = '<xacro:macro name="m" params="x:={}\'"/>'.format("a" * 60)
    assert failure(tmp_path, robot_of + "<xacro:m/>").code == "xacro"


def test_a_file_outside(tmp_path: Path) -> None:
    """By a path, a link, a pattern, an entity, a hidden folder: read by nobody."""
    (tmp_path / "r").mkdir()
    (tmp_path / "secret.yaml").write_text("word: hush")
    (tmp_path / "secret.xacro").write_text('<robot><link name="hush"/></robot>')
    (tmp_path / "r" / ".hidden").mkdir()
    (tmp_path / "r" / ".hidden" / "x.yaml").write_text("word: hush")
    attempts = [
        link_named("xacro.load_yaml('../secret.yaml')['word']"),
        link_named(f"xacro.load_yaml('{tmp_path}/secret.yaml')['word']"),
        link_named("xacro.load_yaml('.hidden/x.yaml')['word']"),
        '<xacro:include filename="../secret.xacro"/>',
        '<xacro:include filename="$(dirname)/../secret.xacro"/>',
        '<xacro:include filename="../secret.x*"/>',
        '<xacro:include filename="*/../../secret.x*"/>',
        '<xacro:include filename="../secret.xacro" optional="true"/>',
    ]
    if sys.platform != "win32":
        (tmp_path / "r" / "link.xacro").symlink_to(tmp_path / "secret.xacro")
        attempts += [
            '<xacro:include filename="link.xacro"/>',
            '<xacro:include filename="li*.xacro"/>',
        ]
    for attempt in attempts:
        error = failure(tmp_path / "r", "\n" + attempt)
        assert error.code == "xacro-file", attempt
        assert error.file == str(tmp_path / "r" / "r.urdf.xacro"), attempt
        assert "packages: {NAME:" in (error.hint or "")
        assert "trust_xacro: true" in (error.hint or "")


def test_what_allows_a_file_outside(tmp_path: Path) -> None:
    (tmp_path / "r").mkdir()
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "values.yaml").write_text("word: open")
    inside = (
        '<xacro:arg name="file" default="../more/values.yaml"/>'
        '<xacro:property name="f" value="$(arg file)"/>' + link_named("xacro.load_yaml(f)['word']")
    )
    source = write_robot(tmp_path / "r", inside)
    with pytest.raises(ConversionError, match="xacro-file"):
        expand(source, Packages({}, source), {})
    given = {"file": str(tmp_path / "more" / "values.yaml")}
    for packages, args, trust in (
        ({"more": tmp_path / "more"}, {}, False),
        ({}, given, False),
        ({}, {}, True),
    ):
        made = expand(source, Packages(packages, source), args, trust=trust)
        assert b'"open"' in made.text


@pytest.mark.skipif(sys.platform == "win32", reason="links of POSIX")
def test_files_of_a_workspace_of_symbolic_links_are_read(tmp_path: Path) -> None:
    """colcon build --symlink-install: what is installed are links to the files of the sources."""
    sources, installed = tmp_path / "ws/src/arm", tmp_path / "ws/install/arm/share/arm"
    for folder in (sources, installed):
        folder.mkdir(parents=True)
    (sources / "package.xml").write_text("<package><name>arm</name></package>")
    write_robot(sources, '<link name="${a.link.mass}"/>')
    for file in sources.iterdir():
        (installed / file.name).symlink_to(file)
    main = tmp_path / "mine" / "main.urdf.xacro"
    main.parent.mkdir()
    main.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="$(find arm)/r.urdf.xacro"/></robot>'
    )
    for source in (installed / "r.urdf.xacro", main):
        made = expand(source, Packages({"arm": installed}, source), {})
        assert b'"2.5"' in made.text


def test_trust_allows_all(tmp_path: Path) -> None:
    source = write_robot(tmp_path, link_named("(lambda x: x * (7**30000 % 10))('a')"))
    assert b'"a"' in expand(source, Packages({}, source), {}, trust=True).text
