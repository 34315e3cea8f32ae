"""Merge: keep the edits of the .mbs that the output replaces.

Beyond the method, whose authors edited their models by hand after the conversion.  The .mbs that
was written last is the base; changes of it since are edits.  They are applied to the new
conversion, and the result is written into their file.  Without edits nothing is done.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import msgspec

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    ConversionError,
    File,
    JointModels,
    Pass,
    counted,
    files,
    hookimpl,
    is_ours,
    read_mbs,
    some,
    was_ours,
)
from urdf2mbs_edits.merge import base_file

if TYPE_CHECKING:
    from pathlib import Path

    from urdf2mbs.plugin import Mbs
    from urdf2mbs_edits.merge.plan import Plan


#: More values that are computed anew are one line of a plan.
MAX_LISTED = 3


class Merge(Pass):
    """Keep the edits that people made in the last output."""

    reads = ("robot", "mbs-file", "names")
    writes = ("mbs-file",)

    prefer: Literal["urdf", "edited"] | dict[str, Literal["urdf", "edited"]] = "urdf"
    """Who wins where the URDF and an edit changed the same value: ``urdf`` or ``edited``, for all
    fields or for each by its name (``{mass: edited}``)."""

    def run(self, conversion: Conversion) -> None:
        """Save the base of the next merge; merge if the file was edited since its base."""
        settings = conversion.settings
        output, robot, source = settings.output, conversion.robot.name, settings.source.name
        if output.suffix.lower() != ".mbs":
            return
        new_base = base_file.make_base(conversion.files[output], robot, source)
        conversion.files[base_file.get_base_path(output)] = File(new_base, "base")
        edited = files.read_bytes(output) if files.is_file(output) else b""
        base = base_file.read_base(output)
        is_edited = base is not None or was_ours(output)
        if not edited or is_ours(output) or not is_edited:
            return
        if settings.fresh:
            conversion.files[output] = File(conversion.files[output], replaces=edited)
        elif base is not None:
            if not base_file.is_made_of(base, robot, source):
                raise ConfigError(
                    "merge-other-robot",
                    f"'{output}' was made of another robot and edited since: robot '{robot}' of "
                    f"{source} is not merged with it",
                    hint="write elsewhere, or start over by --fresh",
                )
            self._merge(conversion, base, edited)

    def _merge(self, conversion: Conversion, base: bytes, edited: bytes) -> None:
        """Merge the edits from ``base`` to ``edited`` into the model and file of a conversion."""
        from urdf2mbs_edits.merge.follow import update_conversion
        from urdf2mbs_edits.merge.merge import merge

        output = conversion.settings.output
        base_model = read_mbs(base, str(base_file.get_base_path(output)))
        edited_model = _read_edited(edited, output)
        merged = merge(base_model, edited_model, conversion.mbs, self.prefer, str(output))
        conversion.files[output] = File(merged.data, replaces=edited)
        update_conversion(conversion, merged.names, merged.plan.kept, output.name)
        _report(conversion, merged.plan)


class PlannedChanges:
    """Lists the changes of a file that is replaced as a whole, for ``--plan``."""

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Conversion) -> None:
        """Compare the file with the one that replaces it, where nothing was merged."""
        output = conversion.settings.output
        is_model = isinstance(pass_, Merge) and output.suffix.lower() == ".mbs"
        if not is_model or "merge" in conversion.report or not files.is_file(output):
            return
        from urdf2mbs_edits.merge.merge import merge
        from urdf2mbs_edits.merge.plan import COMPUTED

        converted = read_mbs(conversion.files[output], str(output))  # a merge changes it
        try:
            replaced = read_mbs(files.read_bytes(output), str(output))
        except (OSError, ConversionError):
            return  # somebody broke the file: it is replaced, whatever it contains
        plan = merge(replaced, replaced, converted, "urdf", str(output)).plan
        if plan.updated:
            sentences, brief = _describe(conversion, plan)
            kinds = ("updated", COMPUTED)
            words = {heading: sentences[heading] for heading in kinds if heading in sentences}
            conversion.report["replaced"] = {"words": words, "brief": brief}


def _read_edited(data: bytes, output: Path) -> Mbs:
    """Read the edited file; the error says what to do if it cannot be read."""
    try:
        return read_mbs(data, str(output))
    except ConversionError as error:
        raise ConfigError(
            "output-not-ours",
            f"'{output}' was edited since urdf2mbs wrote it, and cannot be read: {error.message}",
            file=error.file,
            line=error.line,
            hint="fix it, or start over by --fresh or --force",
        ) from None


def _describe(conversion: Conversion, plan: Plan) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Return the sentences of a plan by heading, and a brief text for a heading with many."""
    from urdf2mbs_edits.merge.check import SideNames
    from urdf2mbs_edits.merge.plan import COMPUTED

    computed = plan.list_computed(conversion.state(JointModels).values)
    models = dict.fromkeys(change.owner.removeprefix("user model ") for change in computed)
    brief = {COMPUTED: f"{counted(len(computed), 'value')} of {some(models, 4)}"}
    return plan.describe(SideNames(), computed), brief if len(computed) > MAX_LISTED else {}


def _report(conversion: Conversion, plan: Plan) -> None:
    """Add the plan to the report, and warn of conflicts, lost edits and negative masses."""
    sentences, brief = _describe(conversion, plan)
    conversion.report["merge"] = {
        "words": sentences,
        "brief": brief,
        **msgspec.to_builtins(plan),
    }
    for sentence in sentences["in conflict"]:
        conversion.warn("merge-conflict-won", sentence)
    for sentence in sentences["orphaned"]:
        conversion.warn("merge-orphaned", sentence)
    file = conversion.settings.output.name
    for body in conversion.mbs.bodies:
        if (body.mass or 0.0) < 0.0:
            message = f"body '{body.name}': mass is {body.mass:g} kg in {file}; expected 0 or more"
            conversion.warn("mass-negative", message)
