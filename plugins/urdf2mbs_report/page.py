"""One HTML page that shows a conversion, or an .mbs alone: 3D model, diagram, tables, proof.

The page is self-contained: it loads nothing, from no network, and its own security policy would
not let it.  Its .mbs side is read back from the file's bytes.  three.js comes from the installed
package jupyter-threejs-sage (``script.find_viewer``).

``templates/page.html`` is the page; ``_render_page`` fills it with the data of ``sections``,
``connections``, ``scene``, ``motion`` and ``script``.
"""

from __future__ import annotations

from collections import Counter
from html import escape
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
    choose_title,
    counted,
    of_plugins,
    project_of,
    read_mbs,
    report,
    some,
)
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_meshes.model import MeshLimit
from urdf2mbs_report import script, sections
from urdf2mbs_report.connections import (
    find_unreadable_limits,
    list_cuts,
    list_marks,
    make_connection_tables,
)
from urdf2mbs_report.draw import draw
from urdf2mbs_report.mesh_store import MeshStore
from urdf2mbs_report.motion import MotionError, Results, describe_motion, read_motion
from urdf2mbs_report.scene import (
    compute_extent,
    describe_mbs,
    describe_stand_ins,
    describe_urdf,
    find_url,
    list_followers,
    make_file_reader,
)
from urdf2mbs_report.script import Script
from urdf2mbs_report.tables import PageTable, format_cell

#: The end of a project's name if ``simulate`` or ``init`` gives it: ``lamp_robotran`` of ``lamp``.
PROJECT_SUFFIX = "_robotran"
#: The size of the robot, divided by the length of the axes of a frame.
FRAMES_IN_SIZE = 18
#: The height of a page in a notebook (px).
FRAME_HEIGHT = 820


class Page(msgspec.Struct):
    """A page, its size, and its losses."""

    data: bytes
    sizes: dict[str, int]
    """Bytes of the viewer (three.js), of the meshes, textures included, and in all."""
    missing: list[str]
    """Meshes of which only the place is shown."""
    diagnostics: list[Diagnostic] = []
    """Warnings of all else that the page does not show."""


def frame_page(page: Page) -> str:
    """Return HTML that shows a page in a notebook: an iframe, which keeps their styles apart."""
    style = f"width: 100%; height: {FRAME_HEIGHT}px; border: 0"
    return (
        f'<iframe title="urdf2mbs" style="{style}" srcdoc="{escape(page.data.decode())}"></iframe>'
    )


class Notice(msgspec.Struct):
    """A notice about meshes that are not drawn as they are."""

    text: str
    meshes_by_reason: dict[str, list[str]] = {}


class ShownModes(msgspec.Struct):
    """The modes of a robot, for a page that lists and shows them."""

    data: dict[str, Any]
    """``js/modes.js`` lists its keys."""
    notes: list[str]
    """What is true of all modes, in sentences."""


class Contents(msgspec.Struct):
    """The contents of a page that differ between a conversion and an .mbs alone."""

    name: str
    title: str
    tree_label: str
    facts: list[str]
    made_from: str
    """The files that the page was made from."""
    summary: Summary
    """What the passes say of the model."""
    joint_table: PageTable
    body_table: PageTable
    stand_ins: set[str] = set()
    """The urls of .wrl files for which meshes of the URDF are drawn."""
    robot: sections.RobotSections | None = None
    """The sections about the URDF; None without one."""
    live_script: str | None = None
    """The module of a robot that is simulated in the page."""
    moves: str = ""
    """``motion`` or ``modes`` if the robot moves by itself; else empty."""
    mode_notes: list[str] = []
    """Sentences below the list of modes."""

    @property
    def view_label(self) -> str:
        """The name of the section with the 3D model."""
        return {"motion": "Simulation", "modes": "Modes"}.get(self.moves, "3D model")


# --- a conversion ---


