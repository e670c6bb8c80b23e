"""The global error of Euler steps on a bob that a joint, solved for velocities, holds to its pivot.

A sequential-impulse engine moves first, then solves the velocities. A pivot joint at the end of a
bob's weightless rod is not kept closed: with lengths in units of the rod and the complex plane
turning with it (1 outwards, i along theta), its opening Z and the pendulum take the step

    theta' = theta + D,  D = h w,      Z' = (1 - k) e^(-iD) Z + e^(-iD) (1 + iD) - 1,
    w' = w cos D + Im S + h (-(g/L) sin theta' + F cos D),    S = k (Z' - e^(-iD) Z) / h,

F the damping and forcing at the step's start. The joint pulls along the rod alone, by the tension

    T'/(m L) = (Re S + w sin D) / h + (g/L) cos theta' + F sin D.

k is the part of its opening that the joint closes in a step. With k = 1, Z follows the motion at
one step's distance and is of order h^2: what the step before opened, which follows from the motion
and its error at that step. With k = 1 - e^(-beta h), where the joint closes at a rate, Z is h Q
with Q' = -(beta + i w) Q + w^2/2: the rod is longer and energy is lost, both at order h. Then Z is
h (Q_0 + h Q_1 + ...), and each Q_p obeys a linear equation of its own after the error's
coefficients up to the p-th. Those follow as in `errors.global_error`, with the opening as one more
state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from plumbob.analytic.errors.smooth_motion.global_error import flow_until, respond
from plumbob.analytic.errors.smooth_motion.rotor_steps import StepSeries, exact
from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_flow import LinearFlow, Response, together
from plumbob.analytic.numerics.rotor.variational import STAGES, TangentFlow
from plumbob.analytic.numerics.truncated_series import constant, product, raised, sine_cosine
from plumbob.analytic.reference import Array
from plumbob.analytic.theory import Coefficients

TERMS = 4
DEGREE = TERMS + 2  # the opening is divided by h twice on its way to the tension
Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class JointedStep:
    """Series in h of what a step makes of theta, theta_dot and the opening, and of the excess of
    the joint's pull over the tension of that state, per mass and length [1/s^2]."""

    theta: Array
    theta_dot: Array  # its last term is not to be used
    opening: Complex  # its last term is not to be used
    excess: Array  # its last two terms are not to be used


def stepped(
    rotor: DrivenRotor,
    times: Array,
    closing: float,
    theta: Array,
    theta_dot: Array,
    opening: Complex,
) -> JointedStep:
    """One step from series of theta, theta_dot and the opening at `times` [s], shape (degree + 1,
    ...), of a pendulum that obeys `rotor`; the joint closes at a rate `closing` [1/s]."""
    pull = StepSeries(DrivenRotor(sin=rotor.sin), times)
    push = StepSeries(replace(rotor, sin=0.0), times)
    turned = raised(theta_dot)
    sine, cosine = sine_cosine(turned)
    back: Complex = np.asarray(cosine - 1j * sine, dtype=np.complex128)
    carried = product(back, opening)
    opened = _kept(carried, closing) + straight(theta_dot)
    gain = opened - carried
    slack = _lowered(gain - _kept(gain, closing))
    pushed = push.acceleration(0.0, theta, theta_dot)
    theta_next = theta + turned
    dot_next = product(theta_dot, cosine) + slack.imag
    dot_next = dot_next + raised(pull.undamped(1.0, theta_next) + product(pushed, cosine))
    pulled = _lowered(slack + product(theta_dot, sine)).real + product(pushed, sine)
    return JointedStep(theta_next, dot_next, opened, pulled - product(dot_next, dot_next))


def straight(theta_dot: Array) -> Complex:
    """Series of e^(-iD) (1 + iD) - 1, D = h theta_dot: what a straight move opens."""
    power, total = theta_dot.astype(complex), np.zeros(theta_dot.shape, dtype=complex)
    for n in range(2, len(theta_dot)):
        power = product(power, theta_dot.astype(complex))
        total += (-1j) ** n * (1 - n) / math.factorial(n) * raised(power, n)
    return total


def _kept(opening: Complex, closing: float) -> Complex:
    """Series of exp(-closing h) times the opening: what the joint leaves of it in a step."""
    if math.isinf(closing):
        return np.zeros_like(opening)
    total = opening.copy()
    for n in range(1, len(opening)):
        total += raised((-closing) ** n / math.factorial(n) * opening, n)
    return total


def _lowered(series: Complex) -> Complex:
    """The series divided by its variable; its last term is unknown and left out."""
    lower = np.zeros_like(series)
    lower[:-1] = series[1:]
    return lower


