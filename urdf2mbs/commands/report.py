"""`report`: one HTML page to look at."""

from __future__ import annotations

import argparse

from urdf2mbs.commands.printing import beside, near, print_json, tell
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import robot_or_config, with_levels
from urdf2mbs.diagnostics import counted
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.output import write_files
from urdf2mbs.summary import report


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.report.page import make

    config, lines = with_levels(*robot_or_config(arguments), arguments)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with Progress(arguments.verbose) as progress:
        pipeline.plugins.watch(progress)
        conversion = pipeline.run()
        conversion.progress("the page")
        page = make(conversion)
    output = arguments.output or beside(conversion.settings.output, ".html")
    write_files({output: page.data})
    found = report(conversion)
    if arguments.json:
        print_json({"page": str(output), "sizes": page.sizes, "missing": page.missing})
    else:
        sizes = page.sizes
        print(f"{found.robot}: report written to {near(output)} ({found.verdict})")
        print(
            f"  {sizes['all'] / 1e6:.2f} MB: three.js {sizes['viewer'] / 1e6:.2f}, "
            f"meshes {sizes['meshes'] / 1e6:.2f}"
        )
        if page.missing:
            print(f"  {counted(len(page.missing), 'mesh')} not drawn; the page names them")
        tell(conversion, found, arguments.verbose)
        print(f"Next: open {near(output)} in a browser; it is one file, which you can send on")
        print("      the .mbs itself is written by: urdf2mbs run, or urdf2mbs convert")
    return 0 if conversion.rejected is None else 3
