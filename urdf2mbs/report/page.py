"""One HTML page that shows a conversion, or an .mbs alone: 3D model, diagram, tables, proof.

The page is self-contained: it loads nothing, from no network, and its own security policy
would not let it.  Its .mbs side is read back from the file's bytes.  three.js comes out of the
installed package jupyter-threejs-sage, which has nothing else in it.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from html import escape
from importlib.metadata import distribution
from importlib.resources import files
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagram.draw import draw
from urdf2mbs.disk.files import project_of
from urdf2mbs.disk.seal import seal
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, counted
from urdf2mbs.proof.verdict import NOT_CHECKED
from urdf2mbs.report import around
from urdf2mbs.report.motion import motion
from urdf2mbs.report.scene import Store, extent, lookup, mbs_side, path_of, urdf_side
from urdf2mbs.report.summary import left_out, report, verdict
from urdf2mbs.report.table import number, table, titled, vector
from urdf2mbs.simulation import Simulation

#: The package that brings three.js, and where in it three.js is.
THREE = ("jupyter-threejs-sage", "jupyter_threejs_sage/static/r130/three.min.js")
#: Messages about what the URDF has and the .mbs has no place for.
LEFT_OUT = ("collision", "extension", "texture", "rotors-left-out", "loop-left-out")


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
    wrong turn shows.  Where the .mbs names a .wrl that no project has yet, the URDF's own mesh
    stands for it.  Raises ConfigError where no .mbs was made.
    """
    settings = conversion.settings
    output = conversion.rejected or settings.output
    if output not in conversion.files:
        raise ConfigError(
            "no-mbs", "there is no .mbs to report on: no pass has made it",
            hint="put 'emit' in the pipeline",
        )  # fmt: skip
    model = read(conversion.files[output], str(output))
    store = Store()
    robot = conversion.robot
    fetch = lookup(conversion.files, settings.project or settings.output.parent)
    filenames = {stem: filename for filename, stem in conversion.meshes.items()}
    stand_ins: set[str] = set()

    def stand_in(url: str) -> Path | None:
        filename = filenames.get(PurePosixPath(url).stem)
        if filename is None or fetch(url) is not None:
            return None
        stand_ins.add(url)
        return conversion.packages.resolve(filename)

    data = _data(model, store, mbs_side(model, store, fetch, stand_in))
    data |= {
        "urdf": urdf_side(robot, store, conversion.packages.resolve),
        "frames": [
            (link, {"body": at.body, "joint": at.joint, "pose": (*at.pose.rot, *at.pose.xyz)})
            for link, at in conversion.frames.items()
        ],
        "coordinates": list(conversion.names.coordinates.items()),
        "joints": list(conversion.names.joints.items()),
        "marks": around.marks(conversion.simulation, model),
    }
    for url in list(store.missing):  # a mesh that neither side has is one mesh
        filename = filenames.get(PurePosixPath(url).stem, url)
        if filename != url and filename in store.missing:
            del store.missing[url]
    if model.view:
        data |= {"size": 18 * model.view.frame, "frame": model.view.frame}
    return _fill(
        store, data, f"{settings.source.name} → {settings.output.name}",
        {
            "name": escape(conversion.robot.name),
            "title": f"{escape(conversion.robot.name)}: URDF and .mbs",
            "tree": "Links",
            "diagram": _diagram(model),
            "verdict": _verdict(conversion),
            "facts": _facts(conversion),
            "notes": _notes(store, stand_ins),
            "joints": _joints(model, _urdf_joints(conversion, model)),
            "bodies": _bodies(model, _links_of(conversion)),
            "around": around.tables(conversion.simulation, model),
            "names": _names(conversion),
            "left_out": _left_out(conversion),
            "proof": _proof(conversion),
            "messages": _messages(conversion),
        },
    )  # fmt: skip


