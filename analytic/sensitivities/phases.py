"""Sensitivities of a motion whose formula changes at known times: differences phase by phase.

In phase k, from T_k to T_k+1, an observable o(t; q) is smooth in the time t and in the parameter q;
after it another formula holds. Close to a switch, a difference at a fixed time would mix two
formulas. A difference at a fixed fraction f of the phase does not. With
tau(q) = T_k + f (T_k+1 - T_k),

    do/dq at fixed t = d/dq o(tau(q); q) - (do/dt) dtau/dq                                      (1)

This includes the saltation at every switch, without its equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.sensitivities.neighbours import (
    OFFSETS_ABOVE,
    Derived,
    Neighbours,
    Sensitivity,
    in_rows,
)

# Ratios of the stencils' widths for do/dt to the length of the phase. Close to the end of a phase
# short stencils are needed: a support's direction settles as a power of the time that is left.
WINDOW_RATIOS = 0.125 ** np.arange(1.0, 6.0)
# Latest fraction of a phase: at its very end round-off decides which formula holds.
LATEST_FRACTION = 1.0 - 1e-11


@dataclass(frozen=True)
class Phased:
    """A motion and the times at which its formula changes [s], ascending from 0, shape (k,)."""

    reference: Reference
    switches: Array


def phased_gradients(motions: Sequence[Neighbours[Phased]], times: Array) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter (eq. 1); `motions`
    has the neighbours by one parameter each."""
    here = motions[0].here
    names = list(here.reference.observe(times))
    phases = np.searchsorted(here.switches, times, side="right") - 1
    sensitivities = []
    for neighbours in motions:
        results = np.empty((2, len(names), times.size))
        for phase in np.unique(phases):
            inside = phases == phase
            results[..., inside] = _phase_sensitivities(
                neighbours, names, int(phase), times[inside]
            )
        values, uncertainties = (dict(zip(names, rows, strict=True)) for rows in results)
        sensitivities.append(Sensitivity(values, uncertainties))
    return sensitivities


def _phase_sensitivities(
    motions: Neighbours[Phased], names: Sequence[str], phase: int, times: Array
) -> Derived:
    """Returns the sensitivities (eq. 1) and their uncertainties, shape (observables, n), at `times`
    [s] within one `phase`."""
    here = motions.here
    since = times - here.switches[phase]
    last = phase + 1 == len(here.switches)
    length = np.inf if last else float(here.switches[phase + 1] - here.switches[phase])
    fraction = np.minimum(since / length, LATEST_FRACTION)

    def tau(motion: Phased) -> Array:
        """Returns tau of eq. 1 for a motion, whose parameter is q: the times [s] in the motion's
        phase at the fractions f of `times`; in the last phase, equally long after its begin."""
        begin = motion.switches[phase]
        if last:
            return np.asarray(begin + since)
        return np.asarray(begin + fraction * (motion.switches[phase + 1] - begin))

    def read(motion: Phased) -> Array:
        """Returns the observables of a motion at its times tau, shape (observables, n)."""
        return in_rows(motion.reference.observe(tau(motion)), names)

    # A motion with a closed form has neighbours without one, whose uncertainties are larger.
    errors = []
    for motion in (motions.moved[0], here, motions.moved[-1]):
        errors.append(in_rows(motion.reference.uncertainty(tau(motion)), names))
    values, uncertainty = motions.derivative(read, np.max(errors, axis=0))
    shift, shift_doubt = motions.derivative(tau)
    if not shift.any():
        return values, uncertainty
    slope, slope_doubt = _slopes(here, names, float(here.switches[phase]), length, times)
    uncertainty = uncertainty + np.abs(slope) * shift_doubt + slope_doubt * np.abs(shift)
    return values - slope * shift, uncertainty


def _slopes(
    motion: Phased, names: Sequence[str], begin: float, length: float, times: Array
) -> Derived:
    """Returns do/dt within a phase and its uncertainty, shape (observables, n) each.

    At each time, the result is taken from the window with the smallest uncertainty. In the last
    phase everything is at rest: both are zero.
    """
    shape = len(names), times.size
    if not np.isfinite(length):
        return np.zeros(shape), np.zeros(shape)
    slopes = np.zeros(shape)
    uncertainty = np.full(shape, np.inf)
    inward = np.where(times - begin < 0.5 * length, 1.0, -1.0)  # away from the nearer end
    for width in length * WINDOW_RATIOS:
        step = inward * width / OFFSETS_ABOVE[-1]
        ahead = tuple(
            in_rows(motion.reference.observe(times + k * step), names) for k in OFFSETS_ABOVE
        )
        stencil = Neighbours(ahead, np.array(OFFSETS_ABOVE, dtype=float))
        rate, rate_doubt = stencil.derivative(np.asarray)
        rate = rate / step
        rate_doubt = rate_doubt / np.abs(step)
        better = rate_doubt < uncertainty
        slopes = np.where(better, rate, slopes)
        uncertainty = np.where(better, rate_doubt, uncertainty)
    return slopes, uncertainty
