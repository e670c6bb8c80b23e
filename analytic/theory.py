"""Predicted discretisation errors of one motion, and where there is no prediction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import Scheme

Coefficients = Mapping[int, Signals]
"""{p: {observable: C_p(t), shape (n,)}} of an error sum_p C_p step^p, simulated minus exact."""


TRUST = 0.1  # chosen: how much of a series its last two terms may be
# Calibrated: how nonlinear the motion's response may be, for those terms and the first nonlinear
# one that is left out (`left_open.nonlinear_part`) to hold what follows. At 0.09 (RK4 next to a
# separatrix) those terms alone hold two thirds of it.
LINEAR = 0.03


def reaches(terms: Mapping[int, float], largest: float, nonlinearity: float) -> bool:
    """Whether a series reaches the step: of its `terms`, {p: largest |C_p| step^p}, the last two,
    since near-symmetric schemes can have tiny alternate ones, are at most a tenth of the `largest`
    value of their sum, and the motion's response to it is linear but for LINEAR."""
    last = sum(terms[p] for p in sorted(terms)[-2:])
    return nonlinearity <= LINEAR and last <= TRUST * largest


@dataclass(frozen=True)
class SteppedErrors:
    """Error of each observable for one step size, simulated minus exact, shape (n,)."""

    errors: Signals
    uncertainty: Signals | None = None
    """Response of the stepped motion to a unit in the last place of every input and of every step,
    shape (n,); None where that of the exact motion applies."""
    lasting: Signals = field(default_factory=dict)
    """Size, shape (n,), of the part of an observable's error that no smaller step reduces, if
    theory derives that size without taking a step: the depth of a contact, the drift of a body that
    friction holds, the jump of a force inside a step. The measured error and the error of stepped
    motions are differences from the same exact motion, which may be wrong. An error that does not
    fall with the step is therefore `predicted` only if it is derived."""


def apart(stepped: Signals, exact: Signals) -> Signals:
    """Observables that steps reach less the `exact` ones, of those that are in both."""
    return {name: stepped[name] - values for name, values in exact.items() if name in stepped}


class ErrorTheory(Protocol):
    """The error of a fixed step on one exact motion, as a power series in the step or for one step
    size."""

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Coefficients of the global error of `scheme` at grid `times` [s], shape (n,); empty where
        there is no such series, or none is known."""
        ...

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Error of `scheme` with `step` [s] at grid `times` [s], shape (n,), for each observable
        that theory reaches: where friction stops a body inside a step, the error is a sawtooth
        without a series, and where the step is too large for a series, the scheme is stepped. Empty
        for schemes and steps that it does not cover."""
        ...


Predicted = Signals | SteppedErrors


@dataclass(frozen=True)
class StepErrors:
    """An `ErrorTheory` of single step sizes, by an `error`, empty for schemes and steps that are
    not covered: where in its step something stops or strikes decides, or nothing moves, so that
    there is no series in the step."""

    error: Callable[[Scheme, float, Array], Predicted]

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Empty."""
        return {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """See `ErrorTheory`."""
        known = self.error(scheme, step, times)
        return known if isinstance(known, SteppedErrors) else SteppedErrors(known)


def no_theory(problem: Any) -> ErrorTheory:
    """The theory of a system that has none."""
    return StepErrors(lambda scheme, step, times: {})
