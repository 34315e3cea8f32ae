"""The one error for a failure inside xacro, with its file and line.

xacro's messages have no lines.  The line is that on which the failed expression, argument or file
name is written, if there is only one; else that of the macro that was being expanded.
"""

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
    absolute_path,
    files,
    nearest,
    safe_parser,
    written,
    xml,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from urdf2mbs_xacro.xacro import Expander

#: xacro's message of a failed expression ends with this, and the expression.
EVALUATING = "when evaluating expression '"
#: A message that quotes more words, or longer ones, is not searched for all of them.
_MAX_WORDS, _MAX_WORD = 20, 1000
_PACKAGE_URL = re.compile(r"package:/+([^/\s'\"*]+)")
_DECLARED = re.compile(r"""<xacro:arg\s([^<>]*)""")
_USED = re.compile(r"\$\(arg\s+([^\s()]+)\s*\)")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)


def find_only_line(texts: Iterable[str], names: Sequence[str]) -> tuple[str, int] | None:
    """Return the file and line of the first of the texts that is on one line of a file only."""
    for text in texts:
        for name in names:
            lines = written.read_text(name).splitlines()
            numbers = [number for number, line in enumerate(lines, 1) if text in line]
            if len(numbers) == 1:
                return name, numbers[0]
            if numbers:
                break
    return None


def undefined_argument(name: str, defined: Sequence[str], files: Sequence[str]) -> ConversionError:
    """Return the error for ``$(arg NAME)`` without a value.

    An argument that a file declares by ``<xacro:arg>`` has a default, but only from there on.

    Args:
        name: The argument.
        defined: The arguments that have a value.
        files: The robot's files; the hint names all arguments in them that have no value.
    """
    texts = [_COMMENT.sub("", written.read_text(file)) for file in files]
    tags = [tag for text in texts for tag in _DECLARED.findall(text)]
    declared = [match[1] for match in map(written.NAME_ATTRIBUTE.search, tags) if match]
    used = [used for text in texts for used in _USED.findall(text)]
    missing = [argument for argument in used if argument not in (*defined, *declared)]
    options = " ".join(f"--arg {argument}:=VALUE" for argument in dict.fromkeys([name, *missing]))
    similar = nearest(name, [argument for argument in declared if argument != name])
    message = f"the argument '{name}' is not defined"
    if name in declared:
        message = f"the argument '{name}' is used before its <xacro:arg> gives it a value"
    hint = f"say `{options}`, or `xacro_args: {{{name}: VALUE}}` in a config"
    return ConversionError("xacro-arg", message, hint="; ".join(filter(None, [hint, similar])))


def explain(expander: Expander, error: BaseException) -> ConversionError:
    """Return the one error for an exception inside xacro."""
    chain = _list_causes(error)
    message = _write_on_one_line(error)
    # xacro's message ends with the outermost expression
    _, evaluating, expression = str(error).rpartition(EVALUATING)
    expression = expression.partition("\n")[0].rstrip("'") if evaluating else ""
    texts = [f"${{{expression}}}", expression] if expression else []
    cause = _find(chain, ConversionError) or find_missing_package(
        f"{message} {chain[-1]}", expander
    )
    if isinstance(cause, ConfigError):
        return ConfigError(cause.code, cause.message, hint=cause.hint)
    if isinstance(cause, ConversionError):
        words = _find_words(cause.message)
        expressions = texts if cause.code.startswith("xacro-") else []
        texts = [*(f"$(arg {word})" for word in words), *expressions, *words]
        located = ConversionError(cause.code, cause.message, hint=cause.hint)
        return _locate(expander, located, texts)
    syntax_error = _find(chain, ExpatError)
    if syntax_error is not None:
        return _explain_syntax(expander, syntax_error)
    exhausted = _explain_exhausted(chain)
    if exhausted is not None:
        return _locate(expander, exhausted, [])
    unread = _find(chain, OSError)
    if unread is not None and unread.filename:
        return _locate(expander, _explain_unread(unread), [Path(unread.filename).name])
    legacy = _find_legacy(expander.list_files())
    if legacy is not None:
        return legacy
    hint = "give its value before, by <xacro:property> or --arg"
    undefined = _find(chain, NameError) is not None
    located = ConversionError("xacro", message, hint=hint if undefined else None)
    return _locate(expander, located, texts or _find_words(message))


