"""xacro without ROS: a copy of the ``xacro`` package's module for each expansion.

xacro keeps its state in its module, and each copy is used once.  These functions of the copy are
replaced, and nothing else:

=====================  ==============================================================
``safe_eval``          expressions are data (``evaluator``)
``parse``, ``open``,   files are read from the workspace and packages (``file_access``),
``glob``               with slips of XML fixed
``load_yaml``          YAML is data, too (``yaml_values``)
``eval_extension``     ``$(find)`` and ``$(arg)`` without ROS
``handle_macro_call``  an unknown macro is left out, with a message
``eval_text``          a text without ``$`` is returned at once
=====================  ==============================================================

A name that xacro does not have any more would be replaced without an effect, and its expressions
would run as Python.  So a copy that lacks one of ``REQUIRED_NAMES`` is refused.
"""

from __future__ import annotations

import io
import re
import threading
import warnings
from collections import ChainMap
from contextlib import nullcontext
from functools import partial
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
    absolute_path,
    files,
    nearest,
    xml,
)
from urdf2mbs_xacro.errors import (
    EVALUATING,
    explain,
    find_missing_package,
    find_only_line,
    undefined_argument,
)
from urdf2mbs_xacro.evaluator import Evaluator, replace_functions, tokenize
from urdf2mbs_xacro.file_access import FileAccess
from urdf2mbs_xacro.limits import MAX_LENGTH, Interrupted, Watch, too_large
from urdf2mbs_xacro.yaml_values import load_yaml

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
#: ``$(find NAME)`` returns this and the name if the package was not found.
_NOT_FOUND = "package://"


#: The names of xacro's modules that are replaced or used here.  Most are private.
REQUIRED_NAMES = {
    "xacro": (
        "ConstructUnits",
        "XacroException",
        "YamlListWrapper",
        "_global_symbols",
        "abs_filename_spec",
        "all_includes",
        "create_global_symbols",
        "error",
        "eval_extension",
        "eval_text",
        "filestack",
        "glob",
        "handle_macro_call",
        "load_yaml",
        "macrostack",
        "message",
        "parse",
        "print_location",
        "process_file",
        "re_macro_arg",
        "replace_node",
        "safe_eval",
        "substitution_args_context",
        "tokenize",
        "warning",
    ),
    "xacro.substitution_args": ("_eval_arg", "_eval_dict", "_eval_find", "resolve_args"),
}


