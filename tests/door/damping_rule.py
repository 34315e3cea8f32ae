"""Give joints without damping a share of their effort at full speed."""

from typing import Annotated

from msgspec import Meta

from urdf2mbs.plugin import Conversion, Pass, hookimpl, some, urdf


class DampingRule(Pass):
    """Give joints without damping a share of their effort at full speed."""

    writes = ("robot",)

    share: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.1
    """The torque of the damper at the joint's full speed, as a part of its effort."""

    def run(self, conversion: Conversion) -> None:
        without_limits = []
        for joint in conversion.robot.joints.values():
            dynamics, limit = joint.dynamics or urdf.Dynamics(), joint.limit
            if dynamics.damping or not joint.moves:
                continue
            if limit is not None and limit.effort and limit.velocity:
                dynamics.damping = self.share * limit.effort / limit.velocity
                joint.dynamics = dynamics
            else:
                without_limits.append(joint.name)
        if without_limits:
            conversion.note("undamped", f"no damper without limits: {some(without_limits)}")


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [DampingRule]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    return {"undamped": "note: a joint without limits got no damper."}
