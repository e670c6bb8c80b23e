"""The protocol of an exact answer: observables, their uncertainty, nonlinearity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Signals = Mapping[str, Array]
"""Values by name of observable, at times: SI, shape (n,) each."""


KEPT = 64  # sets of samples: some ten step sizes, of a few problems


class NoAnswer(Exception):
    """A point without an exact answer; its text is the reason, one line."""


@contextmanager
def answering() -> Iterator[None]:
    """Raises NoAnswer where double precision does not hold an exact solution."""
    try:
        with np.errstate(all="ignore"):
            yield
    except (ArithmeticError, np.linalg.LinAlgError, RuntimeError) as error:
        raise NoAnswer("double precision does not hold the exact solution") from error


class Reference(Protocol):
    """The exact motion of one problem, as functions of time."""

    def observe(self, times: Array) -> Signals:
        """Exact observables at `times` [s], shape (n,), each of shape (n,), in SI units."""
        ...

    def uncertainty(self, times: Array) -> Signals:
        """Uncertainty of double precision: for each observable the absolute error that inputs
        rounded to double, and the reference's own arithmetic, may have caused, shape (n,)."""
        ...

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the motion's response to errors of this size, shape (n,) each: 0 while it
        is linear, about 1 where a linear expansion no longer applies."""
        ...


class LinearResponse:
    """Of a motion whose steps have errors that do not depend on earlier ones."""

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """0: the response to errors is linear."""
        return 0.0


def remembered(observe: Callable[[Any, Array], Signals]) -> Callable[[Any, Array], Signals]:
    """An `observe` of motions that keeps its last answers, read-only: methods and steps share their
    samples, and an error, its uncertainty and its prediction are of the same ones."""

    @lru_cache(KEPT)
    def known(motion: Any, times: bytes) -> Signals:
        observed = observe(motion, np.frombuffer(times))
        for values in observed.values():
            values.setflags(write=False)
        return observed

    return lambda motion, times: dict(known(motion, np.asarray(times, dtype=float).tobytes()))
