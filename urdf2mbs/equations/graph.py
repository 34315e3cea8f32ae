"""Expressions as a graph, in which what is equal is one node.

An expression is a whole number: the number of its node, negative for the expression with the
opposite sign, 0 for zero, 1 for one.  So zeros, ones and signs cost nothing, ``a - b`` and
``b - a`` are one node, and two equal expressions are the same number (hash-consing).
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum
from math import cos, sin, sqrt

#: An expression of a graph.
Expr = int

#: The operations; constants, symbols and inputs are not computed.
Op = IntEnum("Op", "CONST SYMBOL INPUT ADD MUL DIV SIN COS SQRT PAIR FIRST SECOND", start=0)
LEAVES = frozenset([Op.CONST, Op.SYMBOL, Op.INPUT])
#: Those of two operands; the rest has one.
BINARY = frozenset([Op.ADD, Op.MUL, Op.DIV, Op.PAIR])


class Graph:
    """Nodes in the order in which they were made: what a node needs stands before it."""

    def __init__(self) -> None:
        self.op: list[Op] = [Op.CONST, Op.CONST]
        self.a: list[Expr] = [0, 0]
        """The first operand; of a sum and a product always positive."""
        self.b: list[Expr] = [0, 0]
        self.value: list[float] = [0.0, 1.0]
        """Of a constant; never negative."""
        self.name = ["0", "1"]
        """Of a symbol, as in ``q[3]``."""
        self._known: dict[tuple[Op, Expr, Expr], int] = {}
        self._constants = {1.0: 1}
        self._symbols: dict[str, int] = {}

    def _node(self, op: Op, a: Expr, b: Expr = 0, value: float = 0.0, name: str = "") -> int:
        self.op.append(op)
        self.a.append(a)
        self.b.append(b)
        self.value.append(value)
        self.name.append(name)
        return len(self.op) - 1

    def constant(self, value: float) -> Expr:
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
        return node

    def add(self, x: Expr, y: Expr) -> Expr:
        if x == 0 or y == 0:
            return x or y
        if x == -y:
            return 0
        if x == y:
            return self.mul(self.constant(2.0), x)
        if abs(x) > abs(y):
            x, y = y, x
        if x < 0:
            return -self.add(-x, -y)
        if self.op[x] == Op.CONST and self.op[abs(y)] == Op.CONST:
            return self.constant(self.value[x] + (self.value[y] if y > 0 else -self.value[-y]))
        return self._shared(Op.ADD, x, y)

    def sub(self, x: Expr, y: Expr) -> Expr:
        return self.add(x, -y)

    def mul(self, x: Expr, y: Expr) -> Expr:
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
        if op[x] == Op.CONST:
            if op[y] == Op.CONST:
                return self.constant(self.value[x] * self.value[y])
            if op[y] == Op.MUL and op[a[y]] == Op.CONST:
                return self.mul(self.constant(self.value[x] * self.value[a[y]]), self.b[y])
        return self._shared(Op.MUL, x, y)

    def div(self, x: Expr, y: Expr) -> Expr:
        if x == 0:
            return 0
        if self.op[abs(y)] == Op.CONST:
            return self.mul(x, self.constant(1.0 / self.value[abs(y)] * (1 if y > 0 else -1)))
        node = self._shared(Op.DIV, abs(x), abs(y))
        return node if (x > 0) == (y > 0) else -node

    def sin(self, x: Expr) -> Expr:
        """The sine; of a constant within a rounding of a multiple of 90 degrees, exact."""
        return self._turn(Op.SIN, x) if x > 0 else -self._turn(Op.SIN, -x)

    def cos(self, x: Expr) -> Expr:
        return self._turn(Op.COS, abs(x))

    def _turn(self, op: Op, x: Expr) -> Expr:
        if self.op[x] != Op.CONST:
            return self._shared(op, x)
        value = sin(self.value[x]) if op == Op.SIN else cos(self.value[x])
        if abs(value) < RIGHT * self.value[x]:
            value = 0.0
        elif 1.0 - abs(value) < RIGHT:
            value = 1.0 if value > 0.0 else -1.0
        return self.constant(value)

    def sqrt(self, x: Expr) -> Expr:
        return (
            self.constant(sqrt(self.value[x]))
            if self.op[x] == Op.CONST
            else self._shared(Op.SQRT, x)
        )

    def apply(self, op: Op, x: Expr, y: Expr) -> Expr:
        """An operation of one operand (``y`` does not count) or of two."""
        two = {Op.ADD: self.add, Op.MUL: self.mul, Op.DIV: self.div, Op.PAIR: self.pair}
        if op in two:
            return two[op](x, y)
        return {Op.SIN: self.sin, Op.COS: self.cos, Op.SQRT: self.sqrt}[op](x)

    # Two numbers as one, for processors that do the same with both in one step.  What is done
    # with a pair is done with both; a single number may stand in for two equal ones.

    def pair(self, x: Expr, y: Expr) -> Expr:
        return -self._shared(Op.PAIR, -x, -y) if x < 0 else self._shared(Op.PAIR, x, y)

    def part(self, op: Op, pair: Expr) -> Expr:
        """The FIRST or SECOND number of a pair."""
        return -self._shared(op, -pair) if pair < 0 else self._shared(op, pair)

    def _shared(self, op: Op, x: Expr, y: Expr = 0) -> Expr:
        """The node of an operation, made only once."""
        key = (op, x, y)
        node = self._known.get(key)
        if node is None:
            node = self._known[key] = self._node(op, x, y)
        return node

    def input(self, name: str) -> Expr:
        """A value that a call of a user function gives: it is never equal to another."""
        return self._node(Op.INPUT, 0, name=name)

    def operands(self, node: int) -> tuple[int, ...]:
        """The numbers of the nodes that a node is made of."""
        if self.op[node] in LEAVES:
            return ()
        a = abs(self.a[node])
        return (a, abs(self.b[node])) if self.op[node] in BINARY else (a,)

    def reach(self, results: Iterable[Expr]) -> list[int]:
        """All nodes that some results need; what a node is made of stands before it."""
        stack = [abs(x) for x in results]
        nodes = set(stack)
        while stack:
            new = [x for x in self.operands(stack.pop()) if x not in nodes]
            nodes.update(new)
            stack += new
        return sorted(nodes)


#: An angle that is nearest to a multiple of 90 degrees, as numbers of 53 bits go, is that multiple.
RIGHT = 2.0**-52