@dataclass(frozen=True)
class JointedErrors:
    """Coefficients of the first TERMS powers of the step: responses of theta and theta_dot, a
    column each, and the excess of the joint's pull at the nodes."""

    flow: TangentFlow
    responses: Response
    excess: tuple[Array, ...]


@dataclass(frozen=True)
class JointedSeries:
    """The error expansions of the motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] under
    such steps, each computed once. Raises ParameterError."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    _found: dict[float, tuple[float, JointedErrors]] = field(
        default_factory=dict, repr=False, compare=False
    )

    def at(self, closing: float, times: Array) -> Coefficients:
        """Coefficients of the error of steps whose joint closes at a rate `closing` [1/s], infinite
        where it closes in one step, at `times` [s], shape (n,), as {p: {"theta", "theta_dot",
        "excess"}}: "excess" [1/s^2] is that of the joint's pull over the tension of the state, per
        mass and length."""
        until, last = self._found.get(closing, (None,))[0], float(np.max(times))
        if until is None or last > until:
            until = 1.01 * last or 1.0  # the next step may end a little later
            flow = flow_until(self.rotor, self.theta, self.theta_dot, until)
            self._found[closing] = until, expansion(flow, closing)
        errors = self._found[closing][1]
        theta, theta_dot = np.moveaxis(errors.responses.at(times), 0, -1).copy()
        excess = _interpolated(errors.flow, errors.excess, times)
        every = enumerate(zip(theta, theta_dot, excess, strict=True), start=1)
        return {p: {"theta": x, "theta_dot": v, "excess": pull} for p, (x, v, pull) in every}


def expansion(flow: TangentFlow, closing: float) -> JointedErrors:
    """The error's first TERMS coefficients where the joint closes at a rate `closing` [1/s]."""
    state = [constant(values, DEGREE) for values in flow.states]
    flown = exact(StepSeries(flow.rotor, flow.times), state[0], state[1])
    responses: list[Response] = []
    openings: list[Response] = []  # each Q_p
    relaxed = LinearFlow(flow.orbit, -(closing + 1j * flow.states[1])[..., None, None])
    opening = np.zeros(state[0].shape, dtype=complex)
    for power in range(1, TERMS + 2):
        degrees = slice(power + 3)  # up to two powers more, of which the last is not to be used
        if math.isinf(closing):
            opening = _trailing(flown[1], responses)
        else:
            series = (part[degrees] for part in (*state, opening))
            step = stepped(flow.rotor, flow.times, closing, *series)
            source: Any = step.opening[power + 1][..., None, None].copy()
            for order, known in zip(range(power, 0, -1), openings, strict=False):
                source -= known.at_nodes(derivative=order) / math.factorial(order)
            openings.append(relaxed.respond(np.zeros((1, 1)), source))
            opening[power] = openings[-1].at_nodes()[..., 0, 0]
        series = (part[degrees] for part in (*state, opening))
        step = stepped(flow.rotor, flow.times, closing, *series)
        if power > TERMS:
            break
        responses.append(
            respond(
                flow,
                (step.theta, step.theta_dot),
                flown,
                power + 1,
                dict(enumerate(responses, start=1)),
            )
        )
        state[0][power], state[1][power] = np.moveaxis(responses[-1].at_nodes()[..., 0], 2, 0)
    return JointedErrors(flow, together(responses), _at_end(flow, step.excess))


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


def _at_end(flow: TangentFlow, series: Array) -> tuple[Array, ...]:
    """Coefficients of what a step gives at its end, from the series at its start."""
    rule, lengths = gauss_collocation(STAGES), np.diff(flow.orbit.breakpoints)
    late = [np.zeros_like(series[0]) for _ in range(TERMS)]
    for power in range(1, TERMS + 1):
        slope = series[power]
        for j in range(TERMS + 1 - power):
            late[power + j - 1] += (-1.0) ** j * slope / math.factorial(j)
            slope = slope @ rule.derivative.T / lengths[:, None]
    return tuple(late)


def _interpolated(flow: TangentFlow, known: Sequence[Array], times: Array) -> list[Array]:
    """Values at `times` [s], shape (n,), of what is known at the nodes, shape (steps, stages)."""
    step, edges = flow.orbit.locate(times), flow.orbit.breakpoints
    fractions = (times - edges[step]) / np.diff(edges)[step]
    basis = legendre.legvander(2 * fractions - 1, STAGES - 1)
    spectrum = gauss_collocation(STAGES).spectrum.T
    return [np.asarray((basis * (values @ spectrum)[step]).sum(axis=1)) for values in known]
