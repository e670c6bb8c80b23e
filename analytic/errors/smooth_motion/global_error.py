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
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_steps import (
    RotorStep,
    exact,
    rotor_step,
    simplest,
)
from plumbob.analytic.errors.smooth_motion.stepped_rotor import stepped_errors
from plumbob.analytic.numerics.linear_flow import Response, together
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.variational import tangent_flow
from plumbob.analytic.numerics.truncated_series import constant
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.theory import Coefficients, SteppedErrors

SAMPLES = 65  # of a period, for the size of the errors there
NEGLIGIBLE = 1e-10  # of an energy error's size in a period: what collocation and round-off leave
LONGER = 1.1  # the motion is followed to a power of this, further than the last time [s]


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
    if (how := rotor_step(scheme)) is None:
        return {}
    last = float(np.max(times, initial=0.0)) or 1.0
    until = LONGER ** math.ceil(math.log(last, LONGER))
    orders, response = _expansion(rotor, theta, theta_dot, until, how, terms)
    angles, rates = np.moveaxis(response.at(times), 0, -1).copy()
    return {p: {"theta": angles[i], "theta_dot": rates[i]} for i, p in enumerate(orders)}


def energy_drift_rate(
    rotor: DrivenRotor, theta: float, theta_dot: float, period: float, scheme: Scheme
) -> Mapping[int, float]:
    """Coefficients D_p of the mean rate sum_p D_p step^p at which `scheme` changes the energy per
    moment of inertia [rad^2/s^3 over s^p] on the undamped motion of `period` [s] from `theta`
    [rad], `theta_dot` [rad/s], up to twice the scheme's order: that of its error after a period.
    Zero where nothing drifts, empty for a scheme unknown to `rotor_step`. Raises ParameterError."""
    if not rotor.conservative:
        raise ParameterError("rotor", rotor, "without damping and forcing")
    if (how := rotor_step(scheme)) is None:
        return {}
    times, pull = np.linspace(0.0, period, SAMPLES), rotor.acceleration(0.0, theta, theta_dot)
    fastest = np.abs(tangent_flow(rotor, theta, theta_dot, period).states[1]).max()
    rates = {}
    for power, error in leading_error(rotor, theta, theta_dot, times, scheme, how.order).items():
        gained = float(theta_dot * error["theta_dot"][-1] - pull * error["theta"][-1])
        size = np.abs(error["theta_dot"]).max() + fastest * (math.tau / period) ** power
        if power < 2 * how.order:
            rates[power] = gained / period if abs(gained) > NEGLIGIBLE * fastest * size else 0.0
    return rates


@dataclass(frozen=True)
class RotorErrors:
    """The error expansions of the motion of `rotor` from `theta` [rad], `theta_dot` [rad/s], which
    is `known` exactly or else integrated; an `ErrorTheory`."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    known: Reference | None = None
    terms: int = 4

    @cached_property
    def exact(self) -> Reference:
        """The exact motion."""
        return self.known or DrivenMotion(self.rotor, self.theta, self.theta_dot)

    def simplest(self, scheme: Scheme) -> Scheme:
        """A scheme with the same errors, the same for all schemes that have them."""
        return simplest(scheme, self.rotor)

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """`leading_error` at `times` [s], shape (n,). Raises ParameterError."""
        return leading_error(self.rotor, self.theta, self.theta_dot, times, scheme, self.terms)

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """The scheme stepped, less the exact motion, see `stepped_errors`."""
        start = self.theta, self.theta_dot
        return stepped_errors(self.rotor, start, scheme, step, times, self.exact)


@lru_cache(maxsize=32)  # the same for all step sizes
def _expansion(
    rotor: DrivenRotor, theta: float, theta_dot: float, until: float, scheme: RotorStep, terms: int
) -> tuple[Sequence[int], Response]:
    """Orders of the first `terms` coefficients of the scheme's error that are not zero until a time
    [s], and these as the columns of one response."""
    flow = tangent_flow(rotor, theta, theta_dot, until)
    first, stride = scheme.order_on(rotor), 2 if scheme.symmetric else 1
    orders = range(first, first + stride * terms, stride)
    state = [constant(values, orders[-1] + 1) for values in flow.states]
    flown = exact(rotor, flow.times, *state)
    responses: list[Response] = []
    for order in orders:
        stepped = scheme.advance(rotor, flow.times, *(series[: order + 2] for series in state))
        source = _unexplained(stepped, flown, order + 1, dict(zip(orders, responses, strict=False)))
        responses.append(flow.respond(np.zeros((2, 1)), source[..., None]))
        for i in (0, 1):
            state[i][order] = responses[-1].at_nodes()[:, :, i, 0]
    return orders, together(responses)


def _unexplained(
    stepped: Sequence[Array], flown: Sequence[Array], m: int, lower: Mapping[int, Response]
) -> Array:
    """Coefficient `m` of what a step leaves of the exact motion, less what the `lower` orders'
    responses explain of it."""
    source = np.stack([a[m] - b[m] for a, b in zip(stepped, flown, strict=True)], axis=-1)
    for order, response in lower.items():
        j = m - order
        source -= response.at_nodes(derivative=j)[..., 0] / math.factorial(j)
    return source
