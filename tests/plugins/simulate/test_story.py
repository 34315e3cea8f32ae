"""What a run tells of a robot on its feet: that it stands, or when and which way it fell."""

import json
from pathlib import Path

import numpy as np
import pytest

from support.build import link, solid
from support.standin import make
from urdf2mbs.cli import main
from urdf2mbs_simulate.project import simulate
from urdf2mbs_simulate.story import RobotMotion

EDGE, HIGH = 0.1, 0.5


def upright(name: str, mass: float, height: float) -> str:
    """Return a link whose centre of mass is at a height (m)."""
    return link(name, solid(mass, mass / 20, xyz=f"0 0 {height}"))


#: A post on four points, whose centre of mass is 0.5 m above their middle; its head is at 1 m.
POST = f"""<robot name="post">{upright("post", 2.0, HIGH)}{upright("head", 1e-3, 0.0)}
  <joint name="neck" type="fixed"><parent link="post"/><child link="head"/><origin xyz="0 0 1"/>
  </joint></robot>"""
CORNERS = [[EDGE * a, EDGE * b, 0.0] for a in (-1, 1) for b in (-1, 1)]
PASSES = {"contacts": {"points": {"post": CORNERS, "head": [[0, 0, 0]]}, "friction": 2.0}}


@pytest.fixture
def post(tmp_path: Path) -> Path:
    return make(tmp_path, POST, "post", base="floating", passes=PASSES)


def test_it_stands(post: Path) -> None:
    story = simulate(post, time=0.5, language="python").story()
    assert story is not None
    assert not story.fell
    assert story.events == []
    assert story.words.startswith("post stands: its base is ")


@pytest.mark.parametrize("rate", [2.0, pytest.param(1000.0, marks=pytest.mark.slow)])
def test_it_stands_at_any_rate_of_frames(post: Path, rate: float) -> None:
    story = simulate(post, time=1.0, rate=rate).story()
    assert story is not None
    assert not story.fell


@pytest.mark.parametrize(
    ("force", "way"),
    [
        ("0,9,0", "to the left"),
        ("9,1,0", "forward"),
        pytest.param("0,-9,0", "to the right", marks=pytest.mark.slow),
        pytest.param("-9,1,0", "backward", marks=pytest.mark.slow),
    ],
)
def test_it_falls_over_an_edge(force: str, way: str, post: Path) -> None:
    """The edge stays, so that the centre of mass is beside it by what the post's tilt says."""
    results = simulate(post, time=1.2, push=[f"post:{force}@0.2..0.6"], language="python")
    story = results.story()
    assert story is not None
    assert story.fell
    left = story.events[0]
    assert left.what == "left-feet"
    assert left.words.endswith(f" mm {way}")
    frame = round(left.time * 100)
    tilt = np.abs([results.joint(f"floating_base_R{k}")[frame] for k in (1, 2)]).max()
    beside = HIGH * np.sin(tilt) - EDGE * np.cos(tilt)
    assert float(left.words.split()[-2 - way.count(" ") - 1]) / 1e3 == pytest.approx(
        beside, abs=2e-3
    )
    assert 0.03 * HIGH < beside < 0.06 * HIGH


def test_a_run_that_ends_while_it_tips_says_so(post: Path) -> None:
    """It has not fallen yet, and does not stand either."""
    push = ["post:7,1,0@0.2..0.5"]
    story = simulate(post, time=0.7, push=push, language="python").story()
    assert story is not None
    assert not story.fell
    assert [event.what for event in story.events] == ["left-feet"]
    assert story.words.startswith("post is tipping when the run ends, and may fall (--time): at ")
    assert story.words.endswith(" mm forward")


@pytest.mark.parametrize("time", [0.3, 0.5, 0.65, 0.8])
def test_a_push_that_it_withstands_is_no_tipping(time: float, post: Path) -> None:
    """It rocks on its edges, where the centre of pressure jumps."""
    story = simulate(post, time=time, push=["post:3,0,0@0.2..0.6"]).story()
    assert story is not None
    assert story.words.startswith("post stands: ")


def test_it_hits_the_ground_and_the_command_says_so(
    post: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        "simulate",
        str(post),
        "--time",
        "2",
        "--push",
        "post:0,9,0@0.2..0.6",
        "--language",
        "python",
    ]
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fell"] is True
    assert [event["what"] for event in told["events"]] == ["left-feet", "hit-ground"]
    assert told["events"][1]["words"] == "'head' hit the ground"
    assert told["events"][0]["time"] < told["events"][1]["time"]


def test_what_cannot_touch_goes_under_the_ground_and_is_named(tmp_path: Path) -> None:
    """The post has a tail that hangs over the edge, and falls."""
    text = f"""<robot name="post">{upright("post", 2.0, HIGH)}{upright("tail", 5.0, 0.0)}
      <joint name="hip" type="fixed"><parent link="post"/><child link="tail"/>
      <origin xyz="0.6 0 0.1"/></joint></robot>"""
    passes = {"contacts": {"points": {"post": CORNERS}, "friction": 2.0}}
    project = make(tmp_path, text, "post", base="floating", passes=passes)
    story = simulate(project, time=2.0, language="python").story()
    assert story is not None
    under = story.events[-1]
    assert under.what == "under-ground"
    assert under.words == "'tail' went under the ground, since 'contacts' leaves it out"
    assert story.words.endswith(f"at {under.time:.2g} s {under.words}")


def test_what_tips_with_its_mass_over_its_feet_has_not_left_them(post: Path) -> None:
    results = simulate(post, time=0.1, language="python")
    motion = RobotMotion(results)
    assert motion.describe_tipping("post", motion.find_departure(5)).words == "it tipped over"


def test_what_is_bolted_down_has_no_story(tmp_path: Path) -> None:
    bolted = make(tmp_path, POST, "post", base="fixed", passes=PASSES)
    assert simulate(bolted, time=0.1, language="python").story() is None
