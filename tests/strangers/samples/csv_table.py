"""Write the bodies and joints as a table (CSV) instead of the .mbs file.

In a config::

    source: robot.urdf
    output: robot.csv
    plugins: [csv_table.py]
    swap: {emit: csv_table}

A row is a joint, in the order in which Robotran numbers them; the mass stands at the body's last
joint.  Naming and the check are passes of their own, so another format needs nothing but this.
"""

from __future__ import annotations

import csv
import io

from urdf2mbs.plugin import Conversion, Pass, hookimpl


class CsvTable(Pass):
    """Write the bodies and joints as a table."""

    name = "emit"
    reads = ("names", "inertias", "joints", "posture")
    writes = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["number", "joint", "type", "nature", "q", "body", "parent", "mass"])
        numbers = conversion.mbs.numbers()
        for body in conversion.mbs.bodies:
            for joint in body.joints:
                table.writerow(
                    [
                        numbers[joint.name],
                        joint.name,
                        joint.type,
                        joint.nature,
                        joint.q,
                        body.name,
                        body.parent,
                        body.mass if joint is body.joints[-1] else None,
                    ]
                )
        conversion.files[conversion.settings.output] = text.getvalue().encode()


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [CsvTable]
