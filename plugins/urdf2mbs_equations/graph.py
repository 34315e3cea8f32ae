"""Expressions as a graph, in which what is equal is one node.

``Expr`` has operators: ``a + b``, ``2 * a``.  Inside the graph an expression is a whole number: the
number of its node, negative for the expression with the opposite sign, 0 for zero, 1 for one.  So
zeros, ones and signs cost nothing, ``a - b`` and ``b - a`` are one node, and two equal expressions
are the same number (hash-consing).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import IntEnum

#: The number of a node, negative for the opposite expression.
Signed = int

#: The operations; constants, symbols and inputs are not computed.
Op = IntEnum("Op", "CONST SYMBOL INPUT ADD MUL DIV SIN COS SQRT PAIR FIRST SECOND", start=0)
LEAVES = frozenset([Op.CONST, Op.SYMBOL, Op.INPUT])
#: Those of two operands; the rest has one.
BINARY = frozenset([Op.ADD, Op.MUL, Op.DIV, Op.PAIR])


class Graph:
    """Nodes in the order in which they were made: what a node needs stands before it."""

    def __init__(self) -> None:
        self.op: list[Op] = [Op.CONST, Op.CONST]
        self.a: list[Signed] = [0, 0]
        """The first operand; of a sum and a product always positive."""
        self.b: list[Signed] = [0, 0]
        self.value: list[float] = [0.0, 1.0]
        """Of a constant; never negative."""
        self.name = ["0", "1"]
        """Of a symbol, as in ``q[3]``."""
        self._known: dict[tuple[Op, Signed, Signed], int] = {}
        self._constants = {1.0: 1}
        self._symbols: dict[str, int] = {}

    def _node(self, op: Op, a: Signed, b: Signed = 0, value: float = 0.0, name: str = "") -> int:
        self.op.append(op)
        self.a.append(a)
        self.b.append(b)
        self.value.append(value)
        self.name.append(name)
        return len(self.op) - 1

    def _shared(self, op: Op, x: Signed, y: Signed = 0) -> int:
        """The node of an operation, made only once."""
        key = (op, x, y)
        node = self._known.get(key)
        if node is None:
            node = self._known[key] = self._node(op, x, y)
        return node

    def number(self, x: Scalar) -> Signed:
        """The node of an expression or of a constant."""
        return x.node if isinstance(x, Expr) else self.constant(x)

    def constant(self, value: float) -> Signed:
        if value == 0.0:
            return 0
        size = abs(value)
        node = self._constants.get(size)
        if node is None:
            node = self._constants[size] = self._node(Op.CONST, 0, value=size)
        return node if value > 0.0 else -node

    def symbol(self, name: str) -> Expr:
        node = self._symbols.get(name)
        if node is None:
            node = self._symbols[name] = self._node(Op.SYMBOL, 0, name=name)
        return Expr(self, node)

    def input(self, name: str) -> Expr:
        """A value that a call of a user function gives: it is never equal to another."""
        return Expr(self, self._node(Op.INPUT, 0, name=name))

    def add(self, x: Signed, y: Signed) -> Signed:
        if x == 0 or y == 0:
            return x or y
        if x == -y:
            return 0
        if x == y:
            return self.mul(self.constant(2.0), x)
        if abs(x) > abs(y):
            x, y = y, x
        if x < 0:
            return -self._shared(Op.ADD, -x, -y)
        return self._shared(Op.ADD, x, y)

    def mul(self, x: Signed, y: Signed) -> Signed:
        if x == 0 or y == 0:
            return 0
        if (x > 0) != (y > 0):
            return -self.mul(abs(x), abs(y))
        x, y = sorted((abs(x), abs(y)))
        if x == 1:
            return y
        op, a = self.op, self.a
        if op[y] == Op.CONST:
            x, y = y, x
        if op[x] == Op.CONST and op[y] == Op.MUL and op[a[y]] == Op.CONST:
            return self.mul(self.constant(self.value[x] * self.value[a[y]]), self.b[y])
        return self._shared(Op.MUL, x, y)

    def div(self, x: Signed, y: Signed) -> Signed:
        if x == 0:
            return 0
        node = self._shared(Op.DIV, abs(x), abs(y))
        return node if (x > 0) == (y > 0) else -node

    def sin(self, x: Signed) -> Signed:
        return self._shared(Op.SIN, x) if x > 0 else -self._shared(Op.SIN, -x)

    def cos(self, x: Signed) -> Signed:
        return self._shared(Op.COS, abs(x))

    def sqrt(self, x: Signed) -> Signed:
        return self._shared(Op.SQRT, x)

    def apply(self, op: Op, x: Signed, y: Signed) -> Signed:
        """An operation of one operand (``y`` does not count) or of two."""
        function = getattr(self, op.name.lower())
        return int(function(x, y) if op in BINARY else function(x))

    # Two numbers as one, for processors that do the same with both in one step.  What is done
    # with a pair is done with both; a single number may stand in for two equal ones.

    def pair(self, x: Signed, y: Signed) -> Signed:
        return -self._shared(Op.PAIR, -x, -y) if x < 0 else self._shared(Op.PAIR, x, y)

    def part(self, op: Op, pair: Signed) -> Signed:
        """The FIRST or SECOND number of a pair."""
        return -self._shared(op, -pair) if pair < 0 else self._shared(op, pair)

    def operands(self, node: int) -> tuple[int, ...]:
        """The numbers of the nodes that a node is made of."""
        if self.op[node] in LEAVES:
            return ()
        a = abs(self.a[node])
        return (a, abs(self.b[node])) if self.op[node] in BINARY else (a,)

    def reach(self, results: Iterable[Signed]) -> list[int]:
        """All nodes that some results need; what a node is made of stands before it."""
        stack = [abs(x) for x in results]
        nodes = set(stack)
        while stack:
            new = [x for x in self.operands(stack.pop()) if x not in nodes]
            nodes.update(new)
            stack += new
        return sorted(nodes)


class Expr:
    """An expression of a graph; never zero, and never a constant: these are Python's numbers."""

    __slots__ = ("graph", "node")

    def __init__(self, graph: Graph, node: Signed) -> None:
        self.graph, self.node = graph, node

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expr) and self.node == other.node

    def __hash__(self) -> int:
        return hash(self.node)

    def __neg__(self) -> Expr:
        return Expr(self.graph, -self.node)

    def __add__(self, other: Scalar) -> Scalar:
        if not other:
            return self
        graph = self.graph
        node = graph.add(self.node, other.node if type(other) is Expr else graph.number(other))
        return Expr(graph, node) if node else 0

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        return self + -other

    def __rsub__(self, other: float) -> Scalar:
        return -self + other

    def __mul__(self, other: Scalar) -> Scalar:
        graph = self.graph
        if type(other) is Expr:
            return Expr(graph, graph.mul(self.node, other.node))
        if isinstance(other, tuple):
            return NotImplemented  # a vector multiplies each of its elements
        return Expr(graph, graph.mul(self.node, graph.number(other))) if other else 0

    __rmul__ = __mul__

    def __rtruediv__(self, other: float) -> Expr:
        return Expr(self.graph, self.graph.div(self.graph.constant(other), self.node))


#: An expression, or a number.
Scalar = Expr | float


def sine(x: Scalar) -> Scalar:
    return Expr(x.graph, x.graph.sin(x.node)) if isinstance(x, Expr) else _exact(math.sin(x), x)


def cosine(x: Scalar) -> Scalar:
    return Expr(x.graph, x.graph.cos(x.node)) if isinstance(x, Expr) else _exact(math.cos(x), x)


def root(x: Scalar) -> Scalar:
    return Expr(x.graph, x.graph.sqrt(x.node)) if isinstance(x, Expr) else math.sqrt(x)


#: An angle within this share of a multiple of 90 degrees counts as this multiple.
RIGHT = 2.0**-52


def _exact(value: float, angle: float) -> float:
    """The sine or cosine of an angle (rad), exact where the angle is a multiple of 90 degrees."""
    if abs(value) < RIGHT * abs(angle):
        return 0.0
    return math.copysign(1.0, value) if 1.0 - abs(value) < RIGHT else value
