"""Read a format of our own: each line of a .balls file is a joint and a ball, which it turns.

name,parent,x,y,z,axis,mass,radius    (m in the frame of the parent, kg, m)
"""

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

from urdf2mbs.plugin import ConversionError, Expansion, hookimpl

AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


@hookimpl
def urdf2mbs_read(source: Path, data: bytes) -> Expansion | None:
    if source.suffix != ".balls":
        return None
    robot = Element("robot", name=source.stem)
    SubElement(robot, "link", name="base")
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), start=1):
        try:
            name, parent, x, y, z, axis, mass, radius = line.split(",")
            add_ball(robot, name, float(mass), float(radius))
            joint = SubElement(robot, "joint", name=f"{name}_joint", type="continuous")
            SubElement(joint, "parent", link=parent)
            SubElement(joint, "child", link=name)
            SubElement(joint, "origin", xyz=f"{x} {y} {z}")
            SubElement(joint, "axis", xyz=AXES[axis])
        except (KeyError, ValueError) as error:
            message = f"'{line}' is no ball: {error}"
            raise ConversionError("balls", message, file=str(source), line=number) from None
    return Expansion(tostring(robot), [str(source)], [])


def add_ball(robot: Element, name: str, mass: float, radius: float) -> None:
    inertial = SubElement(SubElement(robot, "link", name=name), "inertial")
    SubElement(inertial, "mass", value=repr(mass))
    moment = repr(0.4 * mass * radius**2)
    SubElement(inertial, "inertia", ixx=moment, iyy=moment, izz=moment)
