"""Force-torque: sensors at fixed joints weigh what hangs on them."""

from support.build import SOLID, joint, link, robot
from urdf2mbs.testing import convert_text
from urdf2mbs_project.simulation import Simulation


def test_three_sensors_of_one_name_are_three() -> None:
    """Each has a name of its own in the generated code; a joint that moves cannot have one."""
    text = robot(
        *(link(name, SOLID) for name in "abcd"),
        *(joint("a", child, "fixed", name=f"to_{child}") for child in "bcd"),
        *(
            f'<sensor name="ft" type="force_torque"><parent joint="to_{child}"/></sensor>'
            for child in "bcd"
        ),
        link("e", SOLID),
        joint("a", "e"),
        '<gazebo reference="a_to_e"><sensor name="torque" type="force_torque"/></gazebo>',
    )
    result = convert_text(text, passes={"force-torque": {"joints": ["to_*"]}})
    assert {"to_b_T1", "to_d_R3"} <= result.mbs.joints().keys()
    told = {diagnostic.code: diagnostic.message for diagnostic in result.diagnostics}
    assert "joints that move are left out: a_to_e" in told["force-torque"]
    assert "1 <gazebo>" in told["extension"]
    assert "<sensor>" not in told["extension"]
    names = [sensor.name for sensor in result.conversion.state(Simulation).force_torques]
    assert names == ["ft", "to_c_ft", "to_d_ft"]
    result = convert_text(
        text.replace('"ft"', '"one"', 1), passes={"force-torque": {"joints": ["to_c"]}}
    )
    message, _ = [
        diagnostic.message for diagnostic in result.diagnostics if diagnostic.code == "force-torque"
    ]
    assert message.startswith("force-torque sensors at fixed joints are left out: to_b, to_d; ")
