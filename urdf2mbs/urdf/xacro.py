"""xacro without ROS: a copy of the ``xacro`` package's module for each run, with parts of our own.

xacro keeps its state in its module.  The copy is nobody else's, so nothing is put back.
"""

from __future__ import annotations

import io
import os
import re
import threading
import warnings
from contextlib import suppress
from functools import partial
from glob import glob
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple
from xml.parsers.expat import ExpatError

from urdf2mbs.disk import standard_input
from urdf2mbs.disk.files import read as read_file
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, Diagnostic, nearest
from urdf2mbs.urdf import written, xml
from urdf2mbs.urdf.elements import LEGACY, LEGACY_HINT
from urdf2mbs.urdf.expressions import MOST, TRUST, Guard, tokenize, too_large
from urdf2mbs.urdf.packages import absolute, workspace
from urdf2mbs.xml.parser import safe_parser

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from urdf2mbs.urdf.packages import Packages

_UNKNOWN_MACRO = "unknown macro name: "

# Python catches its warnings for all threads at once
_lock = threading.Lock()
_EVALUATING = "when evaluating expression '"
#: A macro's parameter.  xacro's own pattern of the same meaning takes twice the time for each more
#: letter before a quote that is not closed.
_PARAMETER = re.compile(
    r"""^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?"""
    r"""(\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])+|)(?:\s+|$)(.*)"""
)
#: A message shows so many lines at each end of a stack of includes and macros.
_STACK_ENDS = 4
#: The functions of xacro that ``_Run`` replaces by its own.
_REPLACED = (
    "parse", "open", "load_yaml", "handle_macro_call", "eval_text", "replace_node",
    "parse_macro_arg",
)  # fmt: skip

#: ``$(find NAME)`` gives this and the name if the package was not found.
_NOWHERE = "package://"
_NOWHERE_IN = re.compile(r"package:/+([^/\s'\"*]+)")


class Expansion(NamedTuple):
    """What xacro made of a file."""

    text: bytes
    """The output of the ``xacro`` command, in UTF-8."""
    files: list[str]
    """All files that were read, the source first."""
    warnings: list[Diagnostic]


