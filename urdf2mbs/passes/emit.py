"""Emit: the .mbs file itself (the method's A.2), named, numbered and complete.

Bodies are put depth first, as MBSysPad would renumber them; names become identifiers; the 3D
view is fitted to the robot; and what .mbs cannot hold is named.
"""

from __future__ import annotations

from math import hypot

from urdf2mbs.conversion import Conversion, LinkFrame
from urdf2mbs.diagnostics import ConversionError, counted, some
from urdf2mbs.engine.hookspecs import NoOptions, Pass
from urdf2mbs.mbs.model import Light, View, Viewpoint
from urdf2mbs.mbs.names import identifiers, rename
from urdf2mbs.mbs.writer import write
from urdf2mbs.spatial import HERE, Pose, add, compose, rotate
from urdf2mbs.urdf.model import Box, Cylinder, Joint, Mesh


def run(conversion: Conversion, options: NoOptions) -> None:
    mbs = conversion.mbs
    mbs.name = _name(conversion)
    mbs.base.name = conversion.ground.link
    mbs.bodies = mbs.depth_first()
    conversion.names.bodies, _ = rename(mbs)
    for segment in conversion.segments.values():
        for step in segment.steps:
            name = step.joint.name
            conversion.names.joints[name] = [joint.name for joint in step.joints]
            if step.coordinates:
                conversion.names.coordinates[name] = [joint.name for joint in step.coordinates]
    mbs.view = fit_view(conversion)
    conversion.frames = _frames(conversion)
    _tell(conversion)
    try:
        conversion.files[conversion.settings.output] = write(mbs)
    except ValueError as error:
        raise ConversionError(
            "mbs-unwritable", f"robot '{conversion.robot.name}': {error}",
            file=conversion.robot.file,
            hint="look for huge numbers in the URDF, and for what a plugin's pass has put in",
        ) from None  # fmt: skip


def _name(conversion: Conversion) -> str:
    """The file's own name: Robotran names the equations after it."""
    stem = conversion.settings.output.stem
    (name,) = identifiers([stem])
    if name != stem:
        conversion.note(
            "mbs-name",
            f"the model is called '{name}' in the .mbs, and so are its equations: the file's "
            f"name '{stem}' cannot be one in a program",
        )
    return name


def _frames(conversion: Conversion) -> dict[str, LinkFrame]:
    frames: dict[str, LinkFrame] = {}
    for segment in conversion.segments.values():
        body = None if segment.parent is None else segment.body.name
        for link, pose in segment.parts.items():
            frames[link] = LinkFrame(body, None, pose)
        for step in segment.steps[:-1]:
            for link, pose in step.frames.items():
                frames[link] = LinkFrame(body, step.joints[-1].name, pose)
    return frames


#: What most accounts of Robotran's generator of equations allow.
JOINTS, CUTS, SENSORS = 80, 30, 30
#: The height (m) of the human-sized robots whose view the scale factors are taken from.
HUMAN = 1.8


def fit_view(conversion: Conversion) -> View:
    """A camera that sees the whole robot at zero, and symbols of a size to match."""
    low, high = _extent(conversion)
    x, y, z = (_short((a + b) / 2) for a, b in zip(low, high, strict=True))
    centre = (x, y, z)
    size = max(hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]), 0.1)
    away = (_short(x + 1.3 * size), _short(y + 0.6 * size), _short(z + 0.5 * size))
    unit = size / HUMAN
    return View(
        frame=_short(0.1 * unit), joint=_short(0.2 * unit), com=_short(0.2 * unit),
        point=_short(0.3 * unit),
        viewpoints=[
            Viewpoint(
                "Whole_robot", position=away, target=centre,
                front_clip=_short(0.005 * size), back_clip=_short(30 * size),
            )
        ],
        lights=[Light("Light_1", (2.0, 1.0, 1.0)), Light("Light_2", (-1.0, -2.0, -1.0))],
    )  # fmt: skip


