"""Predicted discretisation errors of one motion, and where there is no prediction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from plumbob.analytic.errors.schemes import Scheme
from plumbob.analytic.reference import Array

Coefficients = Mapping[int, Mapping[str, Array]]
"""{p: {observable: C_p(t), shape (n,)}} of an error sum_p C_p step^p, simulated minus exact."""


class ErrorTheory(Protocol):
    """What is known of the error that a fixed step makes on one exact motion, in one of two ways:
    as a power series in the step, or for a step as it is."""

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Coefficients of the global error of `scheme` at grid `times` [s], shape (n,); empty where
        there is no such series, or none is known."""
        ...

    def at_step(self, scheme: Scheme, step: float, times: Array) -> Mapping[str, Array]:
        """Error of `scheme` with `step` [s] at grid `times` [s], shape (n,), for each observable
        that theory reaches: where friction stops a body inside a step, the error is a sawtooth and
        no series. Empty for schemes that it does not cover."""
        ...


@dataclass(frozen=True)
class StepErrors:
    """An `ErrorTheory` that gives the error for a step as it is."""

    error: Callable[[Scheme, float, Array], Mapping[str, Array]]

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Empty."""
        return {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> Mapping[str, Array]:
        """See `ErrorTheory`."""
        return self.error(scheme, step, times)


@dataclass(frozen=True)
class NoTheory:
    """An `ErrorTheory` without a prediction for any scheme."""

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Empty."""
        return {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> Mapping[str, Array]:
        """Empty."""
        return {}


def no_theory(problem: Any) -> ErrorTheory:
    """The theory of a system of which none is known."""
    return NoTheory()
