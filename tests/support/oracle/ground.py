"""The ground: a push along the normal that grows with depth and rate, and friction.

What touches first of a body, however it is turned, is the lowest point of the shapes that were
asked for.  Each spot is pushed with ``stiffness depth (1 + rate / speed)``, never pulled, and rubs
with at most ``friction`` times the push, by its bristle; the bristles of a body move as the body
does.  Friction and height are those asked for; the other numbers, which urdf2mbs chooses, are those
of the .mbs.
"""

from collections.abc import Iterator
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

import numpy as np

from support.oracle.case import Case

#: The user model with the indices in ux of each body's bristles.
STATE_NUMBERS = "contact_state"
#: Depth of the lowest spot (m), its rate and the slip of the body, in parts of the law's speeds.
STATES = ((-0.1, 0.0, 1.0), (0.01, 0.0, 0.0), (0.02, 0.5, 40.0), (0.03, -0.5, 0.5), (0.3, -2, 1))


class Touch(NamedTuple):
    """A body in the ground: the position of its origin, its velocities and its bristles."""

    force: str
    position: Any
    axes: Any
    """Rows are the axes of the body."""
    speed: Any
    spin: Any
    bent: Any


def prove(case: Case) -> None:
    options = case.asked.get("contacts")
    contacts = {c.point.extforce.name: c for c in case.simulation.contacts if c.point.extforce}
    patterns = (*options.links, *options.roll, *options.points) if options else ()
    if not patterns:
        return
    wanted = [n for n in case.stated.links if any(fnmatchcase(n, pattern) for pattern in patterns)]
    touching = [link for contact in contacts.values() for link in contact.links]
    for link in wanted:
        if link not in touching:
            case.differ(f"link '{link}'", "does not touch the ground")
    friction = options.friction
    if friction is None:  # the URDF's, of the link with the least
        stated = case.stated.ground_friction
        numbers = [stated[link] for link in touching if stated.get(link, -1.0) >= 0.0]
        friction = min(*numbers, 100.0) if numbers else 0.8
    law = {"ground": options.ground, "friction": friction}
    case.compare("contact law", [*law.values()], [case.get("contact", k) for k in law], "", 1.0)
    up = _up(case)
    axes = np.array([up, *case.simulation.horizontal_axes])
    case.compare("the directions of bristles", np.eye(3), axes @ axes.T, "")
    for force, contact in contacts.items():
        _prove_places(case, force, contact.links, options)
        for touch in touches(case, force, contact.spots):
            _prove_law(case, touch, contact.spots)


def lowest(case: Case, contact: Any) -> float:
    """Return the height of the lowest spot of a body at the present state (m)."""
    origin = case.in_mbs(contact.point.extforce.name)
    return float(min((origin.P + _arms(contact.spots, origin.R, _up(case))) @ _up(case)))


def _up(case: Case) -> Any:
    up = -np.array(case.gravity) if any(case.gravity) else np.array((0.0, 0.0, 1.0))
    return up / np.linalg.norm(up)


def touches(case: Case, force: str, spots: Any) -> Iterator[Touch]:
    """Draw poses of a body in the ground, deep and less deep, fast and slow."""
    up, ground = _up(case), case.get("contact", "ground")
    speed, longest = case.get("contact", "speed"), case.get("contact", "friction")
    longest *= case.get("contact", "bristle")
    for depth, rate, slip_factor in STATES:
        axes = np.linalg.qr(case.random.normal(size=(3, 3)))[0]
        axes[0] *= np.linalg.det(axes)
        lowest = min(_arms(spots, axes, up) @ up)
        position = case.random.uniform(-1.0, 1.0, 3)
        position += (ground - depth - lowest - position @ up) * up
        slip = (
            slip_factor * longest / case.get("contact", "bristle_time") * case.random.normal(size=3)
        )
        spin = case.random.normal(size=3) * (np.linalg.norm(slip) + abs(rate) * speed)
        bent = case.random.uniform(-1.0, 1.0, 3) * longest * (2.0, 2.0, 20.0)
        yield Touch(force, position, axes, slip - (slip @ up + rate * speed) * up, spin, bent)


def _prove_places(case: Case, force: str, links: list[str], options: Any) -> None:
    """Compare where the push begins with the lowest point of the shapes of the links."""
    case.go(1)
    up, body = _up(case), case.in_mbs(force)
    ground = case.get("contact", "ground")
    for _ in range(20):
        axes = np.linalg.qr(case.random.normal(size=(3, 3)))[0]
        lowest = np.inf
        for link in links:
            link_pose = case.on_link(link)
            turned = axes.T @ body.R @ link_pose.R.T  # from the link's axes to the base's
            origin = axes.T @ body.R @ (link_pose.P - body.P)
            lowest = min(lowest, origin @ up + _lowest(case, link, options, turned.T @ up))
        for above, touches in ((1e-7, False), (-1e-7, True)):
            position = (ground + above - lowest) * up
            push = case.external(force, position, np.zeros(3), axes=axes)[:3] @ up
            if bool(push > 0.0) != touches:
                problem = "pushes before" if push > 0.0 else "does not push when"
                case.differ(f"contact '{force}'", f"the ground {problem} a shape touches")


