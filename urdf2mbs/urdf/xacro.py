"""xacro without ROS: the ``xacro`` package, its packages found by us, its globals put back."""

from __future__ import annotations

import io
import os
import re
import threading
import warnings
from contextlib import contextmanager
from functools import partial
from glob import glob
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple
from xml.parsers.expat import ExpatError

from urdf2mbs import xml_lines
from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic, nearest
from urdf2mbs.files import note
from urdf2mbs.files import read as read_file
from urdf2mbs.urdf import standard_input, xml
from urdf2mbs.urdf.elements import LEGACY, LEGACY_HINT
from urdf2mbs.urdf.packages import absolute

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from urdf2mbs.urdf.packages import Packages

_UNKNOWN_MACRO = "unknown macro name: "

# xacro keeps its state in module globals: one run at a time.
_lock = threading.RLock()
_EXPRESSION = re.compile(r"when evaluating expression '(.*)'$", re.MULTILINE)
_XACRO_ARG = re.compile(r"""xacro\.arg\(\s*['"]([^'"]+)['"]\s*\)""")
_DECLARED = re.compile(r"""<xacro:arg\s[^>]*?\bname\s*=\s*["']([^"']+)["']""")
#: Longer stacks of includes and macros are cut in the middle.
_SHOWN = 8

#: Something that xacro says: level, text and the file being processed.
_Said = tuple[Literal["warning", "note"], str, "str | None"]

#: Stands in for an argument that is not given, while we look for the others that are not.
_ANY = "0"
#: What ``$(find NAME)`` gives for a package that was not found.
_NOWHERE = "package://"
_NOWHERE_IN = re.compile(r"package:/+([^/\s'\"*]+)")
#: So many files, in so many folders, at most are searched for a macro's definition.
_SEARCHED = 500


class Asked(NamedTuple):
    """All that an expansion depends on, beside its arguments."""

    files: list[str]
    """Those that were read or looked for."""
    packages: dict[str, str]
    """The folder of each."""
    environment: dict[str, str | None]
    """The variables; None: not set."""


class Expansion(NamedTuple):
    """What xacro made of a file, and what that depends on."""

    text: bytes
    """What the ``xacro`` command prints, in UTF-8."""
    files: list[str]
    """All that was read, the source first."""
    warnings: list[Diagnostic]
    asked: Asked | None = None
    """None: it depends on more, such as which files match a pattern."""


