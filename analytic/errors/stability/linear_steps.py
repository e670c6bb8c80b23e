"""One step of each scheme on a linear system M x'' + C x' + K x = 0, as a matrix."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import (
    EULER,
    LEAPFROG,
    LINEARLY_IMPLICIT,
    RK4,
    RK4_ADDED_RATES,
    TABLEAUX,
    Scheme,
)
from plumbob.analytic.tableau import Tableau

TINY = 1e-30  # an imaginary part that is a nudge: its square is lost in a double
Complex = npt.NDArray[np.complex128]
Matrices = Callable[[Array], Array | Complex]
"""Step sizes [s], shape (n,) -> matrices of a step, shape (n, m, m)."""


def stability_function(tableau: Tableau, z: Complex) -> Complex:
    """R(z) = 1 + z b^T (I - zA)^-1 1 of a Runge-Kutta method: what a step makes of 1 on x' = lambda
    x, at z = h lambda of any shape (eq. 13.1)."""
    change = tableau.change(lambda time, state: z * state, 0.0, np.ones_like(z), 1.0)
    return np.asarray(1.0 + change)


@dataclass(frozen=True)
class LinearSystem:
    """M x'' + C x' + K x = 0 with `mass`, `damping` and `stiffness` of shape (d, d), not singular
    in its mass."""

    mass: Array
    damping: Array
    stiffness: Array

    @cached_property
    def pull(self) -> Array:
        """M^-1 K, shape (d, d) [1/s^2]."""
        return np.asarray(np.linalg.solve(self.mass, self.stiffness), dtype=np.float64)

    @cached_property
    def drag(self) -> Array:
        """M^-1 C, shape (d, d) [1/s]."""
        return np.asarray(np.linalg.solve(self.mass, self.damping), dtype=np.float64)

    @cached_property
    def flow(self) -> Array:
        """The matrix A of (x, x')' = A (x, x'), shape (2d, 2d)."""
        nothing, one = np.zeros_like(self.pull), np.eye(len(self.pull))
        return np.block([[nothing, one], [-self.pull, -self.drag]])

    @property
    def rates(self) -> Complex:
        """Eigenvalues of the flow [1/s], shape (2d,)."""
        return np.asarray(np.linalg.eigvals(self.flow), dtype=np.complex128)


def step_matrices(system: LinearSystem, scheme: Scheme) -> Matrices | None:
    """The step of `scheme` on `system`, of (x, x'); None for a scheme that is not known here, or
    that a joint's opening belongs to."""
    if scheme.joint_closing_rate is not None:
        return None
    if scheme.integrator in TABLEAUX or scheme.integrator == RK4_ADDED_RATES:
        tableau = TABLEAUX.get(scheme.integrator, TABLEAUX[RK4])
        return lambda steps: _runge_kutta(tableau, system.flow, steps)
    step = _STEPS.get(scheme.integrator)
    return None if step is None else lambda steps: step(system, scheme, steps[:, None, None])


def _runge_kutta(tableau: Tableau, flow: Array, steps: Array) -> Array:
    one, h = np.eye(len(flow)), steps[:, None, None]
    return np.asarray(one + tableau.change(lambda time, state: flow @ state, 0.0, one, h))


def _euler(system: LinearSystem, scheme: Scheme, h: Array) -> Array:
    """Kick, then drift, or the drift first; what acts on the state after the step divides it."""
    one, nothing = np.eye(len(system.pull)), np.zeros((len(h), *system.pull.shape))
    implicit = 1.0 if scheme.integrator == LINEARLY_IMPLICIT else scheme.implicit_damping
    spring = h * h * system.pull if scheme.implicit_spring else 0.0
    divisor = one + nothing + implicit * h * system.drag + spring
    kept = one + nothing - (1.0 - implicit) * h * system.drag
    kick = np.block([[one + nothing, nothing], [-h * system.pull, kept]])
    kick[:, len(one) :] = np.linalg.solve(divisor, kick[:, len(one) :])
    drift = _drift(one, nothing, h)
    return kick @ drift if scheme.position_first else drift @ kick


def _leapfrog(system: LinearSystem, scheme: Scheme, h: Array) -> Array:
    """Half a kick, explicit; a drift; half a kick whose damping is implicit."""
    one, nothing = np.eye(len(system.pull)), np.zeros((len(h), *system.pull.shape))
    half = h / 2
    first = np.block([[one + nothing, nothing], [-half * system.pull, one - half * system.drag]])
    last = np.block([[one + nothing, nothing], [-half * system.pull, one + nothing]])
    last[:, len(one) :] = np.linalg.solve(one + half * system.drag, last[:, len(one) :])
    return np.asarray(last @ _drift(one, nothing, h) @ first)


def _drift(one: Array, nothing: Array, h: Array) -> Array:
    return np.block([[one + nothing, h * one], [nothing, one + nothing]])


_STEPS: MappingProxyType[str, Callable[[LinearSystem, Scheme, Array], Array]] = MappingProxyType(
    {EULER: _euler, LINEARLY_IMPLICIT: _euler, LEAPFROG: _leapfrog}
)


def jacobians(advance: Callable[..., Sequence[Any]], state: Sequence[Any], count: int) -> Array:
    """The derivative of a step of `count` sizes at once, at a state of d numbers or arrays of shape
    (count,), by imaginary parts: shape (count, d, d)."""
    columns = []
    for varied in range(len(state)):
        nudges = (TINY * 1j * (varied == i) for i in range(len(state)))
        nudged = [np.zeros(count) + x + nudge for x, nudge in zip(state, nudges, strict=True)]
        after = [np.imag(part) / TINY for part in advance(0.0, *nudged)]
        columns.append(np.stack(after, axis=-1))
    return np.stack(columns, axis=-1)
