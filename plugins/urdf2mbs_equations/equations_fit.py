"""Whether the equations in symbolicR fit the .mbs.  Python's own library is enough to tell.

urdf2mbs asks this file, and writes it into a project, where workR/main.py asks it.

Equations rely on the tree of joints, on which numbers are zero, and on the positions of joints
that never move.  They read other masses, centres, inertias and points from the .mbs: a change of
these needs no new equations, and neither does a body that is moved in the diagram.
"""

from __future__ import annotations

import re
import sys
from hashlib import sha256
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, fromstring

# What a file of equations says of the models that it fits.
SAYS = re.compile(r"Fits \((.*)\): sha256 ([0-9a-f]{64})")

# A number this many times smaller than the largest beside it is a rounding of zero.
ROUNDING = 1e-15


def fits(equations: bytes, model: bytes) -> bool | None:
    """Whether a file of equations (bytes) fits a model (an .mbs, bytes); None: it does not say."""
    says = SAYS.search(equations[:2000].decode("utf-8", "replace"))
    return None if says is None else fingerprint(model, says[1]) == says[2]


def fingerprint(model: bytes, parts: str) -> str:
    """A checksum of what equations rely on: the tree; with 'fixed' in parts also where joints are
    that never move, with 'numbers' all numbers."""
    root = fromstring(_decoded(model))
    exact = "numbers" in parts
    bodies = {_text(body, "bodyname"): n for n, body in enumerate(root.iterfind("bodytree/body"))}
    owners = [*root.iterfind("base"), *root.iterfind("bodytree/body")]
    points = {
        (_text(owner, "bodyname") or "base", _text(point, "pointname")): n
        for owner in owners
        for n, point in enumerate(owner.iterfind("point"), start=1)
    }

    def place(element: Element, path: str) -> Any:
        """The numbers of a body and of a point: names do not count."""
        body, point = _text(element, f"{path}/bodyname"), _text(element, f"{path}/pointname")
        return bodies.get(body, body), points.get((body, point), 0)

    def numbers(element: Element, path: str) -> Any:
        found = element.find(path)
        tags = re.compile("I.." if path == "inertia" else "[xyz]")
        known = [] if found is None else [child for child in found if tags.fullmatch(child.tag)]
        values = {child.tag: float(child.text or 0.0) for child in known}
        least = ROUNDING * max(map(abs, values.values()), default=0.0)
        kept = {tag: value for tag, value in values.items() if abs(value) > least}
        return sorted(kept.items()) if exact else sorted(kept)

    def number(element: Element, path: str) -> Any:
        value = float(_text(element, path) or 0.0)
        return value if exact else value != 0.0

    def joint(element: Element) -> Any:
        symbols = element.find("symbols")
        kept = None if symbols is None else sorted(child.tag for child in symbols)
        nature = _text(element, "nature")
        never_moves = nature == "driven" and kept == ["q"]
        known = never_moves and parts != "tree"
        at = float(_text(element, "initialvalue/q") or 0.0) if known else 0.0
        return _text(element, "type"), nature, kept, at

    rows: list[Any] = [_text(root, "mbsname")]
    for owner in owners:
        rows += [place(owner, "parent"), [joint(child) for child in owner.iterfind("joint")]]
        rows += [number(owner, "mass"), numbers(owner, "com/coordinates")]
        rows += [numbers(owner, "inertia"), numbers(owner, "gravity/coordinates")]
        for point in owner.iterfind("point"):
            signals = [
                (child.tag, sorted(set(child.keys()) - {"name"}))
                for child in point
                if child.tag in ("sensor", "extforce")
            ]
            rows += [numbers(point, "coordinates"), signals]
    for element in (*root.iterfind("cuts/*"), *root.iterfind("links/*")):
        ends = place(element, "endpoint1"), place(element, "endpoint2")
        rows += [element.tag, ends, number(element, "length")]
    return sha256(repr(rows).encode()).hexdigest()


def _decoded(model: bytes) -> str:
    """The text of an .mbs, in any encoding that Python has (ElementTree reads few of them)."""
    says = re.match(rb"""\s*<\?xml[^>]*?encoding\s*=\s*["']([\w.-]+)""", model)
    if model[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return model.decode("utf-16")
    return model.decode(says[1].decode() if says else "utf-8-sig")


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