def make_robot_page(conversion: Conversion) -> Page:
    """Make the page of a conversion that has run; nothing is written.

    The URDF's meshes are drawn as RViz draws them, whatever the options of convert-meshes, so that
    a wrong up axis shows.  If a .wrl of the .mbs does not exist yet, the URDF's own mesh is drawn.

    Raises:
        ConfigError: No .mbs was made.
    """
    settings = conversion.settings
    output_file = conversion.written
    if output_file not in conversion.files:
        message = "there is no .mbs to report on: no pass has made it"
        raise ConfigError("no-mbs", message, hint="put 'emit' in the pipeline")
    model = read_mbs(conversion.files[output_file], str(output_file))
    mesh_store = MeshStore(conversion.state(MeshLimit).mebibytes)
    stand_ins: set[str] = set()
    summary = of_plugins(conversion, for_page=True)
    scene_data = _describe_both_sides(conversion, model, summary, mesh_store, stand_ins)
    name = choose_title(conversion.robot.name, settings.source)
    contents = Contents(
        name=name,
        title=f"{name}: URDF and .mbs",
        tree_label="Links",
        facts=_list_robot_facts(conversion),
        made_from=f"{settings.source.name} → {settings.output.name}",
        summary=summary,
        joint_table=sections.make_joint_table(model, conversion),
        body_table=sections.make_body_table(model, conversion),
        stand_ins=stand_ins,
        robot=sections.describe_robot(conversion),
    )
    page = _render_page(model, mesh_store, scene_data, contents)
    page.diagnostics = _warn_of_limits(model, str(output_file))
    return page


def _describe_both_sides(
    conversion: Conversion,
    model: Mbs,
    summary: Summary,
    mesh_store: MeshStore,
    stand_ins: set[str],
) -> dict[str, Any]:
    """Describe the 3D model of the .mbs and the URDF.

    Args:
        conversion: The conversion.
        model: The .mbs, read back.
        summary: The summaries of all plugins.
        mesh_store: The meshes of both are added to this.
        stand_ins: The urls of .wrl files that do not exist yet are added to this.

    Returns:
        The data for the script of the page.
    """
    settings = conversion.settings
    read_file = make_file_reader(conversion.files, settings.project or settings.output.parent)
    filenames = {mesh_stem: filename for filename, mesh_stem in conversion.meshes.items()}
    mesh_files = get_mesh_files(conversion)

    def find_stand_in(url: str) -> Path | None:
        filename = filenames.get(PurePosixPath(url).stem)
        if filename is None or read_file(url) is not None:
            return None
        stand_ins.add(url)
        return mesh_files.find(filename)

    mbs_description = describe_mbs(model, mesh_store, read_file, find_stand_in)
    scene_data = _describe_model(model, mesh_store, mbs_description, summary) | {
        "urdf": describe_urdf(conversion.robot, mesh_store, mesh_files.find),
        "standIns": describe_stand_ins(conversion, mesh_store),
        "followers": list_followers(conversion),
        "frames": [
            (
                link_name,
                {
                    "body": frame.body,
                    "joint": frame.joint,
                    "pose": (*frame.pose.rot, *frame.pose.xyz),
                },
            )
            for link_name, frame in conversion.frames.items()
        ],
        "coordinates": list(conversion.names.coordinates.items()),
        "joints": list(conversion.names.joints.items()),
    }
    for reasons in (mesh_store.missing, mesh_store.incomplete):
        for url in list(reasons):  # a mesh that neither side has is a single mesh
            filename = filenames.get(PurePosixPath(url).stem, url)
            if filename != url and filename in reasons:
                del reasons[url]
    if model.view:
        scene_data |= {"size": FRAMES_IN_SIZE * model.view.frame, "frame": model.view.frame}
    return scene_data


