"""Mirrored limbs in pairs: one operation on two numbers does the work of left and right.

Two mirrored joints need the same operations on other numbers.  From their results down to the
data both ways are followed at once, as long as both do the same; two nodes that are found so
are twins, and become one node that computes both.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush

from urdf2mbs_equations.graph import BINARY, LEAVES, Graph, Op, Signed
from urdf2mbs_equations.routine import Routine, Store


@dataclass
class Twin:
    """The second of two nodes that do the same, and how."""

    node: int
    operands: tuple[Signed, Signed]
    """In the order of those of the first node."""


def in_pairs(routine: Routine) -> Routine:
    """The routine with pairs where it pays."""
    graph = routine.graph
    stores = [step for step in routine.steps if isinstance(step, Store)]
    used = graph.reach(store.value for store in stores)
    twins = _twins(graph, used, routine.alike)
    writer = _Writer(graph, twins)
    for node in _order(graph, used, twins):
        writer.make(node)
    return Routine(graph, [Store(store.places, writer.scalar(store.value)) for store in stores])


def _shapes(graph: Graph, used: list[int]) -> dict[int, int]:
    """A number for each node, the same for nodes that do the same with other data."""
    known: dict[tuple[object, ...], int] = {}
    out: dict[int, int] = {}
    for node in used:
        op = graph.op[node]
        key: tuple[object, ...] = (op, *sorted(out[x] for x in graph.operands(node)))
        if op == Op.SYMBOL:  # the number of the joint is the last index
            key = (op, graph.name[node].rpartition("[")[0])
        out[node] = known.setdefault(key, len(known))
    return out


def _twins(graph: Graph, used: list[int], alike: list[tuple[Signed, Signed]]) -> dict[int, Twin]:
    """By the first of two nodes the second, from the results down to the data."""
    shapes, op = _shapes(graph, used), graph.op

    def likeness(m: int, n: int) -> int:
        return 2 * (m == n) + (shapes[m] == shapes[n])

    # what a node is made of has lower numbers: once the highest are done, they do not come again
    heap = [(-max(abs(x), abs(y)), abs(x), abs(y)) for x, y in alike]
    heapify(heap)
    paired: set[int] = set()
    out: dict[int, Twin] = {}
    while heap:
        _, m, n = heappop(heap)
        if m == n or m in paired or n in paired or op[m] != op[n] or op[m] in LEAVES:
            continue
        paired |= {m, n}
        x, y, u, v = abs(graph.a[m]), abs(graph.b[m]), graph.a[n], graph.b[n]
        if op[m] in (Op.ADD, Op.MUL, Op.PAIR) and (
            likeness(x, abs(v)) + likeness(y, abs(u)) > likeness(x, abs(u)) + likeness(y, abs(v))
        ):
            u, v = v, u
        out[m] = Twin(n, (u, v))
        for first, second in ((x, abs(u)), (y, abs(v))):
            heappush(heap, (-max(first, second), first, second))
    return _linked(graph, out)


def _linked(graph: Graph, twins: dict[int, Twin]) -> dict[int, Twin]:
    """Without twins that neither are made of twins nor make any: these would not pay."""
    linked: set[int] = set()
    for m, twin in twins.items():
        for x, u in zip(graph.operands(m), twin.operands, strict=False):
            if x in twins and twins[x].node == abs(u):
                linked |= {m, x}
    return {m: twin for m, twin in twins.items() if m in linked}


def _order(graph: Graph, used: list[int], twins: dict[int, Twin]) -> list[int]:
    """All nodes, twins by the first of them, what each is made of before it.

    Where twins need each other's results, they are taken apart.
    """
    first = {twin.node: node for node, twin in twins.items()}
    users: dict[int, list[int]] = {node: [] for node in used}
    missing: dict[int, int] = {}
    for node in used:
        operands = graph.operands(node)
        for x in operands:
            users[x].append(node)
        missing[node] = len(operands)
    ready = [node for node in reversed(used) if not missing[node]]
    done: set[int] = set()
    out: list[int] = []
    lowest = 0
    while True:
        if not ready:
            while lowest < len(used) and used[lowest] in done:
                lowest += 1
            if lowest == len(used):
                return out
            # all that the lowest node is made of is done, so it waits for its twin only
            node = first.pop(used[lowest], used[lowest])
            second = twins.pop(node).node
            first.pop(second, None)
            ready = [node, second]
        node = ready.pop()
        node = first.get(node, node)
        both = (node, twins[node].node) if node in twins else (node,)
        if node in done or any(missing[x] for x in both):
            continue
        out.append(node)
        done.update(both)
        for x in both:
            for user in users[x]:
                missing[user] -= 1
                if not missing[user]:
                    ready.append(user)


class _Writer:
    """Makes the nodes anew."""

    def __init__(self, graph: Graph, twins: dict[int, Twin]) -> None:
        self.graph, self.twins = graph, twins
        self.first = {twin.node: node for node, twin in twins.items()}
        self.scalars: dict[int, Signed] = {0: 0}
        self.pairs: dict[int, tuple[Signed, int]] = {}
        """By the first of two twins: a pair of it and the second, this one times a sign, 1 or
        -1, and the sign."""

    def make(self, node: int) -> None:
        """All that the node is made of must be made."""
        if self.graph.op[node] in LEAVES:
            self.scalars[node] = node
        elif node in self.twins:
            self.pairs[node] = self._twins(node, self.twins[node])
        else:
            self.scalars[node] = self._single(node)

    def _single(self, node: int) -> Signed:
        graph = self.graph
        return graph.apply(graph.op[node], self.scalar(graph.a[node]), self.scalar(graph.b[node]))

    def scalar(self, x: Signed) -> Signed:
        """An expression of the routine that was given, in the new one."""
        node = abs(x)
        if node not in self.scalars:
            if node in self.first:
                both, sign = self.pairs[self.first[node]]
                self.scalars[node] = sign * self.graph.part(Op.SECOND, both)
            else:
                self.scalars[node] = self.graph.part(Op.FIRST, self.pairs[node][0])
        return self.scalars[node] if x > 0 else -self.scalars[node]

    def _twins(self, node: int, twin: Twin) -> tuple[Signed, int]:
        graph, op = self.graph, self.graph.op[node]
        if op not in BINARY:
            return graph.pair(self._single(node), self._single(twin.node)), 1
        x, sign = self._both(graph.a[node], twin.operands[0])
        y, sign_of_y = self._both(graph.b[node], twin.operands[1])
        if op != Op.ADD:
            return graph.apply(op, x, y), sign * sign_of_y
        if sign != sign_of_y:
            y = graph.mul(y, graph.pair(1, -1))  # the second is reversed
        return graph.add(x, y), sign

    def _both(self, x: Signed, y: Signed) -> tuple[Signed, int]:
        """A pair of x and y times a sign, and the sign; if they are equal, a number for both."""
        node, second = abs(x), abs(y)
        turned = 1 if x > 0 else -1
        same = 1 if (x > 0) == (y > 0) else -1
        if node == second:
            return self.scalar(x), same
        if node in self.twins and self.twins[node].node == second:
            both, sign = self.pairs[node]
            return turned * both, sign * same
        return self.graph.pair(self.scalar(x), self.scalar(y)), 1
