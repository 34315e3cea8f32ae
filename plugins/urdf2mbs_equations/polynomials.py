"""Results of a graph as polynomials in symbols and in exponentials of angles.

With z = exp(i q) of an angle q, a sine and a cosine are polynomials in z and 1/z::

    cos q = (z + 1/z) / 2          sin q = (z - 1/z) / (2 i)

So a sum, a product, a sine and a cosine of the graph are polynomials with positive and negative
powers, and equal results are equal polynomials: ``sin^2 + cos^2`` is 1 without a rule for it.
Coefficients are sums and products of 1, 2, 1/2 and i, which floats represent exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from operator import add

from urdf2mbs_equations.graph import Graph, Op, SignedNode

#: The powers of all variables, in their order.
Powers = tuple[int, ...]
#: The coefficient of each product of powers; those that are zero are left out.
Polynomial = dict[Powers, complex]

#: The largest number of products that become a term, in a product of two polynomials.
MAX_PRODUCTS = 100


class TooManyTermsError(ValueError):
    """A polynomial that is longer than anybody reads, and takes long to make."""


class Ring:
    """Polynomials in variables with these names, as in ``m[3]`` and ``q[2]``."""

    def __init__(
        self, variables: Iterable[str], multiples: Mapping[str, tuple[str, int]] | None = None
    ) -> None:
        """Make a ring.

        Args:
            variables: The names.
            multiples: Angles that are a variable times a whole number.
        """
        self.index = {name: k for k, name in enumerate(variables)}
        self.multiples = multiples or {}

    def make_constant(self, value: complex) -> Polynomial:
        """Return the polynomial that is a number."""
        return {(0,) * len(self.index): complex(value)} if value else {}

    def make_power(self, name: str, power: int = 1, coefficient: complex = 1) -> Polynomial:
        """Return a multiple of a power of one variable."""
        powers = [0] * len(self.index)
        powers[self.index[name]] = power
        return {tuple(powers): complex(coefficient)}

    def make_cosine(self, angle: str) -> Polynomial:
        """Return the cosine of an angle, whose variable is the exponential z."""
        angle, n = self.multiples.get(angle, (angle, 1))
        return self.make_power(angle, n, 0.5) | self.make_power(angle, -n, 0.5)

    def make_sine(self, angle: str) -> Polynomial:
        """Return the sine of an angle, whose variable is the exponential z."""
        angle, n = self.multiples.get(angle, (angle, 1))
        return self.make_power(angle, n, -0.5j) | self.make_power(angle, -n, 0.5j)

    def evaluate(
        self,
        graph: Graph,
        results: Iterable[SignedNode],
        read_symbol: Callable[[str], Polynomial],
        max_terms: int,
    ) -> dict[SignedNode, Polynomial]:
        """Evaluate results of a graph that has no quotients and no roots.

        Args:
            graph: The graph; its sines and cosines are those of symbols.
            results: The signed nodes.
            read_symbol: Returns the polynomial of a symbol that is no angle.
            max_terms: The largest number of terms of a polynomial.

        Raises:
            TooManyTermsError: A polynomial has more.
        """
        values: dict[int, Polynomial] = {0: {}}
        for node in graph.find_dependencies(results):
            op, left, right = graph.op[node], graph.left[node], graph.right[node]
            if op == Op.CONSTANT:
                values[node] = self.make_constant(graph.value[node])
            elif op == Op.SYMBOL:
                values[node] = read_symbol(graph.name[node])
            elif op == Op.ADD:
                values[node] = add_polynomials(values[left], values[abs(right)], right > 0)
            elif op == Op.MUL:
                if len(values[left]) * len(values[right]) > MAX_PRODUCTS * max_terms:
                    raise TooManyTermsError
                values[node] = multiply(values[left], values[right])
            elif op == Op.SIN:
                values[node] = self.make_sine(graph.name[left])
            elif op == Op.COS:
                values[node] = self.make_cosine(graph.name[left])
            else:
                raise NotImplementedError(op.name)
            if len(values[node]) > max_terms:
                raise TooManyTermsError
        return {
            result: values[result] if result >= 0 else negate(values[-result]) for result in results
        }


def add_polynomials(first: Polynomial, second: Polynomial, is_added: bool = True) -> Polynomial:
    """Return the sum of two polynomials, or their difference."""
    total = dict(first)
    for powers, coefficient in second.items():
        changed = total.get(powers, 0) + (coefficient if is_added else -coefficient)
        if changed:
            total[powers] = changed
        else:
            del total[powers]
    return total


def negate(polynomial: Polynomial) -> Polynomial:
    """Return the opposite of a polynomial."""
    return {powers: -coefficient for powers, coefficient in polynomial.items()}


def multiply(first: Polynomial, second: Polynomial) -> Polynomial:
    """Return the product of two polynomials."""
    product: Polynomial = {}
    for powers, coefficient in first.items():
        for more, factor in second.items():
            key = tuple(map(add, powers, more))
            product[key] = product.get(key, 0) + coefficient * factor
    return {powers: coefficient for powers, coefficient in product.items() if coefficient}
