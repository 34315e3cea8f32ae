"""The generated files of a project in C: what MBSysPad would generate, and NAME_robot.c and .h."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from urdf2mbs.diagnostics import quoted
from urdf2mbs.mbs.model import BASE, Mbs, UserModel
from urdf2mbs.project import FOLDER, fill
from urdf2mbs.project.python import dependent
from urdf2mbs.simulation import Coupling, Simulation
from urdf2mbs.spatial import Rot

NOTE = (
    "/* urdf2mbs writes this file anew at each conversion: do not edit it.\n"
    " * MBSysPad can write it, too: menu \"generate user files\". */\n\n"
)  # fmt: skip


def generated(mbs: Mbs, simulation: Simulation) -> dict[str, bytes]:
    """The files that are written anew at each conversion, by their name in userfctR."""
    source = fill(FOLDER / "c_robot.c.in", mbs.name)
    for mark, lines in _marks(mbs, simulation).items():
        source = source.replace(f"@{mark}@\n", "".join(f"{line}\n" for line in lines))
    header = fill(FOLDER / "c_robot.h.in", mbs.name)
    header = header.replace("@COUNT@", str(len(simulation.couplings)))
    header = header.replace("@TIME_STEP@", repr(simulation.time_step))
    header = header.replace("@SHORTENED_BY@", _comment(simulation.shortened_by))
    texts = {
        f"{mbs.name}_robot.h": header,
        f"{mbs.name}_robot.c": source,
        "user_all_id.h": NOTE + _all_id(mbs),
        "user_model.h": NOTE + _model_header(mbs.user_models),
        "user_model.c": NOTE + _model_source(mbs.user_models),
    }
    return {name: text.encode() for name, text in texts.items()}


# --- NAME_robot.c ---


def _marks(mbs: Mbs, simulation: Simulation) -> dict[str, list[str]]:
    """What stands at each mark of the template."""
    models = {model.name: [p.name for p in model.parameters] for model in mbs.user_models}
    return {
        "CONSTRAINTS": list(_constraints(simulation.couplings)),
        "JDQD": [f"    jdqd[{k}] = 0.0;" for k in range(1, len(simulation.couplings) + 1)],
        "DRIVEN": list(_driven(simulation.driven)),
        "JOINT_FORCES": list(_joint_forces(models, simulation)),
        "STOP": _part("c_stop") if "stops" in models.get("joint_forces", []) else [],
        "HOLD": _part("c_hold") if "hold" in models else [],
        "GROUND": list(_ground(simulation)) if simulation.contacts else [],
        "EXTERNAL": list(_external(simulation)),
        "SPRINGS": list(_springs(simulation)),
        "SENSORS": list(_sensors(simulation)),
        "JOINTS": [f'    "{name}",' for name in mbs.numbers()],
        "DEPENDENT": [f'    "{name}",' for name in dependent(mbs)],
    }


def _constraints(couplings: Iterable[Coupling]) -> Iterator[str]:
    for k, c in enumerate(couplings, start=1):
        follower, leader = f"{c.follower.name}_id", f"{c.leader.name}_id"
        m, b = c.multiplier + 0.0, c.offset + 0.0
        yield f"    h[{k}] = q[{follower}] - {m!r} * q[{leader}] - {b!r};"
        yield f"    Jac[{k}][{follower}] = 1.0;"
        yield f"    Jac[{k}][{leader}] = {-m + 0.0!r};"


def _driven(couplings: Iterable[Coupling]) -> Iterator[str]:
    for c in couplings:
        follower, leader, m = f"{c.follower.name}_id", f"{c.leader.name}_id", c.multiplier + 0.0
        yield f"    q[{follower}] = {m!r} * q[{leader}] + {c.offset + 0.0!r};"
        yield f"    qd[{follower}] = {m!r} * qd[{leader}];"
        yield f"    qdd[{follower}] = {m!r} * qdd[{leader}];"


def _joint_forces(models: dict[str, list[str]], simulation: Simulation) -> Iterator[str]:
    switches = models.get("joint_forces", [])
    if switches or "hold" in models:
        yield "    const UserModel *m = mbs_data->user_model;"
    if "damping" in switches:
        yield "    if (m->joint_forces.damping != 0.0) {"
        for name in models["damping"]:
            yield f"        Qq[{name}_id] -= m->damping.{name} * qd[{name}_id];"
        yield "    }"
    if "friction" in switches:
        yield "    if (m->joint_forces.friction != 0.0) {"
        for name in models["friction"]:
            yield f"        Qq[{name}_id] -= m->friction.{name}"
            yield f"            * tanh(qd[{name}_id] / m->friction_speed.{name});"
        yield "    }"
    if "stops" in switches:
        yield "    if (m->joint_forces.stops != 0.0) {"
        yield "        const double speed = m->joint_forces.stop_speed;"
        for name in models["stop_stiffness"]:
            number, stiffness = f"{name}_id", f"m->stop_stiffness.{name}"
            if name in models.get("q_max", ()):
                yield f"        Qq[{number}] -= stop(q[{number}] - m->q_max.{name}, qd[{number}],"
                yield f"            {stiffness}, speed);"
            if name in models.get("q_min", ()):
                yield f"        Qq[{number}] += stop(m->q_min.{name} - q[{number}], -qd[{number}],"
                yield f"            {stiffness}, speed);"
        yield "    }"
    if "hold" in models:
        efforts = models.get("effort", [])
        yield "    if (m->hold.on != 0.0) {"
        for name in models["hold_stiffness"]:
            most = f"m->effort.{name}" if name in efforts else "0.0"
            yield f"        Qq[{name}_id] += hold(mbs_data, {name}_id, m->hold_stiffness.{name},"
            yield f"            m->hold_damping.{name}, {most});"
        yield "    }"


def _ground(simulation: Simulation) -> Iterator[str]:
    x, y, z = simulation.up
    yield f"static const double up[4] = {{0.0, {x + 0.0!r}, {y + 0.0!r}, {z + 0.0!r}}};"
    yield ""
    yield from _part("c_ground")


def _part(name: str) -> list[str]:
    return (FOLDER / f"{name}.c.in").read_text("utf-8").splitlines()


def _external(simulation: Simulation) -> Iterator[str]:
    if simulation.contacts or simulation.wrenches:
        yield "    switch (ixF) {"
    for contact in simulation.contacts:
        yield f"    case {_force(contact)}_id:"
    if simulation.contacts:
        yield "        ground_force(PxF, VxF, mbs_data, force);"
        yield "        break;"
    for wrench in simulation.wrenches:
        model = f"mbs_data->user_model->{wrench.model.name}"
        yield f"    case {_force(wrench)}_id:"
        yield f"        if ({model}.start <= tsim && tsim < {model}.stop) {{"
        for k, part in enumerate(("Fx", "Fy", "Fz", "Mx", "My", "Mz"), start=1):
            yield f"            force[{k}] = {model}.{part};"
        yield "        }"
        yield "        break;"
    if simulation.contacts or simulation.wrenches:
        yield "    default:"
        yield "        break;"
        yield "    }"


def _force(thing: object) -> str:
    return str(thing.point.extforce.name)  # type: ignore[attr-defined]


def _springs(simulation: Simulation) -> Iterator[str]:
    if not simulation.springs:
        return
    yield "    const UserModel *m = mbs_data->user_model;"
    for spring in simulation.springs:
        name = spring.link.name
        yield f"    if (ilnk == {name}_id) {{"
        yield f"        return m->link_stiffness.{name} * (Z - m->link_length.{name})"
        yield f"            + m->link_damping.{name} * Zd;"
        yield "    }"


def _sensors(simulation: Simulation) -> Iterator[str]:
    for sensor in simulation.sensors:
        if sensor.point.sensor is not None:
            name = sensor.point.sensor.name
            yield f"    {{{name}_id, {{{_row(sensor.rotation)}}}}},  /* {_comment(sensor.name)} */"


def _row(rotation: Rot) -> str:
    return ", ".join(repr(c + 0.0) for c in rotation)


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
    for owner, points in ((BASE, mbs.base.points), *((b.name, b.points) for b in mbs.bodies)):
        for point in points:
            count += 1
            kinds["points, as BODY_POINT"].append((f"{owner}_{point.name}", count))
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
        for j, parameter in enumerate(model.parameters):
            where = f"model[{i}]->parameter_list[{j}]->value_list[0]"
            out.append(f"    um->{model.name}.{parameter.name} = {where};\n")
    return "".join([*out, "}\n"])
