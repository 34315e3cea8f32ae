"""Names that Robotran can work with.

The C code that is generated for a project uses the names of the file, so they must be
identifiers: a letter first, then letters, digits and ``_``.  Bodies, joints, sensors, external
forces, cuts and links share one name space; points have one per body, parameters one per user
model; user constraints, user models and user variables have one each.  Robotran drops
duplicates in silence.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Sequence
from typing import Any

from urdf2mbs.mbs.model import BASE, ORIGIN, Body, Connection, Joint, Mbs, Sensor
from urdf2mbs.messages.diagnostics import ConversionError, nearest

C_KEYWORDS = frozenset([
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else",
    "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register",
    "restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef",
    "union", "unsigned", "void", "volatile", "while",
    # of later standards, and of gcc
    "alignas", "alignof", "asm", "bool", "constexpr", "false", "nullptr", "static_assert",
    "thread_local", "true", "typeof", "typeof_unqual",
    # macros of gcc, and of the headers that user functions include
    "complex", "errno", "i386", "I", "linux", "unix", "stderr", "stdin", "stdout",
    "NULL", "EOF", "NAN", "INFINITY", "HUGE_VAL", "EXIT_FAILURE", "EXIT_SUCCESS", "RAND_MAX",
    "BUFSIZ", "FILENAME_MAX", "FOPEN_MAX", "MB_CUR_MAX", "math_errhandling", "TRUE", "FALSE",
    "M_E", "M_LOG2E", "M_LOG10E", "M_LN2", "M_LN10", "M_PI", "M_PI_2", "M_PI_4", "M_1_PI",
    "M_2_PI", "M_2_SQRTPI", "M_SQRT2", "M_SQRT1_2",
])  # fmt: skip

_GOOD = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII).fullmatch


def free_name(name: str, taken: Container[str], spelled: Callable[[str], str] = str) -> str:
    """``name``, or the first of ``name_2``, ``name_3``, ... that is not taken.

    ``spelled`` gives a name as ``taken`` holds it: ``str.lower`` where letter case does not count.
    """
    free, number = name, 1
    while spelled(free) in taken:
        number += 1
        free = f"{name}_{number}"
    return free


def identifiers(
    names: Sequence[str], reserved: Iterable[str] = (), suffix: str | Sequence[str] = ""
) -> list[str]:
    """An identifier for each name, in the same order, no two alike.

    A name that is good as it is keeps itself, before any other is changed: only the first
    of several equal ones, and none that is ``reserved`` or a word of C's own.  In the others
    each bad character becomes ``_``, a name that does not start with a letter gets ``n_``,
    and where that is taken, the ``suffix`` (one for all, or one for each) and then ``_2``, ``_3``,
    ... are appended.
    """
    suffixes = [suffix] * len(names) if isinstance(suffix, str) else suffix
    taken = {*C_KEYWORDS, *reserved}
    out = [""] * len(names)
    others: list[int] = []
    for index, name in enumerate(names):
        if name in taken or not _GOOD(name):
            others.append(index)
        else:
            taken.add(name)
            out[index] = name
    for index in others:
        new = re.sub("[^A-Za-z0-9_]", "_", names[index])
        if not _GOOD(new):
            new = f"n_{new}"
        if new in taken:
            new = free_name(new + suffixes[index], taken)
        taken.add(new)
        out[index] = new
    return out


def assign_identifiers(mbs: Mbs) -> tuple[dict[str, str], dict[str, str]]:
    """Give everything in ``mbs`` its final name, in place, and mend what refers to it.

    Joints take their names before sensors and external forces, these before cuts and links, and
    these before bodies: where a joint and a body are both called ``hip``, the body becomes
    ``hip_body``.  A user model's parameter that is called as a joint keeps to that joint's name.

    Returns the bodies' and the joints' new names by their old ones.
    """
    mbs.base.name = identifiers([mbs.base.name], (BASE, ORIGIN), "_ground")[0]
    _rename_points(mbs)

    points = [point for body in mbs.bodies for point in body.points]
    kinds: list[tuple[Sequence[Joint | Sensor | Connection | Body], str]] = [
        ([joint for body in mbs.bodies for joint in body.joints], "_joint"),
        ([point.sensor for point in points if point.sensor is not None], "_sensor"),
        ([point.extforce for point in points if point.extforce is not None], "_force"),
        (mbs.cuts, "_cut"),
        (mbs.links, "_link"),
        (mbs.bodies, "_body"),
    ]
    things = [(thing, suffix) for kind, suffix in kinds for thing in kind]
    old = [thing.name for thing, _ in things]
    final = identifiers(old, (BASE, ORIGIN, mbs.base.name), [suffix for _, suffix in things])
    names: dict[type, dict[str, str]] = {}
    for (thing, _), name in zip(things, final, strict=True):
        names.setdefault(type(thing), {}).setdefault(thing.name, name)
        thing.name = name
    body_names, joint_names = names.get(Body, {}), names.get(Joint, {})
    for body in mbs.bodies:
        if body.parent is not None:
            body.parent = body_names[body.parent]
    for connection, end in _ends(mbs):
        body_name, point_name = getattr(connection, end)
        if body_name is not None:
            who = f"{connection.kind} '{connection.name}'"
            setattr(connection, end, (_new(body_names, body_name, "body", who), point_name))
    for constraint in mbs.user_constraints:
        who = f"user constraint '{constraint.name}'"
        constraint.joints = tuple(
            _new(joint_names, name, "joint", who) for name in constraint.joints
        )
    for elements, suffix in (
        (mbs.user_constraints, "_constraint"),
        (mbs.user_models, "_model"),
        (mbs.user_variables, "_variable"),
    ):
        _rename_all(elements, [element.name for element in elements], suffix)
    for model in mbs.user_models:
        old = [joint_names.get(parameter.name, parameter.name) for parameter in model.parameters]
        _rename_all(model.parameters, old, "_parameter")
    return body_names, joint_names


def _ends(mbs: Mbs) -> list[tuple[Connection, str]]:
    """The ends of all cuts and links, by the names of their fields."""
    connections = (*mbs.cuts, *mbs.links)
    return [(connection, end) for connection in connections for end in ("endpoint1", "endpoint2")]


def _rename_all(
    things: Sequence[Any], names: list[str], suffix: str, reserved: Iterable[str] = ()
) -> None:
    """Give things of one name space identifiers made of these names."""
    for thing, name in zip(things, identifiers(names, reserved, suffix), strict=True):
        thing.name = name


def _new(names: dict[str, str], name: str, kind: str, who: str) -> str:
    """The new name of what somebody refers to; raises ConversionError if there is none such."""
    if name not in names:
        raise ConversionError(
            "name-unknown", f"{who} refers to {kind} '{name}', and the .mbs has none such",
            hint=nearest(name, names),
        )  # fmt: skip
    return names[name]


def _rename_points(mbs: Mbs) -> None:
    """Give points their final names; bodies still have their old ones."""
    final: dict[tuple[str | None, str | None], str] = {}
    for owner_name, owner in mbs.base_and_bodies():
        names = [point.name for point in owner.points]
        _rename_all(owner.points, names, "_point", (ORIGIN,))
        for name, point in zip(names, owner.points, strict=True):
            final.setdefault((owner_name, name), point.name)
    for body in mbs.bodies:
        body.point = final.get((body.parent, body.point))
    for connection, end in _ends(mbs):
        body_name, point_name = key = getattr(connection, end)
        if point_name is not None and key not in final:
            raise ConversionError(
                "name-unknown",
                f"{connection.kind} '{connection.name}' refers to point '{point_name}' of "
                f"{'the base' if body_name is None else f'body {body_name!r}'}, which has "
                "none such",
                hint=nearest(point_name, [p for b, p in final if b == body_name and p]),
            )
        setattr(connection, end, (body_name, final.get(key)))