def _lowest(case: Case, link: str, options: Any, up: Any) -> float:
    """Return the height of the lowest point of a link's shapes above its origin (m)."""
    if link in options.points:
        return float(min(np.array(options.points[link]) @ up))
    heights = []
    for shape in case.stated.collisions[link]:
        up_in_shape, middle = shape.pose[:3, :3].T @ up, shape.pose[:3, 3] @ up
        if shape.kind == "sphere":
            heights.append(middle - shape.size[0])
        elif shape.kind == "cylinder":
            radius, length = shape.size
            flat = length / 2 * abs(up_in_shape[2])
            heights.append(middle - flat - radius * np.hypot(up_in_shape[0], up_in_shape[1]))
        elif shape.kind == "box" and not any(fnmatchcase(link, p) for p in options.roll):
            heights.append(middle - np.abs(up_in_shape) @ np.array(shape.size) / 2)
    return float(min(heights))


def _arms(spots: Any, axes: Any, up: Any) -> Any:
    """Return the arms (spots, 3) from the body's origin to where they touch (m)."""
    arms = []
    for spot in spots:
        arm, axis = np.array(spot.centre) @ axes, np.array(spot.axis) @ axes
        down = (up @ axis) * axis - up
        size = np.linalg.norm(down)
        forth = spot.radius * (down / size if size > 1e-9 else np.zeros(3))
        arms.append(
            arm + np.cos(spot.rim_angle) * forth + np.sin(spot.rim_angle) * np.cross(axis, forth)
        )
    return np.array(arms)


def _prove_law(case: Case, touch: Touch, spots: Any) -> None:
    names = ("ground", "stiffness", "speed", "friction", "bristle", "bristle_time")
    ground, stiffness, speed, friction, length, time = (case.get("contact", n) for n in names)
    up, across = _up(case), np.array(case.simulation.horizontal_axes)
    number = [contact.spots is spots for contact in case.simulation.contacts].index(True)
    states = [*case.data.user_model[STATE_NUMBERS].values()][number]
    force, torque, moves = np.zeros(3), np.zeros(3), []
    for arm in _arms(spots, touch.axes, up):
        depth = ground - (touch.position + arm) @ up
        velocity = touch.speed + np.cross(touch.spin, arm)
        normal = stiffness * max(depth, 0.0) * max(1.0 - velocity @ up / speed, 0.0)
        bent = touch.bent[:2] + touch.bent[2] * (across @ np.cross(up, arm))
        slip = across @ velocity
        push = normal * (up - _shortened(bent + time * slip, friction * length) @ across / length)
        force, torque = force + push, torque + np.cross(arm, push)
        if normal:
            rate = slip - (bent - _shortened(bent, friction * length)) / time
            moves.append((np.sqrt(normal), across @ np.cross(up, arm), rate))
    case.data.ux[states] = touch.bent
    actual = case.external(
        touch.force, touch.position, touch.speed, axes=touch.axes, spin=touch.spin
    )
    expected = [*force, *torque, *case.points[touch.force][1].coordinates]
    case.compare(f"contact '{touch.force}'", expected, actual, "N, N m, m")
    rates = -np.array(touch.bent) / time
    if moves:  # the shift and the turn that are nearest to the rates, by the pushes
        root, turned, wanted = (np.array(each) for each in zip(*moves, strict=True))
        centre = root**2 @ turned / (root @ root)
        spread = root**2 @ ((turned - centre) ** 2).sum(axis=1) / (root @ root)
        part = min(max(spread / length**2 - 1.0, 0.0), 1.0)
        rows = np.concatenate(
            [
                weight * np.column_stack([np.eye(2), turn])
                for weight, turn in zip(root, turned - centre, strict=True)
            ]
        )
        fit = np.linalg.lstsq(rows, (root[:, None] * wanted).ravel(), rcond=None)[0]
        turn = part * fit[2] + (1.0 - part) * rates[2]
        rates = [*(fit[:2] - turn * centre), turn]
    case.compare(f"bristles of '{touch.force}'", rates, case.data.uxd[states], "m/s, rad/s")


def _shortened(vector: Any, longest: float) -> Any:
    size = np.linalg.norm(vector)
    return vector * (longest / size if size > longest else 1.0)
