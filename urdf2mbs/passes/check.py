"""Check: compare the file just made with the URDF.

The authors of the method looked at pictures for this (A.3.2).  The pass reads the file's bytes and
compares them with the URDF by the second route of ``verify``: the pose of every link at several
random positions, zero included, and mass, centre and inertia of every rigid group.  Shapes are
those of the model: to read the graphics of the file would take half as long again.

A file that differs never takes the place of a good file.  Differences that follow from edits of
the mechanics are named.  If a plugin writes another format, the pass compares the model instead of
the file.
"""

from __future__ import annotations

from collections.abc import Sequence

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Mbs, UserModel
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.proof.compare import Expectation, compare
from urdf2mbs.proof.match import Match
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.ranges import Tolerance
from urdf2mbs.states import OnPurpose, SecondOpinions
from urdf2mbs.urdf.model import Robot


class Check(Pass):
    """Compare the file just made with the URDF."""

    reads = ("robot", "mbs-file")

    tolerance: Tolerance = TOLERANCE
    """The largest deviation that is no difference, relative to the robot's size or inertia."""

    def run(self, conversion: Conversion) -> None:
        """Compare, record the proof, and reject the file if it is another robot."""
        output = conversion.settings.output
        data = conversion.files[output]
        if output.suffix.lower() == ".mbs":
            mbs = read_mbs(data, str(output), mechanics_only=True)
        else:
            mbs = conversion.mbs
        proof = prove(conversion, mbs, conversion.mbs.user_models, self.tolerance)
        proof.add_differences(
            Difference("frame-lost", f"link '{link}' has no place in the .mbs", link=link)
            for link in conversion.robot.links
            if link not in conversion.frames
        )
        on_purpose = conversion.state(OnPurpose)
        proof.not_compared |= on_purpose.added
        if on_purpose.edited:
            proof.accept_differences(f"as edited in {' and '.join(on_purpose.edited)}")
        checked = conversion.checked
        checked.proven, checked.proof = data, proof
        if not proof.same:
            checked.rejected = output.with_suffix(f".rejected{output.suffix}")
            conversion.files[checked.rejected] = bytes(conversion.files.pop(output))


def prove(
    conversion: Conversion,
    mbs: Mbs,
    models: Sequence[UserModel] | None = None,
    tolerance: float = TOLERANCE,
    robot: Robot | None = None,
) -> Proof:
    """Compare an .mbs with the robot of a conversion.

    Link frames that agree are counted.  A change of the robot that no pass declares is a
    difference.

    Args:
        conversion: The conversion, after its last pass.
        mbs: The model, which may be read from the file.
        models: The user models that are compared with the URDF's properties of joints; None if
            they are not compared.
        tolerance: The largest deviation that is no difference, relative to the robot's size or
            inertia.
        robot: The robot to compare with; None for the conversion's own.
    """
    on_purpose = conversion.state(OnPurpose)
    match = Match(
        joints={name: tuple(joints) for name, joints in conversion.names.coordinates.items()},
        frames=conversion.frames,
        locked=conversion.frozen,
    )
    expectation = Expectation(
        gravity=conversion.settings.config.gravity,
        massless=sorted(on_purpose.massless & conversion.frozen.keys()),
        driven=[joint.name for joint in on_purpose.driven],
        user_models=models,
        shapes=conversion.mbs,
    )
    proof = compare(robot or conversion.robot, mbs, match, expectation, tolerance)
    proof.add_frames()
    proof.add_differences(
        Difference("changed", f"{change}, and does not say so by writes = ('robot',)")
        for change in conversion.checked.changed
        if not change.declared
    )
    conversion.state(SecondOpinions).add_to(proof)
    return proof
