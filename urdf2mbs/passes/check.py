"""Check: that the file just made is the same robot as the URDF (the method's A.3.2, where its
authors looked at pictures).

It reads the file's bytes and compares them with the URDF by the second route of ``verify``:
the pose of every link at several random positions, zero included, and mass, centre and inertia
of every rigid group.  A file that differs never takes the place of a good one.  Where a plugin
writes another format, the model that the file was made of is compared.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Proof
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import Difference
from urdf2mbs.proof.compare import TOLERANCE, compare
from urdf2mbs.ranges import Tolerance


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
        comparison = compare(
            conversion.robot.with_flipped(conversion.names.flipped),
            mbs,
            conversion.names.coordinates,
            frames=conversion.frames,
            frozen=conversion.frozen,
            weightless=sorted(conversion.weightless & conversion.frozen.keys()),
            driven=[coupling.follower.name for coupling in conversion.simulation.driven],
            models=conversion.mbs.user_models,
            gravity=conversion.settings.config.gravity,
            tolerance=self.tolerance,
        )
        undeclared = [
            Difference("changed", f"{one}, and does not say so by writes = ('robot',)")
            for one in conversion.changed
            if not one.declared
        ]
        lost = [
            Difference("frame-lost", f"link '{link}' has no place in the .mbs", link=link)
            for link in conversion.robot.links
            if link not in conversion.frames
        ]
        differences = sorted(
            undeclared + lost + comparison.differences + comparison.frames,
            key=lambda difference: -difference.size,
        )
        conversion.proven = data
        conversion.proof = Proof(
            not differences,
            comparison.positions,
            comparison.groups,
            comparison.largest,
            differences,
            comparison.but_for,
            comparison.not_compared,
            comparison.compared,
        )
        if differences:
            conversion.rejected = output.with_suffix(f".rejected{output.suffix}")
            conversion.files[conversion.rejected] = conversion.files.pop(output)
