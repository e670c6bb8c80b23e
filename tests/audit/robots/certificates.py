"""Certificates held against a file's own integrators at steps 256 to 4096 times smaller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.reference import RESOLVED, largest

FINEST, LEAST = 4096, 256  # times smaller than the own step
MANY = 1e3  # roundings of a motion that up to a million steps may add up to, in a random walk
LIMIT = 60.0  # [s] of processor time that a run is to take
# From a step to a quarter of it an error that goes as a power from a half on is at least halved:
# what is left of it is at most what the two differ by.
QUARTER = 4
HOLDS, OUTSIDE, OPEN = "holds", "OUTSIDE", "not outside: steps tell less"


@dataclass(frozen=True)
class Confirmation:
    """What small steps of one integrator make of a motion that is certified, at the ends of the
    control periods."""

    integrator: str
    finer: int  # times smaller than the own step
    apart: Array  # [m] from the reference at most so far
    scatter: Array  # [m] how far these steps may be from their own limit
    error: float  # [m] of the own step, held against them


def confirmations(found: Audit, limit: float = LIMIT) -> list[Confirmation]:
    """Euler and RK4 at steps as small as `limit` [s] of processor time each allow."""
    model, script, steps = found.model, found.script, found.found
    assert model is not None
    assert steps is not None
    count = steps.index + 1

    def motion(integrator: str, factor: int) -> tuple[Array, float]:
        run = model.stepped(script, integrator, factor * steps.own.parts)
        return model.positions(run.states[:count]), run.seconds

    own, _ = motion(found.integrator, 1)
    confirmed = []
    for integrator in ("euler", "rk4"):
        seconds = motion(integrator, QUARTER**2)[1] / QUARTER**2
        most = limit / (seconds * (1 + 1 / QUARTER))
        factor = next((f for f in (FINEST, FINEST // QUARTER) if f <= most), LEAST)
        fine, coarse = (motion(integrator, f)[0] for f in (factor, factor // QUARTER))
        apart = so_far(fine, found.reference.positions[:count])
        error = float(so_far(own, fine)[-1])
        confirmed.append(Confirmation(integrator, factor, apart, so_far(fine, coarse), error))
    return sorted(confirmed, key=lambda c: c.scatter[-1])


def verdict(found: Audit, confirmed: Sequence[Confirmation]) -> str:
    """Whether the certificate has the small steps of both integrators outside, or the better ones
    tell less than it does."""
    best, rounding = confirmed[0], MANY * found.reference.rounding
    known = found.reference.uncertainty[: best.apart.size]
    if np.all([c.apart > known + c.scatter + rounding for c in confirmed], axis=0).any():
        return OUTSIDE
    tells = best.scatter[-1] <= max(RESOLVED * known[-1], rounding)
    return HOLDS if tells else OPEN


def so_far(one: Array, other: Array) -> Array:
    """The largest distance [m] of any body so far between two motions, shape (n,)."""
    return largest(np.linalg.norm(one - other, axis=2))
