"""The protocol of an exact motion: observables, their uncertainty, and nonlinearity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Signals = Mapping[str, Array]
"""Values of observables at n times, by name, in SI units, shape (n,) each."""


CACHED_RESULTS = 64  # results that caches store: some ten step sizes of a few problems


class NoAnswer(Exception):
    """Raised for parameters without an exact solution; the text is the reason, one line."""


@contextmanager
def answering() -> Iterator[None]:
    """Raises NoAnswer in place of numerical errors: an exact solution exceeds double precision."""
    try:
        with np.errstate(all="ignore"):
            yield
    except (ArithmeticError, np.linalg.LinAlgError, RuntimeError) as error:
        raise NoAnswer("double precision does not hold the exact solution") from error


class Reference(Protocol):
    """The exact motion of one problem, as functions of time."""

    def observe(self, times: Array) -> Signals:
        """Returns the exact observables at `times` [s], shape (n,), each of shape (n,), in SI
        units."""
        ...

    def uncertainty(self, times: Array) -> Signals:
        """Returns the uncertainty of each observable by double precision, shape (n,).

        It is a bound on the absolute error by rounding: of the inputs to doubles, and of the
        reference's own arithmetic.
        """
        ...

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Returns the nonlinearity of the motion's response to `errors`, shape (n,) each.

        It is 0 for a linear response, and about 1 if a linear expansion no longer applies.
        """
        ...


class LinearResponse:
    """Base of references whose motion responds linearly: errors of steps do not depend on earlier
    errors."""

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Returns 0: the response to errors is linear."""
        return 0.0


def remembered(observe: Callable[[Any, Array], Signals]) -> Callable[[Any, Array], Signals]:
    """Returns an `observe` that caches its last results, as read-only arrays.

    Methods and step sizes share samples, and so do an error, its uncertainty and its prediction.
    """

    @lru_cache(CACHED_RESULTS)
    def known(motion: Any, times: bytes) -> Signals:
        """Returns the observables at `times`, the bytes of times [s]."""
        observed = observe(motion, np.frombuffer(times))
        for values in observed.values():
            values.setflags(write=False)
        return observed

    return lambda motion, times: dict(known(motion, np.asarray(times, dtype=float).tobytes()))