def _list_robot_facts(conversion: Conversion) -> list[str]:
    """List the facts below the title of the page of a conversion."""
    conversion_report = report(conversion)
    n_warnings = sum(diagnostic.level == "warning" for diagnostic in conversion.diagnostics)
    return [
        f"{counted(conversion_report.links, 'link')} → {counted(conversion_report.bodies, 'body')}",
        f"{counted(conversion_report.joints.urdf, 'URDF joint')} → {conversion_report.joints}",
        f"{conversion_report.mass:.6g} kg",
        conversion_report.base_in_words,
        counted(n_warnings, "warning"),
    ]


# --- an .mbs alone ---


def make_model_page(
    model: Mbs,
    file: Path,
    results: str | Results = "dirdyn.csv",
    live: Script | None = None,
    *,
    modes: ShownModes | None = None,
    conversion: Conversion | None = None,
) -> Page:
    """Make the page of an .mbs alone, without a URDF.

    Args:
        model: The model.
        file: Where it lies.  ``PRJPATH`` of its urls is the folder around ``dataR``, or else the
            file's own folder.
        results: The motion that is played: results in memory, or a file in the project's resultsR,
            if it exists.
        live: The robot that is simulated in the page.
        modes: The modes that are shown, in place of a motion.
        conversion: The conversion that has made the .mbs, if it is known: its robot's name is the
            title, and its collision shapes are drawn where meshes are missing.
    """
    project = project_of(file.absolute())
    mesh_store = MeshStore()
    read_file = make_file_reader({}, project)
    mbs_description = describe_mbs(model, mesh_store, read_file, lambda url: find_url(url, project))
    scene_data = _describe_model(model, mesh_store, mbs_description, Summary())
    if conversion is not None:
        scene_data["standIns"] = describe_stand_ins(conversion, mesh_store)
        scene_data["followers"] = list_followers(conversion)
    diagnostics: list[Diagnostic] = []
    if modes is not None:
        scene_data["modes"] = modes.data
    elif isinstance(results, Results):
        scene_data["motion"] = describe_motion(model, results)
    else:
        try:
            scene_data["motion"] = read_motion(model, project, results)
        except MotionError as error:
            diagnostics.append(_warn_of_motion(error, project / "resultsR" / results))
    moves = "modes" if scene_data["modes"] else "motion" if scene_data["motion"] else ""
    name = model.name.removesuffix(PROJECT_SUFFIX)
    if conversion is not None:
        name = choose_title(conversion.robot.name, conversion.settings.source)
    contents = Contents(
        name=name,
        title=f"{name}: {moves}" if moves else name,
        tree_label="Bodies",
        facts=_list_model_facts(model),
        made_from=file.name,
        summary=Summary(),
        joint_table=sections.make_joint_table(model, None),
        body_table=sections.make_body_table(model, None),
        moves=moves,
        mode_notes=modes.notes if modes is not None else [],
    )
    if live is not None:
        scene_data["live"] = live.data
        contents.live_script = live.text
    page = _render_page(model, mesh_store, scene_data, contents)
    page.diagnostics = diagnostics + _warn_of_limits(model, str(file))
    return page


def _warn_of_motion(error: MotionError, results_file: Path) -> Diagnostic:
    """Return the warning of results that cannot be played."""
    return Diagnostic(
        "warning",
        "motion-unreadable",
        f"the page plays no motion: {error}",
        file=str(results_file),
        hint="simulate again; or remove the file",
    )


def _list_model_facts(model: Mbs) -> list[str]:
    """List the facts below the title of the page of an .mbs alone."""
    natures = Counter(joint.nature for body in model.bodies for joint in body.joints)
    facts = [counted(len(model.bodies), "body")]
    nature_counts = ", ".join(f"{n_joints} {nature}" for nature, n_joints in natures.items())
    facts.append(f"{counted(natures.total(), 'joint')} ({nature_counts})" if natures else "")
    facts.append(f"{sum(body.mass or 0.0 for body in model.bodies):.6g} kg")
    if model.cuts:
        facts.append(counted(len(model.cuts), "cut"))
    if model.links:
        facts.append(counted(len(model.links), "link"))
    return facts


# --- both ---


