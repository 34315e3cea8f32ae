"""The contract of passes while they run: no pass changes what an earlier one has used.

The sections that passes read and write are listed in ``engine.sections``.  Two rules are checked
while another author's pass takes part, from what the passes really do:

* no pass changes a section from which an earlier pass made another, and
* a pass declares the sections that it changes (otherwise a warning).

Besides, other authors' code leaves the settings, the result of ``check`` and the checked file as
they are, and leaves a robot that is a tree and files that can be written.  The tests hold our own
passes against all of this, as if they were another author's.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.order import ConfiguredPass
from urdf2mbs.engine.sections import IMPLIED, compare, take_snapshot
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import without_origin
from urdf2mbs.messages.diagnostics import ConversionError, some
from urdf2mbs.urdf.changes import RobotChange, encode, find_changes
from urdf2mbs.urdf.model import Robot


class PassCheck:
    """What a conversion was before a pass, to be compared with what the pass leaves.

    Args:
        step: The pass.
        conversion: What the pass changes.
        earlier: The passes that ran before it.
    """

    def __init__(
        self, step: ConfiguredPass, conversion: Conversion, earlier: Sequence[ConfiguredPass]
    ) -> None:
        self._step = step
        self._conversion = conversion
        self._earlier = earlier
        self._had_robot = bool(conversion.robot.links)
        self._robot: bytes | None = None
        if self._had_robot and _may_change_robot(step):
            self._robot = encode(conversion.robot)
        self._protected = "" if step.entry.is_ours else protected_state(conversion)
        self._sections: dict[str, Counter[bytes]] | None = None
        # Our own passes keep the contract among themselves, as the tests show.
        if not step.entry.is_ours or not all(other.entry.is_ours for other in earlier):
            self._sections = take_snapshot(conversion)

    def finish(self) -> None:
        """Check what the pass has left, and record how it changed the robot.

        Raises:
            ConversionError: The pass broke the contract.
        """
        step, conversion = self._step, self._conversion
        entry, kind = step.entry, step.kind
        if not entry.is_ours:
            code = f"pass '{entry.name}' of plugin '{entry.plugin}'"
            check_protected(conversion, self._protected, code, entry.source)
            self._check_result()
        if self._robot is not None:
            declared = "robot" in kind.writes
            record_change(conversion, self._robot, entry.name, entry.plugin, declared)

    def check_sections(self) -> None:
        """Check the sections that the pass has changed.

        Raises:
            ConversionError: ``stale``, an earlier pass had used one of them.
        """
        if self._sections is None:
            return
        entry, kind = self._step.entry, self._step.kind
        change = compare(self._sections, take_snapshot(self._conversion))
        # of two passes of ours, the tests show it
        readers = [step for step in self._earlier if not (entry.is_ours and step.entry.is_ours)]
        stale = find_stale(kind, change.altered, [reader.kind for reader in readers])
        if stale:
            message, hint = stale
            culprit = next(step.entry for step in (self._step, *readers) if not step.entry.is_ours)
            message += f" (plugin '{culprit.plugin}')"
            hint += ": a pass of that place uses the change"
            raise ConversionError("stale", message, file=culprit.source, hint=hint)
        declared = {*kind.writes, *(IMPLIED[name] for name in kind.writes if name in IMPLIED)}
        undeclared = [name for name in change.changed if name not in declared]
        if undeclared and not entry.is_ours:
            self._conversion.warn(
                "undeclared",
                f"pass '{entry.name}' of plugin '{entry.plugin}' changes the "
                f"{' and the '.join(undeclared)}, and does not declare it",
                hint=f"add to its 'writes': {', '.join(map(repr, undeclared))}",
            )

    def _check_result(self) -> None:
        """Raise ConversionError for a robot that is no tree, or files that cannot be written."""
        robot = self._conversion.robot
        code, hint = "plugin-robot-broken", "each link but one is the child of one joint"
        fault = _find_tree_fault(robot) if self._had_robot or robot.links else None
        if fault is None:
            code = "plugin-output-broken"
            fault, hint = _find_output_fault(self._conversion) or (None, "")
        if fault is not None:
            entry = self._step.entry
            message = (
                f"pass '{entry.name}' of plugin '{entry.plugin}' leaves robot '{robot.name}' "
                f"broken: {fault}"
            )
            raise ConversionError(code, message, file=entry.source, hint=hint)


def find_stale(
    kind: type[Pass], altered: Collection[str], earlier: Iterable[type[Pass]]
) -> tuple[str, str] | None:
    """Find a section that a pass changed after another pass had made something from it.

    Args:
        kind: The pass.
        altered: The sections of which the pass changed what was there.
        earlier: The passes that ran before it.

    Returns:
        The message and a hint; None if nothing is stale.  What the pass declares to write it makes
        anew, so that this is not stale.
    """
    for section in altered:
        for reader in earlier:
            stale = [other for other in reader.writes if other not in (section, *kind.writes)]
            if section in reader.reads and stale:
                message = (
                    f"pass '{kind.name}' changes the {section} after pass '{reader.name}' made "
                    f"the {stale[0]} from it"
                )
                return message, f"put '{kind.name}' before '{reader.name}'"
    return None


def protected_state(conversion: Conversion) -> str:
    """Return the fields that a plugin must not change, as text that can be compared."""
    checked = conversion.checked
    return repr(
        (
            conversion.settings,
            checked.proof,
            checked.rejected,
            checked.changed,
            hash(checked.proven),
        )
    )


def check_protected(conversion: Conversion, before: str, code: str, file: str) -> None:
    """Raise ConversionError if other authors' code has changed a protected field or the result.

    Args:
        conversion: What the code may have changed.
        before: Its ``protected_state`` before.
        code: What ran, as the subject of a sentence.
        file: The file of the code.
    """
    if protected_state(conversion) != before:
        message = f"{code} changes the settings, or the result of 'check'"
        hint = "conversion.settings and conversion.checked are for reading"
        raise ConversionError("plugin-verdict", message, file=file, hint=hint)
    checked, written = conversion.checked, conversion.written
    if checked.proof is not None and conversion.files.get(written) != checked.proven:
        message = f"{code} changes the file: it is not the '{written.name}' that was checked"
        hint = "put the pass before 'check', which checks its result then"
        raise ConversionError("plugin-output-broken", message, file=file, hint=hint)


def record_change(
    conversion: Conversion, before: bytes, code: str, plugin: str, declared: bool
) -> None:
    """Record what has changed of the robot; the inserted base is no part of the URDF.

    Args:
        conversion: The conversion, with the robot as it is now.
        before: The robot as it was, encoded.
        code: The name of the pass, or of the hook, that ran.
        plugin: The plugin of the code.
        declared: Whether the code declares to write the robot.

    Raises:
        ConversionError: ``plugin-robot-broken``, the robot holds what no URDF can hold.
    """
    robot, inserted = conversion.robot, conversion.base.inserted
    base = {inserted, robot.joints[inserted].parent} if inserted in robot.joints else set()
    try:
        after = encode(robot)
    except (TypeError, ValueError) as error:
        message = (
            f"{code} (plugin '{plugin}') leaves in robot '{robot.name}' what no URDF can hold: "
            f"{error}"
        )
        raise ConversionError("plugin-robot-broken", message) from error
    changes = [
        change
        for change in find_changes(before, after)
        if not (change.kind in ("link-added", "joint-added") and change.name in base)
    ]
    if changes:
        conversion.checked.changed.append(RobotChange(code, plugin, declared, changes))


def _may_change_robot(step: ConfiguredPass) -> bool:
    """Return whether a pass may change the robot that the URDF states.

    Another author's pass may.  One of ours changes the robot only if its options say so;
    insert-base only puts a base under the robot.
    """
    return not step.entry.is_ours or ("robot" in step.kind.writes and step.pass_ != step.kind())


def _find_output_fault(conversion: Conversion) -> tuple[str, str] | None:
    """Return what keeps the files and the report from being written, and a hint."""
    for path, data in conversion.files.items():
        hint = "conversion.add_file(name, data) takes a path in the folder of the output, and bytes"
        if not isinstance(path, Path) or not isinstance(data, bytes):
            return f"conversion.files has {path!r}: {type(data).__name__}", hint
        if not path.is_absolute() and path != conversion.written:
            return f"conversion.files has '{path}', which is in no folder", hint
    try:
        msgspec.json.encode(conversion.report, enc_hook=without_origin)
    except Exception as error:
        hint = "conversion.report must be plain data: numbers, texts, lists, dicts, Structs"
        return f"conversion.report cannot be JSON: {error}", hint
    return None


def _find_tree_fault(robot: Robot) -> str | None:
    """Return what keeps the robot from being one tree; None if it is a tree."""
    for kind, elements in (("link", robot.links), ("joint", robot.joints)):
        for name, element in elements.items():
            if element.name != name:
                return f"robot.{kind}s['{name}'] is a {kind} called '{element.name}'"
    parent_joints: dict[str, str] = {}
    for joint in robot.joints.values():
        for name in (joint.parent, joint.child):
            if name not in robot.links:
                return f"joint '{joint.name}' names '{name}', which is no link"
        first = parent_joints.setdefault(joint.child, joint.name)
        if first != joint.name:
            return f"link '{joint.child}' is the child of the joints '{first}' and '{joint.name}'"
    roots = [name for name in robot.links if name not in parent_joints]
    if len(roots) != 1:
        return f"{len(roots)} links have no parent joint: {some(roots)}"
    if len(robot.depth_first()) != len(robot.joints):
        return "some of its joints form a loop"
    return None
