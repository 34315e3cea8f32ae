"""Expressions as a graph, in which what is equal is one node.

An expression is a whole number: the number of its node, negative for the expression with the
opposite sign, 0 for zero, 1 for one.  So zeros, ones and signs cost nothing, ``a - b`` and
``b - a`` are one node, and two equal expressions are the same number (hash-consing).
"""

from __future__ import annotations

from math import cos, sin, sqrt

#: An expression of a graph.
Expr = int

#: The operations.  CONST and SYMBOL are what is not computed.
CONST, SYMBOL, ADD, MUL, DIV, SIN, COS, SQRT, INPUT, PAIR, FIRST, SECOND = range(12)
LEAVES = frozenset([CONST, SYMBOL, INPUT])
#: Those of two operands; the rest has one.
BINARY = frozenset([ADD, MUL, DIV, PAIR])


class Graph:
    """Nodes in the order in which they were made: what a node needs stands before it."""

    def __init__(self) -> None:
        self.op = [CONST, CONST]
        self.a: list[Expr] = [0, 0]
        """The first operand; of a sum and a product always positive."""
        self.b: list[Expr] = [0, 0]
        self.value: list[float] = [0.0, 1.0]
        """Of a constant; never negative."""
        self.name = ["0", "1"]
        """Of a symbol, as in ``q[3]``."""
        self._known: dict[tuple[int, int, int], int] = {}
        self._constants = {1.0: 1}
        self._symbols: dict[str, int] = {}

    def _node(self, op: int, a: Expr, b: Expr = 0, value: float = 0.0, name: str = "") -> int:
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
            node = self._constants[size] = self._node(CONST, 0, value=size)
        return node if value > 0.0 else -node

    def symbol(self, name: str) -> Expr:
        node = self._symbols.get(name)
        if node is None:
            node = self._symbols[name] = self._node(SYMBOL, 0, name=name)
        return node

    def add(self, x: Expr, y: Expr) -> Expr:
        if x == 0:
            return y
        if y == 0:
            return x
        if x == -y:
            return 0
        if x == y:
            return self.mul(self.constant(2.0), x)
        if abs(x) > abs(y):
            x, y = y, x
        if x < 0:
            return -self._add(-x, -y)
        return self._add(x, y)

    def _add(self, x: Expr, y: Expr) -> Expr:
        key = (ADD, x, y)
        node = self._known.get(key)
        if node is None:
            if self.op[x] == CONST and self.op[abs(y)] == CONST:
                return self.constant(self.value[x] + (self.value[y] if y > 0 else -self.value[-y]))
            node = self._known[key] = self._node(ADD, x, y)
        return node

    def sub(self, x: Expr, y: Expr) -> Expr:
        return self.add(x, -y)

    def mul(self, x: Expr, y: Expr) -> Expr:
        if x == 0 or y == 0:
            return 0
        positive = (x > 0) == (y > 0)
        x, y = abs(x), abs(y)
        if x > y:
            x, y = y, x
        if x == 1:
            return y if positive else -y
        key = (MUL, x, y)
        node = self._known.get(key)
        if node is None:
            node = self._known[key] = self._mul(x, y)
        return node if positive else -node

    def _mul(self, x: Expr, y: Expr) -> Expr:
        op, a = self.op, self.a
        if op[y] == CONST:
            x, y = y, x
        if op[x] == CONST:
            if op[y] == CONST:
                return self.constant(self.value[x] * self.value[y])
            if op[y] == MUL and op[a[y]] == CONST:
                scale = self.constant(self.value[x] * self.value[a[y]])
                return self.mul(scale, self.b[y])
        return self._node(MUL, x, y)

    def div(self, x: Expr, y: Expr) -> Expr:
        if x == 0:
            return 0
        if self.op[abs(y)] == CONST:
            return self.mul(x, self.constant(1.0 / self.value[abs(y)] * (1 if y > 0 else -1)))
        positive = (x > 0) == (y > 0)
        x, y = abs(x), abs(y)
        key = (DIV, x, y)
        node = self._known.get(key)
        if node is None:
            node = self._known[key] = self._node(DIV, x, y)
        return node if positive else -node

    def sin(self, x: Expr) -> Expr:
        """The sine; of a constant within a rounding of a multiple of 90 degrees, exact."""
        if x <= 0:
            return -self.sin(-x) if x else 0
        return self._function(SIN, x)

    def cos(self, x: Expr) -> Expr:
        return self._function(COS, abs(x)) if x else 1

    def sqrt(self, x: Expr) -> Expr:
        return self._function(SQRT, x)

    def _function(self, op: int, x: Expr) -> Expr:
        key = (op, x, 0)
        node = self._known.get(key)
        if node is None:
            if self.op[x] == CONST:
                value = {SIN: sin, COS: cos, SQRT: sqrt}[op](self.value[x])
                if op != SQRT and abs(value) < RIGHT * self.value[x]:
                    value = 0.0
                elif op != SQRT and 1.0 - abs(value) < RIGHT:
                    value = 1.0 if value > 0.0 else -1.0
                node = self.constant(value)
            else:
                node = self._node(op, x)
            self._known[key] = node
        return node

    def apply(self, op: int, x: Expr, y: Expr) -> Expr:
        """An operation of one operand (``y`` does not count) or of two."""
        two = {ADD: self.add, MUL: self.mul, DIV: self.div, PAIR: self.pair}
        if op in two:
            return two[op](x, y)
        return {SIN: self.sin, COS: self.cos, SQRT: self.sqrt}[op](x)

    # Two numbers as one, for processors that do the same with both in one step.  What is done
    # with a pair is done with both; a single number may stand in for two equal ones.

    def pair(self, x: Expr, y: Expr) -> Expr:
        if x < 0:
            return -self._shared(PAIR, -x, -y)
        return self._shared(PAIR, x, y)

    def first(self, pair: Expr) -> Expr:
        return self._of_pair(FIRST, pair)

    def second(self, pair: Expr) -> Expr:
        return self._of_pair(SECOND, pair)

    def _of_pair(self, op: int, pair: Expr) -> Expr:
        if pair <= 0:
            return -self._of_pair(op, -pair) if pair else 0
        return self._shared(op, pair)

    def _shared(self, op: int, x: Expr, y: Expr = 0) -> Expr:
        key = (op, x, y)
        node = self._known.get(key)
        if node is None:
            node = self._known[key] = self._node(op, x, y)
        return node

    def input(self, name: str) -> Expr:
        """A value that a call of a user function gives: it is never equal to another."""
        return self._node(INPUT, 0, name=name)


#: An angle that is nearest to a multiple of 90 degrees, as numbers of 53 bits go, is that multiple.
RIGHT = 2.0**-52
