"""The one error for what goes wrong inside xacro: with its file, its line, and the way there."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.parsers.expat import ExpatError

from urdf2mbs.plugin import (
    LEGACY,
    LEGACY_HINT,
    ConfigError,
    ConversionError,
    files,
    nearest,
    safe_parser,
    written,
    xml,
)
from urdf2mbs.plugin import absolute_path as absolute

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from urdf2mbs_xacro.xacro import Run

EVALUATING = "when evaluating expression '"
#: A message shows so many lines at each end of a stack of includes and macros.
_STACK_ENDS = 4
_NOWHERE_IN = re.compile(r"package:/+([^/\s'\"*]+)")
_DECLARED = re.compile(r"""<xacro:arg\s([^<>]*)""")
_USED = re.compile(r"\$\(arg\s+([^\s()]+)\s*\)")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)


def locate(texts: Iterable[str], names: Sequence[str]) -> tuple[str, int] | None:
    """The file and line of the first of the texts that stands on one line only: xacro's messages
    have no lines."""
    for wanted in texts:
        for file in names:
            lines = written.read_text(file).splitlines()
            found = [number for number, line in enumerate(lines, 1) if wanted in line]
            if len(found) == 1:
                return file, found[0]
            if found:
                break
    return None


def undefined_argument(name: str, known: Sequence[str], files: Sequence[str]) -> ConversionError:
    """The error for ``$(arg NAME)`` without a value; its hint has all such arguments of the files.

    What a file declares by ``<xacro:arg>`` has a default, but only from there on.
    """
    texts = [_COMMENT.sub("", written.read_text(file)) for file in files]
    tags = [tag for text in texts for tag in _DECLARED.findall(text)]
    declared = [found[1] for found in map(written.NAME_ATTRIBUTE.search, tags) if found]
    used = [used for text in texts for used in _USED.findall(text)]
    lacking = dict.fromkeys([name, *(n for n in used if n not in (*known, *declared))])
    options = " ".join(f"--arg {n}:=VALUE" for n in lacking)
    close = nearest(name, [n for n in declared if n != name])
    return ConversionError(
        "xacro-arg",
        f"the argument '{name}' is used before its <xacro:arg> gives it a value"
        if name in declared
        else f"the argument '{name}' is not defined",
        hint=f"say `{options}`, or `xacro_args: {{{name}: VALUE}}` in a config"
        + (f"; {close}" if close else ""),
    )


def _fault(
    run: Run, code: str, text: str, signs: Sequence[str], hint: str | None, line: int | None = None
) -> ConversionError:
    """An error, with the macros and includes that led to it.

    Its line is the ``line`` of the file being processed, or where one of the ``signs`` stands.
    """
    xacro = run.xacro
    files = [absolute(name) for name in xacro.filestack or [run.file]]
    macros = [(macro, _find_file(macro)) for macro in reversed(xacro.macrostack or [])]
    file = files[-1]
    if line is None:
        defining = [absolute(where) for _, where in macros if where]
        places = list(dict.fromkeys([*defining, *run.files()]))
        found = locate(signs, places)
        if not found and macros and macros[0][1]:
            name = macros[0][0].body.getAttribute("name")
            found = written.find_declaration("xacro:macro", name, [absolute(macros[0][1])])
        file, line = found or (file, None)
    stack: list[str] = []
    for macro, where in macros:
        name = macro.body.getAttribute("name") if macro.body is not None else "?"
        says = "called by the macro" if stack else "in the macro"
        stack.append(f"{says} '{name}' of {where or '?'}")
    first, *others = reversed(files)
    if others or first != file:
        stack += [f"in the file {first}", *(f"included from {other}" for other in others)]
    if len(stack) > 2 * _STACK_ENDS:
        stack[_STACK_ENDS:-_STACK_ENDS] = [f"... {len(stack) - 2 * _STACK_ENDS} more ..."]
    return ConversionError(code, "\n  ".join([text, *stack]), file=file, line=line, hint=hint)


def explain(run: Run, error: Exception) -> ConversionError:
    """The one error for an exception inside xacro."""
    chain = _chain(error)

    def find(kind: type[Exception]) -> Any:
        return next((cause for cause in chain if isinstance(cause, kind)), None)

    text = _sentence(error)
    # the message ends with the outermost expression
    _, evaluated, expression = str(error).rpartition(EVALUATING)
    expression = expression.partition("\n")[0].rstrip("'") if evaluated else ""
    signs = [f"${{{expression}}}", expression] if expression else []
    ours = find(ConversionError) or missing_package(f"{text} {chain[-1]}", run)
    if isinstance(ours, ConfigError):
        return ConfigError(ours.code, ours.message, hint=ours.hint)
    if ours is not None:
        words = _find_words(ours.message)
        calls = [f"$(arg {word})" for word in words]
        signs = [*calls, *(signs if ours.code.startswith("xacro-") else ()), *words]
        return _fault(run, ours.code, ours.message, signs, ours.hint)
    if (syntax := find(ExpatError)) is not None:
        return _explain_syntax(run, syntax)
    if find(MemoryError) is not None:
        hint = "look for macros that call themselves, and for long texts or lists in ${...}"
        return _fault(run, "memory-full", "xacro takes more memory than there is", [], hint)
    if find(RecursionError) is not None:
        text = "macros, includes or properties that call themselves without an end"
        return _fault(run, "xacro", text, [], None)
    unread = find(OSError)
    if unread is not None and unread.filename:
        text = f"cannot read {unread.filename}: {unread.strerror}"
        named = _NOWHERE_IN.search(unread.filename)
        hint = "correct the name of the file, or put the file there"
        if named:
            rest = unread.filename[named.end() :]
            hint = f"xacro reads no package://: write $(find {named[1]}){rest}"
        return _fault(run, "xacro", text, [Path(unread.filename).name], hint)
    define = "give its value before, by <xacro:property> or --arg" if find(NameError) else None
    return _legacy(run.files()) or _fault(run, "xacro", text, signs or _find_words(text), define)


def _explain_syntax(run: Run, error: ExpatError) -> ConversionError:
    """The error for a file that is no XML."""
    if "unbound prefix" in str(error):
        hint = 'declare xmlns:xacro="http://www.ros.org/wiki/xacro" on the root element'
        return _fault(run, "xacro", "the prefix xacro: is not declared", [], hint, error.lineno)
    file = absolute((run.xacro.filestack or [run.file])[-1])
    try:
        xml.parse(files.read_bytes(Path(file)), file)
    except ConversionError as explained:
        return _fault(run, explained.code, explained.message, [], explained.hint, explained.line)
    text = "not well-formed XML: it cannot be read here"
    return _fault(run, "xacro", text, [], None, error.lineno)


def missing_package(text: str, run: Run) -> ConversionError | None:
    """The error of a missing package, if a message names a file of the package."""
    named = _NOWHERE_IN.search(text)
    return run.packages_missing.get(named[1]) if named else None


def _find_file(macro: Any) -> str | None:
    """The file of a macro."""
    return macro.history[-1][-1] if macro.history and macro.history[-1] else None


def _sentence(error: BaseException) -> str:
    """An exception's message on one line."""
    text = " ".join(str(error).split())
    kind = type(error).__name__
    return text if kind.endswith("Exception") and text else f"{kind}: {text}".rstrip(": ")


