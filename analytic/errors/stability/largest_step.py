"""Largest step at which a scheme adds no growth to the modes of a linear system."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from plumbob.analytic.bisection import bisected
from plumbob.analytic.errors.smooth_motion.scheme_steps import SchemeStep, StateParts
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LARGEST_TRIAL_STEP, LOST_GROWTH, SMALLEST_TRIAL_STEP

STABLE_STEPS = 10_000  # fewest steps for which a step size must be stable
LEAST_PERIODS = 100  # fewest periods of the fastest mode for which it must be stable
# A mode that grows in the exact motion may grow 1.5 times faster in steps: chosen. A moderate error
# of a growing mode is a question of accuracy; an instability exceeds any such factor.
ALLOWED_MODE_GROWTH = 1.5
RESTING_SWING_FRACTION = 1e-3  # fraction of a swing below which the motion counts as at rest
# tested h |lambda| of the fastest mode
TESTED_PHASES = (math.tau * SMALLEST_TRIAL_STEP, math.tau * LARGEST_TRIAL_STEP)
# Neighbouring step sizes differ by a factor of 1.02. Narrower windows of instability are missed.
STEP_GRID_SIZE = 600
StableMarks = npt.NDArray[np.bool_]
EigenvalueRates = npt.NDArray[np.complex128]
Matrices = Callable[[Array], Array | EigenvalueRates]
"""Function from step sizes [s], shape (n,), to the matrices of a step, shape (n, m, m)."""


def jacobians(advance: SchemeStep, state: StateParts, count: int) -> Array:
    """Returns the derivatives of a step by its state, shape (count, d, d).

    `advance` takes steps of `count` sizes at once. `state` has d parts, numbers or arrays of shape
    (count,). Derivatives are carried by imaginary parts.
    """
    columns = []
    for varied in range(len(state)):
        nudged = [np.zeros(count) + part + 0j for part in state]
        nudged[varied] = nudged[varied] + 1j * IMAGINARY_STEP
        derivatives = [np.imag(part) / IMAGINARY_STEP for part in advance(0.0, nudged)]
        columns.append(np.stack(derivatives, axis=-1))
    return np.stack(columns, axis=-1)


def run_length(steps: Array, fastest: float) -> npt.NDArray[np.int64]:
    """Returns how many steps of each size in `steps` [s] must be stable, for a motion whose
    shortest period is `fastest` [s]."""
    periods = np.ceil(LEAST_PERIODS * fastest / steps)
    return np.maximum(STABLE_STEPS, periods.astype(np.int64))


def excess_growth(matrices: Matrices, rates: EigenvalueRates, steps: Array) -> Array:
    """Returns by how much a mode grows more in a step than in the exact motion, for the worst mode,
    shape (n,).

    Growth is the logarithm of the factor in one step of size `steps` [s], shape (n,). `matrices`
    gives the steps' matrices, `rates` [1/s] are the eigenvalues of the exact flow. The modes of the
    step and of the flow are matched in the order of their growth (eq. 13.3).
    """
    with np.errstate(divide="ignore"):
        growth = np.log(np.abs(np.linalg.eigvals(matrices(steps))))
    falling_growth = -np.sort(-growth, axis=1)
    exact_rates = np.full(growth.shape[1], -np.inf)  # -inf for modes that only the scheme has
    exact_rates[: len(rates)] = np.sort(rates.real)[::-1]
    allowed_growth = np.maximum(0.0, ALLOWED_MODE_GROWTH * steps[:, None] * exact_rates)
    return np.asarray((falling_growth - allowed_growth).max(axis=1))


def largest_step(
    matrices: Matrices,
    rates: EigenvalueRates,
    rate: float | None = None,
    factor: float = LOST_GROWTH,
) -> float:
    """Returns the step [s] below which every step is stable; infinite if no step of TESTED_PHASES
    fails.

    A step is stable if no mode grows by more than `factor` beyond its growth in the exact flow
    within `run_length` steps. `rates` [1/s] are the eigenvalues of the flow. `rate` [1/s] is the
    fastest rate of the whole motion; if it is left out, the fastest of `rates`.
    """
    rate = float(np.abs(rates).max()) if rate is None else rate

    def fails(steps: Array) -> StableMarks:
        """Returns which of `steps` [s] add growth to a mode, shape (n,)."""
        counts = run_length(steps, math.tau / rate)
        return counts * excess_growth(matrices, rates, steps) > math.log(factor)

    return first_failing_step(fails, rate)


def largest_lasting_step(matrices: Matrices, rates: EigenvalueRates) -> float:
    """Returns the step [s] below which no step damps an undamped swing to rest.

    A swing is at rest if it has shrunk to RESTING_SWING_FRACTION of its size within three quarters
    of `run_length` steps. `rates` [1/s] are the eigenvalues of the exact flow."""
    rate = float(np.abs(rates).max())

    def fails(steps: Array) -> StableMarks:
        """Returns which of `steps` [s] damp the swing to rest, shape (n,)."""
        spectral_radius = np.abs(np.linalg.eigvals(matrices(steps))).max(axis=1)
        counts = run_length(steps, math.tau / rate)
        log_swing = 0.75 * counts * np.log(spectral_radius)
        return np.asarray(log_swing < math.log(RESTING_SWING_FRACTION))

    return first_failing_step(fails, rate)


def first_failing_step(fails: Callable[[Array], StableMarks], rate: float) -> float:
    """Returns the step [s] below which no step fails; infinite if no step fails.

    The steps that are tested are TESTED_PHASES over the fastest `rate` [1/s]. The limit between the
    last step that holds and the first that fails is refined by bisection."""
    if not rate:
        return math.inf
    steps = np.geomspace(*TESTED_PHASES, STEP_GRID_SIZE) / rate
    failing = np.flatnonzero(fails(steps))
    if not failing.size:
        return math.inf
    held, failed = map(float, steps[[max(failing[0] - 1, 0), failing[0]]])

    def middle(held: float, failed: float) -> float | None:
        """Returns the geometric mean of two steps [s]; None if they agree to 1e-12."""
        return math.sqrt(held * failed) if failed / held - 1.0 > 1e-12 else None

    return bisected(lambda step: not fails(np.array([step]))[0], held, failed, middle)[0]
