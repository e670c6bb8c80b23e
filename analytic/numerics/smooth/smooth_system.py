"""A smooth mechanical system of n degrees of freedom, M(q) q'' = f(t, q, q'), and its derivatives.

The user's two functions are written with numpy's functions, element by element: they take floats,
arrays, and complex arrays, whose imaginary parts of 1e-30 of their size carry derivatives without
loss of digits (Squire and Trapp 1998, SIAM Review 40, 110).
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

TINY = 1e-30  # imaginary part per derivative: its square is lost in a double
Elements = Sequence[Any]


@dataclass(frozen=True)
class SmoothSystem:
    """M(q) q'' = f(t, q, q') from `position` and `rate` at time 0; SI units.

    A state is q and q' in one array, shape (2 n, ...). `mass_matrix` and `forces` read a parameter
    of the name `length` as `p.length`. Raises ParameterError for a mass matrix that is not positive
    definite at the start.
    """

    coordinates: tuple[str, ...]  # names of q, as observables
    rates: tuple[str, ...]  # names of q', as observables
    mass_matrix: Callable[[Any, Any], Sequence[Elements]]  # p, q -> rows; symmetric, positive
    forces: Callable[[Any, Any, Any, Any], Elements]  # p, t, q, q' -> n generalised forces
    parameters: Mapping[str, float]
    position: tuple[float, ...]
    rate: tuple[float, ...]
    damped: bool = False  # forces depend on q' in another way than by inertia
    readings: Callable[[Any, Any, Any], Mapping[str, Any]] = lambda p, q, v: {}
    """p, q, q' -> further observables."""

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
        """The parameters as the two functions read them."""
        return SimpleNamespace(**self.parameters)

    def slope(self, time: Any, state: Any, values: SimpleNamespace | None = None) -> Any:
        """Rates of `state`, shape (2 n, ...), at `time` [s]; other `values` of parameters may be
        complex arrays."""
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
        """q'' at `time` [s], with the values `p` of the parameters."""
        return solved(self.mass_matrix(p, q), self.forces(p, time, q, v))

    def observed(self, states: Array) -> Signals:
        """Observables of `states`, shape (2 n, m), of shape (m,) each."""
        half = len(states) // 2
        state = dict(zip((*self.coordinates, *self.rates), states, strict=True))
        return {**state, **self.readings(self.values, states[:half], states[half:])}

    def state(self, observed: Signals) -> Array:
        """The states of observables, shape (m,) each, as shape (2 n, m)."""
        return np.stack([observed[name] for name in (*self.coordinates, *self.rates)])

    def kinetic_energy(self, observed: Signals) -> Array:
        """Kinetic energy [J] of observables, shape (m,) each."""
        q, v = ([observed[name] for name in names] for names in (self.coordinates, self.rates))
        rows = self.mass_matrix(self.values, q)
        parts = (m * v[i] * v[j] for i, row in enumerate(rows) for j, m in enumerate(row))
        return np.asarray(sum(parts) / 2)

    def doubts(self, states: Array, doubts: Array) -> Signals:
        """Uncertainties of the observables of `states`, shape (2 n, m), which are known within
        `doubts` of that shape, with parameters and results that are rounded."""
        half = len(states) // 2
        p = self.perturbed()
        ahead = (
            states[:, None]
            + 1j * TINY * np.eye(2 * half, 2 * half + len(self.parameters))[:, :, None]
        )
        weights = np.concatenate(
            [doubts, np.full((len(self.parameters), doubts.shape[1]), ULP)]
        )
        read = self.readings(p, ahead[:half], ahead[half:])
        return dict(zip((*self.coordinates, *self.rates), doubts, strict=True)) | {
            name: (np.abs(value.imag) / TINY * weights).sum(axis=0)
            + ULP * np.abs(value.real[0])
            for name, value in read.items()
        }

    def jacobian(self, time: Any, states: Array) -> Array:
        """Derivatives of the rates by the state, shape (2 n, 2 n, m), at `states`, shape
        (2 n, m)."""
        return jacobian(self.slope, time, states)

    def perturbed(self) -> SimpleNamespace:
        """The parameters with derivatives by their logarithms: those of number k in the row
        2 n + k of arrays of shape (2 n + parameters, 1)."""
        size = 2 * len(self.coordinates)
        unit = np.eye(size + len(self.parameters))[size:, :, None]
        values = self.parameters.items()
        return SimpleNamespace(
            **{
                name: value * (1 + 1j * TINY * row)
                for (name, value), row in zip(values, unit, strict=True)
            }
        )


def jacobian(slope: Callable[[Any, Array], Array], time: Any, states: Array) -> Array:
    """Derivatives, shape (d, d, m), of a `slope` at `time` [s] by `states`, shape (d, m)."""
    ahead = states[:, None] + 1j * TINY * np.eye(len(states))[:, :, None]
    return np.asarray(slope(time, ahead).imag / TINY)


def solved(matrix: Sequence[Elements], right: Elements) -> list[Any]:
    """Solution of a linear system, whose elements may be arrays, by elimination without a change of
    rows: of a positive definite matrix, or one near the identity."""
    size = len(right)
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for k, pivot in enumerate(rows):
        for row in rows[k + 1 :]:
            ratio = row[k] / pivot[k]
            for j in range(k + 1, size + 1):
                row[j] = row[j] - ratio * pivot[j]
    for i, row in reversed(list(enumerate(rows))):
        known = sum([row[j] * rows[j][-1] for j in range(i + 1, size)], 0.0)
        row[-1] = (row[-1] - known) / row[i]
    return [row[-1] for row in rows]
