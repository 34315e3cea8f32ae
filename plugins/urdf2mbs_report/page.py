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

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    ConversionError,
    Diagnostic,
    Mbs,
    Summary,
    counted,
    of_plugins,
    project_of,
    report,
    some,
)
from urdf2mbs.plugin import read_mbs as read
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_meshes.model import MeshLimit
from urdf2mbs_report import around, sections
from urdf2mbs_report.draw import draw
from urdf2mbs_report.motion import MotionError, motion
from urdf2mbs_report.scene import Store, extent, lookup, mbs_side, path_of, urdf_side

#: The package that brings three.js, and where in it three.js is.
THREE = ("jupyter-threejs-sage", "jupyter_threejs_sage/static/r130/three.min.js")
#: The modules of the page's script, each before those that use it.
MODULES = (
    "basics", "kinematics", "positions", "geometry", "scene", "shapes", "marks", "compare", "show",
    "choose", "camera", "panel", "diagram", "player", "main",
)  # fmt: skip


class Page(msgspec.Struct):
    """The page's bytes, and what of it is what."""

    data: bytes
    sizes: dict[str, int]
    """Bytes of the viewer (three.js), of the meshes, textures included, and in all."""
    missing: list[str]
    """Meshes of which only the place is shown."""
    diagnostics: list[Diagnostic] = []
    """Warnings of what else the page does not show."""


def make(conversion: Conversion) -> Page:
    """The page of a conversion that has run; writes nothing.

    The URDF's meshes are drawn as RViz draws them, whatever convert-meshes was told, so that a
    wrong turn shows.  Where the .mbs names a .wrl that no project has yet, the URDF's own mesh
    stands for it.  Raises ConfigError where no .mbs was made.
    """
    settings = conversion.settings
    output = conversion.written
    if output not in conversion.files:
        raise ConfigError(
            "no-mbs", "there is no .mbs to report on: no pass has made it",
            hint="put 'emit' in the pipeline",
        )  # fmt: skip
    model = read(conversion.files[output], str(output))
    store = Store(conversion.state(MeshLimit).mebibytes)
    stand_ins: set[str] = set()
    data = _both_sides(conversion, model, store, stand_ins)
    name = escape(conversion.robot.name)
    fields = {
        "name": name,
        "title": f"{name}: URDF and .mbs",
        "tree": "Links",
        **_verdict_and_facts(conversion),
        "notes": _notes(store, stand_ins),
        "names": sections.names(conversion),
        "left_out": sections.lost(conversion),
        "proof": sections.proof(conversion),
        "messages": sections.messages(conversion),
    }
    made_from = f"{settings.source.name} → {settings.output.name}"
    page = _fill(model, store, data, made_from, fields, conversion)
    page.diagnostics = _unread_limits(model, str(output))
    return page


def _both_sides(
    conversion: Conversion, model: Mbs, store: Store, stand_ins: set[str]
) -> dict[str, Any]:
    """What the page draws; fills the store, and the urls of .wrl files for which the URDF's own
    mesh stands."""
    settings = conversion.settings
    fetch = lookup(conversion.files, settings.project or settings.output.parent)
    filenames = {stem: filename for filename, stem in conversion.meshes.items()}

    def stand_in(url: str) -> Path | None:
        filename = filenames.get(PurePosixPath(url).stem)
        if filename is None or fetch(url) is not None:
            return None
        stand_ins.add(url)
        return get_mesh_files(conversion).find(filename)

    data = _data(model, store, mbs_side(model, store, fetch, stand_in), of_plugins(conversion)) | {
        "urdf": urdf_side(conversion.robot, store, get_mesh_files(conversion).find),
        "frames": [
            (link, {"body": at.body, "joint": at.joint, "pose": (*at.pose.rot, *at.pose.xyz)})
            for link, at in conversion.frames.items()
        ],
        "coordinates": list(conversion.names.coordinates.items()),
        "joints": list(conversion.names.joints.items()),
    }
    for reasons in (store.missing, store.in_part):
        for url in list(reasons):  # a mesh that neither side has is one mesh
            filename = filenames.get(PurePosixPath(url).stem, url)
            if filename != url and filename in reasons:
                del reasons[url]
    if model.view:
        data |= {"size": 18 * model.view.frame, "frame": model.view.frame}
    return data


class Script(msgspec.Struct):
    """A module of another plugin, and what it reads as ``data.live``: a robot that moves by
    itself."""

    text: str
    data: dict[str, Any]


