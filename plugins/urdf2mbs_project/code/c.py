"""The generated files of a project in C: the tables and the code of NAME_robot.c, and what
MBSysPad would generate."""

from __future__ import annotations

from collections.abc import Iterable

from urdf2mbs.mbs.model import BASE, Mbs, UserModel
from urdf2mbs.messages.diagnostics import quoted
from urdf2mbs.spatial import IDENTITY
from urdf2mbs_project.code import FOLDER, fill
from urdf2mbs_project.code.python import dependent, force_of
from urdf2mbs_project.simulation import (
    CONTACT_STATES,
    JOINT_STATES,
    Coupling,
    Simulation,
    Wrench,
    state_numbers,
)

NOTE = (
    "/* urdf2mbs writes this file anew at each conversion: do not edit it.\n"
    " * MBSysPad can write it, too: menu \"generate user files\". */\n\n"
)  # fmt: skip

#: The user models that are states, which C finds in ux, not in the struct of the user models.
STATES = (JOINT_STATES, CONTACT_STATES)

#: The numbers of joint forces, a ground and a wrench, by their names in the user models.
SWITCHES = ("damping", "springs", "friction", "friction_time", "stops", "stop_speed")
GROUND = ("ground", "stiffness", "speed", "friction", "bristle", "bristle_time")
WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def generated(mbs: Mbs, simulation: Simulation) -> dict[str, bytes]:
    """The files that are written anew at each conversion, by their name in userfctR."""
    header = fill(FOLDER / "NAME_robot.h.in", mbs.name)
    header = header.replace("@COUNT@", str(len(simulation.couplings)))
    header = header.replace("@TIME_STEP@", repr(simulation.time_step))
    header = header.replace("@SHORTENED_BY@", _comment(simulation.shortened_by))
    texts = {
        f"{mbs.name}_robot.h": header,
        f"{mbs.name}_robot.c": fill(FOLDER / "NAME_robot.c", mbs.name),
        f"{mbs.name}_tables.h": _tables(mbs, simulation),
        "user_all_id.h": NOTE + _all_id(mbs),
        "user_model.h": NOTE + _model_header([m for m in mbs.user_models if m.name not in STATES]),
        "user_model.c": NOTE + _model_source(mbs.user_models),
    }
    return {name: text.encode() for name, text in texts.items()}


# --- NAME_tables.h ---


def _tables(mbs: Mbs, simulation: Simulation) -> str:
    """The tables that NAME_robot.c declares the types of."""
    numbers = _Numbers(mbs)
    place, rows = numbers.place, numbers.rows
    sensors = [
        (f"{s.point.sensor.name}_id", f"{{{_row(s.rotation)}}}", f"/* {_comment(s.name)} */")
        for s in simulation.sensors
        if s.point.sensor is not None
    ]
    switches = ", ".join(place("joint_forces", name) for name in SWITCHES)
    ground = ", ".join(place("contact", name) for name in GROUND)
    return "".join(
        [
            f"/* The tables of {mbs.name}_robot.c, which says what they mean.\n"
            " * urdf2mbs writes this file anew at each conversion: do not edit it. */\n\n",
            _table("Coupling", "couplings", map(_coupling, simulation.couplings)),
            _table("Coupling", "driven", map(_coupling, simulation.driven)),
            f"static const Switches joint_forces = {{{switches}}};\n",
            f"static const size_t hold_on = {place('hold', 'on')};\n\n",
            _table("Damping", "dampings", rows("damping")),
            _table("JointSpring", "joint_springs", rows("spring_stiffness", "spring_reference")),
            _table("Friction", "frictions", numbers.frictions(state_numbers(mbs, JOINT_STATES))),
            _table("Stop", "stops", numbers.stops()),
            _table("Hold", "holds", rows("hold_stiffness", "hold_damping")),
            _table("Effort", "efforts", rows("effort")),
            f"static const double up[3] = {{{_row(simulation.up)}}};\n",
            f"static const double across[6] = {{{_row(sum(simulation.across, ()))}}};\n",
            f"static const Ground ground = {{{ground}}};\n\n",
            _contacts(mbs, simulation),
            _table("Wrench", "wrenches", map(numbers.wrench, simulation.wrenches)),
            _table("Spring", "springs", rows("link_stiffness", "link_length", "link_damping")),
            _table("Sensor", "sensors", sensors, f"{{0, {{{_row(IDENTITY)}}}}}"),
            _laws(simulation),
            "/* The joints by Robotran's number; those that follow from the constraints. */\n",
            _names("joints", ["ground", *mbs.numbers()]),
            _names("dependent", dependent(mbs)),
        ]
    )


class _Numbers:
    """The rows of tables that name numbers of the user models."""

    def __init__(self, mbs: Mbs) -> None:
        self.models = {model.name: [p.name for p in model.parameters] for model in mbs.user_models}

    def place(self, model: str, name: str) -> str:
        """Where a number of the user models is in their struct."""
        return f"AT({model}.{name})" if name in self.models.get(model, ()) else "NONE"

    def rows(self, model: str, *more: str) -> list[tuple[str, ...]]:
        """A row for each joint or link of a user model, with its number there and in more."""
        names = self.models.get(model, ())
        return [(f"{name}_id", *(self.place(m, name) for m in (model, *more))) for name in names]

    def frictions(self, states: dict[str, int]) -> list[tuple[str, ...]]:
        """The joints that have friction, each with the number of its state."""
        return [
            (f"{name}_id", self.place("friction", name), self.place("friction_stiffness", name),
             str(state))
            for name, state in states.items()
        ]  # fmt: skip

    def stops(self) -> list[tuple[str, ...]]:
        """The limits that stop a joint."""
        return [
            (f"{name}_id", side, self.place(limit, name), self.place("stop_stiffness", name))
            for name in self.models.get("stop_stiffness", ())
            for side, limit in (("1.0", "q_max"), ("-1.0", "q_min"))
            if name in self.models.get(limit, ())
        ]

    def wrench(self, wrench: Wrench) -> tuple[str, ...]:
        """A force, when it acts, and its parts."""
        start, stop, *parts = (
            self.place(wrench.model.name, part) for part in ("start", "stop", *WRENCH)
        )
        return f"{force_of(wrench.point)}_id", start, stop, f"{{{', '.join(parts)}}}"