class Arguments(dict[str, str]):
    """The arguments of an expansion, and the names that the robot has asked for.

    xacro asks with ``in`` only for an argument that a file declares.
    """

    def __init__(self, args: Mapping[str, str]) -> None:
        super().__init__(
            {argument_name: str(argument_value) for argument_name, argument_value in args.items()}
        )
        self.given = dict(self)
        self.requested: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.requested[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.requested[name] = None
        return super().__getitem__(name)


class Expander:
    """One expansion of one file: its copy of xacro, its messages, the packages that it misses."""

    def __init__(self, file: str, packages: Packages, args: Mapping[str, str], trust: bool) -> None:
        self.file = file
        self.packages = packages
        self.trust = trust
        self.args = Arguments(args)
        self.files = FileAccess(file, packages, self.args.given.values(), trust)
        self.messages: dict[Diagnostic, None] = {}
        self.missing_packages: dict[str, ConversionError] = {}
        self.xacro = _copy_module("xacro")
        self.original = SimpleNamespace(**vars(self.xacro))

    def run(self) -> Expansion:
        """Expand the file; raise ConversionError."""
        with _lock, warnings.catch_warnings(record=True) as python_warnings:
            warnings.simplefilter("always")
            warnings.simplefilter("ignore", ResourceWarning)  # of objects that Python deletes
            self._replace_functions()
            watch = Watch()
            try:
                with nullcontext() if self.trust else watch:
                    document = self.xacro.process_file(self.file, mappings=self.args)
                    urdf_bytes = document.toprettyxml(indent="  ").encode()
            except (Exception, Interrupted) as error:
                watch.stop()
                failure = explain(self, error if watch.exceeded is None else watch.error())
                failure.earlier = list(self.messages)
                raise failure from error
        for warning in python_warnings:
            message = f"{warning.category.__name__}: {warning.message}"
            self.add(Diagnostic("warning", "xacro-warning", message, file=self.file))
        read_files = dict.fromkeys(map(absolute_path, (self.file, *self.xacro.all_includes)))
        existing_files = [file_name for file_name in read_files if Path(file_name).is_file()]
        return Expansion(urdf_bytes, existing_files, [*self.messages, *self._warn_of_unused()])

    def _replace_functions(self) -> None:
        """Replace functions of the copy of xacro, and of its module of substitutions."""
        xacro = self.xacro
        xacro.substitution_args_context = {}
        xacro.re_macro_arg = _PARAMETER
        xacro.glob = SimpleNamespace(glob=self.files.glob)
        xacro.open = lambda file_name: io.BytesIO(self.files.read(file_name))
        for function_name in ("parse", "load_yaml", "handle_macro_call", "eval_text"):
            setattr(xacro, function_name, getattr(self, function_name))
        substitution = _copy_module("xacro.substitution_args")
        substitution._eval_find = substitution._eval_dict["find"] = self.find
        substitution._eval_arg = self.get_argument
        if not self.trust:
            evaluate = Evaluator().evaluate
            xacro.safe_eval = evaluate
            xacro.tokenize = tokenize
            builtins = substitution._eval_dict["__builtins__"]
            substitution.eval = lambda text, _, symbols: evaluate(text, ChainMap(builtins, symbols))
            replace_functions(substitution._eval_dict)
        xacro.eval_extension = partial(self._substitute, substitution)
        xacro._global_symbols = xacro.create_global_symbols()
        if not self.trust:
            replace_functions(xacro._global_symbols)
        reporting: dict[str, Any] = {
            "message": partial(self.report, "note"),
            "warning": partial(self.report, "warning"),
            "error": partial(self.report, "warning"),
            "print_location": lambda *_, **__: "",
        }
        vars(xacro).update(reporting)
        xacro._global_symbols["xacro"].update(reporting, arg=self.get_argument)

    def _substitute(self, substitution: Any, text: str) -> Any:
        """Return the value of ``$(find NAME)``, ``$(eval ...)`` and the like."""
        if text == "$(cwd)":
            return str(Path.cwd())
        xacro = self.xacro
        context = {"arg": self.args, "filename": absolute_path(xacro.filestack[-1])}
        try:
            return substitution.resolve_args(text, context)
        except Exception as error:
            raise xacro.XacroException(exc=error, suffix=f"\n{EVALUATING}{text}'") from error

    def add(self, diagnostic: Diagnostic) -> None:
        """Add a warning or message, once."""
        self.messages[diagnostic] = None

    def get_argument(self, name: str, args: Any = None) -> str:
        """Return the value of ``$(arg NAME)``."""
        try:
            return self.args[name]
        except KeyError:
            raise undefined_argument(name, [*self.args], self.list_files()) from None

    def find(self, package: str) -> str:
        """Return the folder of ``$(find NAME)``; a path that does not exist if it is missing."""
        try:
            return str(self.packages.find(package))
        except ConfigError:
            raise
        except ConversionError as error:
            # no error yet: the path may never be used
            self.missing_packages[package] = error
            message = (
                f"package '{package}' was not found; file names that begin with "
                f"$(find {package}) lead nowhere"
            )
            hint = error.hint
            self.add(
                Diagnostic("warning", "package-unresolved", message, file=self.file, hint=hint)
            )
            return f"{_NOT_FOUND}{package}"

    def report(self, level: Literal["warning", "note"], *words: Any, **_: Any) -> str:
        """Add a message of xacro or of the robot; return the text of its expression."""
        current_file = self.xacro.filestack[-1] if self.xacro.filestack else None
        message = " ".join(str(word) for word in words)
        missing_package = find_missing_package(message, self)
        if missing_package is not None:  # an include by a pattern, which matches nothing
            raise missing_package
        code = "xacro-warning" if level == "warning" else "xacro-message"
        self.add(Diagnostic(level, code, message, file=current_file or self.file))
        return ""

    def eval_text(self, text: Any, symbols: Any) -> Any:
        """Return a text with its expressions evaluated, or the value of its only expression."""
        # most texts have no expression; xacro takes a fifth of its time to find this out
        if not isinstance(text, str) or "$" not in text:
            return text
        if len(text) > MAX_LENGTH and not self.trust:
            raise too_large(f"a text with expressions has more than {MAX_LENGTH:,} letters")
        evaluated = self.original.eval_text(text, symbols)
        if isinstance(evaluated, str) and len(evaluated) > MAX_LENGTH and not self.trust:
            raise too_large(f"a text has more than {MAX_LENGTH:,} letters")
        return evaluated

    def parse(self, _: Any, name: str) -> Any:
        """Return the document of a file, the slips of its XML fixed with a warning."""
        from xml.dom import minidom

        file_path = Path(name)
        try:
            stream = io.BytesIO(files.read_bytes(file_path)) if files.is_stdin(file_path) else None
            return self.original.parse(stream, name)
        except ConversionError:
            self.xacro.filestack.pop()  # the error is in the file that includes this file
            raise
        except (ExpatError, UnicodeError):
            fixed_bytes, slips = xml.fix_slips(files.read_bytes(file_path))
            document = minidom.parseString(fixed_bytes)
            for code, message, line in slips:
                self.add(Diagnostic("warning", code, message, file=absolute_path(name), line=line))
            return document

    def load_yaml(self, name: str) -> Any:
        """Return the values of a YAML file, whose entries are attributes, too."""
        xacro = self.xacro
        yaml_file = xacro.abs_filename_spec(name)
        yaml_bytes = self.files.read(yaml_file)
        constructors = {unit.value.tag: unit.constructor for unit in xacro.ConstructUnits}
        xacro.filestack.append(yaml_file)
        try:
            yaml_values = load_yaml(yaml_bytes, Path(name).name, constructors, self.trust)
            return xacro.YamlListWrapper.wrap(yaml_values)
        finally:
            xacro.filestack.pop()
            xacro.all_includes.append(yaml_file)

    def handle_macro_call(self, node: Any, macros: Any, symbols: Any) -> Any:
        """Expand a call of a macro, if a node is one; leave out that of an unknown macro."""
        xacro = self.xacro
        macro_depth = len(xacro.macrostack or ())
        try:
            return self.original.handle_macro_call(node, macros, symbols)
        except xacro.XacroException as error:
            if len(xacro.macrostack or ()) != macro_depth or not str(error).startswith(
                _UNKNOWN_MACRO
            ):
                raise
            calling_file = absolute_path(xacro.filestack[-1])
            macro_name = node.tagName.partition(":")[2]
            message = (
                f"the macro '{macro_name}' is not defined: the <xacro:include> of the file that "
                "defines it is missing"
            )
            _, line = find_only_line([f"xacro:{macro_name}"], [calling_file]) or ("", None)
            hint = "--level xacro-macro-unknown=warning leaves it out"
            code = "xacro-macro-unknown"
            self.add(Diagnostic("error", code, message, file=calling_file, line=line, hint=hint))
            xacro.replace_node(node, by=None)
            return True

    def list_files(self) -> list[str]:
        """Return the files being processed, the innermost first, then all others that were read."""
        names = (*reversed(self.xacro.filestack or ()), *self.xacro.all_includes, self.file)
        return list(dict.fromkeys(map(absolute_path, names)))

    def _warn_of_unused(self) -> list[Diagnostic]:
        """Return a warning for each argument that was given and has no effect."""
        given, requested = self.args.given, self.args.requested
        unset = [argument_name for argument_name in requested if argument_name not in given]
        diagnostics = []
        for argument_name in given:
            if argument_name not in requested:
                message = (
                    f"the argument '{argument_name}' has no effect: no file declares or uses it"
                )
                hint = nearest(argument_name, unset) or _describe_declared(requested)
                diagnostics.append(
                    Diagnostic("warning", "xacro-unused-arg", message, file=self.file, hint=hint)
                )
        return diagnostics


def _copy_module(module_name: str) -> Any:
    """Return a new copy of one of xacro's modules.

    Raises:
        ConversionError: The installed xacro lacks names that are replaced or used here.
    """
    module_spec: Any = find_spec(module_name)
    module = module_from_spec(module_spec)
    module_spec.loader.exec_module(module)
    missing_names = [name for name in REQUIRED_NAMES[module_name] if not hasattr(module, name)]
    if missing_names:
        from importlib.metadata import version

        listed_names = ", ".join(f"{module_name}.{name}" for name in missing_names)
        message = f"the installed xacro {version('xacro')} has no {listed_names}"
        hint = "pip install 'xacro==2.1.1', with which urdf2mbs is tested"
        raise ConversionError("xacro-incompatible", message, hint=hint)
    return module


def _describe_declared(argument_names: Iterable[str]) -> str:
    listed_names = ", ".join(argument_names)
    return (
        f"the arguments declared are: {listed_names}"
        if listed_names
        else "no file declares an argument"
    )


def expand(
    source: Path, packages: Packages, args: Mapping[str, str], *, trust: bool = False
) -> Expansion:
    """Run xacro on a file.

    A macro that is not defined is left out; the diagnostics have an error for it.

    Args:
        source: The file.
        packages: Finds the packages of ``$(find NAME)``.
        args: The values of ``NAME:=VALUE``.
        trust: Whether expressions may run code, and files may be read from anywhere.

    Raises:
        ConversionError: ``xacro``, ``xacro-arg``, ``package-not-found``, ``xacro-expression``,
            ``xacro-too-large``, ``xacro-file``, ``xacro-incompatible`` and errors of XML.
    """
    return Expander(absolute_path(source), packages, args, trust).run()
