"""A function to be written: what it stores, in order, and the statements that this takes.

Each node that is used more than once becomes a variable; what is used once is written where
it is used, and what is not used is not written.  A variable stands as late as it can.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, field

from urdf2mbs_equations.graph import BINARY, LEAVES, Graph, Op, Scalar, Signed

#: No expression is longer than this many characters; what would be is a variable.
LONGEST = 72


@dataclass
class Store:
    """An expression is written to places such as ``M[1][3]``."""

    places: tuple[str, ...]
    value: Signed


@dataclass
class Call:
    """A user function is called; ``result`` is the name of what it returns."""

    function: str
    arguments: tuple[str, ...]
    result: str


@dataclass
class Routine:
    """One function, or one case of it."""

    graph: Graph
    steps: list[Store | Call] = field(default_factory=list)
    alike: list[tuple[Signed, Signed]] = field(default_factory=list)
    """Results of mirrored joints."""

    def store(self, place: str, value: Scalar, *more: str) -> None:
        self.steps.append(Store((place, *more), self.graph.number(value)))

    def mirror(self, one: Scalar, other: Scalar) -> None:
        """Note two results of mirrored joints."""
        self.alike.append((self.graph.number(one), self.graph.number(other)))

    def fill(self, name: str, values: Iterable[Scalar]) -> Routine:
        """Store values in an array, from index 1; gives the routine."""
        for k, value in enumerate(values, start=1):
            self.store(f"{name}[{k}]", value)
        return self


#: A routine for each number, of a sensor or a joint.
Cases = dict[int, Routine]


@dataclass
class Absent:
    """A function that a model does not need: to call it is a mistake."""

    what: str
    """What the model has not."""

    @property
    def message(self) -> str:
        return f"symbolic files seem obsolete: the model had no {self.what}"


@dataclass
class Loops:
    """The joints by number; of the constraints, those of cuts come first."""

    dependent: list[int]
    independent: list[int]
    driven: list[int]
    cuts: int
    """Equations of cuts."""
    user: int
    """Equations that the user's functions give."""


@dataclass
class Refused:
    """A function that is not generated, and why."""

    why: str
    message = "not generated; the head of its file says why"


#: What may be written as one of Robotran's functions.
Made = Routine | Cases | Absent | Loops | Refused


@dataclass
class Count:
    """How many operations a routine does."""

    products: int = 0
    sums: int = 0
    functions: int = 0
    """Sines, cosines and square roots."""
    divisions: int = 0
    signs: int = 0
    """Changes of sign that are no part of a sum."""
    paired: int = 0
    """Of all these, how many are done two at a time."""

    @property
    def operations(self) -> int:
        return self.products + self.sums + self.functions + self.divisions + self.signs

    def __add__(self, more: Count) -> Count:
        return Count(*map(sum, zip(astuple(self), astuple(more), strict=True)))


#: The field that counts each operation.
COUNTED = {
    Op.ADD: "sums", Op.MUL: "products", Op.DIV: "divisions",
    Op.SIN: "functions", Op.COS: "functions", Op.SQRT: "functions",
}  # fmt: skip


@dataclass
class Statement:
    """``variable`` or ``places`` are given the value of ``text``; or a call."""

    text: str = ""
    variable: str | None = None
    places: tuple[str, ...] = ()
    uses: tuple[str, ...] = ()
    """What stands in the text: variables, and symbols such as ``q[3]``."""
    call: Call | None = None
    pair: bool = False
    """The variable is two numbers."""


def statements(routine: Routine) -> tuple[list[Statement], Count]:
    return _Writer(routine).write()


