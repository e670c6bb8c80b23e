"""How long a method stays right on a periodic motion: by the growth of its error (THEORY.md, 13).

A step's modified equation is autonomous where the exact one is. Its motion near a periodic one is
that motion ahead by a time s(t), but for an error that repeats: s = a t + b t^2, a from the wrong
period, b from the energy's drift, which changes the period.
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

PERIODS = 5  # over which the time ahead is followed
SAMPLES = 128  # of a period
# of the error's series: products of errors, which the time ahead is not linear in, begin
TERMS = 2
# with the third
# of a part of the time ahead, relative to what the error makes of it in a period
NOTHING = 1e-9


@dataclass(frozen=True)
class PeriodicMotion:
    """The `errors` on a conservative rotor's exact motion of a finite `period` [s]."""

    errors: RotorErrors
    period: float

    def long_run(self, scheme: Scheme, step: float, scale: float) -> LongRun | None:
        """The growth of the error of `scheme` with `step` [s], over a `scale` [rad]; None for a
        scheme without a series. Raises ParameterError where the motion does not repeat."""
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
        """b and a of b t^2 + a t, by the error's mean component along the motion in each period;
        of what is nothing, zero."""
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
        """The time ahead [s] at which the error first reaches each level; infinite where none up
        to half a period does. Angles are over their scale."""
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
    """The largest per moment of inertia [rad^2/s^2] of a motion `until` a time [s]; 1 at rest."""
    rates = exact.observe(np.linspace(0.0, until, SAMPLES))["theta_dot"]
    return 0.5 * float(np.abs(rates).max()) ** 2 or 1.0


def _when(ahead: Array, shift: float) -> float:
    """The first time [s] at which the time ahead is `shift` [s], of either sign."""
    roots = np.concatenate([np.roots(np.append(ahead, side * shift)) for side in (1.0, -1.0)])
    real = roots.real[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 0.0)]
    return float(real.min()) if real.size and math.isfinite(shift) else math.inf
