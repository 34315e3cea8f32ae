"""Expressions of xacro are data: ``simpleeval`` computes their values, and no code runs.

xacro hands each ``${...}`` to Python.  Here an expression may compute with constants, names,
operators, comparisons, comprehensions, calls of functions that xacro offers, methods of texts,
lists, mappings and numbers, and entries of namespaces and of YAML.  ``simpleeval`` goes through
its syntax tree; this file adds what robots use beyond it (namespaces, ``*args``), and a limit of
the length of each value, so that no single operation takes long.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import ItemsView, Iterable, Iterator, KeysView, ValuesView
from itertools import islice
from typing import TYPE_CHECKING, Any

from simpleeval import (
    DEFAULT_OPERATORS,
    EvalWithCompoundTypes,
    IterableTooLong,
    NumberTooHigh,
)

from urdf2mbs.plugin import ConversionError
from urdf2mbs_xacro.limits import MAX_LENGTH, TRUST, too_large

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

#: The bits of a whole number.  Python's sets are slow for many larger numbers of equal hash.
MAX_BITS = 64

#: Expressions that are not evaluated, in words.
_NODE_NAMES = {
    ast.Lambda: "a lambda",
    ast.JoinedStr: "an f-string",
    ast.FormattedValue: "an f-string",
    ast.NamedExpr: "an assignment",
}
#: Constants of other kinds are bytes, complex numbers and ``...``.
_CONSTANTS = (str, int, float, type(None))
#: Nodes that may be between ``for`` and ``in``.
_TARGETS = (ast.Name, ast.Tuple, ast.List, ast.expr_context)
#: The kinds of values that have attributes and methods.
_DATA = (str, int, float, list, tuple, dict, set, frozenset, range)
#: Methods of a text that reach the attributes of their arguments.
_FORMATS = ("format", "format_map")
_CONTAINERS = (list, tuple, dict, set, frozenset, KeysView, ValuesView, ItemsView)


def refuse(construct: str) -> ConversionError:
    """Return the error for a construct that no robot needs."""
    message = f"{construct} is not allowed in an expression"
    return ConversionError("xacro-expression", message, hint=TRUST)


def _raise_too_long() -> None:
    raise too_large(f"a value has more than {MAX_LENGTH:,} letters or items")


class Evaluator(EvalWithCompoundTypes):  # type: ignore[misc]
    """Computes the values of a robot's expressions."""

    names: Mapping[str, Any]
    """The names of the expression that is being evaluated."""
    nodes: dict[type[ast.AST], Callable[[Any], Any]]
    """The method that evaluates each kind of node."""
    _max_count: int
    """The number of items of comprehensions, which simpleeval counts."""

    def __init__(self) -> None:
        operators = {**DEFAULT_OPERATORS, ast.Mod: _remainder, ast.Pow: _power}
        super().__init__(operators=operators, functions={}, names={})
        for node_type in (ast.JoinedStr, ast.FormattedValue):
            del self.nodes[node_type]
        self._trees: dict[str, ast.expr] = {}

    def evaluate(self, text: str, symbols: Mapping[str, Any]) -> Any:
        """Return the value of an expression, as ``xacro.safe_eval`` does.

        Raises:
            ConversionError: ``xacro-expression`` or ``xacro-too-large``.
            Exception: Whatever Python raises for an expression that has no value.
        """
        text = text.strip()
        syntax_tree = self._trees.get(text)
        if syntax_tree is None:
            syntax_tree = self._trees[text] = ast.parse(text, "<expression>", "eval").body
        # a name may be a property, whose own expression is evaluated in between
        outer_state = self.names, self.nodes, self._max_count
        self.names, self.nodes, self._max_count = symbols, dict(self.nodes), 0
        self.nodes[ast.Name] = self._eval_name
        try:
            return self._eval(syntax_tree)
        except (IterableTooLong, NumberTooHigh):
            raise too_large("a value of an expression is too long or too large") from None
        finally:
            self.names, self.nodes, self._max_count = outer_state

    def _eval(self, node: ast.AST) -> Any:
        """Return the value of a node, of a limited length."""
        value = self._get_method(node)(node)
        if type(value) is not float:
            _measure_length(value)  # raises for a value that is too long, or that is no data
        return value

    def _eval_owner(self, node: ast.AST) -> Any:
        """Return the value of a node, of any length: only an item or attribute of it is used."""
        return self._get_method(node)(node)

    def _get_method(self, node: ast.AST) -> Callable[[Any], Any]:
        """Return the method that evaluates a kind of node; raise ConversionError if none does."""
        method = self.nodes.get(type(node))
        if method is None:
            raise refuse(_NODE_NAMES.get(type(node), f"'{type(node).__name__}' of Python"))
        return method

    def _eval_constant(self, node: ast.Constant) -> Any:
        if not isinstance(node.value, _CONSTANTS):
            raise refuse(f"the constant {node.value!r}")
        return node.value

    def _eval_name(self, node: ast.Name) -> Any:
        if node.id.startswith("__"):
            raise refuse(f"the name '{node.id}'")
        try:
            return self.names[node.id]
        except KeyError:
            raise NameError(f"name '{node.id}' is not defined") from None

    def _eval_subscript(self, node: ast.Subscript) -> Any:
        return self._eval_owner(node.value)[self._eval(node.slice)]

    def _eval_attribute(self, node: ast.Attribute) -> Any:
        owner = self._eval_owner(node.value)
        attribute = _get_attribute(owner, node.attr)
        if callable(attribute) and isinstance(owner, _DATA) and not is_namespace(owner):
            raise refuse(f"the method '{node.attr}' without a call")
        return attribute

    def _eval_call(self, node: ast.Call) -> Any:
        """Return the result of a function or method; a list of an iterator's items."""
        owner = None
        if isinstance(node.func, ast.Attribute):
            owner = self._eval_owner(node.func.value)
            function = _get_attribute(owner, node.func.attr)
        else:
            function = self._eval(node.func)
        arguments = self._eval_list(ast.List(node.args))
        keywords: dict[str, Any] = {}
        for keyword in node.keywords:
            argument_value = self._eval(keyword.value)
            keywords.update(
                argument_value if keyword.arg is None else {keyword.arg: argument_value}
            )
        if isinstance(owner, _DATA) and not is_namespace(owner):
            _check_method(owner, [*arguments, *keywords.values()])
        result = function(*arguments, **keywords)
        return list(islice(result, MAX_LENGTH)) if isinstance(result, Iterator) else result

    def _eval_comprehension(self, node: ast.ListComp) -> Any:
        for generator in node.generators:
            targets = ast.walk(generator.target)
            if generator.is_async or not all(
                isinstance(target_part, _TARGETS) for target_part in targets
            ):
                raise refuse("a 'for' that assigns to anything but names")
        return super()._eval_comprehension(node)


