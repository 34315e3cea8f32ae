"""URDF files that are wrong, each with the code that must be told.

``CASES`` maps a name to the file and the code.  A file is made from a good robot by one change.
"""

from __future__ import annotations

GOOD = """<?xml version="1.0"?>
<robot name="r">
  <link name="a"><inertial><origin xyz="0 0 1" rpy="0 0 0"/><mass value="2.5"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0 0 2" rpy="0 0 1"/><geometry><box size="1 2 3"/></geometry>
      <material name="m"><color rgba="1 0 0 1"/></material></visual>
    <collision><geometry><cylinder radius="4" length="5"/></geometry></collision></link>
  <link name="b"><inertial><mass value="3.5"/>
    <inertia ixx="2" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial></link>
  <joint name="j" type="revolute"><origin xyz="0 0 3" rpy="0 1 0"/><parent link="a"/>
    <child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1.5" effort="6" velocity="7"/>
    <dynamics damping="8" friction="9"/></joint>
</robot>
"""

#: Words where one number is wanted, and the code of each.
NO_NUMBER = {
    "": "number-missing", " ": "number-missing", "one": "number-invalid", "1,5": "number-invalid",
    "nan": "number-invalid", "inf": "number-invalid", "-inf": "number-invalid",
    "1e999": "number-invalid", "0x10": "number-invalid", "1_000": "number-invalid",
    "١": "number-invalid", "1 2": "number-count", "1;": "number-invalid", "--1": "number-invalid",
    "1.5.2": "number-invalid", "${x}": "xacro-unexpanded", "$(arg x)": "xacro-unexpanded",
    "1&#10;2": "number-count", "π": "number-invalid", "1e": "number-invalid",
}  # fmt: skip
#: The same where three are.
NO_VECTOR = {
    "": "number-missing", "0 0": "number-count", "0 0 0 0": "number-count",
    "x y z": "number-invalid",
    "0 0 nan": "number-invalid", "0, 0, 1": "number-commas", "0 0 1e400": "number-invalid",
    "0 0 ${z}": "xacro-unexpanded", "[0 0 1]": "number-invalid", "1": "number-count",
}  # fmt: skip
#: Where a number stands that the .mbs needs.
NUMBERS = (
    'value="2.5"', 'value="3.5"', 'ixx="1"', 'iyy="1"', 'izz="1"', 'ixx="2"', 'iyz="0" izz="2"',
)  # fmt: skip
VECTORS = ('xyz="0 0 1"', 'xyz="0 0 3"', 'rpy="0 1 0"', 'xyz="0 1 0"')
#: Where one stands that it does not need.
OPTIONAL = (
    'lower="-1"', 'upper="1.5"', 'effort="6"', 'velocity="7"', 'damping="8"', 'friction="9"',
    'radius="4"', 'length="5"', 'xyz="0 0 2"', 'rpy="0 0 1"', 'size="1 2 3"', 'rgba="1 0 0 1"',
)  # fmt: skip

Cases = dict[str, tuple[bytes, str]]


def changed(old: str, new: str) -> bytes:
    assert GOOD.count(old) >= 1, old
    return GOOD.replace(old, new, 1).encode("utf-8", "surrogatepass")


def numbers() -> Cases:
    cases: Cases = {}
    for place in NUMBERS:
        head, _, tail = place.partition('="')
        rest = tail.partition('"')[2]
        for word, code in NO_NUMBER.items():
            cases[f"{place} {word!r}"] = changed(place, f'{head}="{word}"{rest}'), code
    for place in VECTORS:
        head = place.partition("=")[0]
        for word, code in NO_VECTOR.items():
            cases[f"{place} {word!r}"] = changed(place, f'{head}="{word}"'), code
    for place in OPTIONAL:
        head = place.partition("=")[0]
        for word in ("", "x", "nan", "1 2 3 4 5"):
            cases[f"{place} {word!r}"] = changed(place, f'{head}="{word}"'), "number-left-out"
    return cases