def _extent(conversion: Conversion) -> tuple[list[float], list[float]]:
    """The box (m) round all link frames, centres of mass and primitive shapes, at zero."""
    robot = conversion.robot
    at: dict[str, Pose] = {robot.root(): HERE}
    for joint in robot.depth_first():
        at[joint.child] = compose(at[joint.parent], joint.origin.pose)
    low, high = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for name, link in robot.links.items():
        pose = at[name]
        around = [(pose.xyz, 0.0)]
        if link.inertial is not None:
            around.append((add(pose.xyz, rotate(pose.rot, link.inertial.origin.xyz)), 0.0))
        for visual in link.visuals:
            shape = visual.geometry
            if isinstance(shape, Mesh):
                continue
            radius = (
                hypot(*shape.size) / 2 if isinstance(shape, Box)
                else hypot(shape.radius, shape.length / 2) if isinstance(shape, Cylinder)
                else shape.radius
            )  # fmt: skip
            around.append((add(pose.xyz, rotate(pose.rot, visual.origin.xyz)), radius))
        for point, radius in around:
            for k in range(3):
                low[k] = min(low[k], point[k] - radius)
                high[k] = max(high[k], point[k] + radius)
    return low, high


def _short(value: float) -> float:
    """Three significant digits: the view is for the eye, the robot is not rounded."""
    return float(f"{value:.3g}")


def _tell(conversion: Conversion) -> None:
    """Name what .mbs has no place for, and no pass has found one."""
    joints = conversion.robot.joints.values()
    kept = conversion.simulation.kept
    _tell_mimic(conversion)
    _tell_limits(conversion)
    lossy = [
        joint
        for joint in joints
        if joint.dynamics
        and (joint.dynamics.damping or joint.dynamics.friction)
        and joint.name not in kept.get("joint-dynamics", ())
    ]
    if lossy:
        conversion.warn(
            "joint-dynamics",
            f".mbs has no joint damping or friction; left out on {_some(lossy)}",
            hint="add them in the project's user_JointForces",
        )
    for code, what, found in (
        ("limit", "limits", [j for j in joints if j.limit]),
        ("safety-controller", "safety controllers", [j for j in joints if j.safety_controller]),
        ("calibration", "calibration", [j for j in joints if j.calibration]),
    ):
        found = [joint for joint in found if joint.name not in kept.get(code, ())]
        if found:
            conversion.note(code, f".mbs has no joint {what}; left out on {_some(found)}")
    tags: dict[str, int] = {}
    for extension in conversion.robot.extensions:
        if any(extension is one for one in conversion.simulation.used):
            continue
        tags[extension.tag] = tags.get(extension.tag, 0) + 1
    if tags:
        listed = ", ".join(f"{count} <{tag}>" for tag, count in tags.items())
        conversion.note("extension", f".mbs has no place for {listed}; left out")


def _tell_limits(conversion: Conversion) -> None:
    """Robotran's generator is a web service that counts."""
    mbs = conversion.mbs
    counted = {
        "joints": (sum(len(body.joints) for body in mbs.bodies), JOINTS),
        "cuts": (len(mbs.cuts), CUTS),
        "sensors": (
            sum(point.sensor is not None for body in mbs.bodies for point in body.points),
            SENSORS,
        ),
    }
    over = [f"{count} {what} ({most})" for what, (count, most) in counted.items() if count > most]
    if over:
        conversion.note(
            "generator-limits",
            "more than most accounts of Robotran's generator of equations allow: "
            f"{', '.join(over)}; the pass 'equations' writes them without a limit",
        )


def _tell_mimic(conversion: Conversion) -> None:
    """Name the joints that follow others in the URDF, and are independent in the .mbs."""
    free = {
        joint.name
        for body in conversion.mbs.bodies
        for joint in body.joints
        if joint.nature == "independent"
    }
    joints = conversion.robot.with_flipped(conversion.names.flipped).joints
    rules = [
        f"{name} = {mimic.multiplier!r} * {mimic.joint} + {mimic.offset!r}"
        for name, names in conversion.names.coordinates.items()
        if (mimic := joints[name].mimic) is not None and free.issuperset(names)
    ]
    if rules:
        conversion.warn(
            "mimic",
            "joints that follow others are independent in .mbs, which cannot hold this: "
            f"{', '.join(rules)}",
            hint="a project can: 'output: {project: DIR}'",
        )


def _some(joints: list[Joint]) -> str:
    return f"{counted(len(joints), 'joint')}: {some(joint.name for joint in joints)}"


PASS = Pass(
    "emit", run,
    needs=("robot", "inertias", "joints", "anchors", "shapes", "layout"), gives=("mbs-file",),
)  # fmt: skip
