"""What `lint` and `verify` find in a robot: a line for each, or SARIF for the pages of a CI.

SARIF 2.1.0 is the format of OASIS for the results of linters.  GitHub shows it beside the lines.
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
    write_files,
    written,
)

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
#: The code of a difference between two robots.
DIFFERS = "not-the-same"


def add_options(command: argparse.ArgumentParser) -> None:
    """The options of ``verify`` for a CI."""
    command.add_argument(
        "--ci", action="store_true", help="print a line for each finding, with file and line"
    )
    add_sarif(command)


def add_sarif(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--sarif", type=path, metavar="FILE", help="write all findings as SARIF 2.1.0, too"
    )


class Findings:
    """All that was found in a robot, each with its place in the robot's own files."""

    def __init__(self, source: str) -> None:
        self.said: list[Diagnostic] = []
        self.source = source
        self.read_files: Collection[str] = ()
        """The files that were read so far."""

    @property
    def files(self) -> list[str]:
        """The files of the robot that were read."""
        return [file for file in self.read_files if not file.lower().endswith(".mbs")]

    def placed(self) -> list[Diagnostic]:
        """The findings, with the line of the URDF or xacro file as far as it is known."""
        return [self._place(found) for found in self.said]

    def _place(self, found: Diagnostic) -> Diagnostic:
        file = (found.file or self.source).removesuffix(written.EXPANDED)
        line = found.line if found.file == file else None
        file = near(Path(file))
        for kind, name in (("joint", found.joint), ("link", found.link)):
            place = (
                written.find_declaration(kind, name, self.files) if name and line is None else None
            )
            if place is not None:
                file, line = near(Path(place[0])), place[1]
        return msgspec.structs.replace(found, file=file, line=line)

    def tell(self, verbose: bool) -> None:
        """Print each error and warning, and below it what to do; the notes if ``verbose``."""
        for found in self.placed():
            if verbose or found.level != "note":
                print(found)

    def sarif(self) -> dict[str, Any]:
        """The findings as SARIF."""
        from importlib.metadata import version

        placed = self.placed()
        rules = [
            {"id": code, "shortDescription": {"text": code.replace("-", " ")}}
            for code in sorted({found.code for found in placed})
        ]
        results = [
            {
                "ruleId": found.code, "level": found.level, "locations": [_location(found)],
                "message": {"text": "\n".join(filter(None, [found.message, found.hint]))},
            }
            for found in placed
        ]  # fmt: skip
        driver = {"name": "urdf2mbs", "version": version("urdf2mbs"), "rules": rules}
        run = {"tool": {"driver": driver}, "results": results}
        return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


@contextmanager
def collecting(sarif: Path | None, source: str) -> Iterator[Findings]:
    """Gives the findings to be filled; an error that ends the block is one of them.  They are
    written as SARIF at the end, if asked for."""
    found = Findings(source)
    failure = None
    with noting() as read_files:
        found.read_files = read_files
        try:
            yield found
        except ConversionError as error:
            if error.exit_code != ConversionError.exit_code:
                raise  # the command line is wrong, and not the robot
            found.said += [*error.earlier, error.diagnostic()]
            failure = error
    if sarif is not None:
        write_files({sarif: (json.dumps(found.sarif(), indent=1) + "\n").encode()})
    if failure is not None:
        raise failure


@contextmanager
def observe_verify(robot: str, arguments: argparse.Namespace) -> Iterator[Callable[[Any], bool]]:
    """Collect what ``verify`` finds; with ``--ci``, print a line for each finding.

    Args:
        robot: The file of the robot.
        arguments: The options of ``verify``.

    Yields:
        A function that takes the verdict, and returns whether it has printed it.
    """
    with collecting(arguments.sarif, robot) as findings:

        def take(verdict: Any) -> bool:
            findings.said += [*verdict.diagnostics, *differences(verdict.differences)]
            if not arguments.ci or arguments.json:
                return False
            findings.tell(arguments.verbose)
            print(verdict.verdict)
            return True

        yield take


def differences(found: Iterable[Difference]) -> list[Diagnostic]:
    """Where two robots differ, as errors."""
    return [
        Diagnostic("error", DIFFERS, one.message, link=one.link, joint=one.joint) for one in found
    ]


def _location(found: Diagnostic) -> dict[str, Any]:
    file, here = Path(found.file or "").absolute(), Path.cwd()
    inside = file.is_relative_to(here)
    uri = file.relative_to(here).as_posix() if inside else file.as_uri()
    region = {"startLine": found.line or 1}
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}
