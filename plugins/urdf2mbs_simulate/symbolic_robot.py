"""Equations of small robots in symbols: ``load_equations("arm.urdf", math=sympy)``."""

from __future__ import annotations

from typing import Any, NoReturn

from urdf2mbs_equations.formulas import Factor, Product, Sum, Symbol
from urdf2mbs_equations.latex import write_equations
from urdf2mbs_equations.symbolic import NoFormulasError, make_symbolic_equations
from urdf2mbs_simulate.python_calls import EquationsInPython
from urdf2mbs_simulate.python_code import MbsData
from urdf2mbs_simulate.robot import Robot


class _OtherFunctions(EquationsInPython):
    """The functions of a robot that sympy does not have."""

    def evaluate(self, name: str, *state: Any) -> NoReturn:
        """Refuse a function.

        Raises:
            TypeError: Always.
        """
        raise TypeError(
            "sympy has mass_matrix, coriolis, gravity, bias, inverse_dynamics and "
            "forward_dynamics; math=casadi has all functions for symbols"
        )

    def evaluate_place(self, name: str, place: int, point: int, q: Any) -> NoReturn:
        """Refuse a function of a point.

        Raises:
            TypeError: Always.
        """
        self.evaluate(name)


class SymbolicRobot(Robot):
    """The equations M qdd + c + g = tau of a small robot, as matrices of sympy.

    Symbols stand for positions, velocities and all data.  Joints that never move are left out, and
    followers of ``<mimic>`` are multiples of their leaders.  Without arguments, functions return
    formulas in ``q``, ``qd`` and ``qdd``.
    """

    def __init__(self, data: MbsData, sympy: Any) -> None:
        """Take the equations of a model.

        Raises:
            ValueError: The robot has too many joints for formulas.
        """
        super().__init__(data, "python", sympy, moving=True)
        try:
            self.equations = make_symbolic_equations(data._run.mbs, self.selection.followers)
        except NoFormulasError as error:
            raise ValueError(f"{error}; math=casadi takes robots of any size") from None
        self.functions = _OtherFunctions(data, self.selection, sympy)
        self.q, self.qd, self.qdd = (
            sympy.Matrix(
                [self._convert_factor(q._replace(n_dots=n)) for q in self.equations.joints]
            )
            for n in range(3)
        )
        self.relations = {
            self._convert_factor(symbol): self._convert_factor(formula)
            for symbol, formula in self.equations.relations.items()
        }
        """What the positions of followers are."""
        self.values = {
            self._convert_factor(symbol): quantity.value
            for symbol, quantity in self.equations.quantities.items()
        }
        """The numbers of the symbols of data (SI units), as for ``subs``."""

    def _repr_latex_(self) -> str:
        """Return M, c and g for a notebook."""
        return f"$$\\begin{{aligned}}\n{write_equations(self.equations)}\n\\end{{aligned}}$$"

    def mass_matrix(self, q: Any = None) -> Any:
        """Return M: (joints, joints)."""
        elements = self.equations.mass_matrix
        size = range(len(self.joints))
        rows = [[self._convert_factor(elements[min(i, k), max(i, k)]) for k in size] for i in size]
        return self._substitute(self.math.Matrix(rows), q)

    def coriolis(self, q: Any = None, qd: Any = None) -> Any:
        """Return c: centrifugal and Coriolis forces."""
        return self._substitute(self._convert_vector(self.equations.coriolis), q, qd)

    def gravity(self, q: Any = None) -> Any:
        """Return g: the forces against gravity."""
        return self._substitute(self._convert_vector(self.equations.gravity), q)

    def bias(self, q: Any = None, qd: Any = None) -> Any:
        """Return c + g: the forces at constant velocities, against gravity."""
        return self.coriolis(q, qd) + self.gravity(q)

    def inverse_dynamics(self, q: Any = None, qd: Any = None, qdd: Any = None) -> Any:
        """Return the forces tau of the joints."""
        accelerations = self.qdd if qdd is None else self.math.Matrix(list(qdd))
        return self.mass_matrix(q) * accelerations + self.bias(q, qd)

    def forward_dynamics(self, q: Any, qd: Any, tau: Any) -> Any:
        """Return the accelerations of the joints, for an open tree."""
        return self.mass_matrix(q).LUsolve(self.math.Matrix(list(tau)) - self.bias(q, qd))

    def _substitute(self, matrix: Any, q: Any, qd: Any = None) -> Any:
        """Return a matrix with these values, or other symbols, in place of q and qd."""
        matrix = matrix.subs(self.relations) if self.relations else matrix
        values: dict[Any, Any] = {} if q is None else dict(zip(self.q, q, strict=True))
        values |= {} if qd is None else dict(zip(self.qd, qd, strict=True))
        return matrix.subs(values, simultaneous=True) if values else matrix

    def _convert_vector(self, formulas: list[Sum]) -> Any:
        return self.math.Matrix([self._convert_factor(formula) for formula in formulas])

    def _convert_factor(self, factor: Factor) -> Any:
        """Return a factor of a formula as an expression of sympy."""
        sympy = self.math
        if isinstance(factor, Sum):
            return sympy.Add(*map(self._convert_product, factor.terms))
        if isinstance(factor, Symbol):
            return sympy.Symbol(factor.name)
        angle = sympy.Add(*(n * sympy.Symbol(symbol.name) for symbol, n in factor.angle))
        return getattr(sympy, factor.function)(angle)

    def _convert_product(self, product: Product) -> Any:
        number = self.math.Rational(product.coefficient.numerator, product.coefficient.denominator)
        factors = (self._convert_factor(factor) ** power for factor, power in product.factors)
        return self.math.Mul(number, *factors)
