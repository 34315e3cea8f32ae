"""Mechanisms with closed loops, written straight into an ``.mbs``."""

from pathlib import Path
from typing import Any

from urdf2mbs.mbs.model import BASE, Body, Connection, Joint, Mbs, Point
from urdf2mbs.mbs.writer import write

FREE, FOLLOWS = "independent", "dependent"


def arm(
    name: str,
    parent: str,
    *joints: tuple[str, float, str],
    at: Any = None,
    mass: float = 1.0,
    speed: float | None = None,
    **points: Any,
) -> Body:
    """Return a body at a point of another.

    Joints have a type, a position and a nature; the last one may have a speed.
    """
    made = [
        Joint(
            name=f"{name}_{k}",
            type=kind,
            nature=nature,
            q=q or None,
            symbols=("q",) if nature == "driven" else None,
        )
        for k, (kind, q, nature) in enumerate(joints)
    ]
    made[-1].qd = speed
    corners = [Point(name=point, coordinates=place) for point, place in points.items()]
    inertia = tuple(mass * x for x in (0.02, 0.0, 0.0, 0.03, 0.0, 0.04))
    return Body(
        name=name,
        parent=None if parent == BASE else parent,
        point=at,
        joints=made,
        points=corners,
        mass=mass or None,
        com=(0.1, 0.02, -0.05) if mass else None,
        inertia=inertia,  # type: ignore[arg-type]
    )


def made(tmp_path: Path, *bodies: Body, cuts: Any = (), **points: Any) -> Path:
    model = Mbs(
        "loops",
        bodies=list(bodies),
        cuts=[
            Connection(kind, f"cut_{k}", one, other, *length)
            for k, (kind, one, other, *length) in enumerate(cuts, start=1)
        ],
    )
    model.base.points = [Point(name=name, coordinates=place) for name, place in points.items()]
    file = tmp_path / f"{len(list(tmp_path.iterdir()))}" / "dataR" / "loops.mbs"
    file.parent.mkdir(parents=True)
    file.write_bytes(write(model))
    return file


def four_bar_bodies(natures: list[str], turn: float, **crank: Any) -> list[Body]:
    return [
        arm("crank", BASE, ("R2", 0.3, natures[0]), tip=(0.0, 0.0, 0.2), **crank),
        arm("rod", "crank", ("R2", turn, natures[1]), at="tip", tip=(0.0, 0.0, 0.7)),
        arm("rocker", BASE, ("R2", 0.1, natures[2]), at="pivot", tip=(0.0, 0.0, 0.5)),
    ]


def four_bar(tmp_path: Path, natures: list[str], turn: float, *more: Any, **crank: Any) -> Path:
    """Make a crank and two bars; the drawing is not closed where ``turn`` is not the right one."""
    bodies = four_bar_bodies(natures, turn, **crank)
    cuts = [("ball", ("rod", "tip"), ("rocker", "tip")), *more]
    return made(tmp_path, *bodies, cuts=cuts, pivot=(0.6, 0.0, 0.0))
