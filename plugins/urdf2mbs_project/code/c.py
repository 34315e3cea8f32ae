"""The generated files of a project in C: the statements of NAME_robot.c, the tables, and what
MBSysPad would generate."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from math import cos, sin

from urdf2mbs.plugin import BASE, IDENTITY, Mbs, UserModel, quoted
from urdf2mbs_project.code import FOLDER, dependent, fill
from urdf2mbs_project.simulation import (
    CONTACT_STATES,
    JOINT_STATES,
    WRENCH,
    Simulation,
    Spot,
    contact_state,
    force_of,
    state_numbers,
)

NOTE = (
    "/* urdf2mbs writes this file anew at each conversion: do not edit it.\n"
    " * MBSysPad can write it, too: menu \"generate user files\". */\n\n"
)  # fmt: skip

#: The user models that are states, which C finds in ux, not in the struct of the user models.
STATES = (JOINT_STATES, CONTACT_STATES)

#: What a function may use: it is declared where a statement names it.
LOCALS = {
    "user_model": "const UserModel *user_model = mbs_data->user_model;",
    **{name: f"double *{name} = mbs_data->{name};" for name in ("q", "qd", "qdd", "q0", "Qq")},
}
#: A law of a point at which another force acts.
ADDED = """\
{{
    double more[7] = {{0.0}};
    {}
    for (int i = 1; i <= 6; i++) {{
        force[i] += more[i];
    }}
}}"""
GROUND = ("ground", "stiffness", "speed", "friction", "bristle", "bristle_time")


def generated(mbs: Mbs, simulation: Simulation) -> dict[str, bytes]:
    """The files that are written anew at each conversion, by their name in userfctR."""
    header = fill(FOLDER / "NAME_robot.h.in", mbs.name)
    header = header.replace("@COUNT@", str(len(simulation.couplings)))
    header = header.replace("@TIME_STEP@", repr(simulation.time_step))
    header = header.replace("@SHORTENED_BY@", _comment(simulation.shortened_by))
    texts = {
        f"{mbs.name}_robot.h": header,
        f"{mbs.name}_robot.c": _Robot(mbs, simulation).source(),
        f"{mbs.name}_laws.h": fill(FOLDER / "NAME_laws.h", mbs.name),
        f"{mbs.name}_tables.h": _tables(mbs, simulation),
        "user_all_id.h": NOTE + _all_id(mbs),
        "user_model.h": NOTE + _model_header([m for m in mbs.user_models if m.name not in STATES]),
        "user_model.c": NOTE + _model_source(mbs),
    }
    return {name: text.encode() for name, text in texts.items()}


# --- NAME_robot.c ---


class _Robot:
    """The statements of a robot's functions, as a user of Robotran writes them."""

    def __init__(self, mbs: Mbs, simulation: Simulation) -> None:
        self.mbs, self.simulation = mbs, simulation
        self.ids = _ids(mbs)
        self.models = {model.name: [p.name for p in model.parameters] for model in mbs.user_models}

    def source(self) -> str:
        couplings = self.simulation.couplings
        laws = [f"{law.c.strip()}\n\n" for law in self.simulation.laws]
        needs_user_models = str(int(bool(self.models)))
        text = fill(FOLDER / "NAME_robot.c.in", self.mbs.name).replace("@LAWS@\n", "".join(laws))
        text = text.replace("@NEEDS_USER_MODELS@", needs_user_models)
        for name, parameters, statements in (
            ("CONSTRAINTS", "h Jac mbs_data", self.constraints()),
            ("JDQD", "jdqd", (f"jdqd[{k}] = 0.0;" for k in range(1, len(couplings) + 1))),
            ("DRIVEN", "mbs_data", self.driven()),
            ("JOINT_FORCES", "mbs_data", self.joint_forces()),
            ("EFFORTS", "mbs_data joint push", self.efforts()),
            ("EXTERNAL_FORCES", "PxF RxF VxF OMxF mbs_data tsim ixF", self.external_forces()),
            ("LINK_FORCES", "Z Zd mbs_data ilnk", self.link_forces()),
            ("SENSORS", "sensor isens mbs_data force turn", self.sensors()),
        ):
            text = text.replace(f"@{name}@\n", _body(parameters, statements))
        return text

    def value(self, model: str, name: str, otherwise: str = "0.0") -> str:
        """A number of the user models, where it is there."""
        there = name in self.models.get(model, ())
        return f"user_model->{model}.{name}" if there else otherwise

    def constraints(self) -> Iterator[str]:
        for k, c in enumerate(self.simulation.couplings, start=1):
            one, two = f"{c.follower.name}_id", f"{c.leader.name}_id"
            yield f"h[{k}] = q[{one}]{_plus(-c.multiplier, f' * q[{two}]')}{_plus(-c.offset)};"
            yield f"Jac[{k}][{one}] = 1.0;"
            yield f"Jac[{k}][{two}] = {-c.multiplier + 0.0!r};"

    def driven(self) -> Iterator[str]:
        for c in self.simulation.driven:
            for x, offset in (("q", _plus(c.offset)), ("qd", ""), ("qdd", "")):
                rule = f"{c.multiplier!r} * {x}[{c.leader.name}_id]{offset}"
                yield f"{x}[{c.follower.name}_id] = {rule};"

    def joint_forces(self) -> Iterator[str]:
        value = self.value
        yield from self.law("damping", "damping", (
            f"Qq[{name}_id] -= {value('damping', name)} * qd[{name}_id];"
            for name in self.models.get("damping", ())
        ))  # fmt: skip
        yield from self.law("springs", "spring_stiffness", (
            f"Qq[{name}_id] -= {value('spring_stiffness', name)}\n"
            f"    * (q[{name}_id] - {value('spring_reference', name)});"
            for name in self.models.get("spring_stiffness", ())
        ))  # fmt: skip
        time = value("joint_forces", "friction_time")
        yield from self.law("friction", "friction", (
            f"Qq[{name}_id] -= rub(mbs_data, {state}, qd[{name}_id], {value('friction', name)},\n"
            f"    {value('friction_stiffness', name)}, {time});"
            for name, state in state_numbers(self.mbs, JOINT_STATES).items()
        ))  # fmt: skip
        speed = value("joint_forces", "stop_speed")
        yield from self.law("stops", "stop_stiffness", (
            f"Qq[{name}_id] -= stops(q[{name}_id], qd[{name}_id],\n"
            f"    {value('q_min', name, '-INFINITY')}, {value('q_max', name, 'INFINITY')},\n"
            f"    {value('stop_stiffness', name)}, {speed});"
            for name in self.models.get("stop_stiffness", ())
        ))  # fmt: skip
        yield from self.law("on", "hold_stiffness", (
            f"Qq[{name}_id] += within({value('effort', name)},\n"
            f"    {value('hold_stiffness', name)} * (q0[{name}_id] - q[{name}_id])\n"
            f"    - {value('hold_damping', name)} * qd[{name}_id]);"
            for name in self.models.get("hold_stiffness", ())
        ), "hold")  # fmt: skip
        for law in self.simulation.laws:
            for joint in law.joints:
                yield f"Qq[{joint.name}_id] += {law.name}(mbs_data, {joint.name}_id);"

    def law(
        self, switch: str, model: str, statements: Iterable[str], of: str = "joint_forces"
    ) -> Iterator[str]:
        """The statements of a law of joints, which a number of the user models switches on."""
        if switch in self.models.get(of, ()) and model in self.models:
            yield f"if (user_model->{of}.{switch} != 0.0) {{"
            yield from map(_indented, statements)
            yield "}"

    def efforts(self) -> Iterator[str]:
        yield from self.switch("joint", "joint", {
            name: [f"return within({self.value('effort', name)}, push);"]
            for name in self.models.get("effort", ())
        }, "return push;")  # fmt: skip

    def external_forces(self) -> Iterator[str]:
        cases: dict[str, list[str]] = {}
        for contact in self.simulation.contacts:
            name = force_of(contact.point)
            call = f"ground_force(&{name}, &ground, PxF, RxF, VxF, OMxF, mbs_data, force);"
            cases.setdefault(name, []).append(call)
        for wrench in self.simulation.wrenches:
            start, stop, *parts = (
                self.value(wrench.model.name, part) for part in ("start", "stop", *WRENCH)
            )
            cases.setdefault(force_of(wrench.point), []).extend([
                f"if ({start} <= tsim && tsim < {stop}) {{",
                *(f"    force[{k}] = {part};" for k, part in enumerate(parts, start=1)),
                "}",
            ])  # fmt: skip
        for law in self.simulation.laws:
            for point in law.points:
                statements = cases.setdefault(force_of(point), [])
                to = "more" if statements else "force"
                call = f"{law.name}(PxF, VxF, mbs_data, tsim, ixF, {to});"
                statements += ADDED.format(call).splitlines() if statements else [call]
        if self.simulation.contacts:
            yield "const Ground ground = {"
            yield from (f"    .{name} = {self.value('contact', name)}," for name in GROUND)
            yield "};\n"
        yield "for (int i = 1; i <= 6; i++) {\n    force[i] = 0.0;\n}"
        broken = {name: [*statements, "break;"] for name, statements in cases.items()}
        yield from self.switch("ixF", "force", broken, "break;" if cases else "")

    def link_forces(self) -> Iterator[str]:
        yield from self.switch("ilnk", "link", {
            link.name: [
                f"return {self.value('link_stiffness', link.name)}\n"
                f"    * (Z - {self.value('link_length', link.name)})\n"
                f"    + {self.value('link_damping', link.name)} * Zd;"
            ]
            for link in self.simulation.springs
        }, "return 0.0;")  # fmt: skip

    def sensors(self) -> Iterator[str]:
        cases = {
            s.point.sensor.name: [f"axes = {s.point.sensor.name}_axes;", "break;"]
            for s in self.simulation.sensors
            if s.point.sensor is not None
        }
        yield "const double *axes = of_body;\n"
        yield from self.switch("isens", "sensor", cases, "break;" if cases else "")
        yield "read_imu(sensor, axes, mbs_data->g, force, turn);"

    def switch(
        self, number: str, kind: str, cases: dict[str, list[str]], otherwise: str
    ) -> Iterator[str]:
        """What is done for each number of a kind of things, by their names."""
        if cases:
            yield f"switch ({number}) {{"
            for name, statements in cases.items():
                yield f"case {self.ids[kind][name][0]}:"
                yield from map(_indented, statements)
            yield f"default:\n    {otherwise}\n}}"
        elif otherwise:
            yield otherwise


