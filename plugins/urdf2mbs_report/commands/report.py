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
    Conversion,
    Pipeline,
    Progress,
    add_fields,
    add_printing,
    add_running,
    beside,
    check_ending,
    choose_fields,
    counted,
    find_model,
    is_file,
    is_stream,
    near,
    path,
    print_json,
    read_bytes,
    read_mbs_file,
    report,
    robot_or_config,
    saving,
    tell,
    with_near_paths,
)

if TYPE_CHECKING:
    from urdf2mbs_report.page import Page

#: Writes a file, or prints it to standard output.
Save = Callable[[Path, bytes], None]

EXAMPLES = (
    "urdf2mbs report robot.yaml",
    "urdf2mbs report robot.urdf -o look.html",
    "urdf2mbs report project/dataR/model.mbs",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config",
        type=path,
        metavar="CONFIG.yaml",
        help="or a .urdf, .xacro or MJCF file, with the options below; or an .mbs, of any origin, "
        "or the folder of its project",
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="OUT.html",
        help="default: beside the output; - for standard output",
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the page; return the exit code."""
    check_ending(arguments.output, ".html")
    with saving(arguments, is_stream(arguments.output)) as save:
        if model_file := find_model(arguments.config, arguments, "robot", "config"):
            return _report_model(model_file, arguments, save)
        return _report_robot(arguments, save)


def _report_robot(arguments: argparse.Namespace, save: Save) -> int:
    """Convert, and write the page; return 3 if the .mbs is another robot."""
    from urdf2mbs_report.page import make_robot_page

    conversion, command = convert_in_memory(arguments)
    with Progress(arguments) as progress:
        progress.at = "the page"
        page = make_robot_page(conversion)
    mbs_file = conversion.settings.output
    output = arguments.output or beside(mbs_file, ".html")
    save(output, page.data)
    if arguments.json:
        _print_page_as_json(page, output)
    else:
        message = f"report written to {_format_output(output)}"
        tell(conversion, report(conversion), message, arguments.verbose, "the page shows them")
        _print_next_steps(page, output, arguments.verbose)
        is_written = is_file(mbs_file) and read_bytes(mbs_file) == conversion.files.get(mbs_file)
        if not is_written and not is_stream(output):
            print(f"      the .mbs itself is written by: {command}")
    return 0 if conversion.checked.rejected is None else 3


def convert_in_memory(arguments: argparse.Namespace) -> tuple[Conversion, str]:
    """Convert the robot of a command line, and write nothing.

    Returns:
        The conversion, and the command that writes its .mbs.
    """
    config, lines = robot_or_config(arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with Progress(arguments) as progress:
        pipeline.watch(progress)
        conversion = pipeline.run()
    command = "convert" if lines.file is None else "run"
    return conversion, f"urdf2mbs {command} {arguments.config}"


def _report_model(model_file: Path, arguments: argparse.Namespace, save: Save) -> int:
    """Write the page of an .mbs alone: there is no URDF to convert or to compare."""
    from urdf2mbs_report.page import make_model_page

    refuse_fields(arguments, model_file)
    model = read_mbs_file(model_file)
    output = arguments.output or beside(model_file, ".html")
    page = make_model_page(model, model_file)
    save(output, page.data)
    if arguments.json:
        _print_page_as_json(page, output)
    else:
        print(f"{model.name}: page of the model written to {_format_output(output)}")
        _print_next_steps(page, output, arguments.verbose)
    return 0


def refuse_fields(arguments: argparse.Namespace, model_file: Path) -> None:
    """Raise ConfigError if an option is given that has no meaning for an .mbs."""
    for field_name in choose_fields(arguments, ALONE):
        flag = FLAGS[field_name].flag
        raise ConfigError("usage", f"{flag} is for a robot; '{model_file}' is an .mbs already")


def _print_page_as_json(page: Page, output: Path) -> None:
    """Print the place and the sizes of the page, and its missing meshes, as JSON."""
    print_json(
        {
            "page": str(output),
            "sizes": page.sizes,
            "missing": page.missing,
            "diagnostics": page.diagnostics,
        }
    )


def _format_output(output: Path) -> str:
    """Return the name of the output for a message."""
    return "standard output" if is_stream(output) else near(output)


def _print_next_steps(page: Page, output: Path, verbose: bool) -> None:
    """Print the size of the page, its missing meshes, and how to open it."""
    if verbose:
        labels = {"all": "", "viewer": "three.js ", "meshes": "meshes "}
        size_texts = [
            f"{label}{page.sizes[part_name] / 1e6:.2f} MB" for part_name, label in labels.items()
        ]
        print(f"  {', '.join(size_texts)}")
    for diagnostic in page.diagnostics:
        print(with_near_paths(str(diagnostic)), file=sys.stderr)
    if page.missing:
        print(f"  {counted(len(page.missing), 'mesh')} not drawn; the page names them")
    if not is_stream(output):
        print(f"Next: open {near(output)} in a browser; it is one file, which you can send on")
