"""Models to write and to read: one that has everything, and random ones."""

from itertools import count
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st

from support.examples import reproducible
from urdf2mbs.mbs.model import (
    Base,
    Body,
    Connection,
    Drawing,
    Joint,
    Light,
    Mbs,
    Parameter,
    Point,
    Sensor,
    Shape,
    UserConstraint,
    UserModel,
    UserVariable,
    View,
    Viewpoint,
)


def everything() -> Mbs:
    """Return a model with every class and every field in use, no two numbers alike."""
    number = count(1)

    def n() -> float:
        return next(number) / 64

    def xyz() -> tuple[float, float, float]:
        return (n(), n(), n())

    def xy() -> tuple[float, float]:
        return (n(), n())

    def drawing(shape: str = "rectangle", points: int = 4) -> Drawing:
        return Drawing(xy(), xy(), tuple(xy() for _ in range(points)), shape, xy(), n())

    def shape(kind: str, **own: Any) -> Shape:
        return Shape(kind, f"a_{kind}", xyz(), xyz(), xyz(), (1, 2, 3), n(), **own)

    measures = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
    trunk = Body(
        "trunk",
        joints=[
            Joint("lift", "T3", "independent", n(), n(), n(), position=xy()),
            Joint("turn", "R3", "driven", n(), symbols=("q",), position=xy()),
            Joint("tilt", "R1", "dependent", actuated=True, symbols=("q", "qd", "qdd")),
            Joint("still", "R2", "driven", symbols=()),
        ],
        mass=n(),
        com=xyz(),
        inertia=(n(), n(), n(), n(), n(), n()),
        points=[
            Point("shoulder", xyz(), xy(), Sensor("imu", (*measures, "Jac"))),
            Point("handle", xyz(), None, Sensor("touch"), Sensor("push", measures)),
        ],
        shapes=[
            shape("box", size=xyz()),
            shape("cylinder", radius=n(), height=n()),
            shape("cone", radius=n(), height=n()),
            shape("sphere", radius=n()),
            shape("inline", url="PRJPATH/animationR/vrml/trunk & co.wrl"),
        ],
        drawing=drawing(),
    )
    arm = Body(
        "arm",
        "trunk",
        "shoulder",
        [Joint("swing", "R1")],
        points=[Point("tip")],
        drawing=drawing("circle", 1),
    )
    leg = Body("leg", "trunk", None, [Joint("kick", "R2")], drawing=drawing("ellipse"))
    cart = Body("cart", None, "rail", [Joint("roll", "T1")], drawing=drawing())
    return Mbs(
        "machine",
        "1.8",
        Base(
            "workshop",
            xyz(),
            [Point("rail", xyz(), xy())],
            [shape("box", size=xyz())],
            xy(),
            drawing(),
        ),
        [trunk, arm, leg, cart],
        [
            Connection("ball", "a_ball", ("arm", "tip"), (None, "rail")),
            Connection("rod", "a_rod", ("arm", None), ("leg", None), n()),
            Connection("solid", "a_solid", ("cart", None), (None, None)),
        ],
        [
            Connection("link", "a_spring", ("arm", "tip"), ("cart", None)),
            Connection("link3D", "a_bushing", ("arm", "tip"), ("leg", None)),
        ],
        [UserConstraint("gear", ("swing", "kick")), UserConstraint("none_yet")],
        [
            UserModel(
                "Motor",
                [
                    Parameter("gain", "scalar", ("0.5",)),
                    Parameter("table", "lut1D", ("0.0", "1.0", "2.0", "4.0")),
                    Parameter("empty", "state"),
                ],
            )
        ],
        [UserVariable("q_ref", "in", "31"), UserVariable("t", "out", "1")],
        View(
            (4, 5, 6),
            n(),
            n(),
            n(),
            n(),
            [Viewpoint("eye", xyz(), xyz(), xyz(), "swing", "perspective", n(), n(), n(), n())],
            [Light("sun", xyz()), Light("lamp", xyz(), "swing", active=False)],
        ),
    )


#: The same examples every time, however slow the machine.
few = settings(reproducible, max_examples=40)

