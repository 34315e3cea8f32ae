"""One HTML page that shows a conversion: diagram, 3D model, tables, proof.

The page is self-contained: it loads nothing, from no network, and its own security policy
would not let it.  Its .mbs side is read back from the file's bytes.  three.js comes out of the
installed package jupyter-threejs-sage, which has nothing else in it.
"""

from __future__ import annotations

import json
import re
from html import escape
from importlib.metadata import distribution
from importlib.resources import files
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, ConversionError, counted
from urdf2mbs.diagram.draw import draw
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.proof.verdict import NOT_CHECKED
from urdf2mbs.report import around
from urdf2mbs.report.scene import Store, lookup, mbs_side, urdf_side
from urdf2mbs.report.table import number, table, titled, vector
from urdf2mbs.seal import seal
from urdf2mbs.summary import report, verdict
from urdf2mbs.urdf.changes import KINDS
from urdf2mbs.urdf.left_out import left_out

#: The package that brings three.js, and where in it three.js is.
THREE = ("jupyter-threejs-sage", "jupyter_threejs_sage/static/r130/three.min.js")


class Page(msgspec.Struct):
    """The page's bytes, and what of it is what."""

    data: bytes
    sizes: dict[str, int]
    """Bytes of the viewer (three.js), of the meshes, textures included, and in all."""
    missing: list[str]
    """Meshes of which only the place is shown."""


def make(conversion: Conversion) -> Page:
    """The page of a conversion that has run; writes nothing.

    The URDF's meshes are drawn as RViz draws them, whatever convert-meshes was told, so that a
    wrong turn shows.  Raises ConfigError where no .mbs was made.
    """
    viewer, licenses = _viewer()
    settings = conversion.settings
    output = conversion.rejected or settings.output
    if output not in conversion.files:
        raise ConfigError(
            "no-mbs", "there is no .mbs to report on: no pass has made it",
            hint="put 'emit' in the pipeline",
        )  # fmt: skip
    model = read(conversion.files[output], str(output))
    store = Store()
    robot = conversion.robot.with_flipped(conversion.names.flipped)  # one slider moves both
    project = settings.project or settings.output.parent
    data = {
        "name": model.name,
        "mbs": mbs_side(model, store, lookup(conversion.files, project)),
        "urdf": urdf_side(robot, store, conversion.packages.resolve),
        "frames": [
            (link, {"body": at.body, "joint": at.joint, "pose": (*at.pose.rot, *at.pose.xyz)})
            for link, at in conversion.frames.items()
        ],
        "coordinates": list(conversion.names.coordinates.items()),
        "joints": list(conversion.names.joints.items()),
        "meshes": store.meshes,
        "textures": store.textures,
        "marks": around.marks(conversion, model),
        "size": 18 * model.view.frame if model.view else 1.0,
        "frame": model.view.frame if model.view else 0.1,
    }
    arrays = store.packed()
    textures = sum(len(url) for url in store.textures)
    fields = {
        "name": escape(conversion.robot.name),
        "css": _own("page.css"),
        "js": _own("page.js"),
        "viewer": _script(viewer),
        "data": _island(data),
        "arrays": arrays,
        "diagram": _diagram(model),
        "verdict": _verdict(conversion),
        "facts": _facts(conversion),
        "notes": _notes(store.missing),
        "joints": _joints(conversion, model),
        "bodies": _bodies(conversion, model),
        "around": around.tables(conversion, model),
        "names": _names(conversion),
        "left_out": _left_out(conversion),
        "proof": _proof(conversion),
        "messages": _messages(conversion),
        "footer": _footer(conversion, licenses, len(viewer), len(arrays) + textures),
    }
    text = re.sub(r"\{\{(\w+)\}\}", lambda found: fields[found[1]], _own("page.html"))
    page = seal(Path("page.html"), text.encode())
    sizes = {"viewer": len(viewer), "meshes": len(arrays) + textures, "all": len(page)}
    return Page(page, sizes, list(store.missing))


def _own(name: str) -> str:
    return files("urdf2mbs.report").joinpath(name).read_text("utf-8").rstrip("\n")


def _viewer() -> tuple[str, str]:
    """three.js and its licence."""
    package = distribution(THREE[0])
    return Path(str(package.locate_file(THREE[1]))).read_text("utf-8"), package.read_text(
        "LICENSE"
    ) or ""


def _script(text: str) -> str:
    """A script that cannot end the element it stands in."""
    return re.sub(r"</(script)", r"<\\/\1", text, flags=re.IGNORECASE).replace("<!--", "<\\!--")


def _island(data: Any) -> str:
    """JSON in which no name can end the element it stands in."""
    text = json.dumps(msgspec.to_builtins(data), ensure_ascii=False, separators=(",", ":"))
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def _diagram(model: Mbs) -> str:
    try:
        return draw(model)
    except ConversionError as error:
        return f'<p class="note">{escape(error.message)}; {escape(error.hint or "")}</p>'


def _verdict(conversion: Conversion) -> str:
    found = report(conversion)
    kind = "unknown" if found.proof is None else "same" if found.proof.same else "other"
    return f'<span class="verdict {kind}">{escape(found.verdict)}</span>'