def make_of_model(model: Mbs, file: Path) -> Page:
    """The page of an .mbs alone, without a URDF; ``file`` is where it lies.

    The page plays the motion in the project's resultsR, if there is one.
    ``PRJPATH`` of its urls is the folder around ``dataR``, else the file's own folder.
    """
    project = project_of(file.absolute())
    store = Store()
    none = Simulation()
    drawn = mbs_side(model, store, lookup({}, project), lambda url: path_of(url, project))
    data = _data(model, store, drawn) | {
        "marks": around.marks(none, model),
        "motion": motion(model, project),
    }
    return _fill(
        store, data, file.name,
        {
            "name": escape(model.name),
            "title": escape(model.name),
            "tree": "Bodies",
            "diagram": _diagram(model),
            "facts": _facts_of_model(model),
            "notes": _notes(store, set()),
            "joints": _joints(model),
            "bodies": _bodies(model),
            "around": around.tables(none, model),
        },
    )  # fmt: skip


def _data(model: Mbs, store: Store, mbs: dict[str, Any]) -> dict[str, Any]:
    """What the page draws, with a URDF side that is empty."""
    size = extent(model)
    return {
        "name": model.name,
        "mbs": mbs,
        "urdf": {"root": None, "links": [], "joints": []},
        "frames": [],
        "coordinates": [],
        "joints": [],
        "meshes": store.meshes,
        "textures": store.textures,
        "size": size,
        "frame": size / 18,
    }


def _fill(store: Store, data: dict[str, Any], made_from: str, fields: dict[str, str]) -> Page:
    """Fill the template; ``{{#name}}...{{/name}}`` is left out where there is no such field."""
    viewer, licenses = _viewer()
    arrays = store.packed()
    meshes = len(arrays) + sum(len(url) for url in store.textures)
    fields |= {
        "css": _own("page.css"),
        "js": _own("page.js"),
        "viewer": _script(viewer),
        "data": _island(data),
        "arrays": arrays,
        "footer": _footer(made_from, licenses, len(viewer), meshes),
    }
    template = re.sub(
        r"\{\{#(\w+)\}\}(.*?)\{\{/\1\}\}",
        lambda part: part[2] if part[1] in fields else "",
        _own("page.html"), flags=re.DOTALL,
    )  # fmt: skip
    text = re.sub(r"\{\{(\w+)\}\}", lambda field: fields[field[1]], template)
    page = seal(Path("page.html"), text.encode())
    sizes = {"viewer": len(viewer), "meshes": meshes, "all": len(page)}
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
    if found.no_dynamics:
        facts.append(f"<b>{found.no_dynamics}</b>")
    return " · ".join(facts)


def _facts_of_model(model: Mbs) -> str:
    natures = Counter(joint.nature for body in model.bodies for joint in body.joints)
    facts = [
        counted(len(model.bodies), "body"),
        f"{counted(natures.total(), 'joint')}"
        f" ({', '.join(f'{n} {nature}' for nature, n in natures.items())})" * bool(natures),
        f"{sum(body.mass or 0.0 for body in model.bodies):.6g} kg",
        *(counted(len(cuts), "cut") for cuts in [model.cuts] if cuts),
        *(counted(len(links), "link") for links in [model.links] if links),
    ]
    return " · ".join(facts)


def _notes(store: Store, stand_ins: set[str]) -> str:
    """What the pictures of the meshes leave out."""
    notes = []
    if stand_ins:
        notes.append(
            f"<p>{counted(len(stand_ins), 'mesh')} of the .mbs: no .wrl file is there yet "
            "('output: {project: DIR}' makes them). The URDF's own meshes are drawn instead.</p>"
        )
    for reason_of, words in (
        (store.missing, "cannot be drawn; a small frame shows its place"),
        (store.in_part, "drawn in part"),
    ):
        reasons: dict[str, list[str]] = {}
        for name, why in reason_of.items():
            reasons.setdefault(why, []).append(name)
        lines = [
            f"<li>{escape(why)}: {len(names)}, "
            f"{escape(', '.join(names[:4]))}{', ...' if len(names) > 4 else ''}</li>"
            for why, names in reasons.items()
        ]
        if lines:
            count = counted(len(reason_of), "mesh")
            notes.append(f"<p>{count} {words}:</p><ul>{''.join(lines)}</ul>")
    return f'<div class="note warn">{"".join(notes)}</div>' if notes else ""


# --- tables ------------------------------------------------------------------------------------


