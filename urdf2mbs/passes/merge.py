"""Merge: keep what people changed in the .mbs that is there.

Beyond the method, whose authors edited their models by hand after the conversion.  The .mbs that
was written last is the base; what people made of it since are edits.  They are applied to the new
conversion, and the result is written into their file.  Without edits nothing is done.
"""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk import files
from urdf2mbs.disk.seal import has_seal, intact, unseal
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import Part
from urdf2mbs.mbs.reader import read
from urdf2mbs.merge import base
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError

#: The kinds of things that the proof compares.
_COMPARED = frozenset(
    ["base", "body", "joint", "point", "cut", "user constraint", "user model", "parameter"]
)


class Merge(Pass):
    reads = ("mbs-file", "names")
    writes = ("mbs-file",)

    prefer: Literal["urdf", "edited"] | dict[str, Literal["urdf", "edited"]] = "urdf"
    """Who wins where the URDF and an edit changed the same thing: ``urdf`` or ``edited``, for all
    fields or for each by its name (``{mass: edited}``)."""

    def run(self, conversion: Conversion) -> None:
        settings = conversion.settings
        output, robot, source = settings.output, conversion.robot.name, settings.source
        if output.suffix.lower() != ".mbs":
            return
        conversion.behind[base.path(output)] = base.text(conversion.files[output], robot, source)
        there = files.read(output) if files.is_file(output) else b""
        known = base.read(output)
        if not there or intact(there) or (known is None and not has_seal(there)):
            return
        if settings.fresh:
            conversion.replaces[output] = there
        elif known is not None:
            if not base.is_of(known, robot, source):
                raise ConfigError(
                    "merge-other-robot",
                    f"'{output}' was made of another robot and edited since: robot '{robot}' of "
                    f"{source.name} is not merged with it",
                    hint="write elsewhere, or start over by --fresh",
                )
            self._merge(conversion, known, there)

    def _merge(self, conversion: Conversion, known: bytes, there: bytes) -> None:
        from urdf2mbs.merge.merge import merge, with_those_before

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
        conversion.files[output] = unseal(merged.data)
        conversion.replaces[output] = there
        if merged.orphans is not None:
            place = output.with_name(f"{output.stem}.orphaned.mbs")
            before = files.read(place) if files.is_file(place) else b""
            conversion.replaces[place] = before
            conversion.ahead[place] = with_those_before(merged.orphans, unseal(before))
        plan = merged.plan
        conversion.edited = any(
            not edit.drawing and edit.kind in _COMPARED
            and (edit.change, edit.kind) != ("added", "point")
            for edit in plan.kept
        )  # fmt: skip
        conversion.added = {
            f"{edit.kind} '{edit.name}'": f"added in {output.name}"
            for edit in plan.kept
            if edit.change == "added" and not edit.drawing
        }
        _rename(conversion, merged.names)
        _forget_removed(conversion)
        words = plan.words()
        conversion.facts["merge"] = {"words": words, **msgspec.to_builtins(plan)}
        for code, sentences in (
            ("merge-conflict-won", words["in conflict"]), ("merge-orphaned", words["orphaned"])
        ):  # fmt: skip
            for sentence in sentences:
                conversion.warn(code, sentence)


def _rename(conversion: Conversion, names: dict[tuple[str, str], str | None]) -> None:
    """Call the robot's bodies and joints as people call them now; forget what they removed."""
    called = conversion.names

    def now(kind: str, known: list[str]) -> list[str]:
        renamed = [names.get((kind, name), name) for name in known]
        return [name for name in renamed if name is not None]

    called.bodies = {
        link: name for link, body in called.bodies.items() for name in now("body", [body])
    }
    called.joints = {joint: now("joint", known) for joint, known in called.joints.items()}
    called.coordinates = {joint: now("joint", known) for joint, known in called.coordinates.items()}
    for link, frame in list(conversion.frames.items()):
        body = None if frame.body is None else names.get(("body", frame.body), frame.body)
        joint = None if frame.joint is None else names.get(("joint", frame.joint), frame.joint)
        if (body is None) != (frame.body is None) or (joint is None) != (frame.joint is None):
            del conversion.frames[link]
        else:
            frame.body, frame.joint = body, joint


def _forget_removed(conversion: Conversion) -> None:
    """Take out of the simulation what uses a joint, point, link or user model that is no more."""
    from urdf2mbs.diff.matching import things

    simulation = conversion.simulation
    there = {id(thing.part) for thing in things(conversion.mbs)}
    for field in simulation.__struct_fields__:
        used = getattr(simulation, field)
        if isinstance(used, list):
            used[:] = [part for part in used if there.issuperset(map(id, _parts(part)))]


def _parts(used: Any) -> list[Any]:
    """The objects of the model that a part of the simulation uses."""
    values = [getattr(used, field) for field in getattr(used, "__struct_fields__", ())]
    lists = [value if isinstance(value, list) else [value] for value in values]
    return [part for parts in lists for part in parts if isinstance(part, Part)]
