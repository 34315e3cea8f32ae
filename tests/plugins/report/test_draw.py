"""The SVG diagram: all that the file has is in it, where the file says."""

import re
from pathlib import Path

import msgspec
import pytest
from lxml import etree

from support.mbs_models import everything
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Body, Connection, Drawing, Joint, Mbs, Point, Sensor
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_report.draw import draw

SVG = "{http://www.w3.org/2000/svg}"
Box = tuple[float, float, float, float]


class Picture:
    """An SVG diagram, read back."""

    def __init__(self, text: str) -> None:
        self.root = etree.fromstring(text.encode())

    def groups(self, kind: str) -> list[etree._Element]:
        return [g for g in self.root.iter(f"{SVG}g") if kind in (g.get("class") or "").split()]

    def boxes(self) -> dict[str, Box]:
        """Left, top, right, bottom of each body's box; the base is ''."""
        out = {}
        for group in self.groups("body"):
            shape = next(s for s in group if s.get("class") == "box")
            if shape.tag == f"{SVG}rect":
                x, y, w, h = (float(shape.get(k) or "") for k in ("x", "y", "width", "height"))
                out[group.get("data-body") or ""] = (x, y, x + w, y + h)
            elif shape.tag == f"{SVG}polygon":
                corners = [c.split(",") for c in (shape.get("points") or "").split()]
                xs, ys = [float(x) for x, _ in corners], [float(y) for _, y in corners]
                out[group.get("data-body") or ""] = (min(xs), min(ys), max(xs), max(ys))
            else:
                cx, cy, rx, ry = (float(shape.get(k) or "") for k in ("cx", "cy", "rx", "ry"))
                out[group.get("data-body") or ""] = (cx - rx, cy - ry, cx + rx, cy + ry)
        return out

    def dots(self, kind: str, *keys: str) -> dict[tuple[str, ...], tuple[float, float]]:
        out = {}
        for group in self.groups(kind):
            circle = group.find(f"{SVG}circle")
            assert circle is not None
            name = tuple(group.get(key) or "" for key in keys)
            out[name] = (float(circle.get("cx") or ""), float(circle.get("cy") or ""))
        return out

    def labels(self) -> list[tuple[str, str]]:
        return [
            tuple(text.text or "" for text in group.findall(f"{SVG}text"))  # type: ignore[misc]
            for group in self.groups("joint-label")
        ]

    def wires(self) -> list[list[float]]:
        """Return the first and the last point of each wire."""
        ends = []
        for path in self.root.iter(f"{SVG}path"):
            if path.get("class") == "wire":
                numbers = [float(n) for n in re.findall(r"-?[\d.]+", path.get("d") or "")]
                ends.append(numbers[:2] + numbers[-2:])
        return ends


def assert_complete(mbs: Mbs, picture: Picture) -> None:
    """Assert that every body, joint and point is drawn once, where the file has it.

    The wire of each body leads from its parent's point, or frame, through all its joints.
    """
    assert set(picture.boxes()) == {"", *(body.name for body in mbs.bodies)}
    frames = {None: mbs.base.position, **{b.name: b.joints[-1].position for b in mbs.bodies}}
    points = {
        (name, p.name): p.position or frames[name]
        for name, owner in mbs.base_and_bodies()
        for p in owner.points
    }
    expected = {
        (name or "", point): pytest.approx(position) for (name, point), position in points.items()
    }
    assert picture.dots("point", "data-body", "data-point") == expected
    joints, wires = {}, []
    for body in mbs.bodies:
        position = frames[body.parent] if body.point is None else points[body.parent, body.point]
        for joint in body.joints:
            assert position is not None
            assert joint.position is not None
            joints[joint.name,] = pytest.approx(joint.position)
            wires.append(pytest.approx([*position, *joint.position], abs=0.01))
            position = joint.position
    assert picture.dots("joint", "data-joint") == joints
    assert picture.wires() == wires
    types = [joint.type for body in mbs.bodies for joint in body.joints]
    assert picture.labels() == [(type_, f"q{n}") for n, type_ in enumerate(types, start=1)]


def test_boxes_of_a_real_file_stand_where_mbsyspad_draws_them(shared: Path) -> None:
    file = shared / "mbs-samples" / "minimal.mbs"
    boxes = Picture(draw(read_mbs(file.read_bytes(), str(file)))).boxes()
    # read off minimal.png, MBSysPad's own picture of this file
    assert boxes == {
        "": (90, 20, 210, 60),
        "torso": (100, 300, 200, 360),
        "arm": (100, 440, 200, 500),
        "empty": (300, 400, 400, 460),
        "hand": (300, 560, 400, 620),
    }