def structure() -> Cases:
    """What is wrong with links, joints and the tree."""
    link = '<link name="c"/>'
    joint = '<joint name="k" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
    end = "</robot>"

    def with_(more: str) -> bytes:
        return changed(end, f"{more}\n{end}")

    return {
        "no links": (b'<robot name="r"/>', "no-links"),
        "link without a name": (changed('<link name="b">', "<link>"), "name-missing"),
        "link with an empty name": (changed('<link name="b">', '<link name="">'), "name-missing"),
        "link with a blank name": (changed('<link name="b">', '<link name=" ">'), "name-missing"),
        "joint without a name": (changed('<joint name="j" ', "<joint "), "name-missing"),
        "two links of one name": (with_('<link name="a"/>'), "name-doubled"),
        "two joints of one name": (
            with_(link + joint.format("b", "c").replace('"k"', '"j"')), "joint-renamed",
        ),
        "no type": (changed(' type="revolute"', ""), "joint-type-missing"),
        "unknown type": (changed('"revolute"', '"hinge"'), "joint-type-unknown"),
        "type in capitals": (changed('"revolute"', '"Revolute"'), "joint-type-spelling"),
        "no parent": (changed('<parent link="a"/>', ""), "joint-link-missing"),
        "no child": (changed('<child link="b"/>', ""), "joint-link-missing"),
        "empty parent": (changed('<parent link="a"/>', '<parent link=""/>'), "joint-link-missing"),
        "own child": (changed('<child link="b"/>', '<child link="a"/>'), "joint-same-link"),
        "unknown parent": (changed('<parent link="a"/>', '<parent link="z"/>'), "link-unknown"),
        "unknown child": (changed('<child link="b"/>', '<child link="B"/>'), "link-unknown"),
        "zero axis": (changed('xyz="0 1 0"', 'xyz="0 0 0"'), "axis-zero"),
        "two parents": (with_(link + joint.format("c", "b")), "two-parents"),
        "several roots": (
            with_(link + '<link name="d"/>' + joint.format("c", "d")), "several-roots",
        ),
        "loop": (with_(joint.format("b", "a")), "loop"),
        "loop beside": (
            with_(
                link + '<link name="d"/>' + joint.format("c", "d")
                + joint.format("d", "c").replace('"k"', '"l"')
            ),
            "loop",
        ),
        "unattached": (with_(link), "link-unattached"),
        "unknown element": (with_("<lnk/>"), "misspelt"),
        "unknown attribute": (changed('name="b"', 'name="b" nme="c"'), "misspelt"),
        "no robot name": (changed(' name="r"', ""), "robot-unnamed"),
        "no limit": (
            changed('<limit lower="-1" upper="1.5" effort="6" velocity="7"/>', ""),
            "joint-limit-missing",
        ),
        "limits the wrong way": (changed('lower="-1"', 'lower="3"'), "limit-order"),
        "negative mass": (changed('value="2.5"', 'value="-2.5"'), "mass-negative"),
        "no body": (changed('ixx="1"', 'ixx="3"'), "inertia-triangle"),
        "no body at all": (changed('ixx="1"', 'ixx="-3"'), "inertia-indefinite"),
        "xacro left": (
            changed(end, '<xacro:leg xmlns:xacro="http://www.ros.org/wiki/xacro"/></robot>'),
            "xacro-left",
        ),
        "legacy": (with_("<macro name='m'/>"), "xacro-legacy"),
        "world": (changed('<parent link="a"/>', '<parent link="world"/>'), "world-implied"),
        "mimics itself": (changed("<dynamics", '<mimic joint="j"/><dynamics'), "mimic-left-out"),
    }  # fmt: skip


