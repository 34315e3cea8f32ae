r"""Mirrored limbs in pairs, for C: one vector instruction computes left and right.

A reader may skip this file: without it (``pairs: false``) all equations are the same, and C is 1.2
to 1.5 times slower for humanoids.  Two arms or legs need the same operations on different numbers.
gcc and clang have vectors of two numbers, so a pair costs no more than one number::

    left:   x1 = m[7] * C5                   pair:  x1 = PAIR(m[7], m[12]) * PAIR(C5, C10)
    right:  x2 = m[12] * C10

1. ``find_mirrored`` finds which joints are mirrored, from the shape of the tree alone.  A URDF may
   name the axes of left and right frames differently.  So that their equations have the same form,
   the frames of the second limb get axes in another order, which costs no operation::

                    base                     twins: 1 and 4, 2 and 5, 3 and 6
                   /    \
             1 R2 o      o 4 R1              frame 4: the axes in the order (y, x, -z),
                  |      |                   so that its joint turns about its second axis, too
             2 R1 o      o 5 R2
                  |      |
             3 T3 o      o 6 T3

2. The results of twins are marked in the routine (``Routine.mark_mirrored``).

3. ``pair_mirrored`` follows two marked results down to the data, as long as both are made by the
   same operation.  Such two nodes become one node that computes both numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from itertools import permutations, product
from typing import NamedTuple

from urdf2mbs_equations.graph import BINARY, LEAVES, Graph, Op, SignedNode
from urdf2mbs_equations.routine import Routine, Store
from urdf2mbs_equations.tree import Frame, Tree, is_fixed
from urdf2mbs_equations.vectors import SAME_AXES, AxisPermutation

# --- which joints are mirrored ---

#: All permutations of the axes of a frame that are rotations.
RIGHT_HANDED = [
    AxisPermutation(((i, a), (j, b), (k, c)))
    for i, j, k in permutations(range(3))
    for a, b, c in product((1, -1), repeat=3)
    if a * b * c == (1 if (j - i) % 3 == 1 else -1)
]


class Mirrored(NamedTuple):
    """The mirrored joints of a tree."""

    twin: dict[int, int]
    """By joint number, the number of the mirrored joint."""
    axes_in_file: dict[int, AxisPermutation]
    """By joint number, the axes of the frames of second limbs (as ``Tree`` takes them)."""


def find_mirrored(tree: Tree) -> Mirrored:
    """Find the mirrored joints of a tree.

    Joints of one kind (revolute, prismatic) with the same parent, or with parents that are twins,
    are twins.  Joints whose subtrees have the same shape are matched first.  Joints that never move
    are passed over.
    """
    finder = _MirrorFinder(tree)
    finder.find()
    return Mirrored(finder.twin, finder.axes_in_file)


class _MirrorFinder:
    def __init__(self, tree: Tree) -> None:
        self.tree, frames = tree, tree.frames
        self.children: list[list[int]] = [[] for _ in frames]
        """By joint, the next joints that move."""
        self.fixed_joints: list[list[Frame]] = [[] for _ in frames]
        """By joint, the joints that never move between it and its last ancestor that moves."""
        for frame in frames[1:]:
            ancestor = frames[frame.parent]
            while ancestor.number and is_fixed(ancestor.joint):
                self.fixed_joints[frame.number].insert(0, ancestor)
                ancestor = frames[ancestor.parent]
            if not is_fixed(frame.joint):
                self.children[ancestor.number].append(frame.number)
        self.shapes = self._number_shapes()
        self.twin: dict[int, int] = {}
        self.axes_in_file: dict[int, AxisPermutation] = {}

    def _number_shapes(self) -> list[int]:
        """Return a number for the subtree of each joint, the same for subtrees of one shape."""
        frames = self.tree.frames
        shapes = [0] * len(frames)
        numbers: dict[tuple[object, ...], int] = {}
        for frame in reversed(frames):
            k = frame.number
            key = frame.is_revolute, *sorted(shapes[child] for child in self.children[k])
            shapes[k] = numbers.setdefault(key, len(numbers))
        return shapes

    def find(self) -> None:
        """Match the children of each joint, or of two twins, from the base to the leaves."""
        stack = [(0, 0)]
        while stack:
            left, right = stack.pop()
            pairs = self._match(self.children[left], self.children[right])
            if left == right:
                matched = {k for pair in pairs for k in pair}
                stack += [(k, k) for k in self.children[left] if k not in matched]
            else:
                self._align(left, right, pairs)
            stack += pairs

    def _match(self, lefts: list[int], rights: list[int]) -> list[tuple[int, int]]:
        """Match the children of two twins, or of one joint: then both lists are the same one."""
        is_same = lefts is rights
        unmatched = list(lefts)
        candidates = unmatched if is_same else list(rights)
        pairs = []
        is_revolute = [frame.is_revolute for frame in self.tree.frames]
        for kind in (self.shapes, is_revolute):
            for left in lefts:
                if left not in unmatched:
                    continue
                right = next(
                    (k for k in candidates if (k > left or not is_same) and kind[left] == kind[k]),
                    None,
                )
                if right is not None:
                    pairs.append((left, right))
                    unmatched.remove(left)
                    candidates.remove(right)
        return pairs

    def _align(self, left: int, right: int, child_pairs: list[tuple[int, int]]) -> None:
        """Choose the axes of the second of two twins, and of the fixed joints before it."""
        frames, lefts, rights = self.tree.frames, self.fixed_joints[left], self.fixed_joints[right]
        is_alike = len(lefts) == len(rights)
        counterparts = lefts if is_alike else [None] * len(rights)
        for frame, counterpart in zip(rights, counterparts, strict=True):
            self._choose_axes(frame, counterpart, [(left, right)])
        self._choose_axes(frames[right], frames[left], child_pairs)

    def _choose_axes(
        self, frame: Frame, counterpart: Frame | None, next_pairs: list[tuple[int, int]]
    ) -> None:
        """Choose axes so that joints have the same axes as in the counterpart.

        First the axis of the frame's own joint, then those of the next joints; if both allow it,
        the axes change as those of the parent do.
        """
        parent_axes = self.axes_in_file.get(frame.parent, SAME_AXES)
        is_quarter_turn = is_fixed(frame.joint) and frame.sine in (0, 1, -1)
        next_axes = []
        if counterpart is not None:
            next_axes = [
                (self._find_axis(right, frame), self._find_axis(left, counterpart))
                for left, right in next_pairs
            ]

        def compute_cost(axes: AxisPermutation) -> tuple[bool, int, bool]:
            new_axis = {old: new for new, (old, _) in enumerate(axes)}
            differs = (
                counterpart is not None
                and not is_quarter_turn
                and new_axis[frame.axis] != counterpart.axis
            )
            n_different = sum(
                1 for right, left in next_axes if right is not None and new_axis[right] != left
            )
            return differs, n_different, axes != parent_axes

        axes = min((axes for axes in RIGHT_HANDED if (frame.axis, 1) in axes), key=compute_cost)
        self.axes_in_file[frame.number] = axes
        if counterpart is not None and axes[counterpart.axis] == (frame.axis, 1):
            self.twin[frame.number] = counterpart.number
            self.twin[counterpart.number] = frame.number

    def _find_axis(self, number: int, frame: Frame) -> int | None:
        """Return which axis of a frame is parallel to the axis of a later joint; None if none is.

        Only joints that never move are between the frame and the joint.
        """
        axis = self.tree.frames[number].joint_axis
        for fixed_joint in reversed(self.fixed_joints[number]):
            if fixed_joint is frame:
                break
            axis = fixed_joint.rotate_to_parent(axis)
        nonzero = [i for i, component in enumerate(axis) if component]
        return nonzero[0] if len(nonzero) == 1 else None


# --- which operations are done in pairs ---


@dataclass
class Twin:
    """The second of two nodes that are made by the same operation."""

    node: int
    operands: tuple[SignedNode, SignedNode]
    """In the order of the operands of the first node."""


def pair_mirrored(routine: Routine) -> Routine:
    """Return a routine that computes the same, in pairs where that saves operations."""
    graph = routine.graph
    stores = [step for step in routine.steps if isinstance(step, Store)]
    nodes = graph.find_dependencies(store.value for store in stores)
    twins = _find_twins(graph, nodes, routine.mirrored)
    builder = _PairBuilder(graph, twins)
    for node in _sort_nodes(graph, nodes, twins):
        builder.build(node)
    return Routine(
        graph, [Store(store.targets, builder.get_number(store.value)) for store in stores]
    )


def _number_forms(graph: Graph, nodes: list[int]) -> dict[int, int]:
    """Return a number for each node, the same for nodes of the same operations on other data."""
    numbers: dict[tuple[object, ...], int] = {}
    forms: dict[int, int] = {}
    for node in nodes:
        op = graph.op[node]
        key: tuple[object, ...] = (
            op,
            *sorted(forms[operand] for operand in graph.list_operands(node)),
        )
        if op == Op.SYMBOL:  # q[3] and q[8] are of one form: the last index is that of the joint
            key = (op, graph.name[node].rpartition("[")[0])
        forms[node] = numbers.setdefault(key, len(numbers))
    return forms


def _find_twins(
    graph: Graph, nodes: list[int], mirrored: Iterable[tuple[SignedNode, SignedNode]]
) -> dict[int, Twin]:
    """Find pairs of nodes, from the results to the data.

    Returns:
        The second node of each pair, by the first.
    """
    forms, op = _number_forms(graph, nodes), graph.op

    def compute_likeness(first: int, second: int) -> int:
        return 2 * (first == second) + (forms[first] == forms[second])

    # Operands have lower numbers than their node: once the highest are done, they never return.
    heap = [(-max(abs(first), abs(second)), abs(first), abs(second)) for first, second in mirrored]
    heapify(heap)
    paired: set[int] = set()
    twins: dict[int, Twin] = {}
    while heap:
        _, first, second = heappop(heap)
        is_pair = op[first] == op[second] and op[first] not in LEAVES
        if first == second or first in paired or second in paired or not is_pair:
            continue
        paired |= {first, second}
        x, y = abs(graph.left[first]), abs(graph.right[first])
        u, v = graph.left[second], graph.right[second]
        if op[first] in (Op.ADD, Op.MUL, Op.PAIR) and (
            compute_likeness(x, abs(v)) + compute_likeness(y, abs(u))
            > compute_likeness(x, abs(u)) + compute_likeness(y, abs(v))
        ):
            u, v = v, u
        twins[first] = Twin(second, (u, v))
        for operand, counterpart in ((x, abs(u)), (y, abs(v))):
            heappush(heap, (-max(operand, counterpart), operand, counterpart))
    return _keep_linked(graph, twins)


def _keep_linked(graph: Graph, twins: dict[int, Twin]) -> dict[int, Twin]:
    """Keep the pairs with an operand or a user that is a pair, too: single ones do not pay."""
    linked: set[int] = set()
    for first, twin in twins.items():
        for operand, counterpart in zip(graph.list_operands(first), twin.operands, strict=False):
            if operand in twins and twins[operand].node == abs(counterpart):
                linked |= {first, operand}
    return {first: twin for first, twin in twins.items() if first in linked}


class _NodeSorter:
    """Sorts nodes so that operands come first, with both nodes of a pair at the same time."""

    def __init__(self, graph: Graph, nodes: list[int], twins: dict[int, Twin]) -> None:
        self.nodes, self.twins = nodes, twins
        self.first = {twin.node: node for node, twin in twins.items()}
        """The first node of a pair, by the second."""
        self.users: dict[int, list[int]] = {node: [] for node in nodes}
        self.n_missing: dict[int, int] = {}
        """By node, the number of operands that are not sorted yet."""
        for node in nodes:
            operands = graph.list_operands(node)
            for operand in operands:
                self.users[operand].append(node)
            self.n_missing[node] = len(operands)
        self.done: set[int] = set()
        self.sorted_nodes: list[int] = []

    def sort(self) -> list[int]:
        ready = [node for node in reversed(self.nodes) if not self.n_missing[node]]
        lowest = 0
        while True:
            if not ready:
                while lowest < len(self.nodes) and self.nodes[lowest] in self.done:
                    lowest += 1
                if lowest == len(self.nodes):
                    return self.sorted_nodes
                ready = self._separate(self.nodes[lowest])
            node = ready.pop()
            node = self.first.get(node, node)
            both = (node, self.twins[node].node) if node in self.twins else (node,)
            if node not in self.done and not any(self.n_missing[each] for each in both):
                self.sorted_nodes.append(node)
                self.done.update(both)
                ready += self._release_users(both)

    def _separate(self, node: int) -> list[int]:
        """Separate a pair whose nodes depend on each other, and return both nodes.

        All operands of ``node`` are sorted, so it waits for its twin only.
        """
        first = self.first.pop(node, node)
        second = self.twins.pop(first).node
        self.first.pop(second, None)
        return [first, second]

    def _release_users(self, nodes: Iterable[int]) -> list[int]:
        """Return the users of nodes whose operands are all sorted now."""
        released = []
        for node in nodes:
            for user in self.users[node]:
                self.n_missing[user] -= 1
                if not self.n_missing[user]:
                    released.append(user)
        return released


def _sort_nodes(graph: Graph, nodes: list[int], twins: dict[int, Twin]) -> list[int]:
    """Return all nodes, of a pair the first, operands first.

    Pairs whose nodes depend on each other are removed from ``twins``.
    """
    return _NodeSorter(graph, nodes, twins).sort()


class _SignedPair(NamedTuple):
    """A pair node ``(x, sign * y)`` that stands for the numbers x and y."""

    node: SignedNode
    sign: int
    """1 or -1."""


class _PairBuilder:
    """Makes the nodes of a routine again, twins as one node."""

    def __init__(self, graph: Graph, twins: dict[int, Twin]) -> None:
        self.graph, self.twins = graph, twins
        self.first = {twin.node: node for node, twin in twins.items()}
        """The first node of a pair, by the second."""
        self.numbers: dict[int, SignedNode] = {0: 0}
        """By node, the new node of the same number."""
        self.pairs: dict[int, _SignedPair] = {}
        """By the first of two twins, the new node of both."""

    def build(self, node: int) -> None:
        """Make a node whose operands are made."""
        if self.graph.op[node] in LEAVES:
            self.numbers[node] = node
        elif node in self.twins:
            self.pairs[node] = self._operate_on_pairs(node, self.twins[node])
        else:
            self.numbers[node] = self._operate(node)

    def _operate(self, node: int) -> SignedNode:
        graph = self.graph
        left, right = self.get_number(graph.left[node]), self.get_number(graph.right[node])
        return graph.apply(graph.op[node], left, right)

    def get_number(self, value: SignedNode) -> SignedNode:
        """Return the new node for a value of the routine; a part of a pair where it is in one."""
        node = abs(value)
        if node not in self.numbers:
            if node in self.first:
                pair = self.pairs[self.first[node]]
                self.numbers[node] = pair.sign * self.graph.get_part(Op.SECOND, pair.node)
            else:
                self.numbers[node] = self.graph.get_part(Op.FIRST, self.pairs[node].node)
        return self.numbers[node] if value > 0 else -self.numbers[node]

    def _operate_on_pairs(self, node: int, twin: Twin) -> _SignedPair:
        """Return the operation of two twins on pairs of their operands.

        With operands (x, s y) and (u, t v), signs s and t: the product (x u, s t y v) has the sign
        s t.  A sum needs equal signs, so if s = -t, the second operand is multiplied by (1, -1).
        """
        graph, op = self.graph, self.graph.op[node]
        if op not in BINARY:
            return _SignedPair(graph.pair(self._operate(node), self._operate(twin.node)), 1)
        left = self._pair_operands(graph.left[node], twin.operands[0])
        right = self._pair_operands(graph.right[node], twin.operands[1])
        if op != Op.ADD:
            return _SignedPair(graph.apply(op, left.node, right.node), left.sign * right.sign)
        addend = right.node
        if left.sign != right.sign:
            addend = graph.mul(addend, graph.pair(1, -1))
        return _SignedPair(graph.add(left.node, addend), left.sign)

    def _pair_operands(self, first: SignedNode, second: SignedNode) -> _SignedPair:
        """Return two operands as one; two equal numbers need no pair, a single number will do."""
        node, second_node = abs(first), abs(second)
        first_sign = 1 if first > 0 else -1
        relative_sign = 1 if (first > 0) == (second > 0) else -1
        if node == second_node:
            return _SignedPair(self.get_number(first), relative_sign)
        if node in self.twins and self.twins[node].node == second_node:
            pair = self.pairs[node]
            return _SignedPair(first_sign * pair.node, pair.sign * relative_sign)
        return _SignedPair(self.graph.pair(self.get_number(first), self.get_number(second)), 1)
