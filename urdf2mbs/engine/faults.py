"""One clear message for what goes wrong in a plugin: whose pass, which robot, at which link."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.conversion import Conversion, Segment, Step
from urdf2mbs.diagnostics import ConversionError, memory_full
from urdf2mbs.engine.plugins import GROUP, Registered
from urdf2mbs.mbs import model as mbs
from urdf2mbs.urdf.model import Joint, Link, Robot

if TYPE_CHECKING:
    from types import FrameType, TracebackType


def pass_failed(
    found: Registered, conversion: Conversion, error: BaseException, before: Sequence[Registered]
) -> ConversionError:
    """The error for an exception that came out of a pass; ``before`` are the passes that ran."""
    ours = found.plugin == GROUP
    if isinstance(error, MemoryError):
        robot = getattr(conversion.robot, "name", "") or conversion.settings.source.name
        return memory_full(f"pass '{found.kind.name}' on robot '{robot}'")
    strangers = [f"'{one.kind.name}' ({one.plugin})" for one in before if one.plugin != GROUP]
    if not ours:
        hint = "--debug shows the traceback"
    elif strangers:
        hint = f"it may come of what a plugin's pass did before: {', '.join(strangers)}"
    else:
        hint = "this is a mistake in urdf2mbs: please report it with the robot; --debug shows more"
    whose = "" if ours else f" of plugin '{found.plugin}'"
    return _failed(
        "internal" if ours else "plugin-failed",
        f"pass '{found.kind.name}'{whose}", found.file, conversion, error, hint,
    )  # fmt: skip


def hook_failed(
    hook: str, plugin: str, file: str, pass_name: str, conversion: Conversion, error: BaseException
) -> ConversionError:
    """The error for an exception that came out of a plugin's hook around a pass."""
    when = "before" if "before" in hook else "after"
    what = f"pass '{pass_name}'" if pass_name else "the source is read"
    return _failed(
        "plugin-failed", f"hook '{hook}' of plugin '{plugin}', called {when} {what},",
        file, conversion, error, "--debug shows the traceback",
    )  # fmt: skip


def check_left(found: Registered, conversion: Conversion, known: bool) -> None:
    """Raise ConversionError if a plugin's pass left something that later passes, or the program,
    would stumble over, or lose in silence; ``known``: there was a robot before."""
    robot = conversion.robot
    code, fault = "plugin-robot-broken", None
    if known or robot.links:
        fault = _tree_fault(robot)
    if fault is None:
        code, fault = "plugin-output-broken", _output_fault(conversion)
    if fault is not None:
        raise ConversionError(
            code,
            f"pass '{found.kind.name}' of plugin '{found.plugin}' leaves robot '{robot.name}' "
            f"broken: {fault[0]}",
            file=found.file,
            hint=fault[1],
        )


def _failed(
    code: str, who: str, file: str, conversion: Conversion, error: BaseException, hint: str
) -> ConversionError:
    where, line, at = _at_hand(error.__traceback__, file)
    text = " ".join(str(error).split())
    said = type(error).__name__ + (f": {text}" if text else "")
    robot = getattr(conversion.robot, "name", "") or conversion.settings.source.name
    return ConversionError(
        code, f"{who} failed on robot '{robot}'{at}: {said}", file=where, line=line, hint=hint
    )


def _at_hand(tb: TracebackType | None, file: str) -> tuple[str, int | None, str]:
    """File and line of the innermost frame in a plugin's own code (its file, or its folder if
    that is a package), and what link, joint or body its local variables hold."""
    import traceback

    own = Path(file)
    frames = list(traceback.walk_tb(tb))
    found = [
        (frame, line)
        for frame, line in frames
        if Path(frame.f_code.co_filename) == own
        or (own.name == "__init__.py" and Path(frame.f_code.co_filename).is_relative_to(own.parent))
    ]
    if not found:
        if not frames:
            return file, None, ""
        frame, line = frames[-1]
        return frame.f_code.co_filename, line, ""
    frame, line = found[-1]
    # a helper may have been given a number only: its callers in the file know of which link
    at = next((text for one, where in reversed(found) if (text := _elements(one, where))), "")
    return frame.f_code.co_filename, line, at


