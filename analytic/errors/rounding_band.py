"""The band within which rounding lets two runs of one motion differ: its growth by step Jacobians.

Two runs take the same steps x_n+1 = f(x_n), and each rounds in its own way. Step n adds a
difference w_n, whose mean square is Q_n, and the step Jacobians A_n carry what is there:

    e_n+1 = A_n e_n + w_n,    P_n+1 = A_n P_n A_n^T + Q_n.                                      (1)

The root of the diagonal of P is the mean-square estimate of the difference. If all steps round the
same way, their parts c_k of a coordinate add up; by Cauchy and Schwarz

    |sum c_k| <= sum |c_k| <= sqrt(n) sqrt(sum c_k^2) <= LARGEST sqrt(n) sqrt(P),               (2)

where a part is at most LARGEST times its own mean square. What a solver leaves of a step is carried
in the same way, as a term of its own: each of two runs leaves as much, and a solver that takes its
constraints in another order may leave twice as much. If the two runs have different solvers, what
each of them leaves is a row of its own."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array

# Largest rounding of one step in its mean squares: three standard deviations. Calibrated for what
# solvers leave: two thirds of it are used (`tests/difference/bands.py`).
LARGEST = 3.0


@dataclass(frozen=True)
class StepRounding:
    """The part of one step in the growth of a difference, in tangent coordinates."""

    jacobian: Array  # derivative of the state after the step by the state before, shape (m, m)
    # Changes of the state after the step by nudges of what the step computes, shape (nudges, m)
    nudged: Array
    # Changes of the state after the step if its solver converges, of one run for both, or of each,
    # shape (m,) or (runs, m)
    left: Array


@dataclass(frozen=True)
class BandSample:
    """The band after some steps, shape (m,) each, in tangent coordinates."""

    estimate: Array  # root mean square of the difference that rounding makes
    rounding: Array  # bound of the difference that rounding makes
    solver: Array  # bound of the difference that the solver's tolerance makes
    start: Array  # difference that the difference at the start has become, without its sign
    covariance: Array  # mean square of the difference that rounding makes, shape (m, m)

    @property
    def bound(self) -> Array:
        """The bound of the whole difference: rounding, solver and start."""
        return self.rounding + self.solver + self.start


def carried_band(
    steps: Iterable[StepRounding], start: Array, largest: float = LARGEST
) -> Iterator[BandSample]:
    """Yields eq. 1 and 2 after each step, from the difference `start` of the states, shape (m,).
    The rounding of one step is at most `largest` times its mean square."""
    covariance = np.zeros((start.size, start.size))
    left = np.zeros((start.size, start.size))
    for number, step in enumerate(steps, 1):
        by_state = step.jacobian
        added = step.nudged.T @ step.nudged / len(step.nudged)
        covariance = by_state @ covariance @ by_state.T + added
        rows = np.atleast_2d(step.left)
        left = by_state @ left @ by_state.T + rows.T @ rows
        start = by_state @ start
        estimate = np.sqrt(np.diag(covariance))
        yield BandSample(
            estimate=estimate,
            rounding=largest * math.sqrt(number) * estimate,
            solver=LARGEST * math.sqrt(number) * np.sqrt(np.diag(left)),
            start=np.abs(start),
            covariance=covariance,
        )
