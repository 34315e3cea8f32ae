"""Expressions of xacro are data: checked over their syntax tree, and evaluated within bounds.

xacro hands each ``${...}`` to Python.  This module checks the tree of an expression first: the tree
may hold constants, names, arithmetic, comparisons, conditions, subscripts, displays,
comprehensions, calls, and attributes without an underscore, and nothing else.  Then a call of
``Guard`` replaces each operation in the tree, and a function that ``Guard`` watches replaces each
function that xacro offers.  So an expression never reaches a function, a method or an attribute
that is not on the list, and ``Guard`` measures every operand and every result.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, ItemsView, Iterable, Iterator, KeysView, ValuesView
from functools import partial, reduce, wraps
from itertools import islice
from string import Formatter
from typing import Any

from urdf2mbs.messages.diagnostics import ConversionError

#: The letters, items and steps of one expression.
MOST = 10**6
#: The bits of a whole number: about 3,000 digits.
MOST_BITS = 10_000
#: The work for one robot, in units of about a microsecond.
MOST_WORK = 10**8

TRUST = "if you trust the robot's author: `trust_xacro: true` in the config, or --trust-xacro"

_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "Add": operator.add, "Sub": operator.sub, "Mult": operator.mul, "Div": operator.truediv,
    "FloorDiv": operator.floordiv, "Mod": operator.mod, "Pow": operator.pow,
    "LShift": operator.lshift, "RShift": operator.rshift, "BitAnd": operator.and_,
    "BitOr": operator.or_, "BitXor": operator.xor,
}  # fmt: skip
_NODES: tuple[type[ast.AST], ...] = (
    ast.Expression, ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.Starred,
    ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.keyword,
    ast.List, ast.Tuple, ast.Set, ast.Dict,
    ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp, ast.comprehension,
    ast.expr_context, ast.operator, ast.unaryop, ast.boolop, ast.cmpop,
)  # fmt: skip
_NAMES = {"Lambda": "a lambda", "JoinedStr": "an f-string", "NamedExpr": "an assignment"}
#: The fields of nodes whose values Python compares, hashes or takes apart without an operation.
_MEASURED: dict[type[ast.AST], tuple[str, ...]] = {
    ast.Compare: ("left", "comparators"), ast.Starred: ("value",), ast.keyword: ("value",),
    ast.Dict: ("keys", "values"), ast.Set: ("elts",), ast.SetComp: ("elt",), ast.DictComp: ("key",),
}  # fmt: skip
_NUMBERS = (int, float, complex)
#: The kinds of values that have methods and items.
_DATA = (str, list, tuple, dict, set, frozenset, range, *_NUMBERS)
_VIEWS = (KeysView, ValuesView, ItemsView)
#: Functions that xacro offers and that reach beyond values, or whose arguments do not show their
#: work.  No robot needs them.
_WITHHELD = frozenset(
    ("type", "vars", "issubclass", "prod", "lcm", "factorial", "comb", "perm")
)  # fmt: skip


def refusal(what: str) -> ConversionError:
    """The error for something that no robot needs."""
    text = f"{what} is not allowed in an expression"
    return ConversionError("xacro-expression", text, hint=TRUST)


def too_large(what: str) -> ConversionError:
    """The error for something beyond the bounds."""
    return ConversionError("xacro-too-large", f"{what} is more than is allowed", hint=TRUST)


class Guard:
    """The expressions of one robot, and the work that has been done for it."""

    def __init__(self) -> None:
        self.work = 0
        self._until = math.inf
        """The work at which the current expression is stopped."""
        self._codes: dict[str, Any] = {}
        self._operations = {
            "__operate": self.operate, "__attribute": self.attribute, "__item": self.item,
            "__slice": slice, "__measured": self.measure, "__each": self.each,
        }  # fmt: skip

    def spend(self, work: int) -> None:
        """Count the work of an expression; raises ConversionError where a bound is passed."""
        self.work += work
        if self.work > self._until:
            raise too_large(f"an expression with over {MOST:,} letters, items and steps")
        if self.work > MOST_WORK:
            raise too_large("the work for this robot")

    def spend_beside(self, work: int) -> None:
        """Count work of the robot that is no work of the current expression."""
        self._until += work
        self.spend(work)

    def evaluate(self, text: str, symbols: dict[str, Any]) -> Any:
        """The value of an expression, as ``xacro.safe_eval`` gives it.

        :raises ConversionError: ``xacro-expression``, ``xacro-too-large``
        :raises Exception: whatever Python raises for an expression that has no value
        """
        text = text.strip()
        before, until = self.work, self._until
        self._until = self.work + MOST
        try:
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
            function = eval(code, symbols)
            return self.measure(function(*self._operations.values()))
        finally:
            self._until = until + self.work - before

    def offer(self, names: dict[str, Any]) -> None:
        """Replace the functions of a table, and of the tables in it, by watched ones."""
        for name, value in list(dict.items(names)):
            if isinstance(value, dict):
                self.offer(value)
            elif name in _WITHHELD:
                dict.__setitem__(names, name, partial(self._withhold, name))
            elif callable(value):
                own: dict[str, Callable[..., Any]] = {
                    "round": _round, "sum": self._sum,
                    "isinstance": _isinstance, "tokenize": _tokenize,
                }  # fmt: skip
                dict.__setitem__(names, name, self._watch(own.get(name, value)))

    # what the tree of an expression calls

    def operate(self, name: str, left: Any, right: Any) -> Any:
        """``left + right``, say."""
        self.spend(10)
        sizes = self._take(left), self._take(right)
        if name in ("Pow", "LShift") and isinstance(left, int) and isinstance(right, int):
            bits = left.bit_length()
            if (bits * right if name == "Pow" else bits + right) > MOST_BITS:
                raise too_large("a number of so many digits")
        elif name == "Mult":
            for value, size, count in ((left, sizes[0], right), (right, sizes[1], left)):
                if isinstance(count, int) and not isinstance(value, _NUMBERS):
                    _check_product(size, count)
        elif name == "Mod" and isinstance(left, str):
            _check_widths(left)
            _check_product(*sizes)
        return self.measure(_OPERATORS[name](left, right))

    def attribute(self, value: Any, name: str) -> Any:
        """``value.name``: an entry of a namespace or of YAML, or a method of a text or list."""
        if str(name).startswith("_"):
            raise refusal(f"the attribute '{name}'")
        if hasattr(type(value), "_resolve_"):  # a namespace of xacro
            try:
                return value[name]
            except KeyError:
                raise NameError(f"name '{name}' is not defined") from None
        if not isinstance(value, _DATA):
            raise refusal(f"the attribute '{name}' of a {type(value).__name__}")
        if callable(getattr(type(value), name, None)):
            return self._method(value, name)
        return getattr(value, name)

    def item(self, value: Any, key: Any) -> Any:
        """``value[key]``."""
        self._take(key)
        if hasattr(type(value), "_resolve_"):
            return self.attribute(value, key)
        if not isinstance(value, _DATA):
            raise TypeError(f"'{type(value).__name__}' object is not subscriptable")
        part = value[key]  # type: ignore[index]
        return self.measure(part) if isinstance(key, slice) else part

    def measure(self, value: Any) -> Any:
        """The same value, where it is within the bounds."""
        self._take(value)
        return value

    def each(self, items: Iterable[Any]) -> Iterator[Any]:
        """The items of a loop."""
        for item in items:
            self.spend(5)
            yield item

    def _take(self, value: Any) -> int:
        """Count the contents of a value, each part as often as it can be reached, as work.

        Returns the size that was counted.
        """
        if type(value) is float:
            self.spend(1)
            return 1
        size, todo = 0, [value]
        while todo:
            value = todo.pop()
            size += 1
            if isinstance(value, (str, bytes)):
                size += len(value)
            elif isinstance(value, int):
                if value.bit_length() > MOST_BITS:
                    raise too_large("a number of so many digits")
            elif isinstance(value, slice):
                todo += [value.start, value.stop, value.step]
            elif isinstance(value, range):
                size += abs(value.stop - value.start) // abs(value.step)
            elif isinstance(value, (list, tuple, set, frozenset, dict, *_VIEWS)):
                size += len(value)
                # not by the iterators of YAML's lists and mappings, which wrap each item
                plain: Any = list.__iter__ if isinstance(value, list) else iter
                todo += dict.values(value) if isinstance(value, dict) else ()
                todo += plain(value)
            if size > MOST:
                break
        self.spend(size)
        return size

    # what an expression calls

    def _withhold(self, name: str, *_: Any) -> None:
        raise refusal(f"the function '{name}'")

    def _watch(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A function whose arguments and results are measured; an iterator becomes a list."""

        @wraps(function, updated=())
        def watched(*args: Any, **more: Any) -> Any:
            self.spend(10)
            for value in (*args, *more.values()):
                self._take(value)
            result = function(*args, **more)
            if isinstance(result, Iterator):
                result = list(islice(result, MOST))
            return self.measure(result)

        return watched

    def _method(self, value: Any, name: str) -> Callable[..., Any]:
        method = getattr(value, name)
        if isinstance(value, str) and name == "format":
            method = lambda *args, **more: _Format().vformat(value, args, more)  # noqa: E731
        elif name in ("format", "format_map"):
            raise refusal(f"the method '{name}'")

        def bounded(*args: Any, **more: Any) -> Any:
            size = self._take(value)
            # 'a'.ljust(10**9), 'aa'.replace('a', ...)
            for given in (*args, *more.values()) if isinstance(value, (str, int)) else ():
                _check_product(size, abs(given) if isinstance(given, int) else self._take(given))
            return method(*args, **more)

        return self._watch(bounded)

    def _sum(self, items: Iterable[Any], start: Any = 0) -> Any:
        return reduce(partial(self.operate, "Add"), items, start)