def _locate(expander: Expander, error: ConversionError, texts: Sequence[str]) -> ConversionError:
    """Return an error with the file and line of the first of the texts, or of the macro.

    Without either, the file is the one being processed.  The message names the macro.
    """
    xacro = expander.xacro
    error.file = absolute_path((xacro.filestack or [expander.file])[-1])
    macros = list(reversed(xacro.macrostack or []))
    defining = [absolute_path(file) for file in map(_find_file, macros) if file]
    searched = list(dict.fromkeys([*defining, *expander.list_files()]))
    place = find_only_line([text for text in texts if len(text) <= _MAX_WORD], searched)
    if macros and macros[0].body is not None:
        name = macros[0].body.getAttribute("name")
        error.message += f", in the macro '{name}'"
        if place is None:
            place = written.find_declaration("xacro:macro", name, defining[:1])
    if place is not None:
        error.file, error.line = place
    return error


def _explain_syntax(expander: Expander, error: ExpatError) -> ConversionError:
    """Return the error for a file that is not XML."""
    file = absolute_path((expander.xacro.filestack or [expander.file])[-1])
    message, hint = "not well-formed XML: it cannot be read here", None
    if "unbound prefix" in str(error):
        message = "the prefix xacro: is not declared"
        hint = 'declare xmlns:xacro="http://www.ros.org/wiki/xacro" on the root element'
    else:
        try:
            xml.parse(files.read_bytes(Path(file)), file)
        except ConversionError as explained:
            explained.file = file
            return explained
    return ConversionError("xacro", message, file=file, line=error.lineno, hint=hint)


def _explain_exhausted(chain: Sequence[BaseException]) -> ConversionError | None:
    """Return the error if memory or the stack of calls was exhausted."""
    if _find(chain, MemoryError) is not None:
        hint = "look for macros that call themselves, and for long texts or lists in ${...}"
        message = "xacro takes more memory than there is"
        return ConversionError("memory-full", message, hint=hint)
    if _find(chain, RecursionError) is not None:
        message = "macros, includes or properties that call themselves without an end"
        return ConversionError("xacro", message)
    return None


def _explain_unread(error: OSError) -> ConversionError:
    """Return the error for a file that cannot be read."""
    hint = "correct the name of the file, or put the file there"
    url = _PACKAGE_URL.search(error.filename)
    if url is not None:
        rest = error.filename[url.end() :]
        hint = f"xacro reads no package://: write $(find {url[1]}){rest}"
    message = f"cannot read {error.filename}: {error.strerror}"
    return ConversionError("xacro", message, hint=hint)


def find_missing_package(text: str, expander: Expander) -> ConversionError | None:
    """Return the error of a missing package, if a message names a file of the package."""
    url = _PACKAGE_URL.search(text)
    return expander.missing_packages.get(url[1]) if url else None


def _find_file(macro: Any) -> str | None:
    """Return the file that defines a macro."""
    return macro.history[-1][-1] if macro.history and macro.history[-1] else None


def _write_on_one_line(error: BaseException) -> str:
    """Return the message of an exception on one line, with its kind where that says more."""
    text = " ".join(str(error).split())
    kind = type(error).__name__
    return text if kind.endswith("Exception") and text else f"{kind}: {text}".rstrip(": ")


def _list_causes(error: BaseException) -> list[BaseException]:
    """Return an exception and all those that it was raised from or wraps."""
    chain: list[BaseException] = []
    unvisited: list[BaseException | None] = [error]
    while unvisited:
        cause = unvisited.pop()
        if cause is not None and all(cause is not visited for visited in chain):
            chain.append(cause)
            unvisited += [cause.__context__, cause.__cause__, getattr(cause, "exc", None)]
    return chain


def _find(chain: Sequence[BaseException], kind: type[Exception]) -> Any:
    """Return the first exception of a kind, if any."""
    return next((cause for cause in chain if isinstance(cause, kind)), None)


def _find_words(message: str) -> list[str]:
    """Return the words that a message of xacro's has in quotes, or names at its end."""
    pattern = r"'([^']+)'|\"([^\"]+)\"|(xacro:[\w.]+)$|(?<![\w.-])([\w.-]+)$"
    words = [group for match in re.findall(pattern, message) for group in match if group]
    return words[:_MAX_WORDS]


def _find_legacy(names: Sequence[str]) -> ConversionError | None:
    """Return an error for the first element in the form that xacro has not read since 2014."""
    from lxml import etree

    for name in names:
        root: Any = None
        with suppress(etree.XMLSyntaxError, ValueError):
            text = written.read_text(name).encode()
            root = etree.fromstring(text, safe_parser(recover=True))
        child = None if root is None else next(root.iterchildren(*LEGACY), None)
        if child is not None:
            message = f"<{child.tag}> without the prefix xacro: is not read by xacro any more"
            hint = LEGACY_HINT.format(tag=child.tag)
            return ConversionError(
                "xacro-legacy", message, file=name, line=child.sourceline, hint=hint
            )
    return None
