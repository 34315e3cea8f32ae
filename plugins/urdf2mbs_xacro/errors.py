"""The one error for a failure inside xacro, with its file and line.

xacro's messages have no lines.  The line is that on which the failed expression, argument or file
name is written, if there is only one; else that of the macro that was being expanded.
"""

from __future__ import annotations

import re
from contextlib import suppress
from itertools import pairwise
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
    some,
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
#: The most values of an argument that a hint lists.
_MAX_CHOICES = 20
_PACKAGE_URL = re.compile(r"package:/+([^/\s'\"*]+)")
_DECLARED = re.compile(r"""<xacro:arg\s([^<>]*)""")
_USED = re.compile(r"\$\(arg\s+([^\s()]+)\s*\)")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)


def find_only_line(texts: Iterable[str], names: Sequence[str]) -> tuple[str, int] | None:
    """Return the file and line of the first of the texts that is on one line of a file only."""
    for text in texts:
        for file_name in names:
            lines = written.read_text(file_name).splitlines()
            line_numbers = [
                line_number for line_number, line in enumerate(lines, 1) if text in line
            ]
            if len(line_numbers) == 1:
                return file_name, line_numbers[0]
            if line_numbers:
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
    file_texts = [_COMMENT.sub("", written.read_text(file_name)) for file_name in files]
    declarations = [tag for file_text in file_texts for tag in _DECLARED.findall(file_text)]
    declared_arguments = [
        name_match[1]
        for name_match in map(written.NAME_ATTRIBUTE.search, declarations)
        if name_match
    ]
    used_arguments = [
        used_argument for file_text in file_texts for used_argument in _USED.findall(file_text)
    ]
    missing_arguments = [
        argument for argument in used_arguments if argument not in (*defined, *declared_arguments)
    ]
    options = " ".join(
        f"--arg {argument}:=VALUE" for argument in dict.fromkeys([name, *missing_arguments])
    )
    similar = nearest(name, [argument for argument in declared_arguments if argument != name])
    message = f"the argument '{name}' is not defined"
    if name in declared_arguments:
        message = f"the argument '{name}' is used before its <xacro:arg> gives it a value"
    hint = f"say `{options}`, or `xacro_args: {{{name}: VALUE}}` in a config"
    return ConversionError("xacro-arg", message, hint="; ".join(filter(None, [hint, similar])))


def explain(expander: Expander, error: BaseException) -> ConversionError:
    """Return the one error for an exception inside xacro."""
    causes = _list_causes(error)
    message = _write_on_one_line(error)
    # xacro's message ends with the outermost expression
    _, evaluating, expression = str(error).rpartition(EVALUATING)
    expression = expression.partition("\n")[0].rstrip("'") if evaluating else ""
    texts = [f"${{{expression}}}", expression] if expression else []
    cause = _find_cause(causes, ConversionError) or find_missing_package(
        f"{message} {causes[-1]}", expander
    )
    if isinstance(cause, ConfigError):
        return ConfigError(cause.code, cause.message, hint=cause.hint)
    if isinstance(cause, ConversionError):
        quoted_words = _find_words(cause.message)
        expressions = texts if cause.code.startswith("xacro-") else []
        texts = [
            *(f"$(arg {quoted_word})" for quoted_word in quoted_words),
            *expressions,
            *quoted_words,
        ]
        located = ConversionError(cause.code, cause.message, hint=cause.hint)
        return _locate(expander, located, texts)
    syntax_error = _find_cause(causes, ExpatError)
    if syntax_error is not None:
        return _explain_syntax(expander, syntax_error)
    exhausted_error = _explain_exhausted(causes)
    if exhausted_error is not None:
        return _locate(expander, exhausted_error, [])
    unread_error = _find_cause(causes, OSError)
    if unread_error is not None and unread_error.filename:
        located, texts = _explain_unread(expander, unread_error)
        return _locate(expander, located, texts)
    attribute_error = _explain_attribute(expander, message)
    if attribute_error is not None:
        return attribute_error
    legacy_error = _find_legacy(expander.list_files())
    if legacy_error is not None:
        return legacy_error
    hint = "give its value before, by <xacro:property> or --arg"
    is_undefined = _find_cause(causes, NameError) is not None
    located = ConversionError("xacro", message, hint=hint if is_undefined else None)
    return _locate(expander, located, texts or _find_words(message))