class _Args(dict[str, str]):
    """The arguments.  They note each name that the robot asks for.

    xacro asks with ``in`` only for an argument that a file declares.
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


class _Names(dict[str, Any]):
    """The names of ``$(eval ...)``: ``found`` says what each is, but for those that are offered."""

    def __init__(self, found: Mapping[str, Any], offered: Mapping[str, Any]) -> None:
        super().__init__(offered)
        self.found = found

    def __missing__(self, name: str) -> Any:
        return self.found[name]


class _Run:
    """One run of xacro on one file: its messages, and the things that it does not find."""

    def __init__(self, file: str, packages: Packages, args: Mapping[str, str], trust: bool) -> None:
        self.file = file
        self.packages = packages
        self.trust = trust
        self.args = _Args(args)
        self.messages: dict[tuple[Literal["warning", "note"], str, str | None], None] = {}
        """Level, text, and the file that was being processed."""
        self.slips: dict[tuple[str, xml.Slip], None] = {}
        self.macros: dict[tuple[str, str], None] = {}
        """Macros that are called and not defined, and the file that calls each."""
        self.packages_missing: dict[str, ConversionError] = {}
        self.guard = Guard()
        self.xacro = _copy("xacro")
        self.plain = SimpleNamespace(**vars(self.xacro))
        self._replace()

    def run(self) -> Expansion:
        """Expand the file; raises ConversionError."""
        with _lock, warnings.catch_warnings(record=True) as python_warnings:
            warnings.simplefilter("always")
            try:
                document = self.xacro.process_file(self.file, mappings=self.args)
                text = document.toprettyxml(indent="  ").encode()
            except Exception as error:
                failure = self.explain(error)
                failure.said = self.diagnostics()
                raise failure from error
        for warning in python_warnings:
            name = warning.category.__name__
            self.messages["warning", f"{name}: {warning.message}", None] = None
        names = dict.fromkeys(map(absolute, (self.file, *self.xacro.all_includes)))
        files = [name for name in names if Path(name).is_file()]
        return Expansion(text, files, [*self.diagnostics(), *self.warn_of_unused()])

    def _replace(self) -> None:
        """Give our copy of xacro its parts of our own."""
        xacro = self.xacro
        vars(xacro).update({name: getattr(self, name) for name in _REPLACED})
        xacro.substitution_args_context = {}
        xacro.glob = SimpleNamespace(glob=self.glob)
        xacro.re_macro_arg = _PARAMETER
        functions: dict[str, Any] = {
            "message": partial(self.say, "note"),
            "warning": partial(self.say, "warning"),
            "error": partial(self.say, "warning"),
            "print_location": lambda *_, **__: "",
        }
        substitution = _copy("xacro.substitution_args")
        substitution._eval_find = substitution._eval_dict["find"] = self.find
        substitution._eval_arg = self.argument
        if not self.trust:
            xacro.tokenize = tokenize
            xacro.safe_eval = self.guard.evaluate
            offered = substitution._eval_dict["__builtins__"]
            substitution.eval = lambda text, _, names: self.guard.evaluate(
                text, _Names(names, offered)
            )
        xacro._global_symbols = xacro.create_global_symbols()
        vars(xacro).update(functions)
        xacro._global_symbols["xacro"].update(functions, arg=self.argument)

        def extension(text: str) -> Any:
            if text == "$(cwd)":
                return str(Path.cwd())
            context = {"arg": self.args, "filename": absolute(xacro.filestack[-1])}
            try:
                return substitution.resolve_args(text, context)
            except Exception as error:
                raise xacro.XacroException(exc=error, suffix=f"\n{_EVALUATING}{text}'") from error

        xacro.eval_extension = extension

    def spend(self, work: int) -> None:
        if not self.trust:
            self.guard.spend(work)

    def argument(self, name: str, args: Any = None) -> str:
        """The value of ``$(arg NAME)``."""
        try:
            return self.args[name]
        except KeyError:
            declared = written.arguments(self.files())
            close = nearest(name, declared)
            raise ConversionError(
                "xacro-arg", f"the argument '{name}' is not defined",
                hint=f"give it a value: `xacro_args: {{{name}: VALUE}}` or `--arg {name}:=VALUE`; "
                f"{close + ' ' if close else ''}{_declares(declared)}",
            ) from None  # fmt: skip

    def find(self, package: str) -> str:
        try:
            return str(self.packages.find(package))
        except ConfigError:
            raise
        except ConversionError as error:
            # no error yet: the path may never be used
            self.packages_missing[package] = error
            return f"{_NOWHERE}{package}"

    def say(self, level: Literal["warning", "note"], *message: Any, **_: Any) -> str:
        where = self.xacro.filestack[-1] if self.xacro.filestack else None
        text = " ".join(str(part) for part in message)
        missing = _missing_package(text, self)
        if missing is not None:  # an include by a pattern, which matches nothing
            raise missing
        self.messages[level, text, where] = None
        return ""

    def eval_text(self, text: Any, symbols: Any) -> Any:
        # most texts have no expression; xacro takes a fifth of its time to find this out
        if not isinstance(text, str) or "$" not in text:
            return text
        # xacro copies the rest of a text for each expression in it
        self.spend(10 + len(text) * text.count("$") // 1000)
        result = self.plain.eval_text(text, symbols)
        if isinstance(result, str) and len(result) > MOST and not self.trust:
            raise too_large(f"a text of over {MOST:,} letters")
        return result

    def parse_macro_arg(self, text: str) -> Any:
        self.spend(len(text) // 50)  # xacro copies the rest for each parameter
        return self.plain.parse_macro_arg(text)

    def parse(self, _: Any, name: str) -> Any:
        import xml.dom.minidom as minidom

        file = Path(name)
        try:
            given = standard_input.stands_for(file)
            return self.plain.parse(io.BytesIO(standard_input.read(file)) if given else None, name)
        except ConversionError:
            self.xacro.filestack.pop()  # the error names the file that includes this file
            raise
        except (ExpatError, UnicodeError):
            data, slips = xml.mend(standard_input.read(file))
            document = minidom.parseString(data)
            self.slips.update(((absolute(name), slip), None) for slip in slips)
            return document

    def handle_macro_call(self, node: Any, macros: Any, symbols: Any) -> Any:
        self.spend(300 if node.tagName.startswith("xacro:") else 50)
        xacro = self.xacro
        depth = len(xacro.macrostack or ())
        try:
            return self.plain.handle_macro_call(node, macros, symbols)
        except xacro.XacroException as error:
            if len(xacro.macrostack or ()) != depth or not str(error).startswith(_UNKNOWN_MACRO):
                raise
            self.macros[node.tagName.partition(":")[2], absolute(xacro.filestack[-1])] = None
            xacro.replace_node(node, by=None)
            return True

    def replace_node(self, node: Any, by: Any, content_only: bool = False) -> None:
        # minidom looks for the node among all its neighbours, once for each new node
        nodes = by if isinstance(by, list) else [by] if by is not None else []
        moved = 1 + sum(len(part.childNodes) if content_only else 1 for part in nodes)
        self.spend(moved * len(node.parentNode.childNodes) // 100)
        self.plain.replace_node(node, by, content_only)

    def open(self, name: str) -> io.BytesIO:
        """An included file's bytes, up to the bound for all files."""
        self.check_file(name)
        data = read_file(Path(name))
        # minidom goes through all neighbours of a comment to remove it
        self.spend(len(data) // 4 + data.count(b"<!--") ** 2 // 100)
        return io.BytesIO(data)

    def glob(self, pattern: str) -> list[str]:
        """The files that match a pattern."""
        fixed, _, rest = pattern.partition(re.findall(r"[*?[]", pattern)[0])
        self.check_file(str(Path(fixed + "x").parent) if ".." not in rest else "/")
        return glob(pattern)  # noqa: PTH207 just what xacro calls

    def load_yaml(self, name: str) -> Any:
        import yaml

        class Loader(yaml.SafeLoader):
            """A loader of this run's own: xacro adds its tags to the loader of the process."""

        xacro = self.xacro
        for unit in xacro.ConstructUnits:
            Loader.add_constructor(unit.value.tag, unit.constructor)
        file = xacro.abs_filename_spec(name)
        data = self.open(file).getvalue()
        self.spend(10 * len(data))
        loader = Loader(data)
        xacro.filestack.append(file)
        try:
            node = loader.get_single_node()
            if not self.trust and node is not None and _count_nodes(node, {}) > MOST:
                raise too_large(f"a YAML file of over {MOST:,} items")
            value = None if node is None else loader.construct_document(node)
            return xacro.YamlListWrapper.wrap(value)
        finally:
            xacro.filestack.pop()
            xacro.all_includes.append(file)

    def check_file(self, name: str) -> None:
        """Raise ConversionError for a file outside of what the robot may read."""
        file = Path(os.path.realpath(name))
        given = set(map(os.path.realpath, self.args.given.values()))
        if self.trust or str(file) in given or not file.exists():
            return
        source = Path(os.path.realpath(self.file))
        roots = [self.packages.root, workspace(source)]
        for folder in self.packages.found().values():
            # of a workspace with links, the files are where its package.xml leads
            described = Path(os.path.realpath(folder / "package.xml"))
            roots += [folder, described.parent if described.name == "package.xml" else folder]
        for root in map(os.path.realpath, roots):
            inside = file.relative_to(root).parts if file.is_relative_to(root) else (".",)
            if not any(part.startswith(".") for part in inside):
                return
        raise ConversionError(
            "xacro-file",
            f"'{Path(name).name}' is not read: {name} is outside the workspace "
            f"{self.packages.root} and the packages that were found",
            hint=f"add its folder to the config: `packages: {{NAME: {file.parent}}}`; or, {TRUST}",
        )

    def files(self) -> list[str]:
        """The files being processed, the innermost first, then all others that were read."""
        read = (*reversed(self.xacro.filestack or ()), *self.xacro.all_includes, self.file)
        return list(dict.fromkeys(map(absolute, read)))

    def fault(
        self, code: str, text: str, signs: Sequence[str], hint: str | None, line: int | None = None
    ) -> ConversionError:
        """An error, with the macros and includes that led to it.

        Its line is the ``line`` of the file being processed, or where one of the ``signs`` stands.
        """
        xacro = self.xacro
        files = [absolute(name) for name in xacro.filestack or [self.file]]
        macros = [(macro, _find_file(macro)) for macro in reversed(xacro.macrostack or [])]
        file = files[-1]
        if line is None:
            defining = [absolute(where) for _, where in macros if where]
            places = list(dict.fromkeys([*defining, *self.files()]))
            found = written.locate(signs, places)
            if not found and macros and macros[0][1]:
                name = macros[0][0].body.getAttribute("name")
                found = written.place("xacro:macro", name, [absolute(macros[0][1])])
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

    def explain(self, error: Exception) -> ConversionError:
        """The one error for an exception inside xacro."""
        chain = _chain(error)

        def find(kind: type[Exception]) -> Any:
            return next((cause for cause in chain if isinstance(cause, kind)), None)

        text = _sentence(error)
        # the message ends with the outermost expression
        _, evaluated, expression = str(error).rpartition(_EVALUATING)
        expression = expression.partition("\n")[0].rstrip("'") if evaluated else ""
        signs = [f"${{{expression}}}", expression] if expression else []
        ours = find(ConversionError) or _missing_package(f"{text} {chain[-1]}", self)
        if isinstance(ours, ConfigError):
            return ConfigError(ours.code, ours.message, hint=ours.hint)
        if ours is not None:
            words = _find_words(ours.message)
            calls = [f"$(arg {word})" for word in words]
            signs = [*calls, *(signs if ours.code.startswith("xacro-") else ()), *words]
            return self.fault(ours.code, ours.message, signs, ours.hint)
        if (syntax := find(ExpatError)) is not None:
            return self.explain_syntax(syntax)
        if find(MemoryError) is not None:
            hint = "look for macros that call themselves, and for long texts or lists in ${...}"
            return self.fault("memory-full", "xacro takes more memory than there is", [], hint)
        if find(RecursionError) is not None:
            text = "macros, includes or properties that call themselves without an end"
            return self.fault("xacro", text, [], None)
        unread = find(OSError)
        if unread is not None and unread.filename:
            text = f"cannot read {unread.filename}: {unread.strerror}"
            return self.fault("xacro", text, [Path(unread.filename).name], None)
        return _legacy(self.files()) or self.fault("xacro", text, signs or _find_words(text), None)

    def explain_syntax(self, error: ExpatError) -> ConversionError:
        """The error for a file that is no XML."""
        if "unbound prefix" in str(error):
            hint = 'declare xmlns:xacro="http://www.ros.org/wiki/xacro" on the root element'
            return self.fault("xacro", "the prefix xacro: is not declared", [], hint, error.lineno)
        file = absolute((self.xacro.filestack or [self.file])[-1])
        try:
            xml.parse(standard_input.read(Path(file)), file)
        except ConversionError as explained:
            return self.fault(explained.code, explained.message, [], explained.hint, explained.line)
        text = "not well-formed XML: it cannot be read here"
        return self.fault("xacro", text, [], None, error.lineno)

    def warn_of_unused(self) -> list[Diagnostic]:
        """Warnings of arguments that were given for nothing."""
        given, asked = self.args.given, self.args.asked
        known = [name for name in asked if name not in given]
        return [
            Diagnostic(
                "warning", "xacro-unused-arg",
                f"the argument '{name}' has no effect: no file declares or uses it",
                file=self.file, hint=nearest(name, known) or _declares(asked),
            )
            for name in given
            if name not in asked
        ]  # fmt: skip

    def diagnostics(self) -> list[Diagnostic]:
        """All warnings and messages so far, and the macros that are not defined."""
        slips = [
            Diagnostic("warning", slip.code, slip.message, file=file, line=slip.line)
            for file, slip in self.slips
        ]
        macros = [
            Diagnostic(
                "error", "xacro-macro-unknown",
                f"the macro '{name}' is not defined: the <xacro:include> of the file that "
                "defines it is missing",
                file=caller, line=(written.locate([f"xacro:{name}"], [caller]) or ("", None))[1],
                hint="--level xacro-macro-unknown=warning leaves it out",
            )
            for name, caller in self.macros
        ]  # fmt: skip
        missing = [
            Diagnostic(
                "warning", "package-unresolved",
                f"package '{name}' was not found; file names that begin with $(find {name}) lead "
                "nowhere",
                file=self.file, hint=failure.hint,
            )
            for name, failure in self.packages_missing.items()
        ]  # fmt: skip
        said = [
            Diagnostic(
                level, "xacro-warning" if level == "warning" else "xacro-message", text,
                file=file or self.file,
            )
            for level, text, file in self.messages
        ]  # fmt: skip
        return [*slips, *macros, *missing, *said]


def _copy(name: str) -> Any:
    """A new copy of one of xacro's modules."""
    spec: Any = find_spec(name)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _count_nodes(node: Any, counted: dict[int, int]) -> int:
    """The nodes of a YAML text, each as often as an alias or a merge repeats it."""
    if id(node) not in counted:
        counted[id(node)] = MOST  # as often as it repeats itself
        parts = node.value if isinstance(node.value, list) else ()
        pairs = (part if isinstance(part, tuple) else (part,) for part in parts)
        counted[id(node)] = 1 + sum(_count_nodes(part, counted) for pair in pairs for part in pair)
    return counted[id(node)]


def expand(
    source: Path, packages: Packages, args: Mapping[str, str], *, trust: bool = False
) -> Expansion:
    """Run xacro on a file; ``args`` are those of ``NAME:=VALUE``.

    Without ``trust`` its expressions are data, and xacro reads no file outside of the workspace and
    the packages.  A macro that is not defined is left out; the diagnostics have an error for it.

    :raises ConversionError: ``xacro``, ``xacro-arg``, ``package-not-found``,
        ``xacro-expression``, ``xacro-too-large``, ``xacro-file``
    """
    return _Run(absolute(source), packages, args, trust).run()


def _missing_package(text: str, run: _Run) -> ConversionError | None:
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


def _declares(names: Iterable[str]) -> str:
    shown = ", ".join(names)
    return f"the arguments declared are: {shown}" if shown else "no file declares an argument"


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
            root = etree.fromstring(written.text(file).encode(), safe_parser(recover=True))
        child = None if root is None else next(root.iterchildren(*LEGACY), None)
        if child is not None:
            text = f"<{child.tag}> without the prefix xacro: is not read by xacro any more"
            hint, line = LEGACY_HINT.format(tag=child.tag), child.sourceline
            return ConversionError("xacro-legacy", text, file=file, line=line, hint=hint)
    return None
