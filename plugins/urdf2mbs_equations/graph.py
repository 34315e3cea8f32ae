"""Symbolic expressions as a graph in which equal expressions are one node.

``Expr`` has operators: ``a + b``, ``2 * a``.  Inside the graph an expression is a signed node: the
number of its node, negated for the opposite expression; 0 is zero and 1 is one.  An operation with
the same operands returns the same node (hash-consing).  With ``x`` and ``y`` the nodes 5 and 6::

    x + y     ADD(5, 6)  = node 7        y + x     node 7
    x - y     ADD(5, -6) = node 8        y - x     -8, the opposite of node 8
    -x - y    -7                         (x + y) * 1    node 7

So zeros, ones and changes of sign cost no operation, and a subexpression that many results need is
computed once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import IntEnum

#: The number of a node, negative for the opposite expression; 0 is the expression zero.
SignedNode = int


class Op(IntEnum):
    """The kinds of nodes; constants, symbols and inputs are leaves, which compute nothing."""

    CONSTANT = 0
    SYMBOL = 1
    INPUT = 2
    ADD = 3
    MUL = 4
    DIV = 5
    SIN = 6
    COS = 7
    SQRT = 8
    PAIR = 9
    """Two numbers as one operand of vector instructions: see ``pairs``, which makes them."""
    FIRST = 10
    """The first number of a pair."""
    SECOND = 11
    """The second number of a pair."""


LEAVES = frozenset([Op.CONSTANT, Op.SYMBOL, Op.INPUT])
#: Operations with two operands; all others have one.
BINARY = frozenset([Op.ADD, Op.MUL, Op.DIV, Op.PAIR])


class Graph:
    """Nodes in the order in which they were made: the operands of a node precede it.

    The attributes are parallel lists, indexed by node.
    """

    def __init__(self) -> None:
        self.op: list[Op] = [Op.CONSTANT, Op.CONSTANT]
        self.left: list[SignedNode] = [0, 0]
        """First operand; positive in sums and products."""
        self.right: list[SignedNode] = [0, 0]
        """Second operand; 0 if there is only one."""
        self.value: list[float] = [0.0, 1.0]
        """Value of a constant, which is not negative."""
        self.name = ["0", "1"]
        """Name of a symbol or input, as in ``q[3]``."""
        self._operations: dict[tuple[Op, SignedNode, SignedNode], int] = {}
        self._constants = {1.0: 1}
        self._symbols: dict[str, int] = {}

    def _append(
        self,
        op: Op,
        left: SignedNode = 0,
        right: SignedNode = 0,
        *,
        value: float = 0.0,
        name: str = "",
    ) -> int:
        self.op.append(op)
        self.left.append(left)
        self.right.append(right)
        self.value.append(value)
        self.name.append(name)
        return len(self.op) - 1

    def _operate(self, op: Op, left: SignedNode, right: SignedNode = 0) -> int:
        """Return the node of an operation, which is made only once."""
        key = (op, left, right)
        node = self._operations.get(key)
        if node is None:
            node = self._operations[key] = self._append(op, left, right)
        return node

    def to_node(self, scalar: Scalar) -> SignedNode:
        """Return the signed node of an expression or a number."""
        return scalar.node if isinstance(scalar, Expr) else self.make_constant(scalar)

    def make_constant(self, value: float) -> SignedNode:
        """Return the signed node of a number."""
        if value == 0.0:
            return 0
        magnitude = abs(value)
        node = self._constants.get(magnitude)
        if node is None:
            node = self._constants[magnitude] = self._append(Op.CONSTANT, value=magnitude)
        return node if value > 0.0 else -node

    def make_symbol(self, name: str) -> Expr:
        """Return the expression that reads a number of the model's data, such as ``q[3]``."""
        node = self._symbols.get(name)
        if node is None:
            node = self._symbols[name] = self._append(Op.SYMBOL, name=name)
        return Expr(self, node)

    def make_input(self, name: str) -> Expr:
        """Return an expression for a result of a user function, equal to no other expression."""
        return Expr(self, self._append(Op.INPUT, name=name))

    def add(self, left: SignedNode, right: SignedNode) -> SignedNode:
        """Return the sum of two nodes."""
        if left == 0 or right == 0:
            return left or right
        if left == -right:
            return 0
        if left == right:
            return self.mul(self.make_constant(2.0), left)
        if abs(left) > abs(right):
            left, right = right, left
        if left < 0:
            return -self._operate(Op.ADD, -left, -right)
        return self._operate(Op.ADD, left, right)

    def mul(self, left: SignedNode, right: SignedNode) -> SignedNode:
        """Return the product of two nodes; constant factors are multiplied."""
        if left == 0 or right == 0:
            return 0
        if (left > 0) != (right > 0):
            return -self.mul(abs(left), abs(right))
        left, right = sorted((abs(left), abs(right)))
        if left == 1:
            return right
        op = self.op
        if op[right] == Op.CONSTANT:
            left, right = right, left
        if op[left] == Op.CONSTANT and op[right] == Op.MUL:
            factor = self.left[right]
            if op[factor] == Op.CONSTANT:  # 2 * (3 * x) is 6 * x
                product = self.make_constant(self.value[left] * self.value[factor])
                return self.mul(product, self.right[right])
        return self._operate(Op.MUL, left, right)

    def div(self, left: SignedNode, right: SignedNode) -> SignedNode:
        """Return the quotient of two nodes."""
        if left == 0:
            return 0
        node = self._operate(Op.DIV, abs(left), abs(right))
        return node if (left > 0) == (right > 0) else -node

    def sin(self, angle: SignedNode) -> SignedNode:
        """Return the sine of a node (rad); ``sin(-x)`` is ``-sin(x)``."""
        return self._operate(Op.SIN, angle) if angle > 0 else -self._operate(Op.SIN, -angle)

    def cos(self, angle: SignedNode) -> SignedNode:
        """Return the cosine of a node (rad); ``cos(-x)`` is ``cos(x)``."""
        return self._operate(Op.COS, abs(angle))

    def sqrt(self, square: SignedNode) -> SignedNode:
        """Return the square root of a node."""
        return self._operate(Op.SQRT, square)

    def pair(self, first: SignedNode, second: SignedNode) -> SignedNode:
        """Return two numbers as one operand; an operation on pairs is done on both numbers.

        A single number beside a pair stands for two equal ones.
        """
        if first < 0:
            return -self._operate(Op.PAIR, -first, -second)
        return self._operate(Op.PAIR, first, second)

    def get_part(self, part: Op, pair: SignedNode) -> SignedNode:
        """Return the FIRST or the SECOND number of a pair."""
        return -self._operate(part, -pair) if pair < 0 else self._operate(part, pair)

    def apply(self, op: Op, left: SignedNode, right: SignedNode) -> SignedNode:
        """Return the result of any operation; ``right`` is ignored if it has one operand."""
        function = getattr(self, op.name.lower())
        return int(function(left, right) if op in BINARY else function(left))

    def list_operands(self, node: int) -> tuple[int, ...]:
        """Return the nodes of the operands of a node, without their signs."""
        if self.op[node] in LEAVES:
            return ()
        left = abs(self.left[node])
        return (left, abs(self.right[node])) if self.op[node] in BINARY else (left,)

    def find_dependencies(self, results: Iterable[SignedNode]) -> list[int]:
        """Return all nodes that results depend on, the operands of a node before it."""
        stack = [abs(result) for result in results]
        nodes = set(stack)
        while stack:
            new = [node for node in self.list_operands(stack.pop()) if node not in nodes]
            nodes.update(new)
            stack += new
        return sorted(nodes)