def _body(parameters: str, statements: Iterable[str]) -> str:
    """The inside of a function: declarations of what it uses, and what it does not use."""
    text = "".join(f"{_indented(statement)}\n" for statement in statements)
    code = re.sub(r'"[^"]*"', "", text)
    used = set(re.findall(r"(?<![.>])\b\w+", code))  # no members of structs
    declared = "".join(f"    {LOCALS[name]}\n" for name in LOCALS if name in used)
    used |= set(re.findall(r"\w+", declared))
    unused = "".join(f"    (void) {name};\n" for name in parameters.split() if name not in used)
    return declared + ("\n" if declared else "") + unused + text


def _indented(text: str) -> str:
    return re.sub(r"(?m)^(?=.)", "    ", text)


def _plus(number: float, times: str = "") -> str:
    """A term of a sum; nothing where it is zero."""
    return f" {'-' if number < 0.0 else '+'} {abs(number)!r}{times}" if number else ""


# --- NAME_tables.h ---


def _tables(mbs: Mbs, simulation: Simulation) -> str:
    """Where bodies touch the ground, the axes of sensors, and the names of joints."""
    across = ", ".join(f"{{{_row(way)}}}" for way in simulation.across)
    out = [
        f"/* The tables of {mbs.name}_robot.c; {mbs.name}_laws.h has their types.\n"
        " *\n * urdf2mbs writes this file anew at each conversion: do not edit it. */\n\n"
        "/* Against gravity, and two directions in the ground, in the axes of the base. */\n"
        f"static const double up[3] = {{{_row(simulation.up)}}};\n"
        f"static const double across[2][3] = {{{across}}};\n\n"
    ]
    first = contact_state(mbs)
    for k, contact in enumerate(simulation.contacts):
        name = force_of(contact.point)
        out.append(f"/* {_comment(', '.join(contact.links))} */\n")
        out.append(_list("Spot", f"{name}_spots", map(_spot, contact.spots)))
        numbers = f"{len(contact.spots)}, {first + 3 * k}, {contact.bound!r}"
        out.append(f"static const Contact {name} = {{{name}_spots, {numbers}}};\n\n")
    out.append("/* The axes of sensors in their bodies, row by row. */\n")
    for sensor in simulation.sensors:
        if sensor.point.sensor is not None:
            of = f"{sensor.point.sensor.name}_axes[9]"
            out.append(f"static const double {of} = {{{_row(sensor.rotation)}}};\n")
    joints = (f'"{name}"' for name in ("ground", *mbs.numbers()))
    return "".join([
        *out,
        f"static const double of_body[9] = {{{_row(IDENTITY)}}};\n\n",
        "/* The joints by Robotran's number; those that follow from the constraints. */\n",
        _list("char *const", "joints", joints),
        f'static const char dependent[] = "{" ".join(dependent(mbs))}";\n',
    ])  # fmt: skip