def make_of_model(
    model: Mbs, file: Path, results: str = "dirdyn.csv", live: Script | str | None = None
) -> Page:
    """The page of an .mbs alone, without a URDF; ``file`` is where it lies.

    The page plays the motion of this file in the project's resultsR, if there is one.
    ``live`` is the robot that moves by itself, or why there is none.
    ``PRJPATH`` of its urls is the folder around ``dataR``, else the file's own folder.
    """
    project = project_of(file.absolute())
    store = Store()
    drawn = mbs_side(model, store, lookup({}, project), lambda url: path_of(url, project))
    data = _data(model, store, drawn, Summary())
    diagnostics: list[Diagnostic] = []
    try:
        data["motion"] = motion(model, project, results)
    except MotionError as error:
        played = project / "resultsR" / results
        message = f"the page plays no motion: {error}"
        hint = "simulate again; or remove the file"
        diagnostics.append(
            Diagnostic("warning", "motion-unreadable", message, file=str(played), hint=hint)
        )
        data["motion"] = None
    name = escape(model.name)
    fields = {
        "name": name,
        "title": name,
        "tree": "Bodies",
        "facts": _facts_of_model(model),
        "notes": _notes(store, set()),
    }
    diagnostics += _unread_limits(model, str(file))
    if isinstance(live, Script):
        data["live"] = live.data
        fields["live"] = live.text
    elif live:
        fields["not_live"] = escape(live)
    page = _fill(model, store, data, file.name, fields)
    page.diagnostics = diagnostics
    return page


def _unread_limits(model: Mbs, file: str) -> list[Diagnostic]:
    """Return a warning of the limits that are no numbers, if there are any."""
    unread = around.find_unread_limits(model)
    if not unread:
        return []
    hint = "write a number into the .mbs"
    return [Diagnostic("warning", "limit-unreadable", some(unread, 3), file=file, hint=hint)]


def _data(model: Mbs, store: Store, mbs: dict[str, Any], said: Summary) -> dict[str, Any]:
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
        "marks": around.marks(said, model),
    }


def _fill(
    model: Mbs,
    store: Store,
    data: dict[str, Any],
    made_from: str,
    fields: dict[str, str],
    conversion: Conversion | None = None,
) -> Page:
    """Fill the template; ``{{#name}}...{{/name}}`` is left out where there is no such field."""
    viewer, licenses = _viewer()
    arrays = store.packed()
    meshes = len(arrays) + sum(len(url) for url in store.textures)
    said = Summary() if conversion is None else of_plugins(conversion)
    fields |= {
        "joints": sections.joints(model, conversion),
        "bodies": sections.bodies(model, conversion),
        "around": around.tables(said, model),
        "css": _own("page.css"),
        "js": _joined_modules(fields.get("live", "")),
        "viewer": _script(viewer),
        "diagram": _diagram(model),
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
    page = text.encode()
    sizes = {"viewer": len(viewer), "meshes": meshes, "all": len(page)}
    return Page(page, sizes, list(store.missing))


def _own(name: str) -> str:
    return files("urdf2mbs_report").joinpath(name).read_text("utf-8").rstrip("\n")


def _joined_modules(last: str) -> str:
    """The page's own script: all modules in one scope, for a page on disk can load none.

    The last one, another plugin's, has its own names.
    """
    own = [_own(f"js/{name}.js") for name in MODULES]
    text = "\n\n".join([*own, f"{{\n{last}}}"])
    text = re.sub(r"^import .*?;\n+", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^export ", "", text, flags=re.MULTILINE)
    return f'"use strict";\n(() => {{\n{text}\n}})();'


def _viewer() -> tuple[str, str]:
    """three.js and its licence."""
    package = distribution(THREE[0])
    try:
        text = Path(str(package.locate_file(THREE[1]))).read_text("utf-8")
    except OSError:
        what = f"the installed {THREE[0]} does not have {THREE[1]}"
        raise ConfigError("viewer-missing", what, hint=f"pip install {THREE[0]}==130") from None
    return text, files("urdf2mbs_report").joinpath("LICENSE.three.txt").read_text("utf-8")


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


def _verdict_and_facts(conversion: Conversion) -> dict[str, str]:
    """The two lines below the page's title."""
    found = report(conversion)
    kind = "unknown" if found.proof is None else "same" if found.proof.same else "other"
    warnings = sum(d.level == "warning" for d in conversion.diagnostics)
    facts = [
        f"{counted(found.links, 'link')} → {counted(found.bodies, 'body')}",
        f"{counted(found.joints.urdf, 'URDF joint')} → {found.joints}",
        f"{found.mass:.6g} kg",
        escape(found.base_in_words),
        counted(warnings, "warning"),
    ]
    if found.no_dynamics:
        facts.append(f"<b>{found.no_dynamics}</b>")
    verdict = f'<span class="verdict {kind}">{escape(found.verdict)}</span>'
    return {"verdict": verdict, "facts": " · ".join(facts)}


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


def _footer(made_from: str, licenses: str, viewer: int, meshes: int) -> str:
    return (
        f"<p>{escape(made_from)}, by urdf2mbs. "
        f"In this page: three.js {viewer / 1e6:.2f} MB, meshes and textures {meshes / 1e6:.2f} MB. "
        "It loads nothing from elsewhere.</p>"
        "<details><summary>Licence of three.js, which draws the 3D model</summary>"
        f"<pre>{escape(licenses)}</pre></details>"
    )