def is_namespace(value: Any) -> bool:
    """Return True for a namespace of xacro."""
    return hasattr(type(value), "_resolve_")


def _get_attribute(owner: Any, attribute_name: str) -> Any:
    """Return an entry of a namespace or of YAML, or a method of a text or list."""
    if attribute_name.startswith("_"):
        raise refuse(f"the attribute '{attribute_name}'")
    if is_namespace(owner):
        try:
            return owner[attribute_name]
        except KeyError:
            raise NameError(f"name '{attribute_name}' is not defined") from None
    if not isinstance(owner, _DATA):
        raise refuse(f"the attribute '{attribute_name}' of a {type(owner).__name__}")
    if attribute_name in _FORMATS:
        raise refuse(f"the method '{attribute_name}'")
    return getattr(owner, attribute_name)


def _measure_length(value: Any) -> int:
    """Return the letters and items of a value, each part as often as it can be reached."""
    length, pending = 0, [value]
    while pending:
        current = pending.pop()
        length += 1
        if isinstance(current, (str, bytes)):
            length += len(current)
        elif isinstance(current, int):
            if current.bit_length() > MAX_BITS:
                raise too_large(f"a whole number has more than {MAX_BITS} bits")
        elif isinstance(current, range):
            length += abs(current.stop - current.start) // abs(current.step)
        elif isinstance(current, _CONTAINERS):
            length += len(current)
            pending += dict.values(current) if isinstance(current, dict) else ()
            # not by the iterator of YAML's lists, which wraps each item
            pending += list.__iter__(current) if isinstance(current, list) else iter(current)
        elif isinstance(current, (Iterator, complex)):
            raise refuse(f"a {type(current).__name__} within a value")
        if length > MAX_LENGTH:
            _raise_too_long()
    return length


