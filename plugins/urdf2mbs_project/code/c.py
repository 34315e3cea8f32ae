"""The generated files of a project in C, which are written anew at each conversion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import msgspec

from urdf2mbs.plugin import Mbs
from urdf2mbs_project.code import FOLDER, fill_template
from urdf2mbs_project.code.c_text import escape_comment, format_body, format_term, indent
from urdf2mbs_project.code.mbsyspad import (
    assign_identifiers,
    generate_all_id,
    generate_model_header,
    generate_model_source,
)
from urdf2mbs_project.code.tables import generate_tables
from urdf2mbs_project.simulation import (
    JOINT_STATES,
    WRENCH_COMPONENTS,
    Simulation,
    find_state_indices,
    get_force_name,
)

#: The statements that add a law of a point to another force at this point.
ADDED_LAW = """\
{{
    double added[7] = {{0.0}};
    {}
    for (int i = 1; i <= 6; i++) {{
        force[i] += added[i];
    }}
}}"""
#: The fields of the struct Ground, which are the numbers of the user model ``contact``.
GROUND_FIELDS = ("ground", "stiffness", "speed", "friction", "bristle", "bristle_time")


def generate_c_files(mbs: Mbs, simulation: Simulation) -> dict[str, bytes]:
    """Return the generated files, by their names in userfctR.

    Args:
        mbs: The model, with its final names.
        simulation: What its code is generated from.
    """
    header = fill_template(FOLDER / "NAME_robot.h.in", mbs.name)
    header = header.replace("@COUNT@", str(len(simulation.couplings)))
    header = header.replace("@TIME_STEP@", repr(simulation.time_step))
    header = header.replace("@SHORTENED_BY@", escape_comment(simulation.shortened_by))
    texts = {
        f"{mbs.name}_robot.h": header,
        f"{mbs.name}_robot.c": _RobotSource(mbs, simulation).generate(),
        f"{mbs.name}_laws.h": fill_template(FOLDER / "NAME_laws.h", mbs.name),
        f"{mbs.name}_tables.h": generate_tables(mbs, simulation),
        "user_all_id.h": generate_all_id(mbs),
        "user_model.h": generate_model_header(mbs),
        "user_model.c": generate_model_source(mbs),
    }
    return {name: text.encode() for name, text in texts.items()}


class _Law(msgspec.Struct):
    """A force law of joints, which a number of the user models switches on."""

    switch: str
    """The name of the number, in the user model ``switch_model``."""
    model: str
    """The user model with a number for each joint; without it no joint has the law."""
    statements: Iterable[str]
    switch_model: str = "joint_forces"


class _RobotSource:
    """The functions of NAME_robot.c."""

    def __init__(self, mbs: Mbs, simulation: Simulation) -> None:
        self.mbs, self.simulation = mbs, simulation
        self.identifiers = assign_identifiers(mbs)
        self.parameters = {
            model.name: [parameter.name for parameter in model.parameters]
            for model in mbs.user_models
        }

    def generate(self) -> str:
        """Return the text of NAME_robot.c."""
        laws = [f"{law.c.strip()}\n\n" for law in self.simulation.laws]
        text = fill_template(FOLDER / "NAME_robot.c.in", self.mbs.name)
        text = text.replace("@LAWS@\n", "".join(laws))
        text = text.replace("@NEEDS_USER_MODELS@", str(int(bool(self.parameters))))
        n_constraints = len(self.simulation.couplings)
        zeros = (f"jdqd[{k}] = 0.0;" for k in range(1, n_constraints + 1))
        bodies = {
            "CONSTRAINTS": format_body("h Jac mbs_data", self.write_constraints()),
            "JDQD": format_body("jdqd", zeros),
            "DRIVEN": format_body("mbs_data", self.write_driven_joints()),
            "JOINT_FORCES": format_body("mbs_data", self.write_joint_forces()),
            "EFFORTS": format_body("mbs_data joint force", self.write_efforts()),
            "EXTERNAL_FORCES": format_body(
                "PxF RxF VxF OMxF mbs_data tsim ixF", self.write_external_forces()
            ),
            "LINK_FORCES": format_body("Z Zd mbs_data ilnk", self.write_link_forces()),
            "SENSORS": format_body("sensor isens mbs_data force turn", self.write_sensors()),
        }
        for word, body in bodies.items():
            text = text.replace(f"@{word}@\n", body)
        return text

    def get_expression(self, model: str, name: str, default: str = "0.0") -> str:
        """Return the C expression of a number in the user models; the default if it has none."""
        exists = name in self.parameters.get(model, ())
        return f"user_model->{model}.{name}" if exists else default

    # --- joints ---

    def write_constraints(self) -> Iterator[str]:
        """Yield the constraints of followers, and their derivatives."""
        for k, coupling in enumerate(self.simulation.couplings, start=1):
            follower, leader = f"{coupling.follower.name}_id", f"{coupling.leader.name}_id"
            terms = format_term(-coupling.multiplier, f" * q[{leader}]")
            terms += format_term(-coupling.offset)
            yield f"h[{k}] = q[{follower}]{terms};"
            yield f"Jac[{k}][{follower}] = 1.0;"
            yield f"Jac[{k}][{leader}] = {-coupling.multiplier + 0.0!r};"

    def write_driven_joints(self) -> Iterator[str]:
        """Yield the positions, velocities and accelerations of driven followers."""
        for coupling in self.simulation.driven:
            follower, leader = f"{coupling.follower.name}_id", f"{coupling.leader.name}_id"
            for variable in ("q", "qd", "qdd"):
                offset = format_term(coupling.offset) if variable == "q" else ""
                rule = f"{coupling.multiplier!r} * {variable}[{leader}]{offset}"
                yield f"{variable}[{follower}] = {rule};"

    def write_joint_forces(self) -> Iterator[str]:
        """Yield the laws of joints: ours, then those of plugins."""
        for law in (
            _Law("damping", "damping", self.write_damping()),
            _Law("springs", "spring_stiffness", self.write_springs()),
            _Law("friction", "friction", self.write_friction()),
            _Law("stops", "stop_stiffness", self.write_stops()),
            _Law("on", "hold_stiffness", self.write_hold(), switch_model="hold"),
        ):
            if law.switch in self.parameters.get(law.switch_model, ()) and (
                law.model in self.parameters
            ):
                yield f"if (user_model->{law.switch_model}.{law.switch} != 0.0) {{"
                yield from map(indent, law.statements)
                yield "}"
        for plugin_law in self.simulation.laws:
            for joint in plugin_law.joints:
                yield f"Qq[{joint.name}_id] += {plugin_law.name}(mbs_data, {joint.name}_id);"

    def write_damping(self) -> Iterator[str]:
        """Yield the damping of joints."""
        for name in self.parameters.get("damping", ()):
            damping = self.get_expression("damping", name)
            yield f"Qq[{name}_id] -= {damping} * qd[{name}_id];"

    def write_springs(self) -> Iterator[str]:
        """Yield the springs of joints."""
        for name in self.parameters.get("spring_stiffness", ()):
            stiffness = self.get_expression("spring_stiffness", name)
            reference = self.get_expression("spring_reference", name)
            yield f"Qq[{name}_id] -= {stiffness}\n    * (q[{name}_id] - {reference});"

    def write_friction(self) -> Iterator[str]:
        """Yield the friction of joints."""
        time = self.get_expression("joint_forces", "friction_time")
        for name, state in find_state_indices(self.mbs, JOINT_STATES).items():
            friction = self.get_expression("friction", name)
            stiffness = self.get_expression("friction_stiffness", name)
            yield (
                f"Qq[{name}_id] -= joint_friction(mbs_data, {state}, qd[{name}_id], {friction},\n"
                f"    {stiffness}, {time});"
            )

    def write_stops(self) -> Iterator[str]:
        """Yield the stops of joints at their limits."""
        speed = self.get_expression("joint_forces", "stop_speed")
        for name in self.parameters.get("stop_stiffness", ()):
            lower = self.get_expression("q_min", name, "-INFINITY")
            upper = self.get_expression("q_max", name, "INFINITY")
            yield (
                f"Qq[{name}_id] -= stop_forces(q[{name}_id], qd[{name}_id],\n"
                f"    {lower}, {upper},\n"
                f"    {self.get_expression('stop_stiffness', name)}, {speed});"
            )

    def write_hold(self) -> Iterator[str]:
        """Yield the controller that holds the start position."""
        for name in self.parameters.get("hold_stiffness", ()):
            stiffness = self.get_expression("hold_stiffness", name)
            damping = self.get_expression("hold_damping", name)
            yield (
                f"Qq[{name}_id] += limit_effort({self.get_expression('effort', name)},\n"
                f"    {stiffness} * (q0[{name}_id] - q[{name}_id])\n"
                f"    - {damping} * qd[{name}_id]);"
            )

    def write_efforts(self) -> Iterator[str]:
        """Yield the limits of the motors' forces."""
        cases = {
            name: [f"return limit_effort({self.get_expression('effort', name)}, force);"]
            for name in self.parameters.get("effort", ())
        }
        yield from self.write_switch("joint", "joint", cases, "return force;")

    # --- points, links, sensors ---

    def write_external_forces(self) -> Iterator[str]:
        """Yield the forces at points: of the ground, of wrenches, of plugins."""
        cases: dict[str, list[str]] = {}
        for contact in self.simulation.contacts:
            name = get_force_name(contact.point)
            call = f"ground_force(&{name}, &ground, PxF, RxF, VxF, OMxF, mbs_data, force);"
            cases.setdefault(name, []).append(call)
        for wrench in self.simulation.wrenches:
            start, stop, *components = (
                self.get_expression(wrench.model.name, name)
                for name in ("start", "stop", *WRENCH_COMPONENTS)
            )
            cases.setdefault(get_force_name(wrench.point), []).extend(
                [
                    f"if ({start} <= tsim && tsim < {stop}) {{",
                    *(f"    force[{k}] = {value};" for k, value in enumerate(components, start=1)),
                    "}",
                ]
            )
        for law in self.simulation.laws:
            for point in law.points:
                statements = cases.setdefault(get_force_name(point), [])
                target = "added" if statements else "force"
                call = f"{law.name}(PxF, VxF, mbs_data, tsim, ixF, {target});"
                statements += ADDED_LAW.format(call).splitlines() if statements else [call]
        if self.simulation.contacts:
            yield "const Ground ground = {"
            for name in GROUND_FIELDS:
                yield f"    .{name} = {self.get_expression('contact', name)},"
            yield "};\n"
        yield "for (int i = 1; i <= 6; i++) {\n    force[i] = 0.0;\n}"
        broken = {name: [*statements, "break;"] for name, statements in cases.items()}
        yield from self.write_switch("ixF", "force", broken, "break;" if cases else "")

    def write_link_forces(self) -> Iterator[str]:
        """Yield the springs between two points."""
        cases = {}
        for link in self.simulation.springs:
            stiffness = self.get_expression("link_stiffness", link.name)
            length = self.get_expression("link_length", link.name)
            damping = self.get_expression("link_damping", link.name)
            cases[link.name] = [
                f"return {stiffness}\n    * (Z - {length})\n    + {damping} * Zd;",
            ]
        yield from self.write_switch("ilnk", "link", cases, "return 0.0;")

    def write_sensors(self) -> Iterator[str]:
        """Yield the axes of the sensors, and the reading of an IMU."""
        cases = {
            sensor.point.sensor.name: [f"axes = {sensor.point.sensor.name}_axes;", "break;"]
            for sensor in self.simulation.sensors
            if sensor.point.sensor is not None
        }
        yield "const double *axes = body_axes;\n"
        yield from self.write_switch("isens", "sensor", cases, "break;" if cases else "")
        yield "read_imu(sensor, axes, mbs_data->g, force, turn);"

    def write_switch(
        self, variable: str, kind: str, cases: Mapping[str, list[str]], default: str
    ) -> Iterator[str]:
        """Yield a switch over the numbers of joints, forces, links or sensors.

        Args:
            variable: The variable that has the number.
            kind: The kind of element, as in ``assign_identifiers``.
            cases: The statements for each element, by its name.
            default: The statement for all others; empty for none.
        """
        if cases:
            yield f"switch ({variable}) {{"
            for name, statements in cases.items():
                yield f"case {self.identifiers[kind][name].word}:"
                yield from map(indent, statements)
            yield f"default:\n    {default}\n}}"
        elif default:
            yield default
