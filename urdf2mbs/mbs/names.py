"""Names that Robotran can work with.

The C code that is generated for a project uses the names of the file, so they must be identifiers:
a letter first, then letters, digits and ``_``.  Robotran drops duplicates silently.  The name
spaces are:

* bodies, joints, sensors, external forces, cuts and links together;
* the points of each body;
* the parameters of each user model;
* user constraints; user models; user variables.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Sequence
from typing import Any

from urdf2mbs.mbs.model import BASE, ORIGIN, Body, Connection, Joint, Mbs, Sensor
from urdf2mbs.messages.diagnostics import ConversionError, nearest

_C_KEYWORDS = """
    auto break case char const continue default do double else enum extern float for goto if inline
    int long register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile while
"""
#: Of later standards, and of gcc.
_NEW_KEYWORDS = """
    alignas alignof asm bool constexpr false nullptr static_assert thread_local true typeof
    typeof_unqual
"""
#: Of gcc, and of the headers that user functions include.
_MACROS = """
    complex errno i386 I linux unix stderr stdin stdout NULL EOF NAN INFINITY HUGE_VAL EXIT_FAILURE
    EXIT_SUCCESS RAND_MAX BUFSIZ FILENAME_MAX FOPEN_MAX MB_CUR_MAX math_errhandling TRUE FALSE
    M_E M_LOG2E M_LOG10E M_LN2 M_LN10 M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI M_2_SQRTPI M_SQRT2 M_SQRT1_2
