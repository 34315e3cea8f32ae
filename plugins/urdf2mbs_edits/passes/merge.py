"""Merge: keep what people changed in the .mbs that is there.

Beyond the method, whose authors edited their models by hand after the conversion.  The .mbs that
was written last is the base; what people made of it since are edits.  They are applied to the new
conversion, and the result is written into their file.  Without edits nothing is done.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    ConversionError,
    File,
    Pass,
    files,
    is_ours,
    was_ours,
)
from urdf2mbs.plugin import read_mbs as read
from urdf2mbs_edits.merge import base


class Merge(Pass):
    reads = ("robot", "mbs-file", "names")
    writes = ("mbs-file",)

    prefer: Literal["urdf", "edited"] | dict[str, Literal["urdf", "edited"]] = "urdf"
    """Who wins where the URDF and an edit changed the same thing: ``urdf`` or ``edited``, for all
    fields or for each by its name (``{mass: edited}``)."""

    def run(self, conversion: Conversion) -> None:
        settings = conversion.settings
        output, robot, source = settings.output, conversion.robot.name, settings.source.name
        if output.suffix.lower() != ".mbs":
            return
        conversion.files[base.path(output)] = File(
            base.text(conversion.files[output], robot, source), "base"
        )
        there = files.read_bytes(output) if files.is_file(output) else b""
        known = base.read(output)
        if not there or is_ours(output) or (known is None and not was_ours(output)):
            return
        if settings.fresh:
            conversion.files[output] = File(conversion.files[output], replaces=there)
        elif known is not None:
            if not base.is_of(known, robot, source):
                raise ConfigError(
                    "merge-other-robot",
                    f"'{output}' was made of another robot and edited since: robot '{robot}' of "
                    f"{source} is not merged with it",
                    hint="write elsewhere, or start over by --fresh",
                )
            self._merge(conversion, known, there)

    def _merge(self, conversion: Conversion, known: bytes, there: bytes) -> None:
        from urdf2mbs_edits.merge.follow import follow
        from urdf2mbs_edits.merge.merge import merge, with_those_before

        output = conversion.settings.output
        try:
            edited = read(there, str(output))
        except ConversionError as error:
            raise ConfigError(
                "output-not-ours",
                f"'{output}' was edited since urdf2mbs wrote it, and is not read: {error.message}",
                file=error.file, line=error.line,
                hint="mend it, or start over by --fresh or --force",
            ) from None  # fmt: skip
        merged = merge(read(known, str(base.path(output))), edited, conversion.mbs, self.prefer)
        conversion.files[output] = File(merged.data, replaces=there)
        if merged.orphans is not None:
            place = output.with_name(f"{output.stem}.orphaned.mbs")
            before = files.read_bytes(place) if files.is_file(place) else b""
            orphans = with_those_before(merged.orphans, before)
            conversion.files[place] = File(orphans, "orphans", replaces=before)
        plan = merged.plan
        follow(conversion, merged.names, plan.kept, output.name)
        words = plan.words()
        conversion.report["merge"] = {"words": words, **msgspec.to_builtins(plan)}
        for code, sentences in (
            ("merge-conflict-won", words["in conflict"]), ("merge-orphaned", words["orphaned"])
        ):  # fmt: skip
            for sentence in sentences:
                conversion.warn(code, sentence)
        for body in conversion.mbs.bodies:
            if (body.mass or 0.0) < 0.0:
                has = f"body '{body.name}' has the mass {body.mass:g} kg in {output.name}"
                conversion.warn("mass-negative", f"{has}, and no body has a mass below zero")
