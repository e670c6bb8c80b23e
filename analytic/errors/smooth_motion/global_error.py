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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_steps import (
    RotorStep,
    StepSeries,
    exact,
    rotor_step,
    simplest,
)
from plumbob.analytic.errors.smooth_motion.stepped_rotor import stepped_errors
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_flow import Response, together
from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.numerics.rotor.variational import TangentFlow
from plumbob.analytic.numerics.truncated_series import constant
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.pendulums.unending_motion import UnendingMotion
from plumbob.analytic.theory import Coefficients, SteppedErrors


def leading_error(
    rotor: DrivenRotor,
    theta: float,
    theta_dot: float,
    times: Array,
    scheme: Scheme,
    terms: int = 2,
) -> Coefficients:
    """The first `terms` coefficients C_p(t) of the error (scheme minus exact) sum_p C_p step^p of a
    motion from `theta` [rad], `theta_dot` [rad/s], at `times` [s], shape (n,), as {p: {"theta":
    (n,), "theta_dot": (n,)}}; empty for a scheme unknown to `rotor_step`. Raises ParameterError."""
    if (rotor_scheme := rotor_step(scheme)) is None:
        return {}
    flow = flow_until(rotor, theta, theta_dot, float(np.max(times, initial=0.0)) or 1.0)
    return _evaluated(*_as_one(expansion(flow, rotor_scheme, terms)), times)


@lru_cache(maxsize=4)  # the same for all schemes of one motion
def flow_until(rotor: DrivenRotor, theta: float, theta_dot: float, until: float) -> TangentFlow:
    """The linearisation along the motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] until
    the time `until` [s]. Raises ParameterError."""
    return TangentFlow(rotor, integrate(rotor, theta, theta_dot, until))


@dataclass(frozen=True)
class RotorErrors:
    """The error expansions of the motion of `rotor` from `theta` [rad], `theta_dot` [rad/s], which
    is `known` exactly or else integrated, each computed once; an `ErrorTheory`."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    known: Reference | None = None
    terms: int = 4
    _found: dict[Scheme, tuple[float, tuple[int, ...], Response]] = field(
        default_factory=dict, repr=False, compare=False
    )

    @cached_property
    def exact(self) -> Reference:
        """The exact motion."""
        return self.known or UnendingMotion(self.rotor, self.theta, self.theta_dot)

    def simplest(self, scheme: Scheme) -> Scheme:
        """A scheme with the same errors, the same for all schemes that have them."""
        return simplest(scheme, self.rotor)

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """`leading_error` at `times` [s], shape (n,). Raises ParameterError."""
        if (how := rotor_step(scheme)) is None:
            return {}
        known, last = self._found.get(scheme), float(np.max(times))
        if known is None or last > known[0]:
            until = 1.01 * last  # the next step may end a little later
            flow = flow_until(self.rotor, self.theta, self.theta_dot, until)
            known = until, *_as_one(expansion(flow, how, self.terms))
            self._found[scheme] = known
        return _evaluated(*known[1:], times)

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """The scheme stepped, less the exact motion, see `stepped_errors`."""
        start = self.theta, self.theta_dot
        return stepped_errors(self.rotor, start, scheme, step, times, self.exact)


def _as_one(coefficients: Mapping[int, Response]) -> tuple[tuple[int, ...], Response]:
    """The orders of an expansion, and its coefficients as the columns of one response."""
    return tuple(coefficients), together(tuple(coefficients.values()))


def _evaluated(orders: Sequence[int], response: Response, times: Array) -> Coefficients:
    """Values of an expansion at `times` [s], shape (n,), by order and by name."""
    theta, theta_dot = np.moveaxis(response.at(times), 0, -1).copy()
    return {p: {"theta": theta[i], "theta_dot": theta_dot[i]} for i, p in enumerate(orders)}


def expansion(flow: TangentFlow, scheme: RotorStep, terms: int = 2) -> Mapping[int, Response]:
    """The first `terms` coefficients of the scheme's error that are not zero, by order."""
    first = scheme.order_on(flow.rotor)
    stride = 2 if scheme.symmetric else 1
    last = first + stride * (terms - 1)
    step = StepSeries(flow.rotor, flow.times, scheme.control)
    state = [constant(values, last + 1) for values in flow.states]
    flown = exact(StepSeries(flow.rotor, flow.times), *state)
    responses: dict[int, Response] = {}
    for order in range(first, last + 1, stride):
        m = order + 1
        stepped = scheme.advance(step, *(series[: m + 1] for series in state))
        responses[order] = respond(flow, stepped, flown, m, responses)
        for i in (0, 1):
            state[i][order] = responses[order].at_nodes()[:, :, i, 0]
    return responses


def respond(
    flow: TangentFlow,
    stepped: Sequence[Array],
    flown: Sequence[Array],
    m: int,
    lower: Mapping[int, Response],
) -> Response:
    """Response to coefficient `m` of what a step leaves of the exact motion, less what the `lower`
    orders' responses explain of it."""
    source = np.stack([a[m] - b[m] for a, b in zip(stepped, flown, strict=True)], axis=-1)
    for order, response in lower.items():
        j = m - order
        source -= response.at_nodes(derivative=j)[..., 0] / math.factorial(j)
    return flow.respond(np.zeros((2, 1)), source[..., None])