def _chain(error: BaseException) -> list[BaseException]:
    """An exception and all those it was raised from or wraps."""
    chain: list[BaseException] = []
    todo: list[BaseException | None] = [error]
    while todo:
        cause = todo.pop()
        if cause is not None and all(cause is not known for known in chain):
            chain.append(cause)
            todo += [cause.__context__, cause.__cause__, getattr(cause, "exc", None)]
    return chain


def _find_words(text: str) -> list[str]:
    """The words that a message of xacro's puts in quotes, or names at its end."""
    words = r"'([^']+)'|\"([^\"]+)\"|(xacro:[\w.]+)$|(?<![\w.-])([\w.-]+)$"
    return [group for match in re.findall(words, text) for group in match if group]


def _legacy(files: list[str]) -> ConversionError | None:
    """An error for the first element in the form that xacro has not read since 2014."""
    from lxml import etree

    for file in files:
        root: Any = None
        with suppress(etree.XMLSyntaxError, ValueError):
            root = etree.fromstring(written.read_text(file).encode(), safe_parser(recover=True))
        child = None if root is None else next(root.iterchildren(*LEGACY), None)
        if child is not None:
            text = f"<{child.tag}> without the prefix xacro: is not read by xacro any more"
            hint, line = LEGACY_HINT.format(tag=child.tag), child.sourceline
            return ConversionError("xacro-legacy", text, file=file, line=line, hint=hint)
    return None