def _check_product(length: int, n_repetitions: int) -> None:
    """Raise ConversionError if the repetitions of a value are too long."""
    if length * n_repetitions > MAX_LENGTH:
        _raise_too_long()


def _check_method(owner: Any, arguments: list[Any]) -> None:
    """Check the lengths of a value and of what its method is given: ``'a'.ljust(10**9)``."""
    length = _measure_length(owner)
    if isinstance(owner, (str, int)):
        for argument in arguments:
            argument_length = (
                abs(argument) if isinstance(argument, int) else _measure_length(argument)
            )
            _check_product(length, argument_length)


def _remainder(left: Any, right: Any) -> Any:
    """Return ``left % right``; in a text, the width of a field has at most three digits."""
    if isinstance(left, str):
        if re.search(r"\d{4}|%[^a-zA-Z%]*\*", left):
            raise too_large("a field of a text is wider than 999")
        _check_product(_measure_length(left), _measure_length(right))
    return left % right


def _power(base: Any, exponent: Any) -> Any:
    """Return ``base ** exponent``."""
    if isinstance(base, int) and isinstance(exponent, int):
        _check_product(base.bit_length(), exponent)
    return base**exponent


def _round(number: Any, digits: int | None = None) -> Any:
    """Return Python's ``round``, of a limited number of digits."""
    _check_product(1, abs(digits or 0))
    return round(number, digits)


def _sum(items: Iterable[Any], start: float = 0) -> Any:
    """Return Python's ``sum``, of numbers."""
    if not isinstance(start, (int, float)):
        raise refuse("a sum of anything but numbers")
    return sum(items, start)


def tokenize(s: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """Split a text at any of the letters of ``sep``, as xacro's function of this name."""
    if "]" in sep:  # it is a set of letters in a pattern
        raise refuse("']' among the letters of tokenize")
    words = re.split(f"[{sep}]", s)
    return [word for word in words if word] if skip_empty else words


def _withhold(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that refuses to be called in place of another."""

    def refuse_call(*_: Any, **__: Any) -> Any:
        raise refuse(f"the function '{function.__name__}'")

    return refuse_call


#: Functions that reach beyond values, or whose arguments do not show how much work they are.
_WITHHELD = (
    type,
    vars,
    issubclass,
    complex,
    slice,
    math.prod,
    math.lcm,
    math.factorial,
    math.comb,
    math.perm,
)
#: The functions that an expression is given in place of Python's.
_REPLACEMENTS: dict[Any, Any] = {
    round: _round,
    sum: _sum,
    **{function: _withhold(function) for function in _WITHHELD},
}


def replace_functions(namespace: dict[str, Any]) -> None:
    """Replace the functions of a table that could take long, or could do more than compute."""
    for function_name, value in dict.items(namespace):
        if callable(value) and value in _REPLACEMENTS:
            dict.__setitem__(namespace, function_name, _REPLACEMENTS[value])
        elif isinstance(value, dict):
            replace_functions(value)
