"""Convergence of methods that no theory covers: does the error go to zero with the step?

The errors' envelope is the largest error in each octave of steps. The envelope has to fall. If the
error is smooth in the step, its extrapolation to a step of zero has to be zero. The constants are
rules of judgement, chosen and not derived.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.engines.study.measurement import Measurement, rounding_bound, worst
from plumbob.engines.study.order import fit_order
from plumbob.models.scene import Quantity

MIN_RUNS_PER_OCTAVE = 3  # least runs in an octave of steps: fewer may all be accurate by chance
LEAST_OCTAVES = 4  # octaves over which the envelope has to fall
LEAST_SLOPE = 0.5  # lower bound on the confidence interval of the envelope's slope
ROUND_OFFS = 10.0  # multiple of the round-off level: an error below it is not resolved
STALLED_RATIO = 0.7  # ratio of errors, two octaves apart, from which smaller steps do not help
# Largest residual of the series in the step, relative to the smallest error.
SMOOTH_RESIDUAL = 0.05
EXTRAPOLATED_RATIO = 0.5  # largest extrapolated error relative to the smallest measured error


@dataclass(frozen=True)
class Convergence:
    """The verdict by the envelope, with the reason: `converges`, `not-converging` or None."""

    verdict: Literal["converges", "not-converging"] | None
    reason: str


def convergence(runs: Sequence[Measurement], quantities: Sequence[Quantity]) -> Convergence:
    """Returns the verdict on the runs of a method without theory, coarse to fine, by their relative
    errors."""
    rows = [_run_row(run, quantities) for run in runs if run.status == "done"]
    complete = [row for row in rows if row]
    steps, errors, round_offs, ends = np.reshape(complete, (-1, 4)).T
    resolved = errors > ROUND_OFFS * round_offs
    maxima = _octave_maxima(steps, errors)
    resolved_maxima = maxima[resolved[maxima]]
    if len(maxima) < LEAST_OCTAVES:
        # A study ends early once its errors reach round-off.
        if len(steps) >= MIN_RUNS_PER_OCTAVE and not resolved.any():
            return Convergence("converges", f"within {ROUND_OFFS:g} round-offs at every step")
        return Convergence(
            None, f"{len(maxima)} octaves of steps, and {LEAST_OCTAVES} are needed"
        )
    smallest = f"the smallest error resolved is {errors[maxima].min():.2g}, relative"
    if not len(resolved_maxima):
        reason = f"within {ROUND_OFFS:g} round-offs at every step; {smallest}"
        return Convergence("converges", reason)
    finest = maxima[-1]
    if resolved[finest] and errors[finest] >= STALLED_RATIO * errors[maxima[-3]]:
        return Convergence("not-converging", _plateau(errors[finest], round_offs[finest]))
    if len(resolved_maxima) < LEAST_OCTAVES:
        reason = f"{len(resolved_maxima)} octaves above the round-off level; {smallest}"
        return Convergence(None, reason)
    slope = _envelope_slope(steps[resolved_maxima].tolist(), errors[resolved_maxima].tolist())
    if slope is None:
        reason = f"the error does not fall as a power of the step; {smallest}"
        return Convergence(None, reason)
    return _falling_verdict(steps[resolved], errors[resolved], ends[resolved], slope, smallest)


def _plateau(error: float, round_off: float) -> str:
    """Says at which relative error a method stays, and how far above its round-off level."""
    stays = f"the relative error stays at {error:.3g}"
    # An exact zero has no rounding.
    return f"{stays}, {error / round_off:.2g} times the round-off level" if round_off else stays


def _falling_verdict(
    steps: Array,
    errors: Array,
    ends: Array,
    slope: tuple[float, float, float],
    smallest: str,
) -> Convergence:
    """Returns the verdict on errors above round-off whose envelope falls. If they are smooth in the
    step and extrapolate to an error far from zero, they do not converge. `slope` is the envelope's
    slope with its confidence interval; `smallest` is a phrase on the smallest error."""
    finest = slice(-3 * MIN_RUNS_PER_OCTAVE, None)
    limit = _extrapolated_error(steps[finest], ends[finest], max(1, round(slope[0])))
    if limit > EXTRAPOLATED_RATIO * errors[-1]:
        reason = f"the error is smooth in the step, and leads to {limit:.2g} and not to zero"
        return Convergence("not-converging", f"{reason}; {smallest}")
    order = "of order {:.2f} ({:.2f} to {:.2f})".format(*slope)
    return Convergence("converges", f"{order}; {smallest}")


def _run_row(run: Measurement, quantities: Sequence[Quantity]) -> tuple[float, ...]:
    """Returns four numbers of a run: its step [s], its error, its round-off level, and its signed
    error at the end, all three relative to the scale of the worst quantity. Empty if the run lacks
    a quantity."""
    quantity, relative_error = worst(run, quantities)
    if math.isnan(relative_error):
        return ()
    error = run.errors[quantity.observable]
    round_off = rounding_bound(error, run.steps) / quantity.scale
    return run.step, relative_error, round_off, error.end / quantity.scale


def _octave_maxima(steps: Array, errors: Array) -> npt.NDArray[np.intp]:
    """Returns the indices of the runs with the largest error in each octave of steps, coarse to
    fine. An octave counts if it has MIN_RUNS_PER_OCTAVE runs or more."""
    octaves = np.floor(np.log2(steps / steps.min(initial=np.inf)) + 1e-9)
    coarse_to_fine = np.unique(octaves)[::-1]
    groups = [np.flatnonzero(octaves == octave) for octave in coarse_to_fine]
    full = [group for group in groups if len(group) >= MIN_RUNS_PER_OCTAVE]
    return np.array([group[errors[group].argmax()] for group in full], dtype=np.intp)


def _envelope_slope(
    steps: list[float], errors: list[float]
) -> tuple[float, float, float] | None:
    """Returns the slope of the envelope and the ends of its 95 % confidence interval, over the
    finest octaves. Their number is the smallest, four or more, with which the interval lies above
    LEAST_SLOPE. Returns None if there is no such number, or if the slope over the finest four is
    LEAST_SLOPE or less."""
    no_round_off = [0.0] * len(steps)
    for most in range(LEAST_OCTAVES, len(steps) + 1):
        fit = fit_order(steps, errors, no_round_off, most)
        if fit is None:
            return None
        if most == LEAST_OCTAVES and not fit.slope > LEAST_SLOPE:
            return None
        if fit.low > LEAST_SLOPE:
            return fit.slope, fit.low, fit.high
    return None


def _extrapolated_error(steps: Array, ends: Array, order: int) -> float:
    """Returns the magnitude of the error at the end, extrapolated to a step of zero by a series in
    the step that begins with the power `order`. Returns 0 if the error is not smooth in the
    step."""
    x = steps / steps[0]
    powers = np.stack([np.ones_like(x), x**order, x ** (order + 1)], axis=1)
    weights = 1.0 / np.abs(x**order)
    weighted_ends = ends * weights
    coefficients = np.linalg.lstsq(powers * weights[:, None], weighted_ends, rcond=None)[0]
    residuals = np.abs(powers @ coefficients - ends) * weights
    if residuals.max() > SMOOTH_RESIDUAL * float(np.abs(weighted_ends).min()):
        return 0.0
    return float(abs(coefficients[0]))
