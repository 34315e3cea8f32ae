"""`report`: one HTML page to look at.

Converts the robot, or reads an .mbs.  Writes one HTML page: the robot in 3D,
its diagram, tables, and what differs from the URDF.  Writes no .mbs.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import (
    ALONE,
    FLAGS,
    ConfigError,
    Pipeline,
    Progress,
    add_fields,
    add_printing,
    add_running,
    beside,
    choose_fields,
    counted,
    is_file,
    is_stream,
    near,
    path,
    print_json,
    report,
    robot_or_config,
    saving,
    tell,
    with_near_paths,
)
from urdf2mbs.plugin import read_bytes as read
from urdf2mbs.plugin import read_mbs_file as read_file

if TYPE_CHECKING:
    from urdf2mbs_report.page import Page

Save = Callable[[Path, bytes], None]

EXAMPLES = (
    "urdf2mbs report robot.yaml",
    "urdf2mbs report robot.urdf -o look.html",
    "urdf2mbs report project/dataR/model.mbs",
)


def add_options(command: argparse.ArgumentParser) -> None:
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config", type=path, metavar="CONFIG.yaml",
        help="or a .urdf or .xacro file, with the options below; or an .mbs, of any origin",
    )  # fmt: skip
    command.add_argument(
        "-o", "--output", type=path, metavar="OUT.html",
        help="default: beside the output; - for standard output",
    )  # fmt: skip
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    with saving(arguments, is_stream(arguments.output)) as save:
        if arguments.config.suffix.lower() == ".mbs":
            return _report_model(arguments, save)
        return _report_robot(arguments, save)


def _report_robot(arguments: argparse.Namespace, save: Save) -> int:
    """Convert, and write the page."""
    from urdf2mbs_report.page import make

    config, lines = robot_or_config(arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with Progress(arguments) as progress:
        pipeline.watch(progress)
        conversion = pipeline.run()
        progress.at = "the page"
        page = make(conversion)
    found, model = report(conversion), conversion.settings.output
    output = arguments.output or beside(model, ".html")
    save(output, page.data)
    if not _as_json(arguments, page, output):
        done = f"report written to {_place(output)}"
        tell(conversion, found, done, arguments.verbose, "the page shows them")
        _tell_next(page, output, arguments.verbose)
        written = is_file(model) and read(model) == conversion.files.get(model)
        if not written and not is_stream(output):
            print("      the .mbs itself is written by: urdf2mbs run, or urdf2mbs convert")
    return 0 if conversion.checked.rejected is None else 3


def _report_model(arguments: argparse.Namespace, save: Save) -> int:
    """Write the page of an .mbs alone: there is no URDF to convert or to compare."""
    from urdf2mbs_report.page import make_of_model

    file: Path = arguments.config
    for field in choose_fields(arguments, ALONE):
        flag = FLAGS[field].flag
        raise ConfigError("usage", f"{flag} is for a robot; '{file}' is an .mbs already")
    model = read_file(file)
    output = arguments.output or beside(file, ".html")
    page = make_of_model(model, file)
    save(output, page.data)
    if not _as_json(arguments, page, output):
        print(f"{model.name}: page of the model written to {_place(output)}")
        _tell_next(page, output, arguments.verbose)
    return 0


def _as_json(arguments: argparse.Namespace, page: Page, output: Path) -> bool:
    """Print what is known of the page as JSON, if that is wanted."""
    if arguments.json:
        print_json(
            {
                "page": str(output),
                "sizes": page.sizes,
                "missing": page.missing,
                "diagnostics": page.diagnostics,
            }
        )
    return bool(arguments.json)


def _place(output: Path) -> str:
    return "standard output" if is_stream(output) else near(output)


def _tell_next(page: Page, output: Path, verbose: bool) -> None:
    """Say how large the page is, what it lacks, and what to do with it."""
    if verbose:
        parts = {"all": "", "viewer": "three.js ", "meshes": "meshes "}
        sizes = [f"{name}{page.sizes[part] / 1e6:.2f} MB" for part, name in parts.items()]
        print(f"  {', '.join(sizes)}")
    for diagnostic in page.diagnostics:
        print(with_near_paths(str(diagnostic)), file=sys.stderr)
    if page.missing:
        print(f"  {counted(len(page.missing), 'mesh')} not drawn; the page names them")
    if not is_stream(output):
        print(f"Next: open {near(output)} in a browser; it is one file, which you can send on")