numbers = st.floats(allow_nan=False, allow_infinity=False).map(lambda value: value + 0.0)
vectors = st.tuples(numbers, numbers, numbers)
pixels = st.tuples(numbers, numbers)
#: What may stand in a name, though not in an identifier.
spellings = st.sampled_from(["link", "Ünï code", "<&>", "\"quoted'", "1", "_", "int", "a]]>b"])


@st.composite
def models(draw: st.DrawFn) -> Mbs:
    """Any model that a file can hold, its names unique."""
    unique = count()

    def name() -> str:
        return f"{draw(spellings)}{next(unique)}"

    def optional(strategy: st.SearchStrategy[Any]) -> Any:
        return draw(st.none() | strategy)

    def some(most: int) -> range:
        return range(draw(st.integers(0, most)))

    def sensor() -> Sensor:
        measures = st.sampled_from(["Pos", "Rot", "Vit", "Om", "Acc", "Omp"])
        return Sensor(name(), tuple(draw(st.lists(measures, unique=True))))

    def drawing() -> Drawing:
        corners = tuple(draw(pixels) for _ in range(4))
        return Drawing(draw(pixels), draw(pixels), corners, angle=draw(numbers))

    def point(in_base: bool) -> Point:
        return Point(
            name(),
            draw(vectors),
            optional(pixels),
            sensor() if not in_base and draw(st.booleans()) else None,
            sensor() if not in_base and draw(st.booleans()) else None,
        )

    def shape() -> Shape:
        kind = draw(st.sampled_from(["box", "cylinder", "cone", "sphere", "inline"]))
        round_ = kind in ("cylinder", "cone", "sphere")
        return Shape(
            kind,
            name(),
            draw(vectors),
            draw(vectors),
            draw(vectors),
            size=draw(vectors) if kind == "box" else None,
            radius=draw(numbers) if round_ else None,
            height=draw(numbers) if round_ and kind != "sphere" else None,
            url=f"{name()}.wrl" if kind == "inline" else None,
        )

    def joint() -> Joint:
        symbols = st.sampled_from([(), ("q",), ("q", "qd"), ("q", "qd", "qdd"), ("qdd",)])
        return Joint(
            name(),
            draw(st.sampled_from(["T1", "T2", "T3", "R1", "R2", "R3"])),
            draw(st.sampled_from(["independent", "dependent", "driven"])),
            optional(numbers),
            optional(numbers),
            optional(numbers),
            draw(st.booleans()),
            optional(symbols),
            optional(pixels),
        )

    mbs = Mbs(
        name(),
        base=Base(
            name(),
            draw(vectors),
            [point(True) for _ in some(2)],
            [shape() for _ in some(1)],
            optional(pixels),
            drawing() if draw(st.booleans()) else None,
        ),
    )
    for _ in some(4):
        parent = draw(st.sampled_from([None, *mbs.bodies]))
        carrier = mbs.base if parent is None else parent
        at = draw(st.sampled_from([None, *carrier.points]))
        mbs.bodies.append(
            Body(
                name(),
                parent and parent.name,
                at and at.name,
                [joint(), *(joint() for _ in some(2))],
                optional(numbers),
                optional(vectors),
                optional(st.tuples(*[numbers] * 6)),
                [point(False) for _ in some(2)],
                [shape() for _ in some(2)],
                drawing() if draw(st.booleans()) else None,
            )
        )
    places: list[tuple[str | None, str | None]] = [(None, None)]
    places += [(body.name, point.name) for body in mbs.bodies for point in body.points]
    for kind in draw(st.lists(st.sampled_from(["ball", "rod", "solid", "link", "link3D"]))):
        ends = draw(st.sampled_from(places)), draw(st.sampled_from(places))
        connection = Connection(kind, name(), *ends, draw(numbers) if kind == "rod" else None)
        (mbs.links if kind.startswith("link") else mbs.cuts).append(connection)
    for _ in some(1):
        joints = [joint.name for body in mbs.bodies for joint in body.joints]
        mbs.user_constraints.append(UserConstraint(name(), tuple(joints)))
        mbs.user_models.append(UserModel(name(), [Parameter(name(), "vector", ("1", "2"))]))
        mbs.user_variables.append(UserVariable(name(), "inout", "3"))
        mbs.view = View(
            frame=draw(numbers),
            viewpoints=[Viewpoint(name(), draw(vectors), draw(vectors))],
            lights=[Light(name(), draw(vectors))],
        )
    return mbs
