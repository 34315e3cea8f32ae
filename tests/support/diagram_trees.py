"""Random trees of bodies, for the tests of the diagram and of its pass."""

from hypothesis import strategies as st

from support.diagram_faults import boxes
from urdf2mbs.mbs.model import Body, Joint, Mbs, Point
from urdf2mbs.spatial import Vec

#: Coordinates of points (m).
LENGTHS = st.sampled_from((0.0, 0.1, -0.1, 0.2, -0.35, 0.5, 1e-6, -0.02))


@st.composite
def trees(draw: st.DrawFn) -> Mbs:
    """Random trees in any order of bodies: long chains, many points, shared points, long names."""
    mbs = Mbs("m")
    where = st.tuples(LENGTHS, LENGTHS, LENGTHS)
    for k in range(draw(st.integers(0, 8))):
        mbs.base.points.append(Point(f"bp{k}", draw(where)))
    for index in range(draw(st.integers(0, 14))):
        parent = draw(st.sampled_from([None, *mbs.bodies]))
        points = mbs.base.points if parent is None else parent.points
        point = draw(st.sampled_from([None, *points]))
        mbs.bodies.append(
            Body(
                f"{index}".rjust(draw(st.integers(2, 65)), "b"),
                None if parent is None else parent.name,
                None if point is None else point.name,
                [Joint(f"j{index}_{k}", "R1") for k in range(draw(st.integers(1, 8)))],
                points=[Point(f"p{k}", draw(where)) for k in range(draw(st.integers(0, 20)))],
            )
        )
    return mbs


def add_body(
    mbs: Mbs, parent: Body | None, name: str, at: Vec = (0.0, 0.0, 0.0), joints: int = 1
) -> Body:
    """A body at a point of its own on its parent."""
    point = Point(f"to_{name}", at)
    (mbs.base.points if parent is None else parent.points).append(point)
    body = Body(
        name,
        None if parent is None else parent.name,
        point.name,
        [Joint(f"{name}_j{k}", "R1") for k in range(joints)],
    )
    mbs.bodies.append(body)
    return body


def humanoid() -> Mbs:
    """A pelvis, a chest, a head, two arms of four bodies and two legs of four."""
    mbs = Mbs("m")
    pelvis = add_body(mbs, None, "pelvis", joints=6)
    chest = add_body(mbs, pelvis, "chest", (0.0, 0.0, 0.3))
    add_body(mbs, chest, "head", (0.0, 0.0, 0.3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        arm = add_body(mbs, chest, f"{side}_shoulder", (0.0, 0.2 * sign, 0.2))
        for part in ("arm", "forearm", "hand"):
            arm = add_body(mbs, arm, f"{side}_{part}", (0.0, 0.0, -0.2))
        leg = add_body(mbs, pelvis, f"{side}_hip", (0.0, 0.1 * sign, -0.1))
        for part in ("thigh", "shank", "foot"):
            leg = add_body(mbs, leg, f"{side}_{part}", (0.0, 0.0, -0.3))
    return mbs


def centres(mbs: Mbs) -> dict[str, tuple[float, float]]:
    return {b.name: ((b.left + b.right) / 2, (b.top + b.bottom) / 2) for b in boxes(mbs)}