def small() -> Mbs:
    body_one = Body(
        "one",
        point="p",
        joints=[Joint("j1", "R3", position=(100, 200))],
        points=[Point("q", (0, 0, 1), (100, 260), Sensor("s"), Sensor("f"))],
        drawing=Drawing((-50, 0), (100, 60)),
    )
    body_two = Body(
        "two",
        parent="one",
        point="q",
        joints=[Joint("j2", "T1", "driven", q=0.5, position=(400, 300))],
        drawing=Drawing((35, -4), (34, 34), shape="circle"),
    )
    body_three = Body(
        "three",
        parent="two",
        joints=[Joint("j3", "R2", position=(400, 500))],
        drawing=Drawing((0, 10), (60, 20), shape="ellipse"),
    )
    mbs = Mbs("small", bodies=[body_one, body_two, body_three])
    mbs.base.position = (100, 60)
    mbs.base.drawing = Drawing((-60, -40), (120, 40))
    mbs.base.points = [Point("p", (0, 0, 0), (130, 60))]
    return mbs


def test_shapes_are_drawn_where_the_model_has_them() -> None:
    boxes = Picture(draw(small())).boxes()
    assert boxes["one"] == (50, 200, 150, 260)
    assert boxes["two"] == (400 + 35 - 34, 300 - 4 - 34, 400 + 35 + 34, 300 - 4 + 34)
    assert boxes["three"] == (340, 490, 460, 530)


def test_everything_is_inside_the_picture() -> None:
    mbs = small()
    mbs.bodies[2].drawing = Drawing((-700, 10), (60, 900))
    picture = Picture(draw(mbs))
    x, y, width, height = map(float, (picture.root.get("viewBox") or "").split())
    for left, top, right, bottom in picture.boxes().values():
        assert x <= left < right <= x + width
        assert y <= top < bottom <= y + height


def test_arrows_lead_from_each_body_to_its_points() -> None:
    text = draw(small())
    starts = re.findall(r'class="arrow" d="M([\d.]+),([\d.]+) L', text)
    assert starts == [("100", "60"), ("100", "200")]


def test_sensors_and_forces_are_marked() -> None:
    marks = re.findall(r'class="mark"[^>]*>(\w)<', draw(small()))
    assert marks == ["S", "F"]
    marks = re.findall(r'class="mark" x="([\d.]+)"', draw(small()))
    assert float(marks[1]) - float(marks[0]) >= 6.0


def test_a_wire_is_an_s() -> None:
    """Its control points are aside by 0.2 of its length, by 40 px at most, to the left first."""
    mbs = small()
    for end, aside in (((100, 300), 20.0), ((100, 1200), 40.0)):
        mbs.bodies[0].joints = [
            Joint("a", "R1", position=(100, 200)),
            Joint("b", "R1", position=end),
        ]
        (wire,) = re.findall(r'class="wire" d="M100,200 C(.*?)"', draw(mbs))
        first, second, last = (tuple(map(float, p.split(","))) for p in wire.split())
        length = end[1] - 200
        assert first == pytest.approx((100 + aside, 200 + length / 3), abs=0.01)
        assert second == pytest.approx((100 - aside, 200 + 2 * length / 3), abs=0.01)
        assert last == end


def test_cuts_and_links_are_drawn() -> None:
    mbs = small()
    mbs.cuts = [Connection("rod", "strut", ("one", "q"), ("three", None), length=0.3)]
    mbs.links = [Connection("link", "spring", (None, "p"), ("two", None))]
    text = draw(mbs)
    assert 'class="cut" d="M100,260 L400,500"' in text
    assert 'class="link" d="M130,60 L400,300"' in text
    assert "length 0.3 m" in text


def test_the_label_of_a_cut_keeps_off_other_words() -> None:
    """Two cuts that cross at their middles: the second label goes aside."""
    mbs = small()
    mbs.cuts = [
        Connection("rod", "first", ("one", "q"), ("three", None)),
        Connection("rod", "again", ("one", "q"), ("three", None)),
    ]
    picture = Picture(draw(mbs))
    places = [g.find(f"{SVG}text") for g in picture.groups("connection")]
    first, again = ((float(t.get("x")), float(t.get("y"))) for t in places)
    assert max(abs(first[0] - again[0]) / 39, abs(first[1] - again[1]) / 30) >= 1


def test_a_polyline_is_drawn_corner_by_corner() -> None:
    mbs = small()
    mbs.bodies[0].drawing = Drawing((0, 0), (60, 40), ((0, 0), (60, 0), (60, 40)), shape="polyline")
    assert '<polygon class="box" points="100,200 160,200 160,240"/>' in draw(mbs)