def _locate(expander: Expander, error: ConversionError, texts: Sequence[str]) -> ConversionError:
    """Return an error with the file and line of the first of the texts, or of the macro.

    Without either, the file is the one being processed.  The message names the macro.
    """
    xacro = expander.xacro
    error.file = absolute_path((xacro.filestack or [expander.file])[-1])
    macro_stack = list(reversed(xacro.macrostack or []))
    defining_files = [absolute_path(file) for file in map(_find_file, macro_stack) if file]
    searched_files = list(dict.fromkeys([*defining_files, *expander.list_files()]))
    declaration = find_only_line([text for text in texts if len(text) <= _MAX_WORD], searched_files)
    if macro_stack and macro_stack[0].body is not None:
        macro_name = macro_stack[0].body.getAttribute("name")
        error.message += f", in the macro '{macro_name}'"
        if declaration is None:
            declaration = written.find_declaration("xacro:macro", macro_name, defining_files[:1])
    if declaration is not None:
        error.file, error.line = declaration
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


def _explain_exhausted(causes: Sequence[BaseException]) -> ConversionError | None:
    """Return the error if memory or the stack of calls was exhausted."""
    if _find_cause(causes, MemoryError) is not None:
        hint = "look for macros that call themselves, and for long texts or lists in ${...}"
        message = "xacro takes more memory than there is"
        return ConversionError("memory-full", message, hint=hint)
    if _find_cause(causes, RecursionError) is not None:
        message = "macros, includes or properties that call themselves without an end"
        return ConversionError("xacro", message)
    return None


def _explain_unread(expander: Expander, error: OSError) -> tuple[ConversionError, list[str]]:
    """Return the error for a file that cannot be read, and texts that are in its line."""
    file_name = str(error.filename)
    texts = [Path(file_name).name]
    reason, hint = error.strerror, "correct the name of the file, or put the file there"
    package_url = _PACKAGE_URL.search(file_name)
    if package_url is not None:
        path_in_package = file_name[package_url.end() :]
        hint = f"xacro reads no package://: write $(find {package_url[1]}){path_in_package}"
    elif isinstance(error, FileNotFoundError):
        path = Path(absolute_path(file_name))
        missing = _find_missing_part(path)
        argument = _find_argument(expander, missing.name)
        if argument is not None:
            texts.append(f"$(arg {argument})")
            reason, hint = _blame_argument(expander, argument, path, missing)
    return ConversionError("xacro", f"cannot read {file_name}: {reason}", hint=hint), texts


def _find_missing_part(path: Path) -> Path:
    """Return the first folder of a path that does not exist, or the file itself."""
    parts = [path, *path.parents]
    return next(part for part, parent in pairwise(parts) if files.is_folder(parent))


def _find_argument(expander: Expander, file_name: str) -> str | None:
    """Return the argument whose value is a name of a file, or the longest word in it."""
    values = {
        name: value
        for name, value in expander.args.items()
        if value and re.search(rf"(?<![^\W_]){re.escape(value)}(?![^\W_])", file_name)
    }
    return max(values, key=lambda name: len(values[name])) if values else None


def _blame_argument(
    expander: Expander, argument: str, path: Path, missing: Path
) -> tuple[str, str]:
    """Return why a file does not exist, and what to do.

    Args:
        expander: The expansion that failed.
        argument: The argument whose value is in the name of the missing part.
        path: The file.
        missing: The first of its folders that does not exist, or the file.
    """
    value = expander.args[argument]
    reason = f"'{value}' is the value of the argument '{argument}'"
    if argument not in expander.args.given:
        reason = f"'{value}' is the default of the argument '{argument}'"
        declaration = written.find_declaration("xacro:arg", argument, expander.list_files())
        if declaration is not None:
            reason += f" ({declaration[0]}:{declaration[1]})"
    hint = f"say `--arg {argument}:=VALUE`, or `xacro_args: {{{argument}: VALUE}}` in a config"
    choices = _list_values(value, path, missing)
    if choices:
        hint += f"; the values there are: {some(choices, _MAX_CHOICES)}"
    return f"{reason}, and '{missing.name}' does not exist", hint