class Expr:
    """An expression of a graph.

    Results that are zero or constant are Python's numbers where possible: ``x - x`` is 0.
    """

    __slots__ = ("graph", "node")

    def __init__(self, graph: Graph, node: SignedNode) -> None:
        self.graph, self.node = graph, node

    def __eq__(self, value: object) -> bool:
        return isinstance(value, Expr) and self.node == value.node

    def __hash__(self) -> int:
        return hash(self.node)

    def __neg__(self) -> Expr:
        return Expr(self.graph, -self.node)

    def __add__(self, term: Scalar) -> Scalar:
        if not term:
            return self
        graph = self.graph
        node = graph.add(self.node, term.node if type(term) is Expr else graph.to_node(term))
        return Expr(graph, node) if node else 0

    __radd__ = __add__

    def __sub__(self, term: Scalar) -> Scalar:
        return self + -term

    def __rsub__(self, minuend: float) -> Scalar:
        return -self + minuend

    def __mul__(self, factor: Scalar) -> Scalar:
        graph = self.graph
        if type(factor) is Expr:
            return Expr(graph, graph.mul(self.node, factor.node))
        if isinstance(factor, tuple):
            return NotImplemented  # a vector multiplies each of its elements
        return Expr(graph, graph.mul(self.node, graph.to_node(factor))) if factor else 0

    __rmul__ = __mul__

    def __rtruediv__(self, dividend: float) -> Expr:
        return Expr(self.graph, self.graph.div(self.graph.make_constant(dividend), self.node))


#: An expression, or a number.
Scalar = Expr | float


def sine(angle: Scalar) -> Scalar:
    """Return the sine of an angle (rad)."""
    if isinstance(angle, Expr):
        return Expr(angle.graph, angle.graph.sin(angle.node))
    return _snap_to_right_angle(math.sin(angle), angle)


def cosine(angle: Scalar) -> Scalar:
    """Return the cosine of an angle (rad)."""
    if isinstance(angle, Expr):
        return Expr(angle.graph, angle.graph.cos(angle.node))
    return _snap_to_right_angle(math.cos(angle), angle)


def square_root(square: Scalar) -> Scalar:
    """Return the square root of an expression or a number."""
    if isinstance(square, Expr):
        return Expr(square.graph, square.graph.sqrt(square.node))
    return math.sqrt(square)


#: An angle that differs from a multiple of 90 degrees by less than this, relative to the angle, is
#: treated as this multiple.
RIGHT_ANGLE_TOLERANCE = 2.0**-52


def _snap_to_right_angle(value: float, angle: float) -> float:
    """Return a sine or cosine of an angle (rad), exact if the angle is a multiple of 90 degrees."""
    if abs(value) < RIGHT_ANGLE_TOLERANCE * abs(angle):
        return 0.0
    return math.copysign(1.0, value) if 1.0 - abs(value) < RIGHT_ANGLE_TOLERANCE else value
