"""xacro without ROS: a copy of the ``xacro`` package's module for each run, with parts of our own.

xacro keeps its state in its module.  The copy is nobody else's, so nothing is put back.
"""

from __future__ import annotations

import io
import os
import re
import threading
import warnings
from functools import partial
from glob import glob
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple
from xml.parsers.expat import ExpatError

from urdf2mbs import xml_lines
from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic, nearest
from urdf2mbs.files import note
from urdf2mbs.files import read as read_file
from urdf2mbs.urdf import standard_input, written, xml
from urdf2mbs.urdf.elements import LEGACY, LEGACY_HINT
from urdf2mbs.urdf.expressions import MOST, TRUST, Guard, too_large
from urdf2mbs.urdf.packages import absolute, workspace

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from urdf2mbs.urdf.packages import Packages

_UNKNOWN_MACRO = "unknown macro name: "

# Python catches its warnings for all threads at once
_lock = threading.Lock()
_EVALUATING = "when evaluating expression '"
_XACRO_ARG = re.compile(r"""xacro\.arg\(\s*['"]([^'"]+)['"]\s*\)""")
#: What xacro's own pattern of a macro's parameter means; that takes a time that doubles with each
#: letter before a quote that is not closed.
_PARAMETER = re.compile(
    r"""^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?"""
    r"""(\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])+|)(?:\s+|$)(.*)"""
)
#: Longer stacks of includes and macros are cut in the middle.
_SHOWN = 8

#: Something that xacro says: level, text and the file being processed.
_Said = tuple[Literal["warning", "note"], str, "str | None"]

#: Stands in for an argument that is not given, while we look for the others that are not.
_ANY = "0"
#: What ``$(find NAME)`` gives for a package that was not found.
_NOWHERE = "package://"
_NOWHERE_IN = re.compile(r"package:/+([^/\s'\"*]+)")


