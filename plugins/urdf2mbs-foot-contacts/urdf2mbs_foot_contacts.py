"""Contact points at the corners of soles, each with an external force and a sensor.

Robotran computes the kinematics of each point that has an ``extforce`` and calls the project's
``user_ExtForces`` with it: the place for a ground contact law.
"""

from fnmatch import fnmatchcase

from urdf2mbs.plugin import ConfigError, Pass, hookimpl, mbs, spatial, urdf

#: What is measured at a point, as in models that Robotran's users have made by hand.
FORCE = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
SENSOR = (*FORCE, "Jac")

DIRECTIONS = {"+x": (0, 1), "-x": (0, -1), "+y": (1, 1), "-y": (1, -1), "+z": (2, 1), "-z": (2, -1)}


class FootContacts(Pass):
    """Put points with external forces at the corners of the soles."""

    reads = ("robot", "bodies")
    writes = ("anchors",)

    links: list[str]
    """Patterns (``*_foot``) of the links with a sole."""
    corners: list[spatial.Vec] = []
    """The corners in the link's frame (m); none: those of the face of the link's box."""
    down: str = "-z"
    """The direction in the link's frame that the sole's face of the box looks to."""
    sensor: bool = True
    """Whether each point has a sensor, too."""

    def run(self, conversion):
        if self.down not in DIRECTIONS:
            raise ConfigError(
                "foot-contacts-down", f"foot-contacts: down is '{self.down}'",
                hint=f"it may be: {', '.join(DIRECTIONS)}",
            )  # fmt: skip
        holders = {
            link: (segment, pose)
            for segment in conversion.segments.values()
            for link, pose in segment.parts.items()
        }
        done = {}
        for link in chosen(conversion.robot, self.links):
            segment, pose = holders.get(link.name, (None, None))
            if segment is None or segment.parent is None:
                # the C library overruns its memory for forces on the base
                why = (
                    "moves with a joint only, not with a body" if segment is None else "is the base"
                )
                raise ConfigError(
                    "foot-contacts-body", f"foot-contacts: link '{link.name}' {why}",
                    hint="leave it out of 'links'",
                )  # fmt: skip
            points = []
            for number, corner in enumerate(self.corners or box_corners(link, self.down), 1):
                name = f"{link.name}_contact_{number}"
                point = mbs.Point(name, spatial.compose(pose, spatial.Pose(corner)).xyz)
                point.extforce = mbs.Sensor(f"{name}_force", FORCE)
                if self.sensor:
                    point.sensor = mbs.Sensor(f"{name}_sensor", SENSOR)
                points.append(point)
            segment.body.points += points
            done[link.name] = points
        # emit may still change names: these are the very points, and show what they are called then
        conversion.facts["foot-contacts"] = done
        conversion.note(
            "foot-contacts", f"{sum(map(len, done.values()))} contact points on {', '.join(done)}"
        )


def chosen(robot, patterns):
    links = [
        link for link in robot.links.values() if any(fnmatchcase(link.name, p) for p in patterns)
    ]
    for pattern in patterns:
        if not any(fnmatchcase(link.name, pattern) for link in links):
            raise ConfigError(
                "foot-contacts-links", f"foot-contacts: no link is called '{pattern}'",
                hint="'*' in a pattern stands for any text: '*_foot'",
            )  # fmt: skip
    return links


def box_corners(link, down):
    """The corners of the face of the link's box that looks down, in the link's frame, all round.

    The box is that of the collision, else of the visual.
    """
    boxes = [
        part for part in (*link.collisions, *link.visuals) if isinstance(part.geometry, urdf.Box)
    ]
    if not boxes:
        raise ConfigError(
            "foot-contacts-box", f"foot-contacts: link '{link.name}' has no box to take corners of",
            hint="give them: 'corners: [[x, y, z], ...]' (m, in the link's frame)",
        )  # fmt: skip
    half = [size / 2 for size in boxes[0].geometry.size]
    pose = boxes[0].origin.pose
    # the face whose normal is most along 'down': that row of the rotation has the largest element
    row, sign = DIRECTIONS[down]
    along = pose.rot[3 * row : 3 * row + 3]
    axis = max(range(3), key=lambda k: abs(along[k]))
    one, two = (k for k in range(3) if k != axis)
    corners = []
    for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
        corner = [0.0, 0.0, 0.0]
        corner[axis] = half[axis] if sign * along[axis] > 0 else -half[axis]
        corner[one], corner[two] = a * half[one], b * half[two]
        corners.append(spatial.compose(pose, spatial.Pose(tuple(corner))).xyz)
    return corners


@hookimpl
def urdf2mbs_passes():
    return [FootContacts]
