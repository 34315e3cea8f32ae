"""The findings of `lint` and `verify`: a line for each, or SARIF for the pages of a CI.

SARIF 2.1.0 is OASIS's format for the results of linters.  GitHub shows them beside the code.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    ConversionError,
    Diagnostic,
    Difference,
    near,
    noting,
    path,
    with_near_paths,
    write_files,
    written,
)

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
#: The code of a difference between two robots.
DIFFERENCE_CODE = "not-the-same"


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of ``verify`` for a CI."""
    command.add_argument(
        "--ci", action="store_true", help="print a line for each finding, with file and line"
    )
    add_sarif(command)


def add_sarif(command: argparse.ArgumentParser) -> None:
    """Add the option ``--sarif``."""
    command.add_argument(
        "--sarif", type=path, metavar="FILE", help="write all findings as SARIF 2.1.0, too"
    )


class Findings:
    """The findings about a robot, each located in the robot's source files."""

    def __init__(self, source: str) -> None:
        self.diagnostics: list[Diagnostic] = []
        """The findings as they were reported."""
        self.source = source
        self.read_files: Collection[str] = ()
        """The files that were read so far."""

    def locate(self) -> list[Diagnostic]:
        """Return the findings with their lines in the URDF or xacro files, if known."""
        return [self._locate(diagnostic) for diagnostic in self.diagnostics]

    def _locate(self, diagnostic: Diagnostic) -> Diagnostic:
        """Return a finding with its line: as reported, or that of its joint or link."""
        file = (diagnostic.file or self.source).removesuffix(written.EXPANDED)
        line = diagnostic.line if diagnostic.file == file else None
        file = near(Path(file))
        source_files = [file for file in self.read_files if not file.lower().endswith(".mbs")]
        for kind, name in (("joint", diagnostic.joint), ("link", diagnostic.link)):
            if not name or line is not None:
                continue
            declaration = written.find_declaration(kind, name, source_files)
            if declaration is not None:
                file, line = near(Path(declaration[0])), declaration[1]
        return msgspec.structs.replace(diagnostic, file=file, line=line)

    def print(self, *, verbose: bool) -> None:
        """Print each error and warning with its remedy; with ``verbose`` also the notes."""
        for diagnostic in self.locate():
            if verbose or diagnostic.level != "note":
                print(with_near_paths(str(diagnostic)))

    def make_sarif(self) -> dict[str, Any]:
        """Return the findings as SARIF."""
        from importlib.metadata import version

        diagnostics = self.locate()
        rules = [
            {"id": code, "shortDescription": {"text": code.replace("-", " ")}}
            for code in sorted({diagnostic.code for diagnostic in diagnostics})
        ]
        results = [
            {
                "ruleId": diagnostic.code,
                "level": diagnostic.level,
                "locations": [_make_location(diagnostic)],
                "message": {"text": "\n".join(filter(None, [diagnostic.message, diagnostic.hint]))},
            }
            for diagnostic in diagnostics
        ]
        driver = {"name": "urdf2mbs", "version": version("urdf2mbs"), "rules": rules}
        run = {"tool": {"driver": driver}, "results": results}
        return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


@contextmanager
def collect_findings(sarif: Path | None, source: str) -> Iterator[Findings]:
    """Collect findings about a robot.

    Args:
        sarif: Write the findings into this file at the end.
        source: The file of the robot.

    Yields:
        The findings, to be filled.  An error that ends the block is added.

    Raises:
        ConversionError: The error that ended the block.
    """
    findings = Findings(source)
    failure = None
    with noting() as read_files:
        findings.read_files = read_files
        try:
            yield findings
        except ConversionError as error:
            if error.exit_code != ConversionError.exit_code:
                raise  # the command line is wrong, not the robot
            findings.diagnostics += [*error.earlier, error.diagnostic()]
            failure = error
    if sarif is not None:
        write_files({sarif: (json.dumps(findings.make_sarif(), indent=1) + "\n").encode()})
    if failure is not None:
        raise failure


@contextmanager
def observe_verify(robot: str, arguments: argparse.Namespace) -> Iterator[Callable[[Any], bool]]:
    """Collect the findings of ``verify``; with ``--ci``, print a line for each.

    Args:
        robot: The file of the robot.
        arguments: The options of ``verify``.

    Yields:
        A function that takes the verdict, and returns whether it has printed it.
    """
    with collect_findings(arguments.sarif, robot) as findings:

        def take(verdict: Any) -> bool:
            findings.diagnostics += verdict.diagnostics
            findings.diagnostics += make_diagnostics(verdict.differences)
            if not arguments.ci or arguments.json:
                return False
            findings.print(verbose=arguments.verbose)
            print(verdict.verdict)
            return True

        yield take


def make_diagnostics(differences: Iterable[Difference]) -> list[Diagnostic]:
    """Return an error for each difference between two robots."""
    return [
        Diagnostic(
            "error",
            DIFFERENCE_CODE,
            difference.message,
            link=difference.link,
            joint=difference.joint,
        )
        for difference in differences
    ]


def _make_location(diagnostic: Diagnostic) -> dict[str, Any]:
    """Return the location of a finding as SARIF, relative to the working folder if possible."""
    file, working_folder = Path(diagnostic.file or "").absolute(), Path.cwd()
    if file.is_relative_to(working_folder):
        uri = file.relative_to(working_folder).as_posix()
    else:
        uri = file.as_uri()
    region = {"startLine": diagnostic.line or 1}
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}