def _spot(spot: Spot) -> str:
    axis = f", .axis = {{{_row(spot.axis)}}}" if any(spot.axis) else ""
    forth, aside = spot.radius * cos(spot.turn), spot.radius * sin(spot.turn)
    rim = f", .rim = {{{_row((forth, aside))}}}" if spot.radius else ""
    return f"{{.at = {{{_row(spot.at)}}}{axis}{rim}}}"


def _list(kind: str, name: str, rows: Iterable[str]) -> str:
    lines = "".join(f"    {row},\n" for row in rows)
    return f"static const {kind} {name}[] = {{\n{lines}}};\n\n"


def _row(numbers: Iterable[float]) -> str:
    return ", ".join(repr(number + 0.0) for number in numbers)


def _comment(text: str) -> str:
    return quoted(text).replace("*/", "* /").replace("/*", "/ *")


# --- what MBSysPad would generate ---


#: The kinds of things that have a number, and what user_all_id.h says above each.
KINDS = {
    "joint": "joints", "body": "bodies, each the number of its last joint", "sensor": "sensors",
    "force": "external forces", "link": "links", "point": "points, as BODY_POINT",
}  # fmt: skip


def _all_id(mbs: Mbs) -> str:
    out = ["#ifndef USER_ALL_ID_h\n#define USER_ALL_ID_h\n"]
    for kind, ids in _ids(mbs).items():
        out.append(f"\n/* {KINDS[kind]} */\n")
        out += [f"#define {word} {number}\n" for word, number in ids.values()]
    return "".join([*out, "\n#endif\n"])


