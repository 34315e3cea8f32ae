"""Check: that the file just made is the same robot as the URDF (the method's A.3.2, where its
authors looked at pictures).

It reads the file's bytes and compares them with the URDF by the second route of ``verify``:
the pose of every link at several random positions, zero included, and mass, centre and inertia
of every rigid group.  A file that differs never takes the place of a good file; what
differs because people edited the mechanics is named.  If a plugin writes
another format, the pass compares the model instead of the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import Mbs, UserModel
from urdf2mbs.mbs.reader import read
from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.ranges import Tolerance
from urdf2mbs.urdf.model import Robot


class Check(Pass):
    reads = ("robot", "mbs-file")

    tolerance: Tolerance = TOLERANCE
    """The largest deviation that is no difference, relative to the robot's size or inertia."""

    def run(self, conversion: Conversion) -> None:
        output = conversion.settings.output
        data = conversion.files[output]
        if output.suffix.lower() == ".mbs":
            mbs = read(data, str(output), mechanics_only=True)
        else:
            mbs = conversion.mbs
        proof = prove(conversion, mbs, conversion.mbs.user_models, self.tolerance)
        proof.differ(
            Difference("frame-lost", f"link '{link}' has no place in the .mbs", link=link)
            for link in conversion.robot.links
            if link not in conversion.frames
        )
        made = (*_made(conversion),)
        proof.not_compared = {
            thing: why for thing, why in proof.not_compared.items() if not thing.startswith(made)
        }
        proof.not_compared |= conversion.added
        if conversion.edited:
            proof.forgive(f"as edited in {' and '.join(conversion.edited)}")
        conversion.proven, conversion.proof = data, proof
        if not proof.same:
            conversion.rejected = output.with_suffix(f".rejected{output.suffix}")
            conversion.files[conversion.rejected] = conversion.files.pop(output)


def prove(
    conversion: Conversion,
    mbs: Mbs,
    models: Sequence[UserModel] | None = None,
    tolerance: float = TOLERANCE,
    robot: Robot | None = None,
) -> Proof:
    """Compare the .mbs of a conversion with its robot, or with another; frames count, and so do
    changes of the robot that no pass declares."""
    proof = compare(
        robot or conversion.robot,
        mbs,
        conversion.names.coordinates,
        frames=conversion.frames,
        frozen=conversion.frozen,
        weightless=sorted(conversion.weightless & conversion.frozen.keys()),
        driven=[coupling.follower.name for coupling in conversion.simulation.driven],
        models=models,
        gravity=conversion.settings.config.gravity,
        tolerance=tolerance,
    )
    proof.count_frames()
    proof.differ(
        Difference("changed", f"{change}, and does not say so by writes = ('robot',)")
        for change in conversion.changed
        if not change.declared
    )
    return proof


def _made(conversion: Conversion) -> Iterator[str]:
    """What passes made for a project, as ``Proof.not_compared`` begins: no URDF has it, and the
    generated user functions compute it."""
    if conversion.settings.project is None:
        return
    made = conversion.simulation
    for point in [c.point for c in made.contacts] + [w.point for w in made.wrenches]:
        if point.extforce is not None:
            yield f"force '{point.extforce.name}'"
    for link in made.springs:
        yield f"link '{link.name}' ({link.kind})"
    followers = {coupling.follower.name for coupling in made.couplings}
    if not conversion.replaces:  # else people may have changed the start
        yield "start of "
    for step, joint in conversion.single_coordinates():
        if joint.name in followers:
            yield f"<mimic> of joint '{step.joint.name}'"
