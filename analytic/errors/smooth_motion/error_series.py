"""The global error of a fixed-step scheme as a power series in its step.

Let z(t; h) = y(t) + sum_k h^k e_k(t) be what a scheme computes at the times it reaches, y the exact
motion, Psi_h the scheme's step and phi_h the exact flow. Stepping is z(t + h) = Psi_h(t, z(t)), so

    sum_k h^k e_k(t + h) = Psi_h(t, y + sum_k h^k e_k) - phi_h(t, y).

The right side is a power series in h with coefficients R_m. The left side's is
e_m + e_{m-1}' + e_{m-2}''/2! + ... Of e_m and e_{m-1}, R_m holds exactly e_m + J e_{m-1}, hence

    e_{m-1}' = J e_{m-1} + R_m[e_1 ... e_{m-2}] - sum_{j>=2} e_{m-j}^{(j)} / j!,    e(0) = 0,

a linear equation along the motion, for each order after the one before (Hairer, Norsett and Wanner
1993, Solving ODEs I, II.8). R_m comes exactly from the scheme run on truncated power series, the
terms that are not linear in the error included; the e^{(j)} from collocation polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.linear_flow import Response, together
from plumbob.analytic.numerics.power_series import Series, constant, flown, variable
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.theory import Coefficients, SteppedErrors

LONGER = 1.1  # the motion is followed to a power of this, further than the last time [s]
# Of a term, at a step in which the motion changes by 1, and of its own length so measured: rounding
# makes up to a tenth of it where a term is zero; what is taken for zero is below a step's rounding.
ROUNDING = 16 * ULP

Step = Callable[[Any, Any, Sequence[Any]], Sequence[Any]]
"""The time at a step's start [s], its length [s] and the state there -> the state after it."""


@dataclass(frozen=True, eq=False)
class ErrorSeries:
    """The series of all schemes' errors on one `motion`, whose state has these `names`; an
    `ErrorTheory`."""

    motion: SmoothMotion
    names: Sequence[str]
    slope: Callable[[Any, Sequence[Any]], Sequence[Any]]
    """Rates of change at a time [s] and a state, of series."""
    stepped: Callable[[Scheme], tuple[Step, Sequence[int]] | None]
    """The step of a scheme and the orders of its error that are followed; None for others."""

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Empty: beyond the range of the series there is no prediction."""
        return SteppedErrors({})

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """The coefficients C_p(t) of the error (scheme minus exact) sum_p C_p step^p at `times`
        [s], shape (n,), as {p: {name: (n,)}}; empty for other schemes. Raises ParameterError."""
        if (known := self.stepped(scheme)) is None:
            return {}
        last = float(np.max(times, initial=0.0)) or 1.0
        until = LONGER ** math.ceil(math.log(last, LONGER))
        errors = np.moveaxis(_expansion(self, scheme, until).at(times), 0, -1).copy()
        return {
            order: dict(zip(self.names, errors[:, column], strict=True))
            for column, order in enumerate(known[1])
        }


@lru_cache(maxsize=32)  # the same for all step sizes
def _expansion(series: ErrorSeries, scheme: Scheme, until: float) -> Response:
    """The coefficients of a scheme's error until a time [s] as the columns of one response."""
    known = series.stepped(scheme)
    motion = series.motion
    assert known is not None
    step, orders = known
    times, states, flow = motion.linearised(motion.grid(until))
    state = [constant(values, orders[-1] + 1) for values in states]
    exact = flown(lambda h, z: series.slope(times + h, z), state)
    least = ROUNDING * np.abs(states).max(axis=1) * (1.0 + motion.pace * until)
    responses: dict[int, Response] = {}
    for order in orders:
        after = step(times, variable(order + 1), state)
        left = np.stack(_left(after, exact, order + 1, times), axis=-1)
        source = left.reshape(*flow.matrix.shape[:3], 1) - sum(
            _derivatives(responses, order + 1)
        )
        response = flow.respond(np.zeros((len(states), 1)), source)
        responses[order] = _above(response, least * motion.pace**order)
        _include(state, order, responses[order])
    return together(list(responses.values()))


def _left(after: Sequence[Any], exact: Sequence[Any], m: int, times: Array) -> list[Array]:
    """Coefficient `m` of what a step leaves of the exact motion, of each part of the state."""
    pairs = zip(after, exact, strict=True)
    return [a.terms[m] - b.terms[m] + np.zeros_like(times) for a, b in pairs]


def _include(state: Sequence[Series], order: int, response: Response) -> None:
    """Sets the terms of an order."""
    errors = response.at_nodes()
    for part, error in zip(state, np.moveaxis(errors[..., 0], -1, 0), strict=True):
        part.terms[order] = error.ravel()


def _above(response: Response, levels: Array) -> Response:
    """The parts of a response that somewhere exceed these, and zero for the others."""
    sizes = np.abs(response.at_nodes()).max(axis=(0, 1, 3))
    kept = (sizes > levels).astype(float)[:, None]
    return Response(response.orbit, response.states * kept, response.slopes * kept)


def _derivatives(lower: Mapping[int, Response], m: int) -> list[Array]:
    """Coefficient `m` of what the errors of `lower` orders become in a step."""
    return [
        response.at_nodes(derivative=m - order) / math.factorial(m - order)
        for order, response in lower.items()
    ]