def _describe_model(
    model: Mbs, mesh_store: MeshStore, mbs_description: dict[str, Any], summary: Summary
) -> dict[str, Any]:
    """Return the data for the script of the page, with an empty URDF side."""
    extent = compute_extent(model)
    return {
        "name": model.name,
        "mbs": mbs_description,
        "urdf": {"root": None, "links": [], "joints": []},
        "frames": [],
        "coordinates": [],
        "joints": [],
        "standIns": [],
        "followers": [],
        "motion": None,
        "modes": None,
        "cuts": list_cuts(model),
        "meshes": mesh_store.meshes,
        "textures": mesh_store.textures,
        "size": extent,
        "frame": extent / FRAMES_IN_SIZE,
        "marks": list_marks(summary, model),
    }


def _warn_of_limits(model: Mbs, file: str) -> list[Diagnostic]:
    """Return a warning of the limits that are not numbers, if there are any."""
    unreadable_limits = find_unreadable_limits(model)
    if not unreadable_limits:
        return []
    hint = "write a number into the .mbs"
    return [
        Diagnostic("warning", "limit-unreadable", some(unreadable_limits, 3), file=file, hint=hint)
    ]


def _render_page(
    model: Mbs, mesh_store: MeshStore, scene_data: dict[str, Any], contents: Contents
) -> Page:
    """Render the template of the page.

    Texts are escaped by the template, but for those that are HTML, a script or a style already.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=PackageLoader("urdf2mbs_report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["format_cell"] = format_cell
    packed_viewer = script.pack_viewer()
    packed_arrays = mesh_store.pack_arrays()
    mesh_size = len(packed_arrays) + sum(len(url) for url in mesh_store.textures)
    try:
        diagram, no_diagram = Markup(draw(model)), None
    except ConversionError as error:
        diagram, no_diagram = Markup(), f"{error.message}; {error.hint or ''}"
    page_html = environment.get_template("page.html").render(
        contents=contents,
        robot=contents.robot,
        connection_tables=make_connection_tables(contents.summary, model),
        notices=_list_notices(mesh_store, contents.stand_ins),
        diagram=diagram,
        no_diagram=no_diagram,
        n_missing=len(mesh_store.missing),
        has_stand_ins=bool(scene_data["standIns"]),
        n_meshes=len(mesh_store.missing) + len(mesh_store.meshes),
        css=Markup(script.read_resource("page.css")),
        data=Markup(script.encode_data(scene_data)),
        arrays=Markup(packed_arrays),
        viewer=Markup(packed_viewer),
        script=Markup(script.bundle_modules(contents.live_script or "")),
        megabytes={"viewer": len(packed_viewer) / 1e6, "meshes": mesh_size / 1e6},
        viewer_license=script.read_resource("LICENSE.three.txt"),
    )
    page_data = page_html.encode()
    sizes = {"viewer": len(packed_viewer), "meshes": mesh_size, "all": len(page_data)}
    return Page(page_data, sizes, list(mesh_store.missing))


def _list_notices(mesh_store: MeshStore, stand_ins: set[str]) -> list[Notice]:
    """List the notices about meshes that are not drawn as they are."""
    notices = []
    if stand_ins:
        notices.append(
            Notice(
                f"{counted(len(stand_ins), 'mesh')} of the .mbs: no .wrl file is there yet "
                "('output: {project: DIR}' makes them). The URDF's own meshes are drawn instead."
            )
        )
    for reasons, consequence in (
        (mesh_store.missing, "cannot be drawn; a collision shape or a small frame shows its place"),
        (mesh_store.incomplete, "drawn in part"),
    ):
        meshes_by_reason: dict[str, list[str]] = {}
        for mesh_name, reason in reasons.items():
            meshes_by_reason.setdefault(reason, []).append(mesh_name)
        if meshes_by_reason:
            notice_text = f"{counted(len(reasons), 'mesh')} {consequence}:"
            notices.append(Notice(notice_text, meshes_by_reason))
    return notices
