"""Derivatives of expressions: forward differentiation on the graph.

What is equal is one node there, so that the derivatives by all variables share what they can
(Griewank and Walther, Evaluating Derivatives, 2008, chapter 3).
"""

from __future__ import annotations

from collections.abc import Iterable

from urdf2mbs.equations.graph import BINARY, LEAVES, Expr, Graph, Op


def jacobian(graph: Graph, values: list[Expr], variables: Iterable[Expr]) -> list[list[Expr]]:
    """For each of the variables (symbols, or what is constant) the derivatives of the values."""
    order = reach(graph, values)
    return [_tangents(graph, order, values, variable) for variable in variables]


def reach(graph: Graph, values: list[Expr]) -> list[int]:
    """All nodes that some values need; what a node is made of stands before it."""
    nodes = {abs(value) for value in values}
    stack = list(nodes)
    while stack:
        for x in _operands(graph, stack.pop()):
            if abs(x) not in nodes:
                nodes.add(abs(x))
                stack.append(abs(x))
    return sorted(nodes)


def _operands(graph: Graph, node: int) -> tuple[Expr, ...]:
    op = graph.op[node]
    if op in LEAVES:
        return ()
    return (graph.a[node], graph.b[node]) if op in BINARY else (graph.a[node],)


def _tangents(graph: Graph, order: list[int], values: list[Expr], variable: Expr) -> list[Expr]:
    known: dict[int, Expr] = {}
    if variable and graph.op[abs(variable)] == Op.SYMBOL:
        known[abs(variable)] = 1 if variable > 0 else -1

    def of(x: Expr) -> Expr:
        return known.get(abs(x), 0) if x > 0 else -known.get(abs(x), 0)

    for node in order:
        changes = [of(x) for x in _operands(graph, node)]
        if any(changes):
            known[node] = _rule(graph, node, *changes)
    return [of(value) for value in values]


def _rule(graph: Graph, node: int, da: Expr, db: Expr = 0) -> Expr:
    """The derivative of a node from those of its operands."""
    mul, op, a, b = graph.mul, graph.op[node], graph.a[node], graph.b[node]
    if op == Op.ADD:
        return graph.add(da, db)
    if op == Op.MUL:
        return graph.add(mul(da, b), mul(a, db))
    if op == Op.DIV:
        return graph.div(graph.sub(da, mul(node, db)), b)
    if op == Op.SIN:
        return mul(graph.cos(a), da)
    if op == Op.COS:
        return -mul(graph.sin(a), da)
    if op == Op.SQRT:
        return graph.div(da, mul(graph.constant(2.0), node))
    raise ValueError(f"no derivative of {op.name}")
