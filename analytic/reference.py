"""What an exact answer must be able to say of itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Reference(Protocol):
    """The exact motion of one problem, as functions of time."""

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` [s], shape (n,), each of shape (n,), in SI units."""
        ...

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """What double precision allows: for each observable the absolute error that inputs
        rounded to double, and the reference's own arithmetic, may have caused, shape (n,)."""
        ...

    def leading_error(self, scheme: str, times: Array) -> Mapping[int, Mapping[str, Array]]:
        """Coefficients C_p(t) of a scheme's global error sum_p C_p(t) step^p, as
        {p: {observable: shape (n,)}}; empty where theory has none."""
        ...

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """How far errors of this size, shape (n,) each, carry the motion to where its response to
        them is no longer linear: 0 while it is, about 1 where a linear expansion says nothing."""
        ...


@runtime_checkable
class StepReference(Protocol):
    """An exact answer that knows a fixed step's error itself, where it is no series in the step:
    friction stops a body inside a step, and the error is a sawtooth."""

    def predicted(self, scheme: str, step: float, times: Array) -> Mapping[str, Array]:
        """Error, simulated minus exact, of a scheme with `step` [s] at grid `times` [s], shape
        (n,), for each observable that theory reaches; empty for a scheme that it does not."""
        ...
