"""A function to be generated: its results in order, and the statements that compute them.

An expression that is used more than once becomes a variable; one that is used once is written
where it is used, and one that no result needs is not written.  A variable is computed as late as
possible.  The statements have no language yet, except for the form of expressions, which is the
same in Python, C and MATLAB.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, field
from typing import NamedTuple

from urdf2mbs_equations.graph import BINARY, LEAVES, Graph, Op, Scalar, SignedNode

#: An expression with more characters becomes a variable.
MAX_LENGTH = 72


@dataclass
class Store:
    """Store a value in elements of arrays, such as ``M[1][3]``."""

    targets: tuple[str, ...]
    value: SignedNode


@dataclass
class Call:
    """Call a user function, and name what it returns."""

    function: str
    arguments: tuple[str, ...]
    result: str


@dataclass
class Routine:
    """A function, or one case of it."""

    graph: Graph
    steps: list[Store | Call] = field(default_factory=list)
    mirrored: list[tuple[SignedNode, SignedNode]] = field(default_factory=list)
    """Pairs of results that belong to mirrored joints (see ``pairs``)."""

    def store(self, target: str, value: Scalar, *more_targets: str) -> None:
        """Store a value in one or more elements of arrays."""
        self.steps.append(Store((target, *more_targets), self.graph.to_node(value)))

    def mark_mirrored(self, first: Scalar, second: Scalar) -> None:
        """Note that two results belong to mirrored joints."""
        self.mirrored.append((self.graph.to_node(first), self.graph.to_node(second)))

    def fill(self, array: str, values: Iterable[Scalar]) -> Routine:
        """Store values in an array, from index 1, and return this routine."""
        for k, value in enumerate(values, start=1):
            self.store(f"{array}[{k}]", value)
        return self


#: A routine by the number of a sensor or a joint.
Cases = dict[int, Routine]


@dataclass
class Absent:
    """A function that the model does not need, so that calling it is an error."""

    feature: str
    """What the model does not have."""

    @property
    def message(self) -> str:
        """The message of the function that is called by mistake."""
        return f"symbolic files seem obsolete: the model had no {self.feature}"


@dataclass
class Loops:
    """The partition of the joints of a model with loops, and its numbers of constraints."""

    dependent: list[int]
    """Numbers of the dependent joints."""
    independent: list[int]
    driven: list[int]
    n_cut_rows: int
    """Equations of cuts; they precede those of the user."""
    n_user_rows: int
    """Equations of ``user_cons_hJ``."""


@dataclass
class Refused:
    """A function that is not generated."""

    reason: str
    message = "not generated; the head of its file says why"


#: The content of one of Robotran's functions.
Content = Routine | Cases | Absent | Loops | Refused


@dataclass
class OperationCount:
    """The number of operations of a routine."""

    products: int = 0
    sums: int = 0
    functions: int = 0
    """Sines, cosines and square roots."""
    divisions: int = 0
    signs: int = 0
    """Changes of sign that are not part of a sum."""
    paired: int = 0
    """How many of all these are computed two at a time."""

    @property
    def operations(self) -> int:
        """The number of all operations."""
        return self.products + self.sums + self.functions + self.divisions + self.signs

    def __add__(self, count: OperationCount) -> OperationCount:
        return OperationCount(*map(sum, zip(astuple(self), astuple(count), strict=True)))


#: The field of OperationCount for each operation.
COUNTED = {
    Op.ADD: "sums",
    Op.MUL: "products",
    Op.DIV: "divisions",
    Op.SIN: "functions",
    Op.COS: "functions",
    Op.SQRT: "functions",
}


@dataclass
class Statement:
    """Assign an expression to a variable or to elements of arrays, or call a user function."""

    text: str = ""
    variable: str | None = None
    """The variable; None if the targets are elements of arrays."""
    targets: tuple[str, ...] = ()
    """The variable, or the elements of arrays."""
    uses: tuple[str, ...] = ()
    """Variables and symbols (``q[3]``) in the text."""
    call: Call | None = None
    is_pair: bool = False
    """True if the variable is a pair of numbers."""


def make_statements(routine: Routine) -> tuple[list[Statement], OperationCount]:
    """Return the statements of a routine, and the number of their operations."""
    writer = _StatementWriter(routine)
    writer.write()
    return writer.statements, writer.count


def list_arrays(statements: list[Statement]) -> list[str]:
    """Return the names of the arrays that statements read, sorted."""
    parts = {name.partition("[") for statement in statements for name in statement.uses}
    return sorted({array for array, bracket, _ in parts if bracket})


class _Term(NamedTuple):
    """A term of a sum."""

    is_added: bool
    """False if it is subtracted."""
    text: str


class _StatementWriter:
    def __init__(self, routine: Routine) -> None:
        self.routine, self.graph = routine, routine.graph
        self.n_uses: dict[int, int] = {}
        self.sign_balance: dict[int, int] = {}
        """By node, the number of uses with plus minus the number of uses with minus."""
        self.needs_name: set[int] = set()
        """Pairs of which a part is used: only a variable can be indexed."""
        self.pair_nodes: set[int] = set()
        """Nodes that are pairs of numbers."""
        self.terms: dict[int, list[_Term]] = {0: []}
        """The text of a node where it is used, as a sum of terms."""
        self.names: dict[int, tuple[str, ...]] = {0: ()}
        """Variables and symbols in this text."""
        self.statements: list[Statement] = []
        self.count = OperationCount()
        self.n_variables = 0

    def write(self) -> None:
        self._count_uses()
        for step in self.routine.steps:
            if isinstance(step, Call):
                self.statements.append(Statement(call=step))
                continue
            node = abs(step.value)
            self._write_node(node)
            text = self._join_terms(node, step.value > 0) if node else "0.0"
            self.statements.append(Statement(text, None, step.targets, self.names[node]))

    def _count_uses(self) -> None:
        """Count the uses of each node, with their signs, from the results to the leaves."""
        op, left, right = self.graph.op, self.graph.left, self.graph.right
        n_uses, sign_balance = self.n_uses, self.sign_balance
        stack = [
            step.value for step in self.routine.steps if isinstance(step, Store) and step.value
        ]
        while stack:
            value = stack.pop()
            node = abs(value)
            sign_balance[node] = sign_balance.get(node, 0) + (1 if value > 0 else -1)
            n_uses[node] = n_uses.get(node, 0) + 1
            if n_uses[node] > 1 or op[node] in LEAVES:
                continue
            if op[node] in (Op.FIRST, Op.SECOND):
                self.needs_name.add(left[node])
                stack.append(left[node] if value > 0 else -left[node])
                continue
            stack.append(left[node])
            if op[node] in BINARY:
                stack.append(right[node])

    def _write_node(self, result: int) -> None:
        """Write a node and everything that it depends on, operands first."""
        op, left, right, terms = self.graph.op, self.graph.left, self.graph.right, self.terms
        stack = [result]
        while stack:
            node = stack[-1]
            if node in terms:
                stack.pop()
                continue
            if op[node] in LEAVES:
                self._write_leaf(node)
                continue
            first, second = abs(left[node]), abs(right[node])
            if first in terms and second in terms:
                self._write_operation(node, first, second)
                continue
            if second not in terms:
                stack.append(second)
            if first not in terms:
                stack.append(first)

    def _write_leaf(self, node: int) -> None:
        op, name = self.graph.op[node], self.graph.name[node]
        if op == Op.CONSTANT:
            name = repr(self.graph.value[node])
        self.terms[node] = [_Term(True, name)]
        self.names[node] = (name,) if op == Op.SYMBOL else ()

    def _write_operation(self, node: int, left: int, right: int) -> None:
        """Write an operation whose operands are written; name it if it is used repeatedly."""
        op = self.graph.op[node]
        terms = self._make_terms(node, op, left, right)
        self.terms[node], self.names[node] = terms, self.names[left] + self.names[right]
        is_paired = op in BINARY and (left in self.pair_nodes or right in self.pair_nodes)
        if is_paired or op == Op.PAIR:
            self.pair_nodes.add(node)
        self._count_operation(op, is_paired=is_paired)
        length = sum(len(text) + len(" + ") for _, text in terms)
        if self.n_uses[node] > 1 or node in self.needs_name or length > MAX_LENGTH:
            self._assign_variable(node)

    def _make_terms(self, node: int, op: Op, left: int, right: int) -> list[_Term]:
        graph = self.graph
        if op == Op.ADD:
            right_terms = self.terms[right]
            if graph.right[node] < 0:
                right_terms = [_Term(not is_added, text) for is_added, text in right_terms]
            return self.terms[left] + right_terms
        if op in (Op.MUL, Op.DIV):
            return [self._make_product(op, left, right)]
        if op in (Op.FIRST, Op.SECOND):
            is_added, name = self.terms[left][0]
            return [_Term(is_added, f"{name}[{op - Op.FIRST}]")]
        first = self._join_terms(left, graph.left[node] > 0)
        if op == Op.PAIR:
            second = self._join_terms(right, graph.right[node] > 0)
            return [_Term(True, f"PAIR({first}, {second})")]
        return [_Term(True, f"{op.name.lower()}({first})")]

    def _make_product(self, op: Op, left: int, right: int) -> _Term:
        """Return a product or a quotient."""
        left_factor, right_factor = self._make_factor(left), self._make_factor(right)
        text = right_factor.text
        if op == Op.DIV and " " in text and text[0] != "(":
            text = f"({text})"
        is_added = left_factor.is_added == right_factor.is_added
        return _Term(is_added, f"{left_factor.text} {'*' if op == Op.MUL else '/'} {text}")

    def _make_factor(self, node: int) -> _Term:
        """Return a node as a factor of a product, in parentheses if it is a sum."""
        terms = self.terms[node]
        if len(terms) == 1:
            return terms[0]
        is_added = any(term.is_added for term in terms)
        return _Term(is_added, f"({self._join_terms(node, is_added)})")

    def _join_terms(self, node: int, is_added: bool) -> str:
        """Return the sum of a node, or its opposite, starting with an added term if possible."""
        terms = [_Term(term.is_added == is_added, term.text) for term in self.terms[node]]
        if not terms[0].is_added:
            first_added = next((i for i, term in enumerate(terms) if term.is_added), 0)
            terms.insert(0, terms.pop(first_added))
        if not terms[0].is_added:
            self.count.signs += 1
        text = ("" if terms[0].is_added else "-") + terms[0].text
        return text + "".join(f" {'+' if plus else '-'} {term}" for plus, term in terms[1:])

    def _count_operation(self, op: Op, *, is_paired: bool) -> None:
        if op in COUNTED:
            field_name = COUNTED[op]
            setattr(self.count, field_name, getattr(self.count, field_name) + 1 + is_paired)
            self.count.paired += 2 * is_paired

    def _assign_variable(self, node: int) -> None:
        """Assign a node to a variable; its opposite, if that saves changes of sign."""
        signs = [term.is_added for term in self.terms[node]]
        is_added = all(signs) or (any(signs) and self.sign_balance[node] >= 0)
        text = self._join_terms(node, is_added)
        name = self._name_variable(node)
        statement = Statement(
            text, name, (name,), self.names[node], is_pair=node in self.pair_nodes
        )
        self.statements.append(statement)
        self.terms[node], self.names[node] = [_Term(is_added, name)], (name,)

    def _name_variable(self, node: int) -> str:
        """Return ``S3`` or ``C3`` for sine and cosine of ``q[3]``, else ``x1``, ``x2``, ..."""
        op = self.graph.op[node]
        if op in (Op.SIN, Op.COS):
            angle = self.graph.name[abs(self.graph.left[node])]
            if angle.startswith("q["):
                return f"{'S' if op == Op.SIN else 'C'}{angle[2:-1]}"
        self.n_variables += 1
        return f"x{self.n_variables}"
