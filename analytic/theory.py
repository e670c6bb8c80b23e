"""Predicted discretisation errors of one motion: records, protocol, and the range of a series."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import Scheme

Coefficients = Mapping[int, Signals]
"""Coefficients {p: {observable: C_p(t), shape (n,)}} of an error sum_p C_p step^p, simulated minus
exact."""


# Chosen: largest ratio of the sum of a series' last two terms to the sum of all terms
LARGEST_LAST_TERMS = 0.1
# Calibrated: largest nonlinearity of the motion's response at which the remainder of a series is
# bounded by its last two terms and `left_open.nonlinear_part`. At a nonlinearity of 0.09 (RK4 next
# to a separatrix) the last two terms bound only two thirds of the remainder.
LARGEST_NONLINEARITY = 0.03


def reaches(terms: Mapping[int, float], largest: float, nonlinearity: float) -> bool:
    """Returns whether a series describes the error at its step.

    `terms` are {p: largest |C_p| step^p}, `largest` is the largest value of their sum. The sum of
    the last two terms must be at most the fraction LARGEST_LAST_TERMS of `largest`. One term would
    not be enough: every other term of a nearly symmetric scheme can be tiny. The `nonlinearity` of
    the motion's response must be at most LARGEST_NONLINEARITY.
    """
    last = sum(terms[p] for p in sorted(terms)[-2:])
    return nonlinearity <= LARGEST_NONLINEARITY and last <= LARGEST_LAST_TERMS * largest


@dataclass(frozen=True)
class SteppedErrors:
    """Error of each observable for one step size, simulated minus exact, shape (n,)."""

    errors: Signals
    uncertainty: Signals | None = None
    """Response of the stepped motion to a unit in the last place of every input and of every step,
    shape (n,); None if the exact motion's uncertainty applies."""
    lasting: Signals = field(default_factory=dict)
    """Size, shape (n,), of the part of an observable's error that no smaller step reduces, if
    theory derives that size without taking a step: the depth of a contact, the drift of a body that
    friction holds, the jump of a force inside a step. The measured error and the error of stepped
    motions are differences from the same exact motion, which may be wrong. An error that does not
    fall with the step is therefore `predicted` only if it is derived."""


def signal_differences(stepped: Signals, exact: Signals) -> Signals:
    """Returns the `stepped` observables less the `exact` ones, for the names that are in both."""
    return {name: stepped[name] - values for name, values in exact.items() if name in stepped}


class ErrorTheory(Protocol):
    """Theory of the error of fixed steps on one exact motion: power series in the step, or errors
    at single step sizes."""

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Returns the coefficients of the global error of `scheme` at grid `times` [s], shape (n,);
        empty if there is no such series, or none is known."""
        ...

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Returns the error of `scheme` with `step` [s] at grid `times` [s], shape (n,), for each
        observable that theory covers.

        If friction stops a body inside a step, the error is a sawtooth and has no series. If the
        step is too large for a series, the scheme itself is run with this step and its error is
        measured. The errors are empty for schemes and
        steps that theory does not cover.
        """
        ...


Predicted = Signals | SteppedErrors


@dataclass(frozen=True)
class StepErrors:
    """An `ErrorTheory` of single step sizes, for motions without a series in the step.

    There is no series if a body stops or strikes inside a step, or if nothing moves.
    """

    error: Callable[[Scheme, float, Array], Predicted]
    """Function from a scheme, a step [s] and times [s] to the errors; empty for schemes and steps
    that theory does not cover."""

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Returns no coefficients."""
        return {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Returns the errors for one step size, see `ErrorTheory`."""
        known = self.error(scheme, step, times)
        return known if isinstance(known, SteppedErrors) else SteppedErrors(known)


def no_theory(problem: Any) -> ErrorTheory:
    """Returns the error theory of a system without one: it predicts no errors."""
    return StepErrors(lambda scheme, step, times: {})
