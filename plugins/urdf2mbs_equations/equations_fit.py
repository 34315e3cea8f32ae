"""Check that the equations in symbolicR fit the .mbs.

This file needs Python's standard library only.  urdf2mbs uses it, and writes it into a project,
where workR/main.py uses it.  In a project in C, equations_fit.c does the same.

Equations rely on the tree of joints, on which numbers are zero, and on the positions of joints
that never move.  These are described as text, a line for each element, and the checksum of this
text is in the head of each file of equations::

    the .mbs -> description -> sha256  == ?  Fits (tree, fixed): sha256 ...

Equations read other masses, centres of mass, inertias and points from the .mbs: a change of these
needs no new equations, and neither does a body that is moved in the diagram.
"""

from __future__ import annotations

import re
import sys
from hashlib import sha256
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

# The line in the head of a file of equations that states which models it fits.
CHECKSUM = re.compile(r"Fits \((.*)\): sha256 ([0-9a-f]{64})")

# Elements and attributes, in the order in which they are described.
AXES = ("x", "y", "z")
INERTIA = ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
MEASURES = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac")
SYMBOLS = ("q", "qd", "qdd")

# A number this many times smaller than the largest beside it is a rounding of zero.
ROUNDING = 1e-15


def fits(equations: bytes, model: bytes) -> bool | None:
    """Return whether equations fit a model; None if they state no checksum.

    Args:
        equations: The bytes of a file of equations, at least those of its head.
        model: The bytes of an .mbs.
    """
    stated = CHECKSUM.search(equations[:2000].decode("utf-8", "replace"))
    return None if stated is None else fingerprint(model, stated[1]) == stated[2]


def fingerprint(model: bytes, parts: str) -> str:
    """Return a checksum of what equations rely on.

    Args:
        model: The bytes of an .mbs.
        parts: ``tree`` for the tree of joints and which numbers are zero; with ``fixed`` also the
            positions of joints that never move, with ``numbers`` all numbers.
    """
    return sha256(describe(model, parts).encode()).hexdigest()


def describe(model: bytes, parts: str) -> str:
    """Return what equations rely on, a line for each element; equations_fit.c writes the same."""
    root = fromstring(_decode(model))
    exact, with_fixed = "numbers" in parts, parts != "tree"
    bodies = {_text(body, "bodyname"): n for n, body in enumerate(root.iterfind("bodytree/body"))}
    owners = [*root.iterfind("base"), *root.iterfind("bodytree/body")]
    points = {
        (_text(owner, "bodyname") or "base", _text(point, "pointname")): n
        for owner in owners
        for n, point in enumerate(owner.iterfind("point"), start=1)
    }

    def describe_place(element: Element, path: str) -> str:
        """Return the numbers of a body and of a point: names do not count."""
        body, point = _text(element, f"{path}/bodyname"), _text(element, f"{path}/pointname")
        return f"{bodies.get(body, body)} {points.get((body, point), 0)}"

    lines = [f"model {_text(root, 'mbsname')}"]
    for owner in owners:
        lines.append(f"body {describe_place(owner, 'parent')}")
        lines += [_describe_joint(joint, with_fixed) for joint in owner.iterfind("joint")]
        lines.append(f"mass {_describe_number(owner, 'mass', exact)}")
        lines.append(f"com{_describe_numbers(owner, 'com/coordinates', AXES, exact)}")
        lines.append(f"inertia{_describe_numbers(owner, 'inertia', INERTIA, exact)}")
        lines.append(f"gravity{_describe_numbers(owner, 'gravity/coordinates', AXES, exact)}")
        for point in owner.iterfind("point"):
            lines.append(f"point{_describe_numbers(point, 'coordinates', AXES, exact)}")
            for child in point:
                if child.tag in ("sensor", "extforce"):
                    measures = [name for name in MEASURES if child.get(name) is not None]
                    lines.append(" ".join([child.tag, *measures]))
    for element in (*root.iterfind("cuts/*"), *root.iterfind("links/*")):
        ends = f"{describe_place(element, 'endpoint1')} {describe_place(element, 'endpoint2')}"
        lines.append(f"{element.tag} {ends} {_describe_number(element, 'length', exact)}")
    return "".join(f"{line}\n" for line in lines)


def _describe_joint(joint: Element, with_fixed: bool) -> str:
    """Return type, nature and symbols of a joint, and its position if it never moves."""
    symbols = joint.find("symbols")
    present = [] if symbols is None else [tag for tag in SYMBOLS if symbols.find(tag) is not None]
    nature = _text(joint, "nature")
    never_moves = nature == "driven" and present == ["q"]
    position = _number(joint, "initialvalue/q") if never_moves and with_fixed else 0.0
    words = "all" if symbols is None else "".join(f"{tag}," for tag in present)
    return f"joint {_text(joint, 'type')} {nature} {words} {position + 0.0:.17g}"


def _describe_numbers(owner: Element, path: str, tags: tuple[str, ...], exact: bool) -> str:
    """Return the tags of the numbers that are neither zero nor a rounding of zero."""
    coordinates = owner.find(path)
    if coordinates is None:
        return ""
    values = {tag: _number(coordinates, tag) for tag in tags if coordinates.find(tag) is not None}
    threshold = ROUNDING * max(map(abs, values.values()), default=0.0)
    nonzero = {tag: value for tag, value in values.items() if abs(value) > threshold}
    return "".join(f" {tag}={value:.17g}" if exact else f" {tag}" for tag, value in nonzero.items())


def _describe_number(owner: Element, path: str, exact: bool) -> str:
    value = _number(owner, path)
    return f"{value + 0.0:.17g}" if exact else str(int(value != 0.0))


def _number(element: Element, path: str) -> float:
    return float(_text(element, path) or 0.0)


def _decode(model: bytes) -> str:
    """Return the text of an .mbs in any encoding of Python; ElementTree reads only a few."""
    stated = re.match(rb"""\s*<\?xml[^>]*?encoding\s*=\s*["']([\w.-]+)""", model)
    if model[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return model.decode("utf-16")
    return model.decode(stated[1].decode() if stated else "utf-8-sig")


def _text(element: Element, path: str) -> str:
    return (element.findtext(path) or "").strip()


def check_equations(project: Path, name: str) -> None:
    """End the program if equations that urdf2mbs has written are of another model."""
    model = Path(project, "dataR", name + ".mbs")
    files = sorted(Path(project, "symbolicR").glob("mbs_*_" + name + ".py"))
    data = model.read_bytes()
    stale = [file.name for file in files if fits(file.read_bytes(), data) is False]
    if stale:
        sys.exit(
            f"error: the equations in symbolicR are of another model than {model}: {stale[0]} and "
            f"{len(stale) - 1} more. Make them anew: urdf2mbs equations {model}"
        )
