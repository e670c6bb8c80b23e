"""Cache of exact observables and predicted errors, shared by all methods with the same samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.reference import KEPT, Signals
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.theory import SteppedErrors

Powers = Mapping[int, Signals]  # {p: {observable: C_p step^p at the samples}}


@dataclass(frozen=True, eq=False)
class Same:
    """Cache key that compares its object by identity."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.value is other.value

    def __hash__(self) -> int:
        return id(self.value)


@lru_cache(maxsize=KEPT)
def exactly(exact: Same, times: bytes) -> tuple[Signals, Signals]:
    """Returns the observables of a Reference and their uncertainty at `times`, the bytes of times
    [s]."""
    samples = np.frombuffer(times)
    return exact.value.observe(samples), exact.value.uncertainty(samples)


@lru_cache(maxsize=KEPT)
def expected(
    exact: Same, theory: Same, scheme: Scheme, step: float, times: bytes
) -> tuple[Powers, Signals, float]:
    """Returns the terms of an ErrorTheory's series, their sum, and the sum's nonlinearity.

    `step` is in [s], `times` are the bytes of times [s]. The sum has the observables that occur in
    every power. All methods of a scheme share the result.
    """
    samples = np.frombuffer(times)
    powers = {}
    for power, coefficients in theory.value.series(scheme, samples).items():
        powers[power] = {name: c * step**power for name, c in coefficients.items()}
    common = set.intersection(*map(set, powers.values())) if powers else set()
    started = samples > 0.0  # at time 0 no step has been taken, and no joint has pulled
    total = {}
    for name in sorted(common):
        error = sum(terms[name] for terms in powers.values())
        total[name] = np.where(started, error, 0.0)
    nonlinearity = exact.value.nonlinearity(samples, total) if total else 0.0
    return powers, total, nonlinearity


@lru_cache(maxsize=KEPT)
def as_stepped(theory: Same, scheme: Scheme, step: float, times: bytes) -> SteppedErrors:
    """Returns the errors of an ErrorTheory for one step size; arguments are as in `expected`."""
    errors: SteppedErrors = theory.value.at_step(scheme, step, np.frombuffer(times))
    return errors