def _contacts(mbs: Mbs, simulation: Simulation) -> str:
    """What of each body may touch the ground, and the force of the ground on it."""
    states, spots = state_numbers(mbs, CONTACT_STATES), 0
    rows: list[tuple[str, ...]] = []
    for one in simulation.contacts:
        state = states.get(one.body.name, 0)
        first = (str(state), str(spots), str(len(one.spots)))
        rows.append((f"{force_of(one.point)}_id", *first, repr(one.bound)))
        spots += len(one.spots)
    all_spots = (
        (repr(s.radius), f"{{{_row(s.at)}}}", f"{{{_row(s.axis)}}}", repr(s.turn))
        for one in simulation.contacts
        for s in one.spots
    )
    return _table("Spot", "spots", all_spots) + _table("Contact", "contacts", rows)


def _laws(simulation: Simulation) -> str:
    """The laws of plugins, and what each acts on."""
    laws = simulation.laws
    joints = ((f"{joint.name}_id", law.name) for law in laws for joint in law.joints)
    points = ((f"{force_of(point)}_id", law.name) for law in laws for point in law.points)
    return "".join(
        [
            *(f"{law.c.strip()}\n\n" for law in laws),
            _table("JointLaw", "joint_laws", joints),
            _table("PointLaw", "point_laws", points),
        ]
    )


def _coupling(c: Coupling) -> tuple[str, ...]:
    return f"{c.follower.name}_id", f"{c.leader.name}_id", _row((c.multiplier, c.offset))


def _table(kind: str, name: str, rows: Iterable[Iterable[str]], last: str = "{0}") -> str:
    return _list(kind, name, (f"{{{', '.join(row)}}}" for row in rows), last)


def _list(kind: str, name: str, rows: Iterable[str], last: str) -> str:
    lines = "".join(f"    {row},\n" for row in rows)
    return f"static const {kind} {name}[] = {{\n{lines}    {last}\n}};\n\n"


def _names(name: str, names: list[str]) -> str:
    return _list("char *const", name, (f'"{text}"' for text in names), "NULL")


def _row(numbers: Iterable[float]) -> str:
    return ", ".join(repr(number + 0.0) for number in numbers)


def _comment(text: str) -> str:
    return quoted(text).replace("*/", "* /").replace("/*", "/ *")


# --- what MBSysPad would generate ---


def _all_id(mbs: Mbs) -> str:
    numbers = mbs.numbers()
    kinds: dict[str, list[tuple[str, int]]] = {
        "joints": list(numbers.items()),
        "bodies, each the number of its last joint": [
            (body.name, numbers[body.joints[-1].name]) for body in mbs.bodies
        ],
        "points, as BODY_POINT": [],
        "sensors": [],
        "external forces": [],
        "links": [(link.name, k) for k, link in enumerate(
            (link for link in mbs.links if link.kind == "link"), start=1)],
    }  # fmt: skip
    count = 0
    for name, owner in mbs.owners():
        for point in owner.points:
            count += 1
            kinds["points, as BODY_POINT"].append((f"{name or BASE}_{point.name}", count))
            for kind, thing in (("sensors", point.sensor), ("external forces", point.extforce)):
                if thing is not None:
                    kinds[kind].append((thing.name, len(kinds[kind]) + 1))
    out = ["#ifndef USER_ALL_ID_h\n#define USER_ALL_ID_h\n"]
    taken: set[str] = set()
    # where two would have one name, points give way
    for kind in sorted(kinds, key=lambda kind: kind.startswith("points")):
        out.append(f"\n/* {kind} */\n")
        for name, number in kinds[kind]:
            if name not in taken:
                taken.add(name)
                out.append(f"#define {name}_id {number}\n")
    return "".join([*out, "\n#endif\n"])


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


def _model_source(models: list[UserModel]) -> str:
    out = [
        "/* The values come from the .mbs when it is loaded: this is for MBsysC of 2017. */\n"
        "#include <stdlib.h>\n\n"
        '#include "mbs_data.h"\n#include "mbs_load_xml.h"\n'
        '#include "mbs_xml_reader.h"\n#include "user_model.h"\n\n'
        "UserModel* mbs_new_user_model()\n{\n"
        "    return (UserModel*) calloc(1, sizeof(UserModel));\n}\n\n"
        "void mbs_delete_user_model(UserModel *um)\n{\n    free(um);\n}\n\n"
        "void mbs_load_user_model_xml(MDS_gen_strct *gen, UserModel *um)\n{\n"
    ]
    if models:
        out.append("    MDS_user_model_strct **model = gen->user_models->user_model_list;\n\n")
    for i, model in enumerate(models):
        for j, parameter in enumerate(model.parameters if model.name not in STATES else ()):
            where = f"model[{i}]->parameter_list[{j}]->value_list[0]"
            out.append(f"    um->{model.name}.{parameter.name} = {where};\n")
    return "".join([*out, "}\n"])