def _ids(mbs: Mbs) -> dict[str, dict[str, tuple[str, int]]]:
    """What each thing is called in user_all_id.h, by its kind and name, and its number.

    The kind stands behind a name that another thing has: a sensor is often called as its link.
    """
    numbers = mbs.numbers()
    points = [
        (name or BASE, point) for name, owner in mbs.base_and_bodies() for point in owner.points
    ]
    named = {
        "joint": list(numbers.items()),
        "body": [(body.name, numbers[body.joints[-1].name]) for body in mbs.bodies],
        "sensor": _numbered(p.sensor.name for _, p in points if p.sensor is not None),
        "force": _numbered(p.extforce.name for _, p in points if p.extforce is not None),
        "link": _numbered(link.name for link in mbs.links if link.kind == "link"),
        "point": _numbered(f"{body}_{point.name}" for body, point in points),
    }
    ids: dict[str, dict[str, tuple[str, int]]] = {kind: {} for kind in named}
    taken: set[str] = set()
    for kind, things in named.items():
        for name, number in things:
            word = f"{name}_{kind}_id" if f"{name}_id" in taken else f"{name}_id"
            if word not in taken:
                taken.add(word)
                ids[kind][name] = word, number
    return ids


def _numbered(names: Iterable[str]) -> list[tuple[str, int]]:
    return [(name, number) for number, name in enumerate(names, start=1)]


def _model_header(models: list[UserModel]) -> str:
    out = [
        "#ifndef USERMODEL_h\n#define USERMODEL_h\n\n"
        '#include "mbs_user_interface.h"\n\n'
        "struct UserModel\n{\n"
    ]
    for model in models:
        fields = "".join(f"        double {p.name};\n" for p in model.parameters)
        out.append(f"    struct {model.name} {{\n{fields}    }} {model.name};\n")
    if not models:
        out.append("    double none; /* a struct of C wants a member */\n")
    return "".join([*out, "};\n\n#endif\n"])


def _model_source(mbs: Mbs) -> str:
    """Return the text of user_model.c, which reads the numbers of user models by their names."""
    statements = [
        f"um->{model.name}.{parameter.name} =\n"
        f'    find_parameter(gen, "{model.name}", "{parameter.name}", 0)->value_list[0];'
        for model in mbs.user_models
        if model.name not in STATES
        for parameter in model.parameters
    ]
    statements += [
        f'find_parameter(gen, "{kind}", "{name}", {number});'
        for kind in STATES
        for name, number in state_numbers(mbs, kind).items()
    ]
    body = _body("gen um", statements or ["(void) find_parameter;"])
    return fill(FOLDER / "user_model.c.in", mbs.name).replace("@VALUES@\n", body)
