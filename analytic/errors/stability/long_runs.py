"""Long-run growth of a method's error on a periodic motion.

If the exact equation is autonomous, the modified equation of a step is autonomous too. Near a
periodic motion, its solution is the exact motion ahead by a time s(t), plus an error that repeats
in each period. The time ahead is s = a t + b t^2: a comes from the wrong period, b from the drift
of the energy, which changes the period. Derivation: THEORY.md, section 13.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors
from plumbob.analytic.numerics.rotor.orbit import ANGLE_AND_RATE
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.stability import LEVELS, Growth, LongRun

FITTED_PERIODS = 5  # periods over which the time ahead is fitted
TIME_SAMPLES_PER_PERIOD = 128  # samples in a period
# From the third term on, the series contains products of errors, and the time ahead is not linear
# in products.
LINEAR_TERMS = 2
# A part of the time ahead that is smaller, relative to the error along the motion, is rounding.
NEGLIGIBLE_TIME_AHEAD = 1e-9


@dataclass(frozen=True)
class PeriodicMotion:
    """A periodic motion of a conservative rotor, with its error theory and its `period` [s]."""

    errors: RotorErrors
    period: float

    def long_run(self, scheme: Scheme, step: float, scale: float) -> LongRun | None:
        """Returns the long-run growth of the error of a `scheme` with a `step` [s].

        Errors are measured in units of `scale` [rad]. Returns None if the scheme has no series.
        Raises ParameterError if the motion does not repeat.
        """
        if not (self.errors.rotor.conservative and math.isfinite(self.period)):
            raise ParameterError(
                "period", self.period, "finite, of an undamped unforced motion"
            )
        times = (
            np.arange(FITTED_PERIODS * TIME_SAMPLES_PER_PERIOD, dtype=np.float64)
            * self.period
            / TIME_SAMPLES_PER_PERIOD
        )
        error = self._error(scheme, step, times)
        if not error:
            return None
        observed = self.errors.exact.observe(times)
        time_ahead = self._time_ahead(times, error, observed)
        drifting = np.polyval(time_ahead, times) * times * observed["theta_dot"]
        repeating = (error["theta"] - drifting)[:TIME_SAMPLES_PER_PERIOD] / scale
        sign = math.copysign(1.0, time_ahead[0] or time_ahead[1])
        shifts = self._time_shifts(observed["theta"] / scale, repeating, sign)
        level_times = {}
        for level, shift in shifts.items():
            level_times[level] = _time_of_shift(time_ahead, shift)
        finite_times = [time for time in level_times.values() if 0.0 < time < math.inf]
        growth, rate = _growth(time_ahead, finite_times[0] if finite_times else self.period)
        return LongRun(growth, rate, self._energy_rate(scheme, step), level_times)

    def _error(self, scheme: Scheme, step: float, times: Array) -> Signals:
        """Returns the error of theta and theta_dot at `times` [s] by the first LINEAR_TERMS of the
        series; empty if the scheme has no series."""
        series = [*self.errors.series(scheme, times).items()][:LINEAR_TERMS]
        if not series:
            return {}
        error = {}
        for name in ANGLE_AND_RATE:
            error[name] = np.asarray(sum(step**power * terms[name] for power, terms in series))
        return error

    def _energy_rate(self, scheme: Scheme, step: float) -> float:
        """Returns the ratio of the energy's mean rate to the largest kinetic energy [1/s]."""
        coefficients = self.errors.energy_drift_rate(self.period, scheme).items()
        energy_rate = sum(coefficient * step**power for power, coefficient in coefficients)
        return energy_rate / kinetic_energy(self.errors.exact, self.period)

    def _time_ahead(self, times: Array, error: Signals, observed: Signals) -> Array:
        """Returns b [1/s] and a [s/s] of the time ahead b t^2 + a t.

        Both are fitted to the mean, over each period, of the error's component along the motion.
        `error` and `observed` are sampled at `times` [s]. If a coefficient is below rounding, it is
        set to zero.
        """
        rate = observed["theta_dot"]
        acceleration = self.errors.rotor.acceleration(0.0, observed["theta"], rate)
        frequency = math.tau / self.period
        along = error["theta"] * rate + error["theta_dot"] * acceleration / frequency**2
        means = along.reshape(FITTED_PERIODS, -1).mean(axis=1)
        squared_speed = float(
            (rate**2 + (acceleration / frequency) ** 2)[:TIME_SAMPLES_PER_PERIOD].mean()
        )
        middles = times.reshape(FITTED_PERIODS, -1).mean(axis=1)
        coefficients = np.polyfit(middles, means / squared_speed, 2)[:2]
        noise = NEGLIGIBLE_TIME_AHEAD * np.abs(along).max() / squared_speed
        ahead_after_period = coefficients * self.period ** np.array([2.0, 1.0])
        return np.where(np.abs(ahead_after_period) > noise, coefficients, 0.0)

    def _time_shifts(
        self, theta: Array, repeating: Array, sign: float
    ) -> Mapping[float, float]:
        """Returns for each of LEVELS the smallest time ahead [s] at which the error reaches that
        level.

        `theta` is the exact angle over some periods, `repeating` the part of the error that repeats
        in each period; both are over the error's scale. `sign` is the sign of the time ahead. If no
        time up to half a period reaches a level, the result for this level is infinite.
        """
        # The angle is a wave plus a mean growth, which is zero for a libration.
        mean_rate = (theta[TIME_SAMPLES_PER_PERIOD] - theta[0]) / self.period
        shifts = sign * self.period * np.geomspace(1e-7, 0.5, 2000)
        times = np.arange(TIME_SAMPLES_PER_PERIOD) * self.period / TIME_SAMPLES_PER_PERIOD
        wave = theta[:TIME_SAMPLES_PER_PERIOD] - mean_rate * times
        shift_rows = shifts[:, None]
        shifted_wave = np.interp(times + shift_rows, times, wave, period=self.period)
        change = shifted_wave + mean_rate * shift_rows - wave
        largest_error = np.abs(change + repeating).max(axis=1)
        smallest_shifts = {}
        for level in LEVELS:
            above = np.flatnonzero(largest_error >= level)
            smallest_shifts[level] = float(shifts[above[0]]) if above.size else math.inf
        return smallest_shifts


def kinetic_energy(exact: Reference, until: float) -> float:
    """Returns the largest kinetic energy per moment of inertia [rad^2/s^2] of an `exact` motion up
    to the time `until` [s]; 1 if the motion is at rest."""
    rates = exact.observe(np.linspace(0.0, until, TIME_SAMPLES_PER_PERIOD))["theta_dot"]
    return 0.5 * float(np.abs(rates).max()) ** 2 or 1.0


def _growth(time_ahead: Array, time: float) -> tuple[Growth, float]:
    """Returns the kind and the rate of growth that dominate a time ahead b t^2 + a t at a `time`
    [s]. `time_ahead` holds b and a."""
    quadratic, linear = map(float, time_ahead)
    if abs(quadratic * time) > abs(linear):
        return "quadratic", quadratic
    return ("linear" if linear else "constant"), linear


def _time_of_shift(time_ahead: Array, shift: float) -> float:
    """Returns the first positive time t [s] at which |b t^2 + a t| is `shift` [s]; infinite if
    there is none. `time_ahead` holds b and a."""
    roots = np.concatenate(
        [np.roots(np.append(time_ahead, sign * shift)) for sign in (1.0, -1.0)]
    )
    real = roots.real[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0.0)]
    return float(real.min()) if real.size and math.isfinite(shift) else math.inf
