"""The global error of a fixed-step scheme as a power series in its step.

Let y be the exact motion, phi_h the exact flow and Psi_h the scheme's step. At the times that the
scheme reaches, its result is z(t; h) = y(t) + sum_k h^k e_k(t). Since z(t + h) = Psi_h(t, z(t)),

    sum_k h^k e_k(t + h) = Psi_h(t, y + sum_k h^k e_k) - phi_h(t, y).

The right side is a power series in h with coefficients R_m. The coefficients of the left side are
e_m + e_{m-1}' + e_{m-2}''/2! + ... In R_m, the errors e_m and e_{m-1} occur only as the terms
e_m + J e_{m-1}. Hence

    e_{m-1}' = J e_{m-1} + R_m[e_1 ... e_{m-2}] - sum_{j>=2} e_{m-j}^{(j)} / j!,    e(0) = 0,

a linear equation along the motion, which is solved order by order (Hairer, Norsett and Wanner 1993,
Solving ODEs I, II.8). Running the scheme on truncated power series gives R_m exactly, including the
terms that are nonlinear in the errors. The derivatives e^{(j)} come from collocation polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.linear_flow import LinearFlow, Response, join_columns
from plumbob.analytic.numerics.power_series import Series, constant, flow_series, variable
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.theory import Coefficients, SteppedErrors

# Motions are followed up to a power of this factor [s], so that similar durations share a result.
DURATION_FACTOR = 1.1
# A term of the series counts as zero below this size, relative to the state, at a step in which the
# state changes by about 1, and per such step of the time for which the motion keeps deviations.
# Rounding of a term that is zero makes at most a tenth of it. A term below it is smaller than the
# rounding of a step.
ZERO_TERM = 16 * ULP

Step = Callable[[Any, Any, Sequence[Any]], Sequence[Any]]
"""Function from the time [s], the step [s] and the state at its start to the state after it."""


@dataclass(frozen=True, eq=False)
class ErrorSeries:
    """The `ErrorTheory` of one `motion` for all schemes; `names` are the names of the state."""

    motion: SmoothMotion
    names: Sequence[str]
    slope: Callable[[Any, Sequence[Any]], Sequence[Any]]
    """Rates of change of a state, whose parts are series, at a time [s]."""
    stepped: Callable[[Scheme], tuple[Step, Sequence[int]] | None]
    """Function from a scheme to its step and the orders of its error; None for schemes without a
    series."""

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Returns no errors: there is no prediction for steps beyond the range of the series."""
        return SteppedErrors({})

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Returns the coefficients C_p(t) of a scheme's error as {p: {name: C_p}}.

        The error, scheme minus exact, is sum_p C_p step^p. C_p and `times` [s] have the shape (n,).
        If the scheme has no series, the result is empty. Raises ParameterError if the motion is too
        long to be followed.
        """
        step_and_orders = self.stepped(scheme)
        if step_and_orders is None:
            return {}
        _, orders = step_and_orders
        last = float(np.max(times, initial=0.0)) or 1.0
        until = DURATION_FACTOR ** math.ceil(math.log(last, DURATION_FACTOR))
        errors = np.moveaxis(_expansion(self, scheme, until).at(times), 0, -1).copy()
        return {
            order: dict(zip(self.names, errors[:, column], strict=True))
            for column, order in enumerate(orders)
        }


@lru_cache(maxsize=32)  # all step sizes share the result
def _expansion(series: ErrorSeries, scheme: Scheme, until: float) -> Response:
    """Returns the coefficients of a scheme's error up to the time `until` [s].

    The coefficients of the orders, from the lowest on, are the columns of one response.
    """
    step_and_orders = series.stepped(scheme)
    assert step_and_orders is not None
    step, orders = step_and_orders
    motion = series.motion
    times, states, flow = motion.linearised(motion.grid(until))
    state = [constant(values, orders[-1] + 1) for values in states]
    exact = flow_series(lambda h, z: series.slope(times + h, z), state)
    sizes = np.abs(states).max(axis=1)
    noise = ZERO_TERM * sizes * (1.0 + motion.pace * _memory(flow, sizes))
    responses: dict[int, Response] = {}
    for order in orders:
        after = step(times, variable(order + 1), state)
        source = np.stack(_step_error(after, exact, order + 1, times), axis=-1)
        source = source.reshape(*flow.matrix.shape[:3], 1)
        source = source - sum(_derivative_terms(responses, order + 1))
        responses[order] = flow.respond(np.zeros((len(states), 1)), source)
        responses[order] = _without_noise(responses[order], noise * motion.pace**order)
        _set_terms(state, order, responses[order])
    return join_columns(list(responses.values()))


def _memory(flow: LinearFlow, sizes: Array) -> Array:
    """Returns the time [s] for which each part of the state keeps small deviations, shape (d,).

    It is the integral over time of a part's largest response to deviations at the start. Deviations
    and responses are relative to `sizes`, the largest magnitudes of the parts, shape (d,). The
    limit is the duration, which is also the time of a motion without damping.
    """
    deviations = np.diag(sizes)
    integral = np.zeros(len(sizes))
    for length, transition in zip(
        np.diff(flow.grid.breakpoints), flow.transitions, strict=True
    ):
        deviations = transition @ deviations
        integral += length * np.abs(deviations).sum(axis=1)
    return np.minimum(integral / np.where(sizes > 0.0, sizes, 1.0), flow.grid.duration)


def _step_error(
    after: Sequence[Any], exact: Sequence[Any], degree: int, times: Array
) -> list[Array]:
    """Returns the term of a `degree` in the error of a step, `after` minus `exact`, for each part
    of the state, shape (n,) each."""
    differences = []
    for part, exact_part in zip(after, exact, strict=True):
        difference = part.terms[degree] - exact_part.terms[degree]
        differences.append(difference + np.zeros_like(times))
    return differences


def _set_terms(state: Sequence[Series], order: int, response: Response) -> None:
    """Sets the terms of an `order` in the series of a `state` to the errors of a response."""
    errors = response.at_nodes()
    for part, error in zip(state, np.moveaxis(errors[..., 0], -1, 0), strict=True):
        part.terms[order] = error.ravel()


def _without_noise(response: Response, noise: Array) -> Response:
    """Returns a response whose parts are set to zero unless they somewhere exceed `noise`."""
    sizes = np.abs(response.at_nodes()).max(axis=(0, 1, 3))
    factors = (sizes > noise).astype(float)[:, None]
    return Response(response.orbit, response.states * factors, response.slopes * factors)


def _derivative_terms(lower: Mapping[int, Response], degree: int) -> list[Array]:
    """Returns e_k^(j)/j! with j = `degree` - k, for the response e_k of each of the `lower` orders
    k."""
    return [
        response.at_nodes(derivative=degree - order) / math.factorial(degree - order)
        for order, response in lower.items()
    ]
