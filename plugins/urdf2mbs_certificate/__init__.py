"""A certificate: what a second opinion needs, which reads a URDF and an .mbs without urdf2mbs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl, in_project

if TYPE_CHECKING:
    from pathlib import Path

    from urdf2mbs.plugin import Conversion, Intent


def _is_there(conversion: Conversion, given: bool) -> bool:
    """True if a certificate is asked for, or an earlier one may be there."""
    there = conversion.settings.output.with_suffix(".proof.json")
    return in_project(conversion, given) or there.exists()


@hookimpl
def urdf2mbs_intent(model: Path) -> Intent | None:
    from urdf2mbs_certificate.passes.certificate import read_intent

    return read_intent(model)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    after = ("check", "equations", "project")
    return [PassEntry("certificate", "urdf2mbs_certificate", after, _is_there)]
