"""Energy and constraints at the model's own step, beside those of its continuous motion.

The continuous motion books the work of actuators, springs, dampers and friction exactly, as far as
it is certified, so that what the energy of the steps differs by from its energy is the steps' own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel


@dataclass(frozen=True)
class Balance:
    """One reading of the model at the ends of the control periods, up to where errors are known."""

    name: str
    own: float  # the largest magnitude at the own step; of an energy the largest change
    continuous: float  # the same of the continuous motion
    apart: float  # largest difference of the two at the same time


def balances(model: OwnModel, steps: Array, reference: Array, index: int) -> tuple[Balance, ...]:
    """Readings of two courses of states, shapes (n, ...), up to the period `index`. An energy is
    measured from its start, as it has no zero."""
    ours = model.readings(steps[: index + 1])
    theirs = model.readings(reference[: index + 1])
    found = []
    for name in [n for n in (*ours, *theirs) if n in ours or n in theirs]:
        zero = np.zeros(index + 1)
        one, other = ours.get(name, zero), theirs.get(name, zero)
        start = one[0] if name == "energy" else 0.0
        here, there = np.abs(one - start).max(), np.abs(other - start).max()
        found.append(Balance(name, float(here), float(there), float(np.abs(one - other).max())))
    return tuple(dict.fromkeys(found))