def _joints(model: Mbs, urdf: dict[str, list[str]] | None = None) -> str:
    """The joints; ``urdf`` has the cells of each that come from the URDF."""
    numbers = model.numbers()
    rows = [
        (
            f' class="{escape(joint.nature)}" data-joint="{escape(joint.name)}"',
            [
                f"q{numbers[joint.name]}", escape(joint.name), joint.type, escape(joint.nature),
                number(joint.q), escape(body.name), *(urdf[joint.name] if urdf else []),
            ],
        )
        for body in model.bodies
        for joint in body.joints
    ]  # fmt: skip
    head = ["number", "joint", "type", "nature", "initial q [rad, m]", "body"]
    if urdf is not None:
        head += ["URDF joint", "limits [rad, m]", "velocity", "effort", "follows"]
    return table(head, rows, right=(0, 4, 7, 8, 9))


def _urdf_joints(conversion: Conversion, model: Mbs) -> dict[str, list[str]]:
    """What the URDF says of each .mbs joint: its joint, limits, velocity, effort, leader."""
    origin = {name: urdf for urdf, names in conversion.names.joints.items() for name in names}
    alone = {
        names[0]: urdf for urdf, names in conversion.names.coordinates.items() if len(names) == 1
    }
    robot = conversion.robot
    cells = {}
    for name in model.numbers():
        urdf = robot.joints.get(alone.get(name, ""))
        limit = urdf.limit if urdf else None
        mimic = urdf.mimic if urdf else None
        ranged = limit is not None and urdf is not None and urdf.type != "continuous"
        cells[name] = [
            escape(origin.get(name, "")),
            vector((limit.lower, limit.upper)) if limit and ranged else "",
            number(limit.velocity) if limit else "",
            number(limit.effort) if limit else "",
            escape(f"{mimic.multiplier:g} · {mimic.joint} + {mimic.offset:g}") if mimic else "",
        ]
    return cells


def _links_of(conversion: Conversion) -> dict[str, list[str]]:
    """The URDF links of each body."""
    links: dict[str, list[str]] = {}
    for link, at in conversion.frames.items():
        if at.body is not None and at.joint is None:
            links.setdefault(at.body, []).append(link)
    return links


def _bodies(model: Mbs, links: dict[str, list[str]] | None = None) -> str:
    rows = [
        (
            f' data-body="{escape(body.name)}"',
            [
                escape(body.name), escape(body.parent or "base"), escape(body.point or "origin"),
                number(body.mass), vector(body.com), vector(body.inertia), str(len(body.joints)),
                str(len(body.shapes)),
                *([] if links is None else [escape(", ".join(links.get(body.name, ())))]),
            ],
        )
        for body in model.bodies
    ]  # fmt: skip
    head = [
        "body", "parent", "at point", "mass [kg]", "centre of mass [m]",
        "inertia xx, xy, xz, yy, yz, zz [kg m²]", "joints", "shapes",
    ]  # fmt: skip
    if links is not None:
        head.append("URDF links")
    total = sum(body.mass or 0.0 for body in model.bodies)
    foot = ["total", "", "", number(total), *[""] * (len(head) - 4)]
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


def _left_out(conversion: Conversion) -> str:
    """What the messages name, and every number of the URDF's joints that has found no place."""
    said = [escape(one.message) for one in conversion.diagnostics if one.code in LEFT_OUT]
    named = f"<ul>{''.join(f'<li>{text}</li>' for text in said)}</ul>" if said else ""
    rows = []
    for name, parts in left_out(conversion).items():
        for part, values in parts.items():
            listed = ", ".join(
                f"{key} {'none' if value is None else value if key == 'joint' else repr(value)}"
                for key, value in values.items()
            )
            rows.append(("", [escape(name), escape(part.replace("_", " ")), escape(listed)]))
    if not rows:
        return named or '<p class="note">Nothing.</p>'
    columns = ("URDF joint", "part", "values [as in the URDF: rad, m, N m, N, s]")
    return named + table(columns, rows)


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
            [escape(one.by), escape(change.kind), escape(change.name),
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
    return table(("level", "code", "what", "where"), rows)


def _footer(made_from: str, licenses: str, viewer: int, meshes: int) -> str:
    return (
        f"<p>{escape(made_from)}, by urdf2mbs. "
        f"In this page: three.js {viewer / 1e6:.2f} MB, meshes and textures {meshes / 1e6:.2f} MB. "
        "It loads nothing from elsewhere.</p>"
        "<details><summary>Licence of three.js, which draws the 3D model</summary>"
        f"<pre>{escape(licenses)}</pre></details>"
    )
