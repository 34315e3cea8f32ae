"""One clear message for what goes wrong in a plugin: whose pass, which robot, which line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.registered import Registered
from urdf2mbs.engine.tracebacks import frames_in, in_words
from urdf2mbs.mbs.model import without_origin
from urdf2mbs.messages.diagnostics import ConversionError, memory_full_error, some
from urdf2mbs.urdf.model import Robot

_DEBUG = "--debug shows the traceback"


def pass_failed(
    found: Registered, conversion: Conversion, error: BaseException, before: Sequence[Registered]
) -> ConversionError:
    """The error for an exception that came out of a pass; ``before`` are the passes that ran."""
    who = f"pass '{found.name}'"
    if isinstance(error, MemoryError):
        return memory_full_error(f"{who} on robot '{_robot(conversion)}'")
    if not found.is_ours:
        who += f" of plugin '{found.plugin}'"
        return _failed("plugin-failed", who, found.file, conversion, error, _DEBUG)
    strangers = [f"'{ran.name}' ({ran.plugin})" for ran in before if not ran.is_ours]
    hint = "this is a mistake in urdf2mbs: please report it with the robot; --debug shows more"
    if strangers:
        hint = f"a plugin's pass may have caused it before: {', '.join(strangers)}"
    return _failed("internal", who, found.file, conversion, error, hint)


def hook_failed(
    hook: str, plugin: str, file: str, pass_name: str, conversion: Conversion, error: BaseException
) -> ConversionError:
    """The error for an exception that came out of a plugin's hook around a pass."""
    when = "before" if "before" in hook else "after"
    what = f"pass '{pass_name}'" if pass_name else "the source is read"
    who = f"hook '{hook}' of plugin '{plugin}', called {when} {what},"
    return _failed("plugin-failed", who, file, conversion, error, _DEBUG)


def called_plugin_failed(
    plugin: str, file: str, caller: str, conversion: Conversion, error: BaseException
) -> ConversionError:
    """Return the error for an exception of a plugin that a pass of ours has called by a hook."""
    who = f"plugin '{plugin}', called by pass '{caller}',"
    return _failed("plugin-failed", who, file, conversion, error, _DEBUG)


def protected_state(conversion: Conversion) -> str:
    """The fields that a plugin must not change, as text that can be compared."""
    c, found = conversion, conversion.checked
    return repr((c.settings, found.proof, found.rejected, found.changed, hash(found.proven)))


def check_protected(conversion: Conversion, before: str, who: str, plugin: str, file: str) -> None:
    """Raise ConversionError if a plugin's pass or hook has changed a protected field, or the file
    that was checked."""
    who = f"{who} of plugin '{plugin}'"
    if protected_state(conversion) != before:
        raise ConversionError(
            "plugin-verdict",
            f"{who} changes the settings, or the result of 'check'", file=file,
            hint="conversion.settings and conversion.checked are for reading",
        )  # fmt: skip
    found, written = conversion.checked, conversion.written
    if found.proof is not None and conversion.files.get(written) != found.proven:
        raise ConversionError(
            "plugin-output-broken",
            f"{who} changes the file: it is not the '{written.name}' that was checked", file=file,
            hint="put the pass before 'check', which checks its result then",
        )  # fmt: skip


def check_left(found: Registered, conversion: Conversion, known: bool) -> None:
    """Raise ConversionError if a plugin's pass left a robot that is no tree, or files that cannot
    be written; ``known``: there was a robot before."""
    robot = conversion.robot
    code, hint = "plugin-robot-broken", "each link but one is the child of one joint"
    fault = _tree_fault(robot) if known or robot.links else None
    if fault is None:
        code = "plugin-output-broken"
        fault, hint = _output_fault(conversion) or (None, "")
    if fault is not None:
        raise ConversionError(
            code,
            f"pass '{found.kind.name}' of plugin '{found.plugin}' leaves robot '{robot.name}' "
            f"broken: {fault}",
            file=found.file, hint=hint,
        )  # fmt: skip


def _failed(
    code: str, who: str, file: str, conversion: Conversion, error: BaseException, hint: str
) -> ConversionError:
    where, line = [(file, None), *frames_in(file, error.__traceback__)][-1]
    said = f"{who} failed on robot '{_robot(conversion)}': {in_words(error)}"
    return ConversionError(code, said, file=where, line=line, hint=hint)


def _robot(conversion: Conversion) -> str:
    """The robot's name; a plugin may have left no robot."""
    return getattr(conversion.robot, "name", "") or conversion.settings.source.name


def _output_fault(conversion: Conversion) -> tuple[str, str] | None:
    """Return what keeps the files and the report from being written, and what to do."""
    for path, data in conversion.files.items():
        add = "conversion.add_file(name, data) takes a path in the folder of the output, and bytes"
        if not isinstance(path, Path) or not isinstance(data, bytes):
            return f"conversion.files has {path!r}: {type(data).__name__}", add
        if not path.is_absolute() and path != conversion.written:
            return f"conversion.files has '{path}', which is in no folder", add
    try:
        msgspec.json.encode(conversion.report, enc_hook=without_origin)
    except Exception as error:
        hint = "conversion.report must be plain data: numbers, texts, lists, dicts, Structs"
        return f"conversion.report cannot be JSON: {error}", hint
    return None


def _tree_fault(robot: Robot) -> str | None:
    """What keeps the robot from being one tree; None: it is one."""
    for kind, elements in (("link", robot.links), ("joint", robot.joints)):
        for name, element in elements.items():
            if element.name != name:
                return f"robot.{kind}s['{name}'] is a {kind} called '{element.name}'"
    above: dict[str, str] = {}
    for joint in robot.joints.values():
        for name in (joint.parent, joint.child):
            if name not in robot.links:
                return f"joint '{joint.name}' names '{name}', which is no link"
        other = above.setdefault(joint.child, joint.name)
        if other != joint.name:
            return f"link '{joint.child}' is the child of the joints '{other}' and '{joint.name}'"
    roots = [name for name in robot.links if name not in above]
    if len(roots) != 1:
        return f"{len(roots)} links hang on no joint: {some(roots)}"
    if len(robot.depth_first()) != len(robot.joints):
        return "some of its joints form a loop"
    return None
