"""Write a certificate: a second opinion compares a URDF with an .mbs without urdf2mbs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import PassEntry, hookimpl, in_project

if TYPE_CHECKING:
    from pathlib import Path

    from urdf2mbs.plugin import Conversion, Intent


def _is_there(conversion: Conversion, given: bool) -> bool:
    """Return True if a certificate is asked for, or if there is an earlier one."""
    earlier = conversion.settings.output.with_suffix(".proof.json")
    return in_project(conversion, given) or earlier.exists()


@hookimpl
def urdf2mbs_intent(model: Path) -> Intent | None:
    """Return the changes on purpose that the certificate of an .mbs records."""
    from urdf2mbs_certificate.passes.certificate import read_intent

    return read_intent(model)


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the pass ``certificate``, which comes after all passes that write files."""
    after = ("check", "equations", "project")
    return [PassEntry("certificate", "urdf2mbs_certificate", after, _is_there)]