def test_names_stand_above_the_arrows() -> None:
    text = draw(small())
    assert text.rindex('class="arrow"') < text.index('class="body-name')


def test_a_new_model_without_bodies_shows_its_base() -> None:
    assert Picture(draw(Mbs("new"))).boxes() == {"": (-60, -28, 60, 28)}


def test_all_samples_are_drawn_completely(shared: Path) -> None:
    files = sorted((shared / "mbs-samples").glob("*.mbs"))
    assert len(files) > 20
    for file in files:
        mbs = read_mbs(file.read_bytes(), str(file))
        picture = Picture(draw(mbs))
        placed = [c for c in (*mbs.cuts, *mbs.links) if not c.is_draft]
        assert len(picture.groups("connection")) == len(placed), file.name
        assert_complete(mbs, picture)


def test_names_are_escaped() -> None:
    mbs = small()
    mbs.bodies[0].name = mbs.bodies[1].parent = "<b>&\"'"
    mbs.bodies[0].joints[0].name = "</title><script>"
    mbs.name = mbs.bodies[0].points[0].name = mbs.bodies[1].point = "</svg><script>"
    picture = Picture(draw(mbs))
    assert "<b>&\"'" in picture.boxes()
    assert ("</title><script>",) in picture.dots("joint", "data-joint")
    assert ("<b>&\"'", "</svg><script>") in picture.dots("point", "data-body", "data-point")
    assert not list(picture.root.iter(f"{SVG}script"))


@pytest.mark.parametrize("element", ["body", "joint", "point", "base"])
def test_a_model_without_drawings_is_told_what_to_do(element: str) -> None:
    mbs = msgspec.convert(msgspec.to_builtins(small()), Mbs)
    if element == "body":
        mbs.bodies[1].drawing = None
    elif element == "joint":
        mbs.bodies[1].joints[0].position = None
    elif element == "point":
        mbs.bodies[0].points[0].position = None
    else:
        mbs.base.position = None
    with pytest.raises(ConversionError) as caught:
        draw(mbs)
    assert caught.value.code == "no-drawing"
    assert {"body": "body 'two'", "joint": "joint 'j2'", "point": "point 'q'", "base": "the base"}[
        element
    ] in caught.value.message
    assert "layout" in (caught.value.hint or "")


def test_the_command_draws_beside_the_model(
    shared: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "m.mbs"
    model.write_bytes((shared / "mbs-samples" / "minimal.mbs").read_bytes())
    assert main(["diagram", str(model)]) == 0
    assert Picture((tmp_path / "m.svg").read_text()).boxes()
    assert main(["diagram", str(model), "-o", str(tmp_path / "x" / "y.svg")]) == 0
    assert (tmp_path / "x" / "y.svg").read_bytes() == (tmp_path / "m.svg").read_bytes()
    assert "4 bodies" in capsys.readouterr().out


def test_the_command_refuses_what_is_no_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["diagram", str(tmp_path / "none.mbs")]) == 2
    assert "none.mbs" in capsys.readouterr().err
    (tmp_path / "bad.mbs").write_text("<robot/>")
    assert main(["diagram", str(tmp_path / "bad.mbs")]) == 1
    assert "bad.mbs" in capsys.readouterr().err
    assert not (tmp_path / "bad.svg").exists()


def place_all() -> Mbs:
    """Return the model that has everything, each part of it with a place in the diagram."""
    mbs = everything()
    for body in mbs.bodies:
        for part in (*body.joints, *body.points):
            part.position = part.position or (5.0, 5.0)
    return mbs


def test_a_cut_of_which_an_end_is_not_placed_yet_is_left_out() -> None:
    mbs = place_all()
    assert 'data-name="a_ball"' in draw(mbs)
    mbs.cuts[0].endpoint1 = ("", None)
    assert 'data-name="a_ball"' not in draw(mbs)
    assert 'data-name="a_rod"' in draw(mbs)


def test_a_sensor_on_a_bodys_own_frame_is_drawn_there() -> None:
    mbs = place_all()
    arm = mbs.bodies[1]
    arm.points.append(Point("origin", sensor=Sensor("own")))
    x, y = arm.joints[-1].position or (0.0, 0.0)
    assert f'<title>origin\n(0, 0, 0) m\nsensor own</title><circle cx="{x:.10g}" cy="{y:.10g}"' in (
        draw(mbs)
    )
    assert read_mbs(write(mbs), "m.mbs") == mbs