class Expansion(NamedTuple):
    """What xacro made of a file."""

    text: bytes
    """What the ``xacro`` command prints, in UTF-8."""
    files: list[str]
    """All that was read, the source first."""
    warnings: list[Diagnostic]


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

    def __init__(self, file: str, packages: Packages, args: Mapping[str, str], trust: bool) -> None:
        self.file = file
        self.packages = packages
        self.trust = trust
        self.args = _Args(args)
        self.said: list[_Said] = []
        self.slips: dict[tuple[str, xml.Slip], None] = {}
        self.macros: dict[tuple[str, str], None] = {}
        """Macros that are called and not defined, and the file that calls each."""
        self.packages_missing: dict[str, ConversionError] = {}
        self.text = b""
        self.read: list[str] = []
        self.guard = Guard()
        self.xacro = _copy("xacro")

    def __call__(self) -> None:
        xacro = self.xacro
        self._replace()
        with _lock, warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
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

    def _replace(self) -> None:
        """Give our copy of xacro its parts of our own."""
        xacro = self.xacro
        self.plain_parse, self.plain_call = xacro.parse, xacro.handle_macro_call
        self.plain_text, self.plain_parameter = xacro.eval_text, xacro.parse_macro_arg
        self.plain_replace = xacro.replace_node
        xacro.substitution_args_context = {}
        xacro.parse = self.parse
        xacro.open = self.open
        xacro.load_yaml = self.load_yaml
        xacro.glob = SimpleNamespace(glob=self.glob)
        xacro.handle_macro_call = self.handle_macro_call
        xacro.eval_text = self.eval_text
        xacro.replace_node = self.replace_node
        xacro.re_macro_arg = _PARAMETER
        xacro.parse_macro_arg = self.parse_macro_arg
        functions: dict[str, Any] = {
            "message": partial(self.say, "note"),
            "warning": partial(self.say, "warning"),
            "error": partial(self.say, "warning"),
            "print_location": lambda *_, **__: "",
        }
        xacro._global_symbols = xacro.create_global_symbols()
        vars(xacro).update(functions)
        xacro._global_symbols["xacro"].update(functions)
        substitution = _copy("xacro.substitution_args")
        substitution._eval_find = substitution._eval_dict["find"] = self.find

        def extension(text: str) -> Any:
            filename = absolute(xacro.filestack[-1])
            if text == "$(cwd)":
                return str(Path.cwd())
            return substitution.resolve_args(text, {"arg": self.args, "filename": filename})

        xacro.eval_extension = extension
        if not self.trust:
            substitution._eval = partial(self.evaluate, substitution)
            xacro.safe_eval = self.guard.evaluate
            self.guard.offer(xacro._global_symbols)

    def spend(self, work: int) -> None:
        if not self.trust:
            self.guard.spend_beside(work)

    def evaluate(self, substitution: Any, text: str, context: Mapping[str, Any]) -> str:
        """``$(eval ...)`` by the rules of ``${...}``."""

        class Names(dict[str, Any]):
            def __missing__(self, name: str) -> Any:
                return substitution.convert_value(context["arg"][name], "auto")

        names = Names(substitution._eval_dict["__builtins__"])
        names.update(
            (name, value)
            for name, value in substitution._eval_dict.items()
            if not name.startswith("_")
        )
        names["arg"] = lambda name: names.__missing__(name)
        names["dirname"] = lambda: str(Path(context["filename"]).parent)
        self.guard.offer(names)
        try:
            return str(self.guard.evaluate(text, names))
        except Exception as error:
            raise self.xacro.XacroException(exc=error, suffix=f"\n{_EVALUATING}{text}'") from error

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
        self.said.append((level, text, where))
        return ""

    def eval_text(self, text: Any, symbols: Any) -> Any:
        # most texts are only themselves; to find that out, xacro takes a fifth of its time
        if not isinstance(text, str) or "$" not in text:
            return text
        # xacro copies what is left of a text for each expression in it
        self.spend(10 + len(text) * text.count("$") // 1000)
        result = self.plain_text(text, symbols)
        if isinstance(result, str) and len(result) > MOST and not self.trust:
            raise too_large(f"a text of over {MOST:,} letters")
        return result

    def parse_macro_arg(self, text: str) -> Any:
        self.spend(1 + len(text) // 50)  # xacro copies what is left for each parameter
        return self.plain_parameter(text)

    def parse(self, _: Any, name: str) -> Any:
        import xml.dom.minidom as minidom

        given = standard_input.taken(Path(name))
        try:
            return self.plain_parse(None if given is None else io.BytesIO(given), name)
        except ConversionError:
            self.xacro.filestack.pop()  # the file that includes it is to be named
            raise
        except (ExpatError, UnicodeError):
            data, slips = xml.mend(read_file(Path(name)) if given is None else given)
            document = minidom.parseString(data)
            self.slips.update(((absolute(name), slip), None) for slip in slips)
            return document

    def handle_macro_call(self, node: Any, macros: Any, symbols: Any) -> Any:
        self.spend(300 if node.tagName.startswith("xacro:") else 50)
        xacro = self.xacro
        depth = len(xacro.macrostack or ())
        try:
            return self.plain_call(node, macros, symbols)
        except xacro.XacroException as error:
            if len(xacro.macrostack or ()) != depth or not str(error).startswith(_UNKNOWN_MACRO):
                raise
            self.macros[node.tagName.partition(":")[2], absolute(xacro.filestack[-1])] = None
            xacro.remove_previous_comments(node)
            xacro.replace_node(node, by=None)
            return True

    def replace_node(self, node: Any, by: Any, content_only: bool = False) -> None:
        # minidom looks for the node among all its neighbours, once for each that takes its place
        nodes = by if isinstance(by, list) else [by] if by is not None else []
        moved = 1 + sum(len(part.childNodes) if content_only else 1 for part in nodes)
        self.spend(moved * len(node.parentNode.childNodes) // 100)
        self.plain_replace(node, by, content_only)

    def open(self, name: str) -> io.BytesIO:
        """A file's bytes: what is included is read up to a bound, as all else is."""
        self.check_file(name)
        data = read_file(Path(name))
        # minidom goes through all neighbours to take a comment away
        self.spend(len(data) // 4 + data.count(b"<!--") ** 2 // 200)
        return io.BytesIO(data)

    def glob(self, pattern: str) -> list[str]:
        """The files that match a pattern."""
        fixed, _, rest = pattern.partition(re.findall(r"[*?[]", pattern)[0])
        self.check_file(str(Path(fixed + "x").parent) if ".." not in rest else "/")
        note(pattern)
        return glob(pattern)  # noqa: PTH207 just what xacro calls

    def load_yaml(self, name: str) -> Any:
        import yaml

        xacro = self.xacro

        class Loader(yaml.SafeLoader):
            """xacro's own adds its tags to the loader that all programs share."""

            def flatten_mapping(loader, node: Any) -> None:  # noqa: N805
                for key, merged in node.value:
                    if key.tag == "tag:yaml.org,2002:merge":  # <<, which may double what << made
                        several = isinstance(merged, yaml.SequenceNode)
                        for part in merged.value if several else [merged]:
                            if isinstance(part, yaml.MappingNode):
                                loader.flatten_mapping(part)
                                self.spend(300 * len(part.value))
                super().flatten_mapping(node)

        for unit in xacro.ConstructUnits:
            Loader.add_constructor(unit.value.tag, unit.constructor)
        file = xacro.abs_filename_spec(name)
        data = self.open(file).getvalue()
        self.spend(10 * len(data))
        xacro.filestack.append(file)
        try:
            return xacro.YamlListWrapper.wrap(yaml.load(data, Loader))
        finally:
            xacro.filestack.pop()
            xacro.all_includes.append(file)

    def check_file(self, name: str) -> None:
        """Raise ConversionError for a file outside of what the robot may read."""
        file = Path(os.path.realpath(name))
        given = {os.path.realpath(value) for value in self.args.given.values()}
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

    def diagnostics(self) -> list[Diagnostic]:
        diagnostics = [
            Diagnostic("warning", slip.code, slip.message, file=file, line=slip.line)
            for file, slip in self.slips
        ]
        for name, caller in self.macros:
            where = written.locate([f"xacro:{name}"], [caller])
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


def _copy(name: str) -> Any:
    """A module of xacro's that nobody else has."""
    spec = find_spec(name)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def expand(
    source: Path, packages: Packages, args: Mapping[str, str], *, trust: bool = False
) -> Expansion:
    """Run xacro on a file; ``args`` are those of ``NAME:=VALUE``.

    Without ``trust`` its expressions are data, and it reads no files outside of its workspace and
    packages.

    A macro that is not defined is left out, which is an error among the diagnostics.

    :raises ConversionError: ``xacro``, ``xacro-arg``, ``xacro-legacy``, ``package-not-found``,
        ``xacro-expression``, ``xacro-too-large``, ``xacro-file``
    """
    run = _Run(absolute(source), packages, args, trust)
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
    return Expansion(run.text, files, diagnostics)


class UndefinedArgumentError(ConversionError):
    """``xacro-arg``: a value that nobody has given."""

    name = ""


def _list_undefined(error: UndefinedArgumentError, first: _Run) -> None:
    """Make an error name all arguments that are not defined, as far as they can be found."""
    missing = [error.name]
    while len(missing) < 50:
        given = {**first.args.given, **dict.fromkeys(missing, _ANY)}
        try:
            _Run(first.file, first.packages, given, first.trust)()
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
    # the last one is where it was asked for
    _, evaluated, expression = str(error).rpartition(_EVALUATING)
    expression = expression.partition("\n")[0].rstrip("'") if evaluated else ""
    undefined = _undefined_arg(chain, expression)
    deep = next((one for one in chain if isinstance(one, RecursionError)), None)
    unread = next((one for one in chain if isinstance(one, OSError)), None)
    syntax = next((one for one in chain if isinstance(one, ExpatError)), None)
    if ours is not None:
        code, text, hint = ours.code, ours.message, ours.hint
        looked_for = _quoted(text)[:1]
        if expression and code.startswith("xacro-"):
            looked_for = [f"${{{expression}}}", expression, *looked_for]
    elif undefined is not None:
        code = "xacro-arg"
        text = f"the argument '{undefined}' is not defined"
        declared = written.arguments(read)
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
        looked_for = [f"${{{expression}}}", expression] if expression else _quoted(text)
    macro_files = [
        macro.history[-1][-1]
        for macro in reversed(xacro.macrostack or [])
        if macro.history and macro.history[-1]
    ]
    if line is None:
        places = dict.fromkeys([*map(absolute, filter(None, macro_files[:1])), *read])
        file, line = written.locate(looked_for, list(places)) or (file, None)
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
    file = written.macro(macro, dict.fromkeys([packages.source.parent, *packages.table.values()]))
    if file is None:
        return None
    return f'{file} defines it: <xacro:include filename="..."/> of this file is missing'


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


def _declares(names: Iterable[str]) -> str:
    shown = ", ".join(names)
    return f"the arguments declared are: {shown}" if shown else "no file declares an argument"


def _quoted(text: str) -> list[str]:
    """What a message of xacro's puts in quotes or names as a macro or a file."""
    return [
        part
        for part in re.findall(
            r"'([^']+)'|\"([^\"]+)\"|(xacro:[\w.]+)$|(?<![\w.-])([\w.-]+)$", text
        )
        for part in part
        if part
    ]


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
            root = xml_lines.parse(written.text(file).encode(), parser)
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
