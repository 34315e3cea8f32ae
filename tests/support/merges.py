"""Merges of an edited ``.mbs`` with a new conversion."""

from typing import Any

from lxml import etree

from support.edits import Edit
from support.folders import SHARED
from support.mbs_models import everything
from urdf2mbs.mbs.model import Body, Mbs
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.diff.changes import find_differences
from urdf2mbs_edits.merge.merge import Merged, merge


def merged(mine: Edit, theirs: Edit, prefer: Any = "urdf") -> tuple[Mbs, Merged]:
    """Merge an edit with a change of the URDF, or of another file (prefer None)."""
    sides = [read_mbs(write(everything()), "m.mbs") for _ in range(2)]
    mine(sides[1])
    new = everything()
    theirs(new)
    new = new if prefer else read_mbs(write(new), "m.mbs")
    edited = write(sides[1]).replace(b"<box>", b"<box><!-- mine -->")
    result = merge(sides[0], read_mbs(edited, "m.mbs"), new, prefer)
    assert (result.data == edited) is (not result.plan.updated)
    return read_mbs(result.data, "m.mbs"), result


def nothing(mbs: Mbs) -> None:
    pass


def new_body_takes_a_joint(mbs: Mbs) -> None:
    mbs.bodies.append(Body("foot", "leg", None, [mbs.bodies[0].joints.pop(0)]))


def canonical(element: etree._Element) -> object:
    """All that an element says, comments included, without white space."""
    tag = element.tag if isinstance(element.tag, str) else "?"
    return (
        tag,
        (element.text or "").strip(),
        (element.tail or "").strip(),
        sorted(element.items()),
        [canonical(child) for child in element],
    )


SAMPLES = sorted((SHARED / "mbs-samples").glob("*.mbs"))


def three(base: bytes, ours: bytes, theirs: bytes) -> Merged:
    return merge(read_mbs(base, "base"), read_mbs(ours, "ours"), read_mbs(theirs, "theirs"), None)


def differ(first: bytes, second: bytes) -> list[Any]:
    return find_differences(read_mbs(first, "one"), read_mbs(second, "two")).changes


def list_conflicts(done: Merged) -> list[Any]:
    return [*done.plan.conflicts, *done.plan.orphaned]


def check_one_side_alone(base: bytes, changed: bytes) -> None:
    for ours, theirs in ((changed, base), (base, changed), (changed, changed)):
        done = three(base, ours, theirs)
        assert not list_conflicts(done), done.plan
        assert not differ(done.data, changed)
        assert done.data == ours or ours == base
