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
        configured_pass: The pass.
        conversion: What the pass changes.
        earlier_passes: The passes that ran before it.
    """

    def __init__(
        self,
        configured_pass: ConfiguredPass,
        conversion: Conversion,
        earlier_passes: Sequence[ConfiguredPass],
    ) -> None:
        self._configured_pass = configured_pass
        self._conversion = conversion
        self._earlier_passes = earlier_passes
        self._had_robot = bool(conversion.robot.links)
        self._robot: bytes | None = None
        if self._had_robot and _may_change_robot(configured_pass):
            self._robot = encode(conversion.robot)
        self._protected = "" if configured_pass.entry.is_ours else protected_state(conversion)
        self._sections: dict[str, Counter[bytes]] | None = None
        # Our own passes keep the contract among themselves, as the tests show.
        if not configured_pass.entry.is_ours or not all(
            earlier_pass.entry.is_ours for earlier_pass in earlier_passes
        ):
            self._sections = take_snapshot(conversion)

    def finish(self) -> None:
        """Check what the pass has left, and record how it changed the robot.

        Raises:
            ConversionError: The pass broke the contract.
        """
        configured_pass, conversion = self._configured_pass, self._conversion
        entry, pass_class = configured_pass.entry, configured_pass.kind
        if not entry.is_ours:
            subject = f"pass '{entry.name}' of plugin '{entry.plugin}'"
            check_protected(conversion, self._protected, subject, entry.source)
            self._check_result()
        if self._robot is not None:
            declared = "robot" in pass_class.writes
            record_change(conversion, self._robot, entry.name, entry.plugin, declared)

    def check_sections(self) -> None:
        """Check the sections that the pass has changed.

        Raises:
            ConversionError: ``stale``, an earlier pass had used one of them.
        """
        if self._sections is None:
            return
        entry, pass_class = self._configured_pass.entry, self._configured_pass.kind
        change = compare(self._sections, take_snapshot(self._conversion))
        # the tests check our own passes against each other
        readers = [
            earlier_pass
            for earlier_pass in self._earlier_passes
            if not (entry.is_ours and earlier_pass.entry.is_ours)
        ]
        stale_section = find_stale(pass_class, change.altered, [reader.kind for reader in readers])
        if stale_section:
            message, hint = stale_section
            culprit = next(
                earlier_pass.entry
                for earlier_pass in (self._configured_pass, *readers)
                if not earlier_pass.entry.is_ours
            )
            message += f" (plugin '{culprit.plugin}')"
            hint += ": a pass of that place uses the change"
            raise ConversionError("stale", message, file=culprit.source, hint=hint)
        declared = {
            *pass_class.writes,
            *(IMPLIED[section] for section in pass_class.writes if section in IMPLIED),
        }
        undeclared = [section for section in change.changed if section not in declared]
        if undeclared and not entry.is_ours:
            self._conversion.warn(
                "undeclared",
                f"pass '{entry.name}' of plugin '{entry.plugin}' changes the "
                f"{' and the '.join(undeclared)}, and does not declare it",
                hint=f"add to its 'writes': {', '.join(map(repr, undeclared))}",
            )

    def _check_result(self) -> None:
        """Raise ConversionError for a robot that is not a tree, or files that cannot be written."""
        robot = self._conversion.robot
        code, hint = "plugin-robot-broken", "each link but one is the child of one joint"
        fault = _find_tree_fault(robot) if self._had_robot or robot.links else None
        if fault is None:
            code = "plugin-output-broken"
            fault, hint = _find_output_fault(self._conversion) or (None, "")
        if fault is not None:
            entry = self._configured_pass.entry
            message = (
                f"pass '{entry.name}' of plugin '{entry.plugin}' leaves robot "
                f"'{robot.name}' broken: {fault}"
            )
            raise ConversionError(code, message, file=entry.source, hint=hint)


def find_stale(
    pass_class: type[Pass], altered: Collection[str], earlier_passes: Iterable[type[Pass]]
) -> tuple[str, str] | None:
    """Find a section that a pass changed after another pass had made something from it.

    Args:
        pass_class: The pass.
        altered: The sections whose earlier parts the pass changed or removed.
        earlier_passes: The passes that ran before it.

    Returns:
        The message and a hint; None if nothing is stale.  A section that the pass declares to write
        is made anew, and so is not stale.
    """
    for section in altered:
        for reader in earlier_passes:
            stale_sections = [
                written_section
                for written_section in reader.writes
                if written_section not in (section, *pass_class.writes)
            ]
            if section in reader.reads and stale_sections:
                message = (
                    f"pass '{pass_class.name}' changes the {section} after pass "
                    f"'{reader.name}' made the {stale_sections[0]} from it"
                )
                return message, f"put '{pass_class.name}' before '{reader.name}'"
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


def check_protected(
    conversion: Conversion, previous_state: str, subject: str, source_file: str
) -> None:
    """Raise ConversionError if other authors' code has changed a protected field or the result.

    Args:
        conversion: What the code may have changed.
        previous_state: Its ``protected_state`` before.
        subject: What ran, as the subject of a sentence.
        source_file: The file of the code.
    """
    if protected_state(conversion) != previous_state:
        message = f"{subject} changes the settings, or the result of 'check'"
        hint = "conversion.settings and conversion.checked are for reading"
        raise ConversionError("plugin-verdict", message, file=source_file, hint=hint)
    checked, written = conversion.checked, conversion.written
    if checked.proof is not None and conversion.files.get(written) != checked.proven:
        message = f"{subject} changes the file: it is not the '{written.name}' that was checked"
        hint = "put the pass before 'check', which checks its result then"
        raise ConversionError("plugin-output-broken", message, file=source_file, hint=hint)


def record_change(
    conversion: Conversion,
    robot_before: bytes,
    change_author: str,
    plugin_name: str,
    declared: bool,
) -> None:
    """Record the changes of the robot; the inserted base is no part of the URDF.

    Args:
        conversion: The conversion, with the robot as it is now.
        robot_before: The robot as it was, encoded.
        change_author: The name of the pass, or of the hook, that ran.
        plugin_name: The plugin of the code.
        declared: Whether the code declares to write the robot.

    Raises:
        ConversionError: ``plugin-robot-broken``, the robot has a value that no URDF can have.
    """
    robot, inserted = conversion.robot, conversion.base.inserted
    base_names = {inserted, robot.joints[inserted].parent} if inserted in robot.joints else set()
    try:
        robot_after = encode(robot)
    except (TypeError, ValueError) as error:
        message = (
            f"{change_author} (plugin '{plugin_name}') leaves in robot '{robot.name}' "
            f"what no URDF can hold: {error}"
        )
        raise ConversionError("plugin-robot-broken", message) from error
    changes = [
        change
        for change in find_changes(robot_before, robot_after)
        if not (change.kind in ("link-added", "joint-added") and change.name in base_names)
    ]
    if changes:
        conversion.checked.changed.append(
            RobotChange(change_author, plugin_name, declared, changes)
        )


def _may_change_robot(configured_pass: ConfiguredPass) -> bool:
    """Return whether a pass may change the robot that the URDF states.

    Another author's pass may.  One of ours changes the robot only if its options say so;
    insert-base only puts a base under the robot.
    """
    return not configured_pass.entry.is_ours or (
        "robot" in configured_pass.kind.writes and configured_pass.pass_ != configured_pass.kind()
    )


def _find_output_fault(conversion: Conversion) -> tuple[str, str] | None:
    """Return what keeps the files and the report from being written, and a hint."""
    for file_path, content in conversion.files.items():
        hint = "conversion.add_file(name, data) takes a path in the folder of the output, and bytes"
        if not isinstance(file_path, Path) or not isinstance(content, bytes):
            return f"conversion.files has {file_path!r}: {type(content).__name__}", hint
        if not file_path.is_absolute() and file_path != conversion.written:
            return f"conversion.files has '{file_path}', which is in no folder", hint
    try:
        msgspec.json.encode(conversion.report, enc_hook=without_origin)
    except Exception as error:
        hint = "conversion.report must be plain data: numbers, texts, lists, dicts, Structs"
        return f"conversion.report cannot be JSON: {error}", hint
    return None


def _find_tree_fault(robot: Robot) -> str | None:
    """Return what keeps the robot from being one tree; None if it is a tree."""
    for kind, elements in (("link", robot.links), ("joint", robot.joints)):
        for element_name, element in elements.items():
            if element.name != element_name:
                return f"robot.{kind}s['{element_name}'] is a {kind} called '{element.name}'"
    parent_joints: dict[str, str] = {}
    for joint in robot.joints.values():
        for link_name in (joint.parent, joint.child):
            if link_name not in robot.links:
                return f"joint '{joint.name}' names '{link_name}', which is no link"
        first_joint = parent_joints.setdefault(joint.child, joint.name)
        if first_joint != joint.name:
            names = f"'{first_joint}' and '{joint.name}'"
            return f"link '{joint.child}' is the child of the joints {names}"
    root_links = [link_name for link_name in robot.links if link_name not in parent_joints]
    if len(root_links) != 1:
        return f"{len(root_links)} links have no parent joint: {some(root_links)}"
    if len(robot.depth_first()) != len(robot.joints):
        return "some of its joints form a loop"
    return None