class _Writer:
    def __init__(self, routine: Routine) -> None:
        self.routine, self.graph = routine, routine.graph
        self.uses: dict[int, int] = {}
        self.votes: dict[int, int] = {}
        """Uses with plus, less uses with minus."""
        self.named: set[int] = set()
        """Nodes that are variables though they are used once: only these have parts."""
        self.pairs: set[int] = set()
        self.terms: dict[int, list[tuple[bool, str]]] = {0: []}
        """How a node is written where it is used: terms, each with whether it is added."""
        self.used: dict[int, tuple[str, ...]] = {0: ()}
        self.out: list[Statement] = []
        self.count = Count()
        self.variables = 0

    def write(self) -> tuple[list[Statement], Count]:
        self._count_uses()
        for step in self.routine.steps:
            if isinstance(step, Call):
                self.out.append(Statement(call=step))
                continue
            node = abs(step.value)
            self._make(node)
            text = self._join(node, step.value > 0) if node else "0.0"
            self.out.append(Statement(text, None, step.places, self.used[node]))
        return self.out, self.count

    def _count_uses(self) -> None:
        op, a, b = self.graph.op, self.graph.a, self.graph.b
        uses, votes = self.uses, self.votes
        stack = [s.value for s in self.routine.steps if isinstance(s, Store) and s.value]
        while stack:
            x = stack.pop()
            node = abs(x)
            votes[node] = votes.get(node, 0) + (1 if x > 0 else -1)
            uses[node] = uses.get(node, 0) + 1
            if uses[node] > 1 or op[node] in LEAVES:
                continue
            if op[node] in (Op.FIRST, Op.SECOND):
                self.named.add(a[node])
                stack.append(a[node] if x > 0 else -a[node])
                continue
            stack.append(a[node])
            if op[node] in BINARY:
                stack.append(b[node])

    def _make(self, wanted: int) -> None:
        """Write all that an expression needs, deepest first."""
        op, a, b, terms = self.graph.op, self.graph.a, self.graph.b, self.terms
        stack = [wanted]
        while stack:
            node = stack[-1]
            if node in terms:
                stack.pop()
                continue
            if op[node] in LEAVES:
                self._leaf(node)
                continue
            x, y = abs(a[node]), abs(b[node])
            if x in terms and y in terms:
                self._operation(node, x, y)
                continue
            if y not in terms:
                stack.append(y)
            if x not in terms:
                stack.append(x)

    def _leaf(self, node: int) -> None:
        kind, name = self.graph.op[node], self.graph.name[node]
        if kind == Op.CONST:
            name = repr(self.graph.value[node])
        self.terms[node] = [(True, name)]
        self.used[node] = (name,) if kind == Op.SYMBOL else ()

    def _operation(self, node: int, x: int, y: int) -> None:
        graph = self.graph
        kind = graph.op[node]
        if kind == Op.ADD:
            more = self.terms[y]
            if graph.b[node] < 0:
                more = [(not plus, text) for plus, text in more]
            terms = self.terms[x] + more
        elif kind == Op.PAIR:
            first = self._join(x, graph.a[node] > 0)
            terms = [(True, f"PAIR({first}, {self._join(y, graph.b[node] > 0)})")]
        elif kind in (Op.MUL, Op.DIV):
            (plus_a, a), (plus_b, b) = self._factor(x), self._factor(y)
            if kind == Op.DIV and " " in b and b[0] != "(":
                b = f"({b})"
            terms = [(plus_a == plus_b, f"{a} {'*' if kind == Op.MUL else '/'} {b}")]
        elif kind in (Op.FIRST, Op.SECOND):
            plus, name = self.terms[x][0]
            terms = [(plus, f"{name}[{kind - Op.FIRST}]")]
        else:
            terms = [(True, f"{kind.name.lower()}({self._join(x, graph.a[node] > 0)})")]
        self.terms[node], self.used[node] = terms, self.used[x] + self.used[y]
        self._add_to_count(node, kind, x, y)
        if (
            self.uses[node] > 1
            or node in self.named
            or sum(len(text) + 3 for _, text in terms) > LONGEST
        ):
            self._variable(node, kind)

    def _add_to_count(self, node: int, kind: Op, x: int, y: int) -> None:
        paired = kind in BINARY and (x in self.pairs or y in self.pairs)
        if paired or kind == Op.PAIR:
            self.pairs.add(node)
        if kind in COUNTED:
            name, times = COUNTED[kind], 1 + paired
            setattr(self.count, name, getattr(self.count, name) + times)
            self.count.paired += 2 * paired

    def _variable(self, node: int, kind: Op) -> None:
        """Give a name to a node, or to its opposite if so fewer signs have to be changed."""
        signs = [plus for plus, _ in self.terms[node]]
        positive = all(signs) or (any(signs) and self.votes[node] >= 0)
        text = self._join(node, positive)
        argument = self.graph.name[abs(self.graph.a[node])] if kind in (Op.SIN, Op.COS) else ""
        if argument.startswith("q["):
            name = f"{'S' if kind == Op.SIN else 'C'}{argument[2:-1]}"
        else:
            self.variables += 1
            name = f"x{self.variables}"
        pair = node in self.pairs
        self.out.append(Statement(text, name, (name,), self.used[node], pair=pair))
        self.terms[node], self.used[node] = [(positive, name)], (name,)

    def _join(self, node: int, positive: bool) -> str:
        """A sum as text, with a term that is added in front, if there is one."""
        terms = [(plus == positive, text) for plus, text in self.terms[node]]
        if not terms[0][0]:
            first = next((i for i, (plus, _) in enumerate(terms) if plus), 0)
            terms.insert(0, terms.pop(first))
        if not terms[0][0]:
            self.count.signs += 1
        text = ("" if terms[0][0] else "-") + terms[0][1]
        return text + "".join(f" {'+' if plus else '-'} {term}" for plus, term in terms[1:])

    def _factor(self, node: int) -> tuple[bool, str]:
        """Whether a node is added, and its text, as a factor of a product."""
        terms = self.terms[node]
        if len(terms) == 1:
            return terms[0]
        positive = any(plus for plus, _ in terms)
        return positive, f"({self._join(node, positive)})"


def arrays(lines: list[Statement]) -> list[str]:
    """The arrays of the data that are read."""
    used = {name.partition("[") for line in lines for name in line.uses}
    return sorted({array for array, bracket, _ in used if bracket})
