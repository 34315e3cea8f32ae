"""`report`: one HTML page to look at."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.commands.printing import beside, near, print_json, tell
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import (
    ALONE,
    FLAGS,
    add_fields,
    add_printing,
    add_running,
    choose_fields,
    path,
    robot_or_config,
)
from urdf2mbs.commands.streams import STREAM, file_to_stdout, read_model
from urdf2mbs.disk.output import write_files
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConfigError, counted
from urdf2mbs.report.summary import report

if TYPE_CHECKING:
    from urdf2mbs.report.page import Page

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
    if str(arguments.output) == STREAM:
        with file_to_stdout(arguments) as give:
            return _make(arguments, give)
    return _make(arguments)


def _make(arguments: argparse.Namespace, give: Callable[[bytes], None] | None = None) -> int:
    """Convert, and write the page to its file, or hand it to ``give``."""
    from urdf2mbs.report.page import make

    file: Path = arguments.config
    if file.suffix.lower() == ".mbs":
        return _write_page_of_model(arguments, file, give)
    config, lines = robot_or_config(arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with Progress(arguments) as progress:
        pipeline.watch(progress)
        conversion = pipeline.run()
        progress.at = "the page"
        page = make(conversion)
    output = arguments.output or beside(conversion.settings.output, ".html")
    found = report(conversion)
    _write(arguments, page, f"{found.robot}: report", output, give, f" ({found.verdict})")
    if not arguments.json:
        tell(conversion, found, arguments.verbose)
        if give is None:
            print(f"Next: open {near(output)} in a browser; it is one file, which you can send on")
            print("      the .mbs itself is written by: urdf2mbs run, or urdf2mbs convert")
    return 0 if conversion.rejected is None else 3


def _write_page_of_model(
    arguments: argparse.Namespace, file: Path, give: Callable[[bytes], None] | None
) -> int:
    """The page of an .mbs alone: no URDF, nothing to convert or to compare."""
    from urdf2mbs.mbs.reader import read
    from urdf2mbs.report.page import make_of_model

    for field in choose_fields(arguments, ALONE):
        flag = FLAGS[field].flag
        raise ConfigError("usage", f"{flag} is for a robot; '{file}' is an .mbs already")
    model = read(read_model(file), str(file))
    output = arguments.output or beside(file, ".html")
    page = make_of_model(model, file)
    _write(arguments, page, f"{model.name}: page of the model", output, give)
    if give is None and not arguments.json:
        print(f"Next: open {near(output)} in a browser; it is one file, which you can send on")
    return 0


def _write(
    arguments: argparse.Namespace,
    page: Page,
    what: str,
    output: Path,
    give: Callable[[bytes], None] | None,
    more: str = "",
) -> None:
    """Write the page to its file, or hand it to ``give``, and say so."""
    if give is None:
        write_files({output: page.data}, force=arguments.force)
    else:
        give(page.data)
    if arguments.json:
        print_json({"page": str(output), "sizes": page.sizes, "missing": page.missing})
        return
    sizes = page.sizes
    print(f"{what} written to {near(output) if give is None else 'standard output'}{more}")
    print(
        f"  {sizes['all'] / 1e6:.2f} MB: three.js {sizes['viewer'] / 1e6:.2f}, "
        f"meshes {sizes['meshes'] / 1e6:.2f}"
    )
    if page.missing:
        print(f"  {counted(len(page.missing), 'mesh')} not drawn; the page names them")