"""
#: Words that cannot be names in the code of user functions.
C_KEYWORDS = frozenset(f"{_C_KEYWORDS} {_NEW_KEYWORDS} {_MACROS}".split())

_is_identifier = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII).fullmatch


def free_name(name: str, names: Container[str], normalize: Callable[[str], str] = str) -> str:
    """Return a name, or the first of ``name_2``, ``name_3``, ... that is not yet used.

    Args:
        name: The name.
        names: The names that are used, normalized.
        normalize: Normalizes a name, as ``str.lower`` where letter case is ignored.
    """
    candidate, suffix_number = name, 1
    while normalize(candidate) in names:
        suffix_number += 1
        candidate = f"{name}_{suffix_number}"
    return candidate


def identifiers(
    names: Sequence[str], reserved: Iterable[str] = (), suffix: str | Sequence[str] = ""
) -> list[str]:
    """Make an identifier of each name, no two alike.

    A name that is an identifier stays as it is, before any other is changed.  Of several equal
    ones only the first stays, and none that is ``reserved`` or a keyword of C.  In the others each
    bad character becomes ``_``, and a name that does not start with a letter gets the prefix
    ``n_``.  If the result is used already, the suffix and then ``_2``, ``_3``, ... are appended.

    Args:
        names: The names.
        reserved: Names that none may get.
        suffix: A suffix for all names, or one for each.

    Returns:
        The identifiers, in the order of the names.
    """
    suffixes = [suffix] * len(names) if isinstance(suffix, str) else suffix
    used_names = {*C_KEYWORDS, *reserved}
    new_names = [""] * len(names)
    changed_indices: list[int] = []
    for index, name in enumerate(names):
        if name in used_names or not _is_identifier(name):
            changed_indices.append(index)
        else:
            used_names.add(name)
            new_names[index] = name
    for index in changed_indices:
        identifier = re.sub("[^A-Za-z0-9_]", "_", names[index])
        if not _is_identifier(identifier):
            identifier = f"n_{identifier}"
        if identifier in used_names:
            identifier = free_name(identifier + suffixes[index], used_names)
        used_names.add(identifier)
        new_names[index] = identifier
    return new_names


def assign_identifiers(mbs: Mbs) -> tuple[dict[str, str], dict[str, str]]:
    """Give every element its final name, in place, and update all references to it.

    Joints get their names before sensors and external forces, these before cuts and links, and
    these before bodies: where a joint and a body are both called ``hip``, the body becomes
    ``hip_body``.  A parameter of a user model that is called as a joint gets this joint's name.

    Returns:
        The new names of bodies, and those of joints, by their old names.

    Raises:
        ConversionError: ``name-unknown``: an element refers to another that does not exist.
    """
    mbs.base.name = identifiers([mbs.base.name], (BASE, ORIGIN), "_ground")[0]
    _rename_points(mbs)
    body_names, joint_names = _rename_shared(mbs)
    _update_references(mbs, body_names, joint_names)
    _rename_elements(mbs.user_constraints, "_constraint")
    _rename_elements(mbs.user_models, "_model")
    _rename_elements(mbs.user_variables, "_variable")
    for model in mbs.user_models:
        for parameter in model.parameters:
            parameter.name = joint_names.get(parameter.name, parameter.name)
        _rename_elements(model.parameters, "_parameter")
    return body_names, joint_names


def _rename_elements(elements: Sequence[Any], suffix: str, reserved: Iterable[str] = ()) -> None:
    """Give the elements of one name space identifiers."""
    names = [element.name for element in elements]
    for element, new_name in zip(elements, identifiers(names, reserved, suffix), strict=True):
        element.name = new_name


def _rename_points(mbs: Mbs) -> None:
    """Give points their final names, and update references to them; bodies have their old names.

    Raises:
        ConversionError: ``name-unknown``.
    """
    new_names: dict[tuple[str | None, str | None], str] = {}
    for owner_name, owner in mbs.base_and_bodies():
        old_names = [point.name for point in owner.points]
        _rename_elements(owner.points, "_point", (ORIGIN,))
        for old_name, point in zip(old_names, owner.points, strict=True):
            new_names.setdefault((owner_name, old_name), point.name)
    for body in mbs.bodies:
        body.point = new_names.get((body.parent, body.point))
    for connection, end_field in _list_ends(mbs):
        body_name, point_name = key = getattr(connection, end_field)
        if point_name is not None and key not in new_names:
            owner_label = "the base" if body_name is None else f"body '{body_name}'"
            message = (
                f"{connection.kind} '{connection.name}' refers to point '{point_name}', "
                f"which {owner_label} does not have"
            )
            point_names = [point for body, point in new_names if body == body_name and point]
            raise ConversionError("name-unknown", message, hint=nearest(point_name, point_names))
        setattr(connection, end_field, (body_name, new_names.get(key)))


def _rename_shared(mbs: Mbs) -> tuple[dict[str, str], dict[str, str]]:
    """Give the elements of the common name space their final names.

    Returns:
        The new names of bodies, and those of joints, by their old names.
    """
    points = [point for body in mbs.bodies for point in body.points]
    name_groups: list[tuple[Sequence[Joint | Sensor | Connection | Body], str]] = [
        ([joint for body in mbs.bodies for joint in body.joints], "_joint"),
        ([point.sensor for point in points if point.sensor is not None], "_sensor"),
        ([point.extforce for point in points if point.extforce is not None], "_force"),
        (mbs.cuts, "_cut"),
        (mbs.links, "_link"),
        (mbs.bodies, "_body"),
    ]
    elements = [element for group_elements, _ in name_groups for element in group_elements]
    suffixes = [suffix for group_elements, suffix in name_groups for _ in group_elements]
    old_names = [element.name for element in elements]
    new_names = identifiers(old_names, (BASE, ORIGIN, mbs.base.name), suffixes)
    new_names_by_type: dict[type, dict[str, str]] = {}
    for element, name in zip(elements, new_names, strict=True):
        new_names_by_type.setdefault(type(element), {}).setdefault(element.name, name)
        element.name = name
    return new_names_by_type.get(Body, {}), new_names_by_type.get(Joint, {})


def _update_references(mbs: Mbs, body_names: dict[str, str], joint_names: dict[str, str]) -> None:
    """Update the references of bodies, cuts, links and user constraints.

    Args:
        mbs: The model, its elements already renamed.
        body_names: The new names of bodies by their old ones.
        joint_names: The new names of joints by their old ones.

    Raises:
        ConversionError: ``name-unknown``.
    """
    for body in mbs.bodies:
        if body.parent is not None:
            body.parent = body_names[body.parent]
    for connection, end_field in _list_ends(mbs):
        body_name, point_name = getattr(connection, end_field)
        if body_name is not None:
            referrer = f"{connection.kind} '{connection.name}'"
            body_name = _get_new_name(body_names, body_name, f"{referrer} refers to body")
            setattr(connection, end_field, (body_name, point_name))
    for constraint in mbs.user_constraints:
        referrer = f"user constraint '{constraint.name}'"
        constraint.joints = tuple(
            _get_new_name(joint_names, joint_name, f"{referrer} refers to joint")
            for joint_name in constraint.joints
        )


def _list_ends(mbs: Mbs) -> list[tuple[Connection, str]]:
    """List the ends of all cuts and links, by the names of their fields."""
    connections = (*mbs.cuts, *mbs.links)
    return [
        (connection, end_field)
        for connection in connections
        for end_field in ("endpoint1", "endpoint2")
    ]


def _get_new_name(new_names: dict[str, str], old_name: str, reference: str) -> str:
    """Return the new name of an element that another refers to; raise an error if it has none."""
    if old_name not in new_names:
        message = f"{reference} '{old_name}', which the .mbs does not have"
        raise ConversionError("name-unknown", message, hint=nearest(old_name, new_names))
    return new_names[old_name]