def _facts(conversion: Conversion) -> str:
    found = report(conversion)
    warnings = sum(d.level == "warning" for d in conversion.diagnostics)
    facts = [
        f"{counted(found.links, 'link')} → {counted(found.bodies, 'body')}",
        f"{counted(found.joints.urdf, 'URDF joint')} → {found.joints}",
        f"{found.mass:.6g} kg",
        found.base_in_words,
        f"{warnings} warning{'' if warnings == 1 else 's'}",
    ]
    if any(d.code == "no-mass" for d in conversion.diagnostics):
        facts.append("<b>NO DYNAMICS: no link has a mass</b>")
    return " · ".join(facts)


def _notes(missing: dict[str, str]) -> str:
    if not missing:
        return ""
    reasons: dict[str, list[str]] = {}
    for name, why in missing.items():
        reasons.setdefault(why, []).append(name)
    lines = [
        f"<li>{escape(why)}: {len(names)}, "
        f"{escape(', '.join(names[:4]))}{', ...' if len(names) > 4 else ''}</li>"
        for why, names in reasons.items()
    ]
    return (
        f'<div class="note warn">{len(missing)} meshes cannot be drawn; a small frame shows the '
        f"place of each:<ul>{''.join(lines)}</ul></div>"
    )


# --- tables ------------------------------------------------------------------------------------


def _joints(conversion: Conversion, model: Mbs) -> str:
    origin = {
        name: urdf for urdf, names in conversion.names.joints.items() for name in names
    }  # .mbs joint: URDF joint
    alone = {
        names[0]: urdf for urdf, names in conversion.names.coordinates.items() if len(names) == 1
    }
    numbers = model.numbers()
    robot = conversion.robot.with_flipped(conversion.names.flipped)
    rows = []
    for body in model.bodies:
        for joint in body.joints:
            urdf = robot.joints.get(alone.get(joint.name, ""))
            limit = urdf.limit if urdf else None
            ranged = limit is not None and urdf is not None and urdf.type != "continuous"
            mimic = urdf.mimic if urdf else None
            rows.append(
                (
                    f' class="{joint.nature}" data-joint="{escape(joint.name)}"',
                    [
                        f"q{numbers[joint.name]}",
                        escape(joint.name),
                        joint.type,
                        joint.nature,
                        number(joint.q),
                        escape(body.name),
                        escape(origin.get(joint.name, "")),
                        vector((limit.lower, limit.upper)) if limit and ranged else "",
                        number(limit.velocity) if limit else "",
                        number(limit.effort) if limit else "",
                        ""
                        if mimic is None
                        else escape(f"{mimic.multiplier:g} · {mimic.joint} + {mimic.offset:g}"),
                    ],
                )
            )
    head = (
        "number", "joint", "type", "nature", "initial q [rad, m]", "body", "URDF joint",
        "limits [rad, m]", "velocity", "effort", "follows",
    )  # fmt: skip
    return table(head, rows, right=(0, 4, 7, 8, 9))


def _bodies(conversion: Conversion, model: Mbs) -> str:
    links: dict[str, list[str]] = {}
    for link, at in conversion.frames.items():
        if at.body is not None and at.joint is None:
            links.setdefault(at.body, []).append(link)
    total = sum(body.mass or 0.0 for body in model.bodies)
    rows = [
        (
            f' data-body="{escape(body.name)}"',
            [
                escape(body.name),
                escape(body.parent or "base"),
                escape(body.point or "origin"),
                number(body.mass),
                vector(body.com),
                vector(body.inertia),
                str(len(body.joints)),
                str(len(body.shapes)),
                escape(", ".join(links.get(body.name, ()))),
            ],
        )
        for body in model.bodies
    ]
    head = (
        "body", "parent", "at point", "mass [kg]", "centre of mass [m]",
        "inertia xx, xy, xz, yy, yz, zz [kg m²]", "joints", "shapes", "URDF links",
    )  # fmt: skip
    foot = ["total", "", "", number(total), *[""] * 5]
    return table(head, rows, right=(3, 4, 5, 6, 7), foot=foot)


def _names(conversion: Conversion) -> str:
    links = []
    for link in conversion.robot.links:
        at = conversion.frames.get(link)
        if at is None:
            where, turned = "-", ""
        else:
            where = "base" if at.body is None else f"body {at.body}"
            if at.joint is not None:
                where = f"after joint {at.joint}"
            here = (*at.pose.xyz, *at.pose.rot)
            turned = "" if here == (0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1) else vector(at.pose.xyz)
        links.append((f' data-link="{escape(link)}"', [escape(link), escape(where), turned]))
    joints = []
    for name, joint in conversion.robot.joints.items():
        became = ", ".join(conversion.names.joints.get(name, ()))
        why = conversion.frozen.get(name)
        if why is not None:
            became = f"left out, held at 0: {why}"
        elif not became:
            became = f"none: '{joint.child}' is rigid with the body that carries it"
        joints.append(
            (f' data-urdf-joint="{escape(name)}"', [escape(name), joint.type, escape(became)])
        )
    return (
        "<h3>Links</h3>"
        + table(("URDF link", "in the .mbs", "shifted by [m]"), links, right=(2,))
        + "<h3>Joints</h3>"
        + table(("URDF joint", "type", ".mbs joints, in the order in which they act"), joints)
    )