@wraps(isinstance)
def _isinstance(value: Any, kinds: Any) -> bool:
    kinds = kinds if isinstance(kinds, tuple) else (kinds,)
    return isinstance(value, tuple(kind.__wrapped__ for kind in kinds))


def _tokenize(s: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    if "]" in sep:  # it is a set of letters in a pattern
        raise refusal("']' among the letters of tokenize")
    words = re.split(f"[{sep}]", s)
    return [word for word in words if word] if skip_empty else words


class _Format(Formatter):
    """``str.format`` without attributes."""

    def get_field(self, field_name: str, args: Any, kwargs: Any) -> Any:
        if "." in field_name:
            raise refusal("an attribute in a format field")
        return super().get_field(field_name, args, kwargs)

    def format_field(self, value: Any, format_spec: str) -> Any:
        _check_widths(format_spec)
        return super().format_field(value, format_spec)


def _round(number: Any, digits: int | None = None) -> Any:
    if digits is not None and abs(digits) > MOST_BITS:
        raise too_large("a number of so many digits")
    return round(number, digits)


def _check_widths(form: str) -> None:
    if re.search(r"\d{4}|%[^a-zA-Z%]*\*", form):
        raise too_large("so wide a field")


def _check_product(size: int, more: int) -> None:
    if size * more > MOST:
        raise too_large("so long a text or list")


class _Checked(ast.NodeTransformer):
    """A tree of allowed nodes only, with the operations of ``Guard``."""

    def visit(self, node: ast.AST) -> Any:
        if not isinstance(node, _NODES):
            name = type(node).__name__
            raise refusal(_NAMES.get(name, f"'{name}' of Python"))
        checked = super().visit(node)
        if isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
            for field in _MEASURED.get(type(node), ()):
                part = getattr(node, field)
                part = list(map(_measure, part)) if isinstance(part, list) else _measure(part)
                setattr(node, field, part)
        return checked

    def visit_Constant(self, node: ast.Constant) -> Any:
        if not isinstance(node.value, (str, *_NUMBERS, type(None))):
            raise refusal(f"the constant {node.value!r}")
        return node

    def visit_Name(self, node: ast.Name) -> Any:
        if node.id.startswith("__"):
            raise refusal(f"the name '{node.id}'")
        return node

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        if node.attr.startswith("_"):
            raise refusal(f"the attribute '{node.attr}'")
        return self._call(node, "__attribute", node.value, ast.Constant(node.attr))

    def visit_Subscript(self, node: ast.Subscript) -> Any:
        return self._call(node, "__item", node.value, node.slice)

    def visit_Slice(self, node: ast.Slice) -> Any:
        ends = [end or ast.Constant(None) for end in (node.lower, node.upper, node.step)]
        return self._call(node, "__slice", *ends)

    def visit_BinOp(self, node: ast.BinOp) -> Any:
        name = ast.Constant(type(node.op).__name__)
        return self._call(node, "__operate", name, node.left, node.right)

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> Any:
        self.generic_visit(node)
        return ast.ListComp(node.elt, node.generators)

    def visit_comprehension(self, node: ast.comprehension) -> Any:
        self.generic_visit(node)
        if node.is_async:
            raise refusal("'async'")
        node.iter = ast.Call(ast.Name("__each", ast.Load()), [node.iter], [])
        return node

    def _call(self, node: ast.AST, name: str, *args: ast.expr) -> ast.expr:
        if not isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
            raise refusal("a change of a value")
        return ast.Call(ast.Name(name, ast.Load()), [self.visit(arg) for arg in args], [])


def _measure(node: ast.expr | None) -> ast.expr | None:
    # Python warns of some comparisons of constants; ** has no key
    if node is None or isinstance(node, (ast.Constant, ast.Starred)):
        return node
    return ast.Call(ast.Name("__measured", ast.Load()), [node], [])