class _Environment(dict[str, str]):
    """The environment's variables, which notes those that the robot asks for."""

    def __init__(self) -> None:
        super().__init__(os.environ)
        self.asked: dict[str, str | None] = {}

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = self.get(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked[name] = self.get(name)
        return super().__getitem__(name)


class _Context(dict[str, Any]):
    """Substitution arguments; ``filename``, for ``$(dirname)``, is the file being processed."""

    def __init__(self, module: Any, args: _Args) -> None:
        super().__init__(arg=args)
        self.module = module

    def __getitem__(self, key: str) -> Any:
        if key == "filename":
            return absolute(self.module.filestack[-1])
        return super().__getitem__(key)

    def get(self, key: str, default: Any = None) -> Any:
        return self[key] if key == "filename" or key in self else default


class _Args(dict[str, str]):
    """The arguments, which notes the names that the robot asks for.

    xacro looks with ``in`` only where a file declares an argument.
    """

    def __init__(self, args: Mapping[str, str]) -> None:
        super().__init__({name: str(value) for name, value in args.items()})
        self.given = dict(self)
        self.asked: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked[name] = None
        return super().__getitem__(name)


class _Run:
    """One run of xacro on one file: what it says, and what it does not find."""

    def __init__(self, file: str, packages: Packages, args: Mapping[str, str]) -> None:
        self.file = file
        self.packages = packages
        self.args = _Args(args)
        self.said: list[_Said] = []
        self.slips: dict[tuple[str, xml.Slip], None] = {}
        self.macros: dict[tuple[str, str], None] = {}
        """Macros that are called and not defined, and the file that calls each."""
        self.packages_missing: dict[str, ConversionError] = {}
        self.packages_found: dict[str, str] = {}
        self.environment = _Environment()
        self.patterns = False
        """Whether files are included by a pattern."""
        self.text = b""
        self.read: list[str] = []

    def __call__(self) -> None:
        import xacro

        with _lock, _borrowed(xacro, self):
            try:
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    document = xacro.process_file(self.file, mappings=self.args, verbosity=1)
                    self.text = document.toprettyxml(indent="  ").encode()
            except Exception as error:
                failure = _explain(xacro, error, self)
                failure.said = self.diagnostics()
                raise failure from error
            self.read = [absolute(name) for name in (self.file, *xacro.all_includes)]
        self.said += [
            ("warning", f"{one.category.__name__}: {one.message}", None) for one in caught
        ]

    def diagnostics(self) -> list[Diagnostic]:
        diagnostics = [
            Diagnostic("warning", slip.code, slip.message, file=file, line=slip.line)
            for file, slip in self.slips
        ]
        for name, caller in self.macros:
            where = _locate([f"xacro:{name}"], [caller])
            diagnostics.append(
                Diagnostic(
                    "error",
                    "xacro-macro-unknown",
                    f"the macro '{name}' is not defined: the <xacro:include> of the file that "
                    "defines it is missing",
                    file=caller,
                    line=where and where[1],
                    hint=_defined_in(name, self.packages)
                    or f"no .xacro file around defines it; --level {_LOWERED} leaves it out",
                )
            )
        diagnostics += [
            Diagnostic(
                "warning",
                "package-unresolved",
                f"package '{name}' was not found; file names that begin with $(find {name}) lead "
                "nowhere",
                file=self.file,
                hint=failure.hint,
            )
            for name, failure in self.packages_missing.items()
        ]
        diagnostics += [
            Diagnostic(
                level,
                "xacro-warning" if level == "warning" else "xacro-message",
                message,
                file=where or self.file,
            )
            for level, message, where in dict.fromkeys(self.said)
        ]
        return diagnostics


_LOWERED = "xacro-macro-unknown=warning"


def expand(source: Path, packages: Packages, args: Mapping[str, str]) -> Expansion:
    """Run xacro on a file; ``args`` are those of ``NAME:=VALUE``.

    A macro that is not defined is left out, which is an error among the diagnostics.

    :raises ConversionError: ``xacro``, ``xacro-arg``, ``xacro-legacy``, ``package-not-found``
    """
    run = _Run(absolute(source), packages, args)
    undefined = None
    try:
        run()
    except UndefinedArgumentError as error:
        undefined = error
    if undefined is not None:
        # outside the handler, else each new error would have the first one as its context
        _list_undefined(undefined, run)
        raise undefined
    diagnostics = run.diagnostics()
    asked = run.args.asked
    for name in args:
        if name not in asked:
            known = [other for other in asked if other not in args]
            diagnostics.append(
                Diagnostic(
                    "warning",
                    "xacro-unused-arg",
                    f"the argument '{name}' has no effect: no file declares or uses it",
                    file=run.file,
                    hint=nearest(name, known) or _declares(asked),
                )
            )
    files = [name for name in dict.fromkeys(run.read) if Path(name).is_file()]
    depends = Asked(list(dict.fromkeys(run.read)), run.packages_found, run.environment.asked)
    whole = not (run.patterns or run.packages_missing or run.macros)
    return Expansion(run.text, files, diagnostics, depends if whole else None)


class UndefinedArgumentError(ConversionError):
    """``xacro-arg``: a value that nobody has given."""

    name = ""


def _list_undefined(error: UndefinedArgumentError, first: _Run) -> None:
    """Make an error name all arguments that are not defined, as far as they can be found."""
    missing = [error.name]
    while len(missing) < 50:
        given = {**first.args.given, **dict.fromkeys(missing, _ANY)}
        try:
            _Run(first.file, first.packages, given)()
        except UndefinedArgumentError as other:
            if other.name in missing:
                break
            missing.append(other.name)
        except ConversionError:
            break  # the stand-in may be no good value here
        else:
            break
    if len(missing) > 1:
        listed = ", ".join(f"'{name}'" for name in missing)
        _, stack, rest = error.message.partition("\n")
        error.message = f"the arguments {listed} are not defined{stack}{rest}"
        words = " ".join(f"--arg {name}:=VALUE" for name in missing)
        keys = ", ".join(f"{name}: VALUE" for name in missing)
        error.hint = f"give each a value: `xacro_args: {{{keys}}}` or `{words}`"


@contextmanager
def _borrowed(xacro: Any, run: _Run) -> Iterator[None]:
    """xacro's globals fresh, its ``find``, its messages and its reading of files ours; all put
    back at the end."""
    import xml.dom.minidom as minidom

    from xacro import substitution_args as substitution

    def find(package: str) -> str:
        try:
            found = run.packages_found[package] = str(run.packages.find(package))
            return found
        except ConfigError:
            raise
        except ConversionError as error:
            # no error yet: the path may never be used
            run.packages_missing[package] = error
            return f"{_NOWHERE}{package}"

    def say(level: Literal["warning", "note"], *message: Any, **_: Any) -> str:
        where = xacro.filestack[-1] if xacro.filestack else None
        text = " ".join(str(part) for part in message)
        missing = _missing_package(text, run)
        if missing is not None:  # an include by a pattern, which matches nothing
            raise missing
        run.said.append((level, text, where))
        return ""

    plain_parse, plain_call = xacro.parse, xacro.handle_macro_call
    plain_eval = xacro.eval_text

    def eval_text(text: Any, symbols: Any) -> Any:
        # most texts are only themselves; to find that out, xacro takes a fifth of its time
        return text if isinstance(text, str) and "$" not in text else plain_eval(text, symbols)

    def parse(inp: Any, filename: str | None = None) -> Any:
        given = standard_input.taken(Path(filename)) if filename else None
        if inp is None and given is not None:
            inp = io.BytesIO(given)
        try:
            return plain_parse(inp, filename)
        except (ExpatError, UnicodeError):
            if inp is not None or filename is None:
                raise
            data, slips = xml.mend(read_file(Path(xacro.root_dir, filename)))
            document = minidom.parseString(data)
            run.slips.update(((absolute(filename), slip), None) for slip in slips)
            return document

    def handle_macro_call(node: Any, macros: Any, symbols: Any) -> Any:
        depth = len(xacro.macrostack or ())
        try:
            return plain_call(node, macros, symbols)
        except xacro.XacroException as error:
            if len(xacro.macrostack or ()) != depth or not str(error).startswith(_UNKNOWN_MACRO):
                raise
            run.macros[node.tagName.partition(":")[2], absolute(xacro.filestack[-1])] = None
            xacro.remove_previous_comments(node)
            xacro.replace_node(node, by=None)
            return True

    def bounded(name: str) -> io.BytesIO:
        """A file's bytes: what is included is read up to a bound, as all else is."""
        return io.BytesIO(read_file(Path(name)))

    def matching(pattern: str) -> list[str]:
        run.patterns = True
        note(pattern)
        return glob(pattern)  # noqa: PTH207 just what xacro calls

    functions: dict[str, Any] = {
        "message": partial(say, "note"),
        "warning": partial(say, "warning"),
        "error": partial(say, "warning"),
        "print_location": lambda *_, **__: "",
    }
    fresh: dict[str, Any] = {
        "filestack": None,
        "macrostack": None,
        "all_includes": [],
        "substitution_args_context": _Context(xacro, run.args),
        "parse": parse,
        "open": bounded,
        "handle_macro_call": handle_macro_call,
        "eval_text": eval_text,
        "verbosity": 1,
        "root_dir": os.curdir,
        "glob": SimpleNamespace(glob=matching),
        "_empty_text_node": minidom.Document().createTextNode("\n\n"),
        **functions,
    }
    borrowed: list[tuple[dict[str, Any], dict[str, Any]]] = [
        (vars(xacro), fresh),
        (
            vars(substitution),
            {"_eval_find": find, "os": SimpleNamespace(environ=run.environment, path=os.path)},
        ),
        (substitution._eval_dict, {"find": find}),
        (xacro._global_symbols["xacro"], functions),
    ]
    kept = [
        (owner, {key: dict.__getitem__(owner, key) for key in new if dict.__contains__(owner, key)})
        for owner, new in borrowed
    ]
    try:
        for owner, new in borrowed:
            dict.update(owner, new)
        yield
    finally:
        for (owner, new), (_, old) in zip(borrowed, kept, strict=True):
            for key in new:
                dict.__delitem__(owner, key)
            dict.update(owner, old)


def _explain(xacro: Any, error: Exception, run: _Run) -> ConversionError:
    """The one error to show for anything that went wrong inside xacro."""
    source = run.file
    chain = _chain(error)
    files = [absolute(name) for name in xacro.filestack or [source]]
    read = list(dict.fromkeys([*files, *map(absolute, xacro.all_includes), source]))
    text = _sentence(error)
    file, line = files[-1], None
    code, hint = "xacro", None

    ours = next((one for one in chain if isinstance(one, ConversionError)), None)
    if ours is None:
        ours = _missing_package(f"{text} {chain[-1]}", run)
    expression = _EXPRESSION.search(str(error))
    undefined = _undefined_arg(chain, expression[1] if expression else "")
    deep = next((one for one in chain if isinstance(one, RecursionError)), None)
    unread = next((one for one in chain if isinstance(one, OSError)), None)
    syntax = next((one for one in chain if isinstance(one, ExpatError)), None)
    if ours is not None:
        code, text, hint = ours.code, ours.message, ours.hint
        looked_for = _quoted(text)[:1]
    elif undefined is not None:
        code = "xacro-arg"
        text = f"the argument '{undefined}' is not defined"
        declared = _declared(read)
        close = nearest(undefined, declared)
        hint = (
            f"give it a value: `xacro_args: {{{undefined}: VALUE}}` or "
            f"`--arg {undefined}:=VALUE`; {close + ' ' if close else ''}{_declares(declared)}"
        )
        looked_for = [f"$(arg {undefined})", f"'{undefined}'"]
    elif syntax is not None:
        try:
            xml.explain_text(read_file(Path(file)), file)
            text, line = "not well-formed XML: it cannot be read here", syntax.lineno
        except ConversionError as explained:
            code, text, line = explained.code, explained.message, explained.line
            hint = explained.hint
        except OSError:
            text, line = "not well-formed XML", syntax.lineno
        looked_for = []
        if "unbound prefix" in str(syntax):
            text = "the prefix xacro: is not declared"
            hint = 'declare xmlns:xacro="http://www.ros.org/wiki/xacro" on the root element'
    elif any(isinstance(one, MemoryError) for one in chain):
        code, text = "memory-full", "xacro takes more memory than there is"
        hint = "look for macros that call themselves, and for long texts or lists in expressions"
        looked_for = []
    elif deep is not None:
        text = "macros, includes or properties that call themselves without an end"
        looked_for = []
    elif unread is not None and unread.filename:
        text = f"cannot read {unread.filename}: {unread.strerror}"
        looked_for = [Path(unread.filename).name]
    else:
        legacy = _legacy(read)
        if legacy is not None:
            return legacy
        looked_for = [f"${{{expression[1]}}}", expression[1]] if expression else _quoted(text)
    macro_files = [
        macro.history[-1][-1]
        for macro in reversed(xacro.macrostack or [])
        if macro.history and macro.history[-1]
    ]
    if line is None:
        places = dict.fromkeys([*map(absolute, filter(None, macro_files[:1])), *read])
        file, line = _locate(looked_for, list(places)) or (file, None)
    kind = ConversionError if undefined is None else UndefinedArgumentError
    exception = kind(code, text + _stack(xacro, files, file), file=file, line=line, hint=hint)
    if isinstance(exception, UndefinedArgumentError):
        exception.name = undefined or ""
    if ours is not None and ours.exit_code != exception.exit_code:
        exception = ConfigError(code, ours.message, hint=ours.hint)
    return exception


def _missing_package(text: str, run: _Run) -> ConversionError | None:
    """The error of a package that was not found, if a message names a file in it."""
    named = _NOWHERE_IN.search(text)
    return run.packages_missing.get(named[1]) if named else None


def _defined_in(macro: str, packages: Packages) -> str | None:
    """A hint that names the .xacro file, around the source or in the packages, of a macro."""
    wanted = re.compile(rf"""<xacro:macro\s[^>]*\bname\s*=\s*["']{re.escape(macro)}["']""")
    folders = dict.fromkeys([packages.source.parent, *packages.table.values()])
    files = (file for folder in folders for file in _below(folder))
    for file in islice(files, _SEARCHED):
        if wanted.search(_text(file)):
            return f'{file} defines it: <xacro:include filename="..."/> of this file is missing'
    return None


def written_in(kind: str, name: str, files: Sequence[str]) -> str | None:
    """A hint that names the file and line of a link, say, where only one place has it."""
    begin = re.compile(rf"""<{kind}\s(?:[^<>]*\s)?name\s*=\s*["']{re.escape(name)}["']""")
    texts = ((file, _text(file)) for file in files if name)
    places = [
        f"{file}:{text.count(chr(10), 0, found.start()) + 1}"
        for file, text in texts
        for found in begin.finditer(text)
    ]
    return f"{kind} '{name}' is in {places[0]}" if len(places) == 1 else None


def _below(folder: Path) -> Iterator[str]:
    """The .xacro files in a folder and, as far as it is not too large, below it."""
    for above, folders, names in islice(os.walk(folder), _SEARCHED):
        folders.sort()
        yield from (str(Path(above, name)) for name in sorted(names) if name.endswith(".xacro"))


def _sentence(error: BaseException) -> str:
    """An exception's message on one line.  xacro's own exceptions repeat the one they wrap."""
    wrapped = getattr(error, "exc", None)
    if wrapped is not None and error.args and str(error.args[0]).startswith("<class "):
        return _sentence(wrapped)
    text = " ".join(str(error).split())
    kind = type(error).__name__
    return text if kind.endswith("Exception") and text else f"{kind}: {text}".rstrip(": ")


def _chain(error: BaseException) -> list[BaseException]:
    """An exception and all those it was raised from or wraps."""
    chain: list[BaseException] = []
    todo: list[BaseException | None] = [error]
    while todo:
        one = todo.pop()
        if one is not None and all(one is not other for other in chain):
            chain.append(one)
            todo += [one.__context__, one.__cause__, getattr(one, "exc", None)]
    return chain


def _undefined_arg(chain: list[BaseException], expression: str) -> str | None:
    for one in chain:
        if type(one).__name__ == "ArgException":
            return str(one)
    called = _XACRO_ARG.search(expression)
    if called and any(isinstance(one, KeyError) and one.args == (called[1],) for one in chain):
        return called[1]
    return None


def _text(file: str) -> str:
    try:
        return read_file(Path(file)).decode("utf-8", "replace")
    except (OSError, ValueError):
        return ""


def _declared(files: list[str]) -> list[str]:
    return list(dict.fromkeys(name for file in files for name in _DECLARED.findall(_text(file))))


def _declares(names: Iterable[str]) -> str:
    shown = ", ".join(names)
    return f"the arguments declared are: {shown}" if shown else "no file declares an argument"


def _quoted(text: str) -> list[str]:
    """What a message of xacro's puts in quotes or names as a macro or a file."""
    return [
        part
        for part in re.findall(r"'([^']+)'|\"([^\"]+)\"|(xacro:[\w.]+)$|([\w.-]+)$", text)
        for part in part
        if part
    ]


def _locate(texts: list[str], files: list[str]) -> tuple[str, int] | None:
    """The file and line of a text, if only one line has it: xacro gives no line numbers."""
    for text in texts:
        for file in files:
            lines = [
                number for number, line in enumerate(_text(file).splitlines(), 1) if text in line
            ]
            if len(lines) == 1:
                return file, lines[0]
            if lines:
                break
    return None


def _stack(xacro: Any, files: list[str], shown: str) -> str:
    """The macros, then the includes, that led to the error, innermost first."""
    lines = []
    says = "in the macro"
    for macro in reversed(xacro.macrostack or []):
        name = macro.body.getAttribute("name") if macro.body is not None else "?"
        where = macro.history[-1][-1] if macro.history and macro.history[-1] else "?"
        lines.append(f"{says} '{name}' of {where}")
        says = "called by the macro"
    says = "in the file"
    for file in reversed(files):
        if not (len(files) == 1 and file == shown):
            lines.append(f"{says} {file}")
        says = "included from"
    if len(lines) > _SHOWN:
        half = _SHOWN // 2
        lines[half:-half] = [f"... {len(lines) - 2 * half} more ..."]
    return "".join(f"\n  {line}" for line in lines)


def _legacy(files: list[str]) -> ConversionError | None:
    """An error for the first element in the form that xacro has not read since 2014."""
    from lxml import etree

    parser = etree.XMLParser(recover=True, resolve_entities=False, no_network=True)
    for file in files:
        try:
            root = xml_lines.parse(_text(file).encode(), parser)
        except (etree.XMLSyntaxError, ValueError):
            continue
        children: Any = () if root is None else root.iterchildren(*LEGACY)
        for child in children:
            return ConversionError(
                "xacro-legacy",
                f"<{child.tag}> without the prefix xacro: is not read by xacro any more",
                file=file,
                line=child.sourceline,
                hint=LEGACY_HINT.format(tag=child.tag),
            )
    return None