def _elements(frame: FrameType, line: int) -> str:
    """ " at link 'a', joint 'b'": of each kind, what the last local variable of it holds."""
    named: dict[str, str] = {}
    stale = _stale(frame.f_code.co_filename, line)
    for variable, value in frame.f_locals.items():
        if variable in stale:
            continue
        if isinstance(value, Link):
            named["link"] = value.name
        elif isinstance(value, Joint):
            named["joint"] = value.name
        elif isinstance(value, Step):
            named["joint"] = value.joint.name
        elif isinstance(value, Segment):
            named["link"] = value.link
        elif isinstance(value, mbs.Body):
            named["body"] = value.name
        elif isinstance(value, mbs.Joint):
            named["mbs joint"] = value.name
    return "".join(
        f"{' at' if index == 0 else ','} {kind} '{name}'"
        for index, (kind, name) in enumerate(named.items())
    )


def _stale(file: str, line: int) -> set[str]:
    """The variables of loops that are over at a line of a function."""
    try:
        function: ast.AST = ast.parse(Path(file).read_text("utf-8"))
    except (OSError, SyntaxError, ValueError):
        return set()
    for node in ast.walk(function):  # outer functions come before inner ones
        if isinstance(node, ast.FunctionDef) and node.lineno <= line <= (node.end_lineno or 0):
            function = node
    running: set[str] = set()
    over: set[str] = set()
    for node in ast.walk(function):
        if isinstance(node, ast.For):
            names = {n.id for n in ast.walk(node.target) if isinstance(n, ast.Name)}
            (running if node.lineno <= line <= (node.end_lineno or 0) else over).update(names)
    return over - running


def _output_fault(conversion: Conversion) -> tuple[str, str] | None:
    made = conversion.rejected or conversion.settings.output
    if conversion.proof is not None and conversion.files.get(made) != conversion.proven:
        return (
            f"it is not the '{made.name}' that was checked",
            "put the pass before 'check', so that what it does is checked, too",
        )
    for path, data in conversion.files.items():
        if not isinstance(path, Path) or not isinstance(data, bytes):
            return (
                f"conversion.files has {path!r}: {type(data).__name__}",
                "it maps a pathlib.Path to bytes: conversion.files[path] = text.encode()",
            )
    try:
        msgspec.json.encode(conversion.report)
    except Exception as error:
        return f"conversion.report cannot be JSON: {error}", "give it plain data"
    return None


def _tree_fault(robot: Robot) -> tuple[str, str] | None:
    """What keeps the robot from being one tree, and what to do; None: it is one."""
    for kind, elements in (("link", robot.links), ("joint", robot.joints)):
        for name, element in elements.items():
            if element.name != name:
                return (
                    f"robot.{kind}s['{name}'] is a {kind} called '{element.name}'",
                    f"the key of a {kind} and its 'name' must be the same",
                )
    above: dict[str, str] = {}
    for joint in robot.joints.values():
        for which, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in robot.links:
                return (
                    f"joint '{joint.name}' has the {which} '{name}', which is no link",
                    "take the joint away with its link, or give it another",
                )
        if joint.child in above:
            return (
                f"link '{joint.child}' is the child of the joints '{above[joint.child]}' and "
                f"'{joint.name}'",
                "a robot is a tree: each link hangs on one joint",
            )
        above[joint.child] = joint.name
    roots = [name for name in robot.links if name not in above]
    if len(roots) != 1:
        return (
            f"{len(roots)} links hang on no joint" + "".join(f", '{name}'" for name in roots[:5]),
            "a robot is a tree: all links but one hang on a joint",
        )
    if len(robot.depth_first()) != len(robot.joints):
        return "some of its joints form a loop", "a robot is a tree: no loops"
    return None
