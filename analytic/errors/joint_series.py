"""The global error of Euler steps on a jointed bob as a power series in the step.

As `scheme_error` has it, with the joint's opening as one more state. A joint that closes in
one step is open by what the step before opened, which the motion and its error a step ago tell. One
that closes at a rate is open by h (Q_0 + h Q_1 + ...), and each Q_p obeys a linear equation of its
own after the error's coefficients up to the p-th.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import legendre

from plumbob.analytic.errors.joint_step import CLOSING, Complex, stepped, straight
from plumbob.analytic.errors.schemes import StepSeries, exact
from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.numerics.rotor.variational import STAGES, Response, TangentFlow
from plumbob.analytic.numerics.truncated_series import constant
from plumbob.analytic.reference import Array

TERMS = 4
DEGREE = TERMS + 2  # the opening is divided by h twice on its way to the tension


@dataclass(frozen=True)
class JointedErrors:
    """Coefficients of the first TERMS powers of the step: responses of theta and theta_dot, and the
    excess of the joint's pull at the nodes."""

    flow: TangentFlow
    responses: tuple[Response, ...]
    excess: tuple[Array, ...]


@dataclass(frozen=True)
class JointedSeries:
    """The error expansions of one motion under such steps, each worked out once. Raises
    ParameterError."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    _found: dict[str, tuple[float, JointedErrors]] = field(
        default_factory=dict, repr=False, compare=False
    )

    def at(self, scheme: str, times: Array) -> Mapping[int, Mapping[str, Array]]:
        """Coefficients of the error of `scheme`, one of CLOSING, at `times` [s], shape (n,), as {p:
        {"theta", "theta_dot", "excess"}}: "excess" [1/s^2] is that of the joint's pull over the
        tension of the state, per mass and length."""
        until, last = self._found.get(scheme, (None,))[0], float(np.max(times))
        if until is None or last > until:
            until = 1.01 * last or 1.0  # the next step may end a little later
            flow = TangentFlow(self.rotor, integrate(self.rotor, self.theta, self.theta_dot, until))
            self._found[scheme] = until, expansion(flow, CLOSING[scheme])
        errors = self._found[scheme][1]
        return {
            power: {
                "theta": response.at(times)[:, 0, 0],
                "theta_dot": response.at(times)[:, 1, 0],
                "excess": _interpolated(errors.flow, excess, times),
            }
            for power, (response, excess) in enumerate(
                zip(errors.responses, errors.excess, strict=True), start=1
            )
        }


def expansion(flow: TangentFlow, closing: float) -> JointedErrors:
    """The error's first TERMS coefficients where the joint closes at a rate `closing` [1/s]."""
    state = [constant(values, DEGREE) for values in flow.states]
    flown = exact(StepSeries(flow.rotor, flow.times), state[0], state[1])
    responses: list[Response] = []
    openings: list[tuple[Complex, ...]] = []  # each Q_p and its derivatives, at the nodes
    opening = np.zeros(state[0].shape, dtype=complex)
    for power in range(1, TERMS + 2):
        if math.isinf(closing):
            opening = _trailing(flown[1], responses)
        else:
            step = stepped(flow.rotor, flow.times, closing, state[0], state[1], opening)
            source = step.opening[power + 1].copy()
            for lower, known in enumerate(openings):
                source -= known[power - lower] / math.factorial(power - lower)
            openings.append(_relaxed(flow, closing, source))
            opening[power] = openings[-1][0]
        step = stepped(flow.rotor, flow.times, closing, state[0], state[1], opening)
        if power > TERMS:
            break
        m = power + 1
        source = np.stack([step.theta[m] - flown[0][m], step.theta_dot[m] - flown[1][m]], axis=-1)
        for lower, response in enumerate(responses, start=1):
            source -= response.at_nodes(derivative=m - lower)[..., 0] / math.factorial(m - lower)
        responses.append(flow.respond(np.zeros((2, 1)), source[..., None]))
        for i in (0, 1):
            state[i][power] = responses[-1].at_nodes()[:, :, i, 0]
    return JointedErrors(flow, tuple(responses), _at_end(flow, step.excess))


def _trailing(rates: Array, responses: list[Response]) -> Complex:
    """Opening of a joint that closes in one step: what the step before opened, at the rate before.
    `rates` is the series of the exact rate after h; `responses` the error's known coefficients."""
    signs = (-1.0) ** np.arange(DEGREE + 1)
    before = rates * signs.reshape(-1, *[1] * (rates.ndim - 1))
    for power, response in enumerate(responses, start=1):
        for j in range(DEGREE + 1 - power):
            slope = response.at_nodes(derivative=j)[:, :, 1, 0]
            before[power + j] += signs[j] * slope / math.factorial(j)
    return straight(before)


def _relaxed(flow: TangentFlow, closing: float, source: Complex) -> tuple[Complex, ...]:
    """u where u' = -(closing + i theta_dot) u + source and u = 0 at the start, at the nodes, and
    its derivatives after it."""
    rule, lengths = gauss_collocation(STAGES), np.diff(flow.orbit.breakpoints)
    loss = closing + 1j * flow.states[1]
    system = np.eye(STAGES) + lengths[:, None, None] * loss[:, :, None] * rule.integral
    right = np.stack([source, -loss], axis=-1)
    forced, free = np.moveaxis(np.linalg.solve(system, right), -1, 0)
    start, values, slopes = 0j, np.empty_like(source), np.empty_like(source)
    for n, length in enumerate(lengths):
        slopes[n] = forced[n] + free[n] * start
        values[n] = start + length * rule.integral @ slopes[n]
        start += length * complex(rule.weights @ slopes[n])
    known = [values, slopes]
    for _ in range(TERMS):
        known.append(known[-1] @ rule.derivative.T / lengths[:, None])
    return tuple(known)


def _at_end(flow: TangentFlow, series: Array) -> tuple[Array, ...]:
    """Coefficients of what a step tells at its end, from the series at its start."""
    rule, lengths = gauss_collocation(STAGES), np.diff(flow.orbit.breakpoints)
    late = [np.zeros_like(series[0]) for _ in range(TERMS)]
    for power in range(1, TERMS + 1):
        slope = series[power]
        for j in range(TERMS + 1 - power):
            late[power + j - 1] += (-1.0) ** j * slope / math.factorial(j)
            slope = slope @ rule.derivative.T / lengths[:, None]
    return tuple(late)


def _interpolated(flow: TangentFlow, values: Array, times: Array) -> Array:
    """Values at `times` [s], shape (n,), of what is known at the nodes, shape (steps, stages)."""
    step, edges = flow.orbit.locate(times), flow.orbit.breakpoints
    fractions = (times - edges[step]) / np.diff(edges)[step]
    ladder = legendre.legvander(2 * fractions - 1, STAGES - 1)
    return np.asarray((ladder * (values @ gauss_collocation(STAGES).spectrum.T)[step]).sum(axis=1))
