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
from typing import TYPE_CHECKING, Any, Literal
from xml.parsers.expat import ExpatError

from urdf2mbs.plugin import (
    ConfigError,
    ConversionError,
    Diagnostic,
    Expansion,
    files,
    nearest,
    workspace,
    xml,
)
from urdf2mbs.plugin import absolute_path as absolute
from urdf2mbs.plugin import read_bytes as read_file
from urdf2mbs_xacro.expressions import MOST, TRUST, Guard, tokenize, too_large
from urdf2mbs_xacro.xacro_errors import (
    EVALUATING,
    explain,
    locate,
    missing_package,
    undefined_argument,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from urdf2mbs.plugin import Packages

_UNKNOWN_MACRO = "unknown macro name: "

# Python catches its warnings for all threads at once
_lock = threading.Lock()
#: A macro's parameter.  xacro's own pattern of the same meaning takes twice the time for each more
#: letter before a quote that is not closed.
_PARAMETER = re.compile(
    r"""^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?"""
    r"""(\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])+|)(?:\s+|$)(.*)"""
)
#: The functions of xacro that ``Run`` replaces by its own.
_REPLACED = (
    "parse", "open", "load_yaml", "handle_macro_call", "eval_text", "replace_node",
    "parse_macro_arg",
)  # fmt: skip

#: The most lists of a YAML file in one another: PyYAML's C code calls itself for each.
DEEPEST = 100

#: ``$(find NAME)`` gives this and the name if the package was not found.
_NOWHERE = "package://"


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


class Run:
    """One run of xacro on one file: its messages, and the things that it does not find."""

    def __init__(self, file: str, packages: Packages, args: Mapping[str, str], trust: bool) -> None:
        self.file = file
        self.packages = packages
        self.trust = trust
        self.args = _Args(args)
        self.said: list[Diagnostic] = []
        self.packages_missing: dict[str, ConversionError] = {}
        self.guard = Guard(trust)
        self.spend = self.guard.spend
        self.xacro = _copy("xacro")
        self.plain = SimpleNamespace(**vars(self.xacro))
        self._replace()

    def run(self) -> Expansion:
        """Expand the file; raises ConversionError."""
        with _lock, warnings.catch_warnings(record=True) as python_warnings:
            warnings.simplefilter("always")
            warnings.simplefilter("ignore", ResourceWarning)  # of whatever Python tidies up now
            try:
                document = self.xacro.process_file(self.file, mappings=self.args)
                made = document.toprettyxml(indent="  ").encode()
            except Exception as error:
                failure = explain(self, error)
                failure.earlier = self.said
                raise failure from error
        for warning in python_warnings:
            text = f"{warning.category.__name__}: {warning.message}"
            self.tell(Diagnostic("warning", "xacro-warning", text, file=self.file))
        names = dict.fromkeys(map(absolute, (self.file, *self.xacro.all_includes)))
        files = [name for name in names if Path(name).is_file()]
        return Expansion(made, files, [*self.said, *self.warn_of_unused()])

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
                raise xacro.XacroException(exc=error, suffix=f"\n{EVALUATING}{text}'") from error

        xacro.eval_extension = extension

    def tell(self, diagnostic: Diagnostic) -> None:
        """Add a warning or message, once."""
        if diagnostic not in self.said:
            self.said.append(diagnostic)

    def argument(self, name: str, args: Any = None) -> str:
        """The value of ``$(arg NAME)``."""
        try:
            return self.args[name]
        except KeyError:
            raise undefined_argument(name, [*self.args], self.files()) from None

    def find(self, package: str) -> str:
        try:
            return str(self.packages.find(package))
        except ConfigError:
            raise
        except ConversionError as error:
            # no error yet: the path may never be used
            self.packages_missing[package] = error
            what = (
                f"package '{package}' was not found; file names that begin with "
                f"$(find {package}) lead nowhere"
            )
            self.tell(
                Diagnostic("warning", "package-unresolved", what, file=self.file, hint=error.hint)
            )
            return f"{_NOWHERE}{package}"

    def say(self, level: Literal["warning", "note"], *message: Any, **_: Any) -> str:
        where = self.xacro.filestack[-1] if self.xacro.filestack else None
        text = " ".join(str(part) for part in message)
        missing = missing_package(text, self)
        if missing is not None:  # an include by a pattern, which matches nothing
            raise missing
        code = "xacro-warning" if level == "warning" else "xacro-message"
        self.tell(Diagnostic(level, code, text, file=where or self.file))
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
            given = files.is_stdin(file)
            return self.plain.parse(io.BytesIO(files.read_bytes(file)) if given else None, name)
        except ConversionError:
            self.xacro.filestack.pop()  # the error names the file that includes this file
            raise
        except (ExpatError, UnicodeError):
            data, slips = xml.mend(files.read_bytes(file))
            document = minidom.parseString(data)
            for code, message, line in slips:
                self.tell(Diagnostic("warning", code, message, file=absolute(name), line=line))
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
            caller, name = absolute(xacro.filestack[-1]), node.tagName.partition(":")[2]
            what = (
                f"the macro '{name}' is not defined: the <xacro:include> of the file that "
                "defines it is missing"
            )
            _, line = locate([f"xacro:{name}"], [caller]) or ("", None)
            hint = "--level xacro-macro-unknown=warning leaves it out"
            self.tell(
                Diagnostic("error", "xacro-macro-unknown", what, file=caller, line=line, hint=hint)
            )
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

        class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
            """A loader of this run's own: xacro adds its tags to the loader of the process."""

        xacro = self.xacro
        for unit in xacro.ConstructUnits:
            Loader.add_constructor(unit.value.tag, unit.constructor)
        file = xacro.abs_filename_spec(name)
        data = self.open(file).getvalue()
        self.spend(10 * len(data))
        xacro.filestack.append(file)
        try:
            depth = 0
            for event in yaml.parse(data, Loader):
                depth += isinstance(event, yaml.CollectionStartEvent)
                depth -= isinstance(event, yaml.CollectionEndEvent)
                if depth > DEEPEST:
                    text = f"'{Path(name).name}' has more than {DEEPEST} lists in one another"
                    raise ConversionError("xacro-too-large", text)
            loader = Loader(data)
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
        for folder in self.packages.list_found().values():
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
    return Run(absolute(source), packages, args, trust).run()


def _declares(names: Iterable[str]) -> str:
    shown = ", ".join(names)
    return f"the arguments declared are: {shown}" if shown else "no file declares an argument"