def bytes_() -> Cases:
    """What is wrong with the file as XML, or with its letters."""
    good = GOOD.encode()
    bare = GOOD.partition("?>")[2].strip()

    def doctype(text: str, use: str = "") -> bytes:
        return f"<!DOCTYPE robot [{text}]>\n{bare.replace('2.5', use or '2.5')}".encode()

    laughs = '<!ENTITY l0 "lol">' + "".join(
        f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12)
    )
    cases: Cases = {
        "nothing": (b"", "file-empty"),
        "blanks": (b" \n\t\r\n", "file-empty"),
        "a byte order mark": (b"\xef\xbb\xbf", "file-empty"),
        "NULs": (b"\0" * 100, "file-empty"),
        "words": (b"robot", "not-xml"),
        "JSON": (b'{"robot": {}}', "not-xml"),
        "YAML": (b"robot:\n  name: r\n", "not-xml"),
        "an image": (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "not-xml"),
        "an archive": (b"PK\x03\x04" + bytes(100), "not-xml"),
        "SDF": (b'<sdf version="1.6"><model name="r"/></sdf>', "wrong-root"),
        "MJCF": (b"<mujoco/>", "wrong-root"),
        "HTML": (b"<html><body/></html>", "wrong-root"),
        "Robot": (good.replace(b"robot", b"Robot"), "wrong-root"),
        "billion laughs": (doctype(laughs, "&l11;"), "xml-entity"),
        "laughs in an attribute": (doctype(laughs + '<!ATTLIST robot x CDATA "&l11;">'),
                                   "xml-entity"),
        "quadratic blow-up": (doctype(f'<!ENTITY a "{"a" * 10000}">', "&a;" * 1000), "xml-entity"),
        "external entity": (doctype('<!ENTITY e SYSTEM "file:///etc/passwd">', "&e;"),
                            "xml-entity"),
        "entity of the net": (doctype('<!ENTITY e SYSTEM "http://127.0.0.1:9/">', "&e;"),
                              "xml-entity"),
        "unused entity": (doctype('<!ENTITY e "x">'), "xml-entity"),
        "parameter entity": (doctype('<!ENTITY % p SYSTEM "file:///etc/passwd">%p;'),
                             "xml-entity"),
        "parameter entity in text": (doctype("<!ENTITY % p \"<!ENTITY e 'x'>\">%p;", "&e;"),
                                     "xml-entity"),
        "entity of itself": (doctype('<!ENTITY e "&e;">', "&e;"), "xml-entity"),
        "undeclared entity": (GOOD.replace("2.5", "&e;").encode(), "xml-syntax"),
        "deep nesting": (b'<robot name="r">' + b"<a>" * 100_000 + b"</a>" * 100_000 + b"</robot>",
                         "xml-too-large"),
        "deep and open": (b'<robot name="r">' + b"<a>" * 100_000, "xml-too-large"),
        "NUL in a name": (good.replace(b'"j"', b'"j\0k"'), "xml-syntax"),
        "NUL between": (good.replace(b"\n", b"\n\0"), "xml-truncated"),
        "&#0;": (good.replace(b'"j"', b'"&#0;"'), "xml-syntax"),
        "&#xD800;": (good.replace(b'"j"', b'"&#xD800;"'), "xml-syntax"),
        "an escape": (good.replace(b'"j"', b'"\x1b[2J"'), "xml-syntax"),
        "half a letter": (good.replace(b'"j"', b'"\xc3"'), "xml-syntax"),
        "surrogates": (good.replace(b'"j"', b'"\xed\xa0\x80"'), "xml-syntax"),
        "Latin-1 as UTF-8": (GOOD.replace('"j"', '"é"').encode("latin-1"), "xml-syntax"),
        "an unknown encoding": (
            good.replace(b'"1.0"', b'"1.0" encoding="klingon"'), "xml-syntax"),
        "EBCDIC in name only": (
            good.replace(b'"1.0"', b'"1.0" encoding="ebcdic-cp-us"'), "xml-syntax"),
        "21 MB of a comment": (good.replace(b"</robot>", b"<!--" + b"x" * 21_000_000 + b"-->"),
                               "xml-truncated"),
        "21 MB of a comment, closed": (
            good.replace(b"</robot>", b"<!--" + b"x" * 21_000_000 + b"--></robot>"), "xml-mended"),
        "a long name of an element": (good.replace(b"</robot>", b"<" + b"x" * 60_000 + b"/>"),
                                      "xml-too-large"),
        "11 MB of text": (good.replace(b"</robot>", b"x" * 11_000_000 + b"</robot>"),
                          "xml-too-large"),
        "a merge conflict": (good.replace(b"  <link", b"<<<<<<< HEAD\n  <link", 1),
                             "merge-conflict"),
        "two roots": (good + b"<robot/>", "xml-syntax"),
        "no quotes": (good.replace(b'"j"', b"j"), "xml-syntax"),
        "an attribute twice": (good.replace(b'name="j"', b'name="j" name="k"'), "xml-syntax"),
        "a wrong end": (good.replace(b"</joint>", b"</link>"), "xml-syntax"),
        "< in a value": (good.replace(b'"j"', b'"j<k"'), "xml-syntax"),
        "& in a value": (good.replace(b'"j"', b'"j&k"'), "xml-syntax"),
        "CDATA without an end": (good.replace(b"</robot>", b"<![CDATA[</robot>"),
                                 "xml-truncated"),
        "a comment without an end": (good.replace(b"</robot>", b"<!-- </robot>"),
                                     "xml-truncated"),
        "11 MB in one attribute": (GOOD.replace('"j"', '"' + "j" * 11_000_000 + '"').encode(),
                                   "xml-too-large"),
        "XML 2.0": (good.replace(b'"1.0"', b'"2.0"'), "xml-mended"),
        "-- in a comment": (good.replace(b"</robot>", b"<!-- a -- b --></robot>"), "xml-mended"),
        "blanks before": (b"\n" + good, "xml-mended"),
        "an undeclared prefix": (good.replace(b"</robot>", b"<x:y/></robot>"), "xml-namespace"),
    }  # fmt: skip
    for cut in range(30, len(good.rstrip()) - 1, 41):
        cases[f"cut at {cut}"] = good[:cut], "xml-truncated"
    return cases


def all_cases() -> Cases:
    return {**numbers(), **structure(), **bytes_()}
