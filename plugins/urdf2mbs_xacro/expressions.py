"""Expressions of xacro are data: checked over their syntax tree, and evaluated within bounds.

xacro hands each ``${...}`` to Python.  Here the tree of an expression may hold constants, names,
arithmetic, comparisons, conditions, subscripts, displays, comprehensions, calls, and attributes
without an underscore, and nothing else.  ``Guard`` counts the letters and items of each value, and
checks the operations and methods whose result is much larger than what they are given.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import ItemsView, Iterable, Iterator, KeysView, ValuesView
from functools import partial
from itertools import islice
from typing import Any

from urdf2mbs.plugin import ConversionError

#: The letters and items of one value.
MOST = 10**5
#: The bits of a whole number.  Python's sets are slow for many larger numbers of equal hash.
MOST_BITS = 64
#: The work for one robot, in units of about a microsecond.
MOST_WORK = 5 * 10**6

TRUST = "if you trust the robot's author: `trust_xacro: true` in the config, or --trust-xacro"

_NODES: tuple[type[ast.AST], ...] = (
    ast.Expression, ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.Starred,
    ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.keyword,
    ast.List, ast.Tuple, ast.ListComp, ast.GeneratorExp, ast.comprehension,
    ast.expr_context, ast.operator, ast.unaryop, ast.boolop, ast.cmpop,
)  # fmt: skip
_NAMES = {"Lambda": "a lambda", "JoinedStr": "an f-string", "NamedExpr": "an assignment"}
#: What may stand between ``for`` and ``in``.
_TARGETS = (ast.Name, ast.Tuple, ast.List, ast.Starred, ast.expr_context)
#: The operators whose result can be much larger than what they are given.
_GROWING = {ast.Mult: "mul", ast.Mod: "mod", ast.Pow: "pow", ast.LShift: "lshift"}
#: The kinds of values that have attributes and methods.
_DATA = (str, int, float, list, tuple, dict, set, frozenset, range)
_ITERABLE = (list, tuple, dict, set, frozenset, KeysView, ValuesView, ItemsView)


def refusal(what: str) -> ConversionError:
    """The error for something that no robot needs."""
    text = f"{what} is not allowed in an expression"
    return ConversionError("xacro-expression", text, hint=TRUST)


def too_large(what: str) -> ConversionError:
    """The error for something beyond the bounds."""
    return ConversionError("xacro-too-large", f"{what} is more than is allowed", hint=TRUST)


class Guard:
    """The expressions of one robot, and the work that has been done for it."""

    def __init__(self, trust: bool) -> None:
        self.trust = trust
        self.work = 0
        self._codes: dict[str, Any] = {}
        self._operations = {
            "__operate": self.operate, "__attribute": self.attribute, "__measured": self.measure,
        }  # fmt: skip

    def spend(self, work: int) -> None:
        """Count work; raises ConversionError where it is more than is allowed."""
        self.work += work
        if self.work > MOST_WORK and not self.trust:
            raise too_large("the work for this robot")

    def evaluate(self, text: str, symbols: dict[str, Any]) -> Any:
        """The value of an expression, as ``xacro.safe_eval`` gives it.

        :raises ConversionError: ``xacro-expression``, ``xacro-too-large``
        :raises Exception: whatever Python raises for an expression that has no value
        """
        text = text.strip()
        code = self._codes.get(text)
        if code is None:
            self.spend(10 * len(text))
            tree = _Checked().visit(ast.parse(text, "<expression>", "eval"))
            # the operations are parameters of a function: names are looked up in the symbols
            function = ast.parse(f"lambda {', '.join(self._operations)}: 0", mode="eval")
            function.body.body = tree.body  # type: ignore[attr-defined]
            code = compile(ast.fix_missing_locations(function), "<expression>", "eval")
            self._codes[text] = code
        dict.__setitem__(symbols, "__builtins__", {})
        return eval(code, symbols)(*self._operations.values())

    # what the tree of an expression calls

    def measure(self, value: Any) -> Any:
        """The value of a part of an expression, whose letters and items are work.

        An iterator becomes a list, and some functions become our own.
        """
        if isinstance(value, Iterator):
            value = list(islice(value, MOST))
        elif callable(value) and value in _OWN:
            value = _OWN[value]
        self.spend(_size(value))
        return value

    def operate(self, name: str, left: Any, right: Any) -> Any:
        """``left * right``, say."""
        if name in ("pow", "lshift") and isinstance(left, int) and isinstance(right, int):
            _check_product(left.bit_length(), right)
        elif name == "mul":
            for value, count in ((left, right), (right, left)):
                if isinstance(count, int) and not isinstance(value, (int, float)):
                    _check_product(_size(value), count)
        elif name == "mod" and isinstance(left, str):
            if re.search(r"\d{4}|%[^a-zA-Z%]*\*", left):
                raise too_large("so wide a field")
            _check_product(_size(left), _size(right))
        return getattr(operator, name)(left, right)

    def attribute(self, value: Any, name: str) -> Any:
        """``value.name``: an entry of a namespace or of YAML, or a method of a text or list."""
        if hasattr(type(value), "_resolve_"):  # a namespace of xacro
            try:
                return value[name]
            except KeyError:
                raise NameError(f"name '{name}' is not defined") from None
        if not isinstance(value, _DATA):
            raise refusal(f"the attribute '{name}' of a {type(value).__name__}")
        if name in ("format", "format_map"):
            raise refusal(f"the method '{name}'")
        found = getattr(value, name)
        is_method = callable(getattr(type(value), name, None))
        return partial(self.call, value, found) if is_method else found

    def call(self, value: Any, method: Any, *args: Any, **more: Any) -> Any:
        """A method of a text, a list or a number."""
        size = _size(self.measure(value))
        # 'a'.ljust(10**9), 'aa'.replace('a', ...)
        for given in (*args, *more.values()) if isinstance(value, (str, int)) else ():
            _check_product(size, abs(given) if isinstance(given, int) else _size(given))
        return method(*args, **more)


def _size(value: Any) -> int:
    """The letters and items of a value, each part as often as it can be reached."""
    size, todo = 0, [value]
    while todo:
        value = todo.pop()
        size += 1
        if isinstance(value, (str, bytes)):
            size += len(value)
        elif isinstance(value, int):
            if value.bit_length() > MOST_BITS:
                raise too_large("a number of so many digits")
        elif isinstance(value, range):
            size += abs(value.stop - value.start) // abs(value.step)
        elif isinstance(value, _ITERABLE):
            size += len(value)
            todo += dict.values(value) if isinstance(value, dict) else ()
            # not by the iterator of YAML's lists, which wraps each item
            todo += list.__iter__(value) if isinstance(value, list) else iter(value)
        elif isinstance(value, (Iterator, complex)):
            raise refusal(f"a {type(value).__name__} within a value")
        if size > MOST:
            raise too_large(f"a value of over {MOST:,} letters and items")
    return size


def _check_product(size: int, count: int) -> None:
    if size * count > MOST:
        raise too_large("so long a text, list or number")


def _round(number: Any, digits: int | None = None) -> Any:
    _check_product(1, abs(digits or 0))
    return round(number, digits)


def _sum(items: Iterable[Any], start: float = 0) -> Any:
    if not isinstance(start, (int, float)):
        raise refusal("a sum that is no number")
    return sum(items, start)


def tokenize(s: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """xacro's function of this name."""
    if "]" in sep:  # it is a set of letters in a pattern
        raise refusal("']' among the letters of tokenize")
    words = re.split(f"[{sep}]", s)
    return [word for word in words if word] if skip_empty else words