def _list_values(value: str, path: Path, missing: Path) -> list[str]:
    """Return the values of an argument for which a file exists.

    Args:
        value: The value for which it does not.
        path: The file.
        missing: The first of its folders that does not exist, or the file; its name has the value.
    """
    before, _, after = missing.name.partition(value)
    # a value that is the name of a file has an ending, as the others have
    ending = missing.suffix if missing == path and not after else ""
    name = re.compile(rf"{re.escape(before)}(.+{re.escape(ending)}){re.escape(after)}")
    rest = path.relative_to(missing)
    with suppress(OSError):
        entries = sorted(missing.parent.iterdir())
        matches = [(name.fullmatch(entry.name), entry) for entry in entries]
        return [match[1] for match, entry in matches if match and (entry / rest).exists()]
    return []


def _explain_attribute(expander: Expander, message: str) -> ConversionError | None:
    """Return the error for an element of xacro that lacks an attribute; None for another error."""
    match = re.search(r"(xacro:\w+): missing attribute '([^']+)'", message)
    if match is None:
        return None
    tag, attribute = match.groups()
    has_attribute = re.compile(rf"""(?<!\S){re.escape(attribute)}\s*=""")
    for file in expander.list_files():
        text = written.read_text(file)
        for element in re.finditer(rf"<{tag}(?=[\s/>])[^<>]*", _COMMENT.sub(_blank, text)):
            if has_attribute.search(element[0]):
                continue
            name = written.NAME_ATTRIBUTE.search(element[0])
            owner = f"<{tag}> '{name[1]}'" if name else f"<{tag}>"
            error_message = f"{owner} has no attribute '{attribute}', which xacro requires"
            line = text.count("\n", 0, element.start()) + 1
            hint = f'write {attribute}="..."'
            if name and tag == "xacro:arg":
                hint += f", the value without --arg {name[1]}:=VALUE"
            return ConversionError("xacro", error_message, file=file, line=line, hint=hint)
    return None


def _blank(comment: re.Match[str]) -> str:
    """Return blanks in place of a comment, with its line ends."""
    return re.sub(r"[^\n]", " ", comment[0])


def find_missing_package(text: str, expander: Expander) -> ConversionError | None:
    """Return the error of a missing package, if a message names a file of the package."""
    package_url = _PACKAGE_URL.search(text)
    return expander.missing_packages.get(package_url[1]) if package_url else None


def _find_file(macro: Any) -> str | None:
    """Return the file that defines a macro."""
    return macro.history[-1][-1] if macro.history and macro.history[-1] else None


def _write_on_one_line(error: BaseException) -> str:
    """Return the message of an exception on one line, with its kind where that says more."""
    message = " ".join(str(error).split())
    type_name = type(error).__name__
    return (
        message
        if type_name.endswith("Exception") and message
        else f"{type_name}: {message}".rstrip(": ")
    )


def _list_causes(error: BaseException) -> list[BaseException]:
    """Return an exception and all those that it was raised from or wraps."""
    causes: list[BaseException] = []
    unvisited: list[BaseException | None] = [error]
    while unvisited:
        cause = unvisited.pop()
        if cause is not None and all(cause is not visited for visited in causes):
            causes.append(cause)
            unvisited += [cause.__context__, cause.__cause__, getattr(cause, "exc", None)]
    return causes


def _find_cause(causes: Sequence[BaseException], error_type: type[Exception]) -> Any:
    """Return the first exception of a kind, if any."""
    return next((cause for cause in causes if isinstance(cause, error_type)), None)


def _find_words(message: str) -> list[str]:
    """Return the words that a message of xacro's has in quotes, or names at its end."""
    pattern = r"'([^']+)'|\"([^\"]+)\"|(xacro:[\w.]+)$|(?<![\w.-])([\w.-]+)$"
    quoted_words = [group for match in re.findall(pattern, message) for group in match if group]
    return quoted_words[:_MAX_WORDS]


def _find_legacy(file_names: Sequence[str]) -> ConversionError | None:
    """Return an error for the first element in the form that xacro has not read since 2014."""
    from lxml import etree

    for file_name in file_names:
        xml_root: Any = None
        with suppress(etree.XMLSyntaxError, ValueError):
            xml_bytes = written.read_text(file_name).encode()
            xml_root = etree.fromstring(xml_bytes, safe_parser(recover=True))
        child = None if xml_root is None else next(xml_root.iterchildren(*LEGACY), None)
        if child is not None:
            message = f"<{child.tag}> without the prefix xacro: is not read by xacro any more"
            hint = LEGACY_HINT.format(tag=child.tag)
            return ConversionError(
                "xacro-legacy", message, file=file_name, line=child.sourceline, hint=hint
            )
    return None
