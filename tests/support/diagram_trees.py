"""Random trees of bodies, for the tests of the diagram and of its pass."""

from hypothesis import strategies as st

from urdf2mbs.mbs.model import Body, Joint, Mbs, Point

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