def _withhold(*_: Any, **__: Any) -> Any:
    raise refusal("such a function")


#: Functions that reach beyond values, or whose arguments do not show their work.
_WITHHELD = (
    type, vars, issubclass, complex, slice, math.prod, math.lcm, math.factorial, math.comb,
    math.perm,
)  # fmt: skip
#: What an expression gets in place of a function.
_OWN: dict[Any, Any] = {round: _round, sum: _sum, **dict.fromkeys(_WITHHELD, _withhold)}


class _Checked(ast.NodeTransformer):
    """A tree of allowed nodes only, with the operations of ``Guard``."""

    def visit(self, node: ast.AST) -> Any:
        """The node, measured where it is a value."""
        checked = self.check(node)
        plain = (ast.Constant, ast.Starred, ast.Slice)
        if not isinstance(node, ast.expr) or isinstance(node, plain):
            return checked
        return _call("__measured", checked)

    def check(self, node: ast.AST) -> Any:
        """The node; only a part of its value is used."""
        if not isinstance(node, _NODES):
            name = type(node).__name__
            raise refusal(_NAMES.get(name, f"'{name}' of Python"))
        return super().visit(node)

    def visit_Constant(self, node: ast.Constant) -> Any:
        if not isinstance(node.value, (str, int, float, type(None))):
            raise refusal(f"the constant {node.value!r}")
        return node

    def visit_Name(self, node: ast.Name) -> Any:
        if node.id.startswith("__"):
            raise refusal(f"the name '{node.id}'")
        return node

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        if node.attr.startswith("_"):
            raise refusal(f"the attribute '{node.attr}'")
        return _call("__attribute", self.check(node.value), ast.Constant(node.attr))

    def visit_Subscript(self, node: ast.Subscript) -> Any:
        return ast.Subscript(self.check(node.value), self.visit(node.slice), ast.Load())

    def visit_BinOp(self, node: ast.BinOp) -> Any:
        name = _GROWING.get(type(node.op))
        left, right = self.visit(node.left), self.visit(node.right)
        return _call("__operate", ast.Constant(name), left, right) if name else (
            ast.BinOp(left, node.op, right)
        )  # fmt: skip

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> Any:
        self.generic_visit(node)
        return ast.ListComp(node.elt, node.generators)

    def visit_comprehension(self, node: ast.comprehension) -> Any:
        for part in ast.walk(node.target):
            if node.is_async or not isinstance(part, _TARGETS):
                raise refusal("such a loop")
            if isinstance(part, ast.Name):
                self.visit_Name(part)
        ifs = [self.visit(condition) for condition in node.ifs]
        return ast.comprehension(node.target, self.visit(node.iter), ifs, 0)


def _call(name: str, *args: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), list(args), [])
