"""Apply edits: make in the model what a file of edits says.

Beyond the method.  ``urdf2mbs edits`` writes what people changed in an .mbs into such a file, so
that a conversion and its edits are reproducible.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk import files
from urdf2mbs.disk.seal import seal
from urdf2mbs.engine.config import Name
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConfigError


class ApplyEdits(Pass):
    reads = ("mbs-file", "names")
    writes = ("mbs-file",)

    file: Name | None = None
    """The YAML file of edits, relative to the folder of the config; without it, nothing is done."""

    def run(self, conversion: Conversion) -> None:
        if self.file is None:
            return
        from urdf2mbs.diff.matching import things
        from urdf2mbs.diff.words import line
        from urdf2mbs.mbs.writer import write
        from urdf2mbs.merge import overlay
        from urdf2mbs.merge.follow import follow

        place = conversion.settings.folder / self.file
        try:
            data = files.read(place)
        except OSError as error:
            raise ConfigError(
                "edits-unreadable", f"cannot read '{place}': {error.strerror}"
            ) from None
        mbs = conversion.mbs
        try:
            made = []
            before = [(t, t.kind, t.name) for t in things(mbs) if t.kind in ("body", "joint")]
            parts = {id(thing.part): (kind, name) for thing, kind, name in before}
            for changes in overlay.read(data, str(place)):
                applying = overlay.apply(mbs, changes, "edited")
                for conflict in applying.conflicts:
                    conversion.warn("merge-conflict-won", conflict.words("the URDF", "the edit"))
                for edit, why in applying.orphans:
                    conversion.warn("edit-left-out", f"{line(edit.change)}: not made, since {why}")
                for change in applying.unknown:
                    conversion.warn(
                        "edit-left-out", f"{line(change)}: not made, since it is unknown"
                    )
                made += [change for change, _ in changes if change not in applying.unknown]
            now = {parts.get(id(t.part), (t.kind, "")): t.name for t in things(mbs)}
            names = {key: now.get(key) for key in parts.values()}
            follow(conversion, names, made, place.name)
            output = conversion.settings.output
            conversion.files[output] = seal(output, write(mbs))
        except (AttributeError, LookupError, TypeError, ValueError) as error:
            raise ConfigError(
                "edits-unreadable", f"an edit has a value that cannot be there: {error}",
                file=str(place), hint="urdf2mbs edits writes such files",
            ) from None  # fmt: skip
        conversion.overlay = data
