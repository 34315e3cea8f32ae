"""The files that MBSysPad would generate: user_all_id.h, user_model.h and user_model.c."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from urdf2mbs.plugin import BASE, Mbs
from urdf2mbs_project.code import FOLDER, fill_template
from urdf2mbs_project.code.c_text import format_body
from urdf2mbs_project.simulation import STATE_MODELS, find_state_indices

NOTE = """\
/* urdf2mbs writes this file anew at each conversion: do not edit it.
 * MBSysPad can write it, too: menu "generate user files". */

"""
#: The kinds of elements that have a number, and the comment above each in user_all_id.h.
KINDS = {
    "joint": "joints",
    "body": "bodies, each the number of its last joint",
    "sensor": "sensors",
    "force": "external forces",
    "link": "links",
    "point": "points, as BODY_POINT",
}


class Identifier(NamedTuple):
    """The macro of an element in user_all_id.h."""

    word: str
    number: int


def assign_identifiers(mbs: Mbs) -> dict[str, dict[str, Identifier]]:
    """Return the identifiers of the elements, by kind and name.

    The kind is part of an identifier if the name is used already: a sensor often has the name of
    its link.  An element for which both are used has none.
    """
    numbers = mbs.numbers()
    points = [
        (name or BASE, point) for name, owner in mbs.base_and_bodies() for point in owner.points
    ]
    elements = {
        "joint": list(numbers.items()),
        "body": [(body.name, numbers[body.joints[-1].name]) for body in mbs.bodies],
        "sensor": _number(point.sensor.name for _, point in points if point.sensor is not None),
        "force": _number(point.extforce.name for _, point in points if point.extforce is not None),
        "link": _number(link.name for link in mbs.links if link.kind == "link"),
        "point": _number(f"{body}_{point.name}" for body, point in points),
    }
    identifiers: dict[str, dict[str, Identifier]] = {kind: {} for kind in elements}
    used_words: set[str] = set()
    for kind, numbered in elements.items():
        for name, number in numbered:
            word = f"{name}_{kind}_id" if f"{name}_id" in used_words else f"{name}_id"
            if word not in used_words:
                used_words.add(word)
                identifiers[kind][name] = Identifier(word, number)
    return identifiers


def _number(names: Iterable[str]) -> list[tuple[str, int]]:
    """Return names with their numbers, from 1."""
    return [(name, number) for number, name in enumerate(names, start=1)]


def generate_all_id(mbs: Mbs) -> str:
    """Return the text of user_all_id.h, with the numbers of all elements."""
    lines = [NOTE, "#ifndef USER_ALL_ID_h\n#define USER_ALL_ID_h\n"]
    for kind, identifiers in assign_identifiers(mbs).items():
        lines.append(f"\n/* {KINDS[kind]} */\n")
        lines += [f"#define {word} {number}\n" for word, number in identifiers.values()]
    return "".join([*lines, "\n#endif\n"])


def generate_model_header(mbs: Mbs) -> str:
    """Return the text of user_model.h, with the struct of the user models."""
    lines = [
        NOTE,
        "#ifndef USERMODEL_h\n#define USERMODEL_h\n\n"
        '#include "mbs_user_interface.h"\n\n'
        "struct UserModel\n{\n",
    ]
    models = [model for model in mbs.user_models if model.name not in STATE_MODELS]
    for model in models:
        fields = "".join(f"        double {parameter.name};\n" for parameter in model.parameters)
        lines.append(f"    struct {model.name} {{\n{fields}    }} {model.name};\n")
    if not models:
        lines.append("    double none; /* a struct of C requires a member */\n")
    return "".join([*lines, "};\n\n#endif\n"])


def generate_model_source(mbs: Mbs) -> str:
    """Return the text of user_model.c, which reads the numbers of user models by their names."""
    statements = [
        f"um->{model.name}.{parameter.name} =\n"
        f'    find_parameter(gen, "{model.name}", "{parameter.name}", 0)->value_list[0];'
        for model in mbs.user_models
        if model.name not in STATE_MODELS
        for parameter in model.parameters
    ]
    statements += [
        f'find_parameter(gen, "{model}", "{name}", {index});'
        for model in STATE_MODELS
        for name, index in find_state_indices(mbs, model).items()
    ]
    body = format_body("gen um", statements or ["(void) find_parameter;"])
    text = fill_template(FOLDER / "user_model.c.in", mbs.name)
    return NOTE + text.replace("@VALUES@\n", body)
