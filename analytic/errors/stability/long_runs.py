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
from plumbob.analytic.numerics.rotor.orbit import ANGLE
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.stability import LEVELS, Growth, LongRun

PERIODS = 5  # periods over which the time ahead is fitted
SAMPLES = 128  # samples in a period
# From the third term on, the series contains products of errors, and the time ahead is not linear
# in products.
TERMS = 2
# A part of the time ahead that is smaller, relative to the error along the motion, is rounding.
NOTHING = 1e-9


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
        times = np.arange(PERIODS * SAMPLES, dtype=np.float64) * self.period / SAMPLES
        series = [*self.errors.series(scheme, times).items()][:TERMS]
        if not series:
            return None
        observed = self.errors.exact.observe(times)
        error = {n: np.asarray(sum(step**p * part[n] for p, part in series)) for n in ANGLE}
        ahead = self._time_ahead(times, error, observed)
        steady = error["theta"] - np.polyval(ahead, times) * times * observed["theta_dot"]
        sign = math.copysign(1.0, ahead[0] or ahead[1])
        reached = self._time_shifts(observed["theta"] / scale, steady[:SAMPLES] / scale, sign)
        spent = {level: _when(ahead, shift) for level, shift in reached.items()}
        first = next((time for time in spent.values() if 0.0 < time < math.inf), self.period)
        quadratic = abs(ahead[0] * first) > abs(ahead[1])
        growth: Growth = "quadratic" if quadratic else "linear" if ahead[1] else "constant"
        rates = self.errors.energy_drift_rate(self.period, scheme).items()
        drift = sum(rate * step**p for p, rate in rates) / kinetic_energy(
            self.errors.exact, self.period
        )
        return LongRun(growth, float(ahead[0 if quadratic else 1]), drift, spent)

    def _time_ahead(self, times: Array, error: Signals, observed: Signals) -> Array:
        """Returns b [1/s] and a [s/s] of the time ahead b t^2 + a t.

        Both are fitted to the mean, over each period, of the error's component along the motion.
        `error` and `observed` are sampled at `times` [s]. If a coefficient is below rounding, it is
        set to zero.
        """
        theta = observed["theta"]
        rate = observed["theta_dot"]
        push = self.errors.rotor.acceleration(0.0, theta, rate)
        scale = math.tau / self.period
        along = error["theta"] * rate + error["theta_dot"] * push / scale**2
        means = along.reshape(PERIODS, -1).mean(axis=1)
        size = float((rate**2 + (push / scale) ** 2)[:SAMPLES].mean())
        middles = times.reshape(PERIODS, -1).mean(axis=1)
        fitted = np.polyfit(middles, means / size, 2)[:2]
        noise = NOTHING * np.abs(along).max() / size
        lasting = fitted * self.period ** np.array([2.0, 1.0])
        return np.where(np.abs(lasting) > noise, fitted, 0.0)

    def _time_shifts(
        self, theta: Array, repeating: Array, sign: float
    ) -> Mapping[float, float]:
        """Returns the smallest time ahead [s] at which the error reaches each of LEVELS.

        `theta` is the exact angle, `repeating` the error that repeats in each period, both over
        their scale. `sign` is the sign of the time ahead. If no shift up to half a period reaches a
        level, the time ahead is infinite.
        """
        rate = (theta[SAMPLES] - theta[0]) / self.period  # of a rotation
        shifts = sign * self.period * np.geomspace(1e-7, 0.5, 2000)[:, None]
        spaced = np.arange(SAMPLES) * self.period / SAMPLES
        wave = theta[:SAMPLES] - rate * spaced
        moved = np.interp(spaced + shifts, spaced, wave, period=self.period) + rate * shifts
        errors = np.abs(moved - wave + repeating).max(axis=1)
        above = {level: np.flatnonzero(errors >= level) for level in LEVELS}
        return {
            level: float(shifts[first[0], 0]) if first.size else math.inf
            for level, first in above.items()
        }


def kinetic_energy(exact: Reference, until: float) -> float:
    """Returns the largest kinetic energy per moment of inertia [rad^2/s^2] of an `exact` motion up
    to the time `until` [s]; 1 if the motion is at rest."""
    rates = exact.observe(np.linspace(0.0, until, SAMPLES))["theta_dot"]
    return 0.5 * float(np.abs(rates).max()) ** 2 or 1.0


def _when(ahead: Array, shift: float) -> float:
    """Returns the first positive time t [s] at which |b t^2 + a t| is `shift` [s]; infinite if
    there is none. `ahead` holds b and a."""
    roots = np.concatenate([np.roots(np.append(ahead, side * shift)) for side in (1.0, -1.0)])
    real = roots.real[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0.0)]
    return float(real.min()) if real.size and math.isfinite(shift) else math.inf