#: The parts of a joint that a pass may have found a place for, and the code that says so.
_KEPT = {
    "limit": "limit",
    "dynamics": "joint-dynamics",
    "safety_controller": "safety-controller",
    "calibration": "calibration",
}


def _left_out(conversion: Conversion) -> str:
    """Every number of the URDF's joints that has found no place."""
    simulation = conversion.simulation
    following = {c.follower.name for c in (*simulation.couplings, *simulation.driven)}
    kept = {part: simulation.kept.get(code, set()) for part, code in _KEPT.items()}
    kept["mimic"] = {
        name for name, own in conversion.names.coordinates.items() if following.issuperset(own)
    }
    rows = []
    for name, parts in left_out(conversion.robot).items():
        for part, values in parts.items():
            if name in kept[part]:
                continue
            listed = ", ".join(
                f"{key} {'none' if value is None else value if key == 'joint' else repr(value)}"
                for key, value in values.items()
            )
            rows.append(("", [escape(name), escape(part.replace("_", " ")), escape(listed)]))
    if not rows:
        return '<p class="note">Nothing.</p>'
    return table(("URDF joint", "part", "values [as in the URDF: rad, m, N m, N, s]"), rows)


def _proof(conversion: Conversion) -> str:
    proof = conversion.proof
    if proof is None:
        return (
            f'<p class="note">{NOT_CHECKED}: the pass <code>check</code> is not in the '
            "pipeline. Add it after <code>emit</code>. The comparison in the 3D model is made "
            "at the position shown only.</p>"
        )
    same = (
        "The .mbs was read back and compared with the URDF by a second route: it is "
        f"{escape(verdict(conversion))}."
        if proof.same
        else "<b>The .mbs is not the same robot as the URDF.</b> It was written as "
        f"{escape(conversion.rejected.name if conversion.rejected else '')}."
    )
    facts = (
        f"<p>{same}</p><dl><dt>Positions compared</dt><dd>{proof.positions}, zero included</dd>"
        f"<dt>Rigid groups</dt><dd>{proof.groups}: each must move as its counterpart, and have "
        "its mass, centre and inertia</dd></dl>"
    )
    largest = table(
        ("compared", "largest relative deviation"),
        [("", [escape(kind), f"{size:.2e}"]) for kind, size in proof.largest.items()],
        right=(1,),
    )
    differences = [
        ("", [escape(d.kind), f"{d.size:.2e}", escape(d.message)]) for d in proof.differences
    ]
    known = [("", [escape(thing), escape(why)]) for thing, why in proof.but_for.items()]
    left = [("", [escape(thing), escape(why)]) for thing, why in proof.not_compared.items()]
    changed = [
        (
            "",
            [escape(one.by), escape(KINDS[change.kind][0]), escape(change.name),
             _short(change.before), _short(change.after)],
        )
        for one in conversion.changed
        for change in one.changes
    ]  # fmt: skip
    head = ("pass", "what", "link or joint", "in the URDF", "now")
    return (
        facts
        + largest
        + titled("Differences", ("what", "relative size", "where"), differences, right=(1,))
        + titled("The same, but for", ("what", "why"), known)
        + titled("Not compared", ("what", "why"), left)
        + titled("Changed on purpose", head, changed)
    )


def _short(value: Any) -> str:
    """A changed value as text."""
    text = "" if value is None else json.dumps(msgspec.to_builtins(value))
    return escape(text if len(text) <= 80 else f"{text[:77]}...")


def _messages(conversion: Conversion) -> str:
    if not conversion.diagnostics:
        return '<p class="note">None.</p>'
    rows = []
    for said in sorted(conversion.diagnostics, key=lambda d: d.level != "warning"):
        where = f"{Path(said.file).name}:{said.line}" if said.file and said.line else ""
        hint = f'<br><span class="note">{escape(said.hint)}</span>' if said.hint else ""
        about = ""
        if said.joint is not None:
            about = f' data-urdf-joint="{escape(said.joint)}"'
        elif said.link is not None:
            about = f' data-link="{escape(said.link)}"'
        rows.append(
            (
                about,
                [
                    f'<span class="level {said.level}">{said.level}</span>',
                    escape(said.code),
                    escape(said.message) + hint,
                    escape(where),
                ],
            )
        )
    return table(("", "code", "what", "where"), rows)


def _footer(conversion: Conversion, licenses: str, viewer: int, meshes: int) -> str:
    settings = conversion.settings
    return (
        f"<p>{escape(settings.source.name)} → {escape(settings.output.name)}, by urdf2mbs. "
        f"In this page: three.js {viewer / 1e6:.2f} MB, meshes and textures {meshes / 1e6:.2f} MB. "
        "It loads nothing from elsewhere.</p>"
        "<details><summary>Licence of three.js, which draws the 3D model</summary>"
        f"<pre>{escape(licenses)}</pre></details>"
    )
