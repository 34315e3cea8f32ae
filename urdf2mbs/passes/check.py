"""Check: compare the file just made with the URDF (the method's A.3.2, where its authors looked at
pictures).

It reads the file's bytes and compares them with the URDF by the second route of ``verify``:
the pose of every link at several random positions, zero included, and mass, centre and inertia
of every rigid group.  Shapes are those of the model: to read the graphics of the file would take
half as long again.  A file that differs never takes the place of a good file; what
differs because people edited the mechanics is named.  If a plugin writes
another format, the pass compares the model instead of the file.
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
from urdf2mbs.states import OnPurpose
from urdf2mbs.urdf.model import Robot


class Check(Pass):
    reads = ("robot", "mbs-file")

    tolerance: Tolerance = TOLERANCE
    """The largest deviation that is no difference, relative to the robot's size or inertia."""

    def run(self, conversion: Conversion) -> None:
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
        meant, checked = conversion.state(OnPurpose), conversion.checked
        proof.not_compared |= meant.added
        if meant.edited:
            proof.accept_differences(f"as edited in {' and '.join(meant.edited)}")
        checked.proven, checked.proof = data, proof
        if not proof.same:
            checked.rejected = output.with_suffix(f".rejected{output.suffix}")
            conversion.files[checked.rejected] = bytes(conversion.files.pop(output))


def prove(
    conversion: Conversion, mbs: Mbs, models: Sequence[UserModel] | None = None,
    tolerance: float = TOLERANCE, robot: Robot | None = None,
) -> Proof:  # fmt: skip
    """Compare the .mbs of a conversion with its robot, or with another; frames count, and so do
    changes of the robot that no pass declares."""
    meant = conversion.state(OnPurpose)
    match = Match(
        joints={name: tuple(own) for name, own in conversion.names.coordinates.items()},
        frames=conversion.frames,
        locked=conversion.frozen,
    )
    expectation = Expectation(
        gravity=conversion.settings.config.gravity,
        massless=sorted(meant.massless & conversion.frozen.keys()),
        driven=[joint.name for joint in meant.driven],
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
    return proof
