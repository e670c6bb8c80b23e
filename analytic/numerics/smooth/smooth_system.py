"""A smooth mechanical system of n degrees of freedom, M(q) q'' = f(t, q, q'), and its derivatives.

The functions for M and f are written with numpy's functions, element by element. They take floats,
arrays, and complex arrays. Imaginary parts of 1e-30 of the size of a number carry derivatives
without loss of digits (Squire and Trapp 1998, SIAM Review 40, 110).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals

TINY = 1e-30  # imaginary part per derivative: its square is below the rounding of a double
Elements = Sequence[Any]


@dataclass(frozen=True)
class SmoothSystem:
    """M(q) q'' = f(t, q, q') from `position` and `rate` at time 0; SI units.

    A state is q and q' in one array, shape (2 n, ...). `mass_matrix` and `forces` read a parameter
    named `length` as `p.length`. Raises ParameterError for a mass matrix that is not positive
    definite at the start.
    """

    coordinates: tuple[str, ...]  # names of q, as observables
    rates: tuple[str, ...]  # names of q', as observables
    mass_matrix: Callable[[Any, Any], Sequence[Elements]]  # rows of M from p and q
    forces: Callable[[Any, Any, Any, Any], Elements]  # n generalised forces from p, t, q, q'
    parameters: Mapping[str, float]
    position: tuple[float, ...]  # q at time 0
    rate: tuple[float, ...]  # q' at time 0
    damped: bool = False  # whether forces depend on q' in another way than by inertia
    readings: Callable[[Any, Any, Any], Mapping[str, Any]] = lambda p, q, v: {}
    """Function from p, q and q' to further observables."""

    def __post_init__(self) -> None:
        rows = [[float(x) for x in row] for row in self.mass_matrix(self.values, self.position)]
        matrix = np.array(rows)
        definite = False
        if np.isfinite(matrix).all() and np.array_equal(matrix, matrix.T):
            definite = bool(np.linalg.eigvalsh(matrix).min() > 0.0)
        if not definite:
            raise ParameterError("mass matrix", rows, "symmetric and positive definite")

    @property
    def start(self) -> Array:
        """State at time 0, shape (2 n,)."""
        return np.array([*self.position, *self.rate], dtype=np.float64)

    @property
    def values(self) -> SimpleNamespace:
        """Parameters as attributes, in the form that `mass_matrix` and `forces` read."""
        return SimpleNamespace(**self.parameters)

    def slope(self, time: Any, state: Any, values: SimpleNamespace | None = None) -> Any:
        """Returns the rates of a `state`, shape (2 n, ...), at `time` [s].

        `values` are the parameters, which may be complex arrays; None: the system's own.
        """
        half = len(state) // 2
        p = values or self.values
        q = state[:half]
        v = state[half:]
        rates = np.empty_like(state)
        rates[:half] = v
        for i, acceleration in enumerate(self.acceleration(time, q, v, p), start=half):
            rates[i] = acceleration
        return rates

    def acceleration(self, time: Any, q: Elements, v: Elements, p: Any) -> list[Any]:
        """Returns q'' at `time` [s] for the parameters `p`."""
        return solve_linear(self.mass_matrix(p, q), self.forces(p, time, q, v))

    def observed(self, states: Array) -> Signals:
        """Returns the observables of `states`, shape (2 n, m), each of shape (m,)."""
        half = len(states) // 2
        state = dict(zip((*self.coordinates, *self.rates), states, strict=True))
        return {**state, **self.readings(self.values, states[:half], states[half:])}

    def state(self, observed: Signals) -> Array:
        """Returns the states, shape (2 n, m), that belong to observables of shape (m,)."""
        return np.stack([observed[name] for name in (*self.coordinates, *self.rates)])

    def kinetic_energy(self, observed: Signals) -> Array:
        """Returns the kinetic energy [J] for observables of shape (m,)."""
        q = [observed[name] for name in self.coordinates]
        v = [observed[name] for name in self.rates]
        twice_energy: Any = 0
        for row, row_rate in zip(self.mass_matrix(self.values, q), v, strict=True):
            for element, column_rate in zip(row, v, strict=True):
                twice_energy = twice_energy + element * row_rate * column_rate
        return np.asarray(twice_energy / 2)

    def doubts(self, states: Array, doubts: Array) -> Signals:
        """Returns the uncertainties of the observables of `states`, shape (2 n, m).

        The states are known within `doubts`, of the same shape. Parameters and results are rounded.
        """
        size = len(states)
        directions = np.eye(size, size + len(self.parameters))[:, :, None]
        nudged = states[:, None] + 1j * TINY * directions
        parameter_doubts = np.full((len(self.parameters), doubts.shape[1]), ULP)
        input_doubts = np.concatenate([doubts, parameter_doubts])
        uncertainties = dict(zip((*self.coordinates, *self.rates), doubts, strict=True))
        readings = self.readings(self.perturbed(), nudged[: size // 2], nudged[size // 2 :])
        for name, value in readings.items():
            derivatives = np.abs(value.imag) / TINY
            rounding = ULP * np.abs(value.real[0])
            uncertainties[name] = (derivatives * input_doubts).sum(axis=0) + rounding
        return uncertainties

    def jacobian(self, time: Any, states: Array) -> Array:
        """Returns the derivatives of the rates by the state, shape (2 n, 2 n, m), at `states`,
        shape (2 n, m)."""
        return jacobian(self.slope, time, states)

    def perturbed(self) -> SimpleNamespace:
        """Returns the parameters as arrays whose imaginary parts carry derivatives by the logarithm
        of each parameter.

        The arrays have the shape (2 n + parameters, 1). The row 2 n + k has the derivative by the
        parameter k.
        """
        size = 2 * len(self.coordinates)
        directions = np.eye(size + len(self.parameters))[size:, :, None]
        nudged = {}
        for (name, value), direction in zip(self.parameters.items(), directions, strict=True):
            nudged[name] = value * (1 + 1j * TINY * direction)
        return SimpleNamespace(**nudged)


def jacobian(slope: Callable[[Any, Array], Array], time: Any, states: Array) -> Array:
    """Returns the derivatives of a `slope` by the `states`, shape (d, m), at `time` [s], as shape
    (d, d, m)."""
    nudged = states[:, None] + 1j * TINY * np.eye(len(states))[:, :, None]
    return np.asarray(slope(time, nudged).imag / TINY)


def solve_linear(matrix: Sequence[Elements], right: Elements) -> list[Any]:
    """Returns the solution of a linear system whose elements may be arrays.

    Elimination does not exchange rows: the matrix is positive definite, or near the identity.
    """
    size = len(right)
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for k, pivot in enumerate(rows):
        for row in rows[k + 1 :]:
            ratio = row[k] / pivot[k]
            for j in range(k + 1, size + 1):
                row[j] = row[j] - ratio * pivot[j]
    for i, row in reversed(list(enumerate(rows))):
        later_terms = sum([row[j] * rows[j][-1] for j in range(i + 1, size)], 0.0)
        row[-1] = (row[-1] - later_terms) / row[i]
    return [row[-1] for row in rows]
