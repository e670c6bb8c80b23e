"""The driven rotor's motion by Taylor series of high order, one polynomial a step.

The series of sin theta and cos theta follow from that of theta by (sin theta)' = theta' cos theta
and its like, so every coefficient costs two short sums (Jorba and Zou 2005, Experimental Math. 14).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from operator import mul
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.numerics.arithmetic import CompensatedState, two_product, two_sum
from plumbob.analytic.numerics.collocation import TimeGrid
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array

if TYPE_CHECKING:  # a list of scenes needs no scipy
    from scipy.interpolate import PPoly

ORDER = 30  # about ln(2^53): the cheapest per second of motion where every term costs the same
MOST_STEPS = 2**20  # about two minutes of work
TRUNCATION = 1e-17  # of the largest term of a step: a tenth of the round-off of the state


@dataclass(frozen=True)
class Orbit(TimeGrid):
    """A motion from time 0 on, as one polynomial of theta for each step."""

    theta: Array  # [rad] at the breakpoints, shape (steps + 1,)
    theta_dot: Array  # [rad/s] at the breakpoints, shape (steps + 1,)
    theta_low: Array  # what rounding `theta` left out, shape (steps + 1,)
    theta_dot_low: Array  # what rounding `theta_dot` left out, shape (steps + 1,)
    coefficients: Array  # of theta in (t - breakpoint), degrees 1 to ORDER, shape (steps, ORDER)

    def at(self, times: Array) -> tuple[Array, Array]:
        """Theta [rad] and theta_dot [rad/s] at `times` [s], any shape, within the duration.
        Raises ParameterError."""
        step = self.locate(times)
        advance, advance_dot = self._advances
        return (
            self.theta[step] + np.asarray(advance(times)),
            self.theta_dot[step] + np.asarray(advance_dot(times)),
        )

    @cached_property
    def _advances(self) -> tuple[PPoly, PPoly]:
        """Each step's increment to the rounded state at its start, with a small round-off."""
        from scipy.interpolate import PPoly

        degrees = np.arange(1, self.coefficients.shape[1] + 1)
        theta = np.column_stack([self.theta_low[:-1], self.coefficients])
        theta_dot = degrees * self.coefficients
        theta_dot[:, 0] = self.theta_dot_low[:-1]
        return (
            PPoly(np.ascontiguousarray(theta.T[::-1]), self.breakpoints),
            PPoly(np.ascontiguousarray(theta_dot.T[::-1]), self.breakpoints),
        )


def integrate(
    rotor: DrivenRotor, theta: float, theta_dot: float, duration: float, start: float = 0.0
) -> Orbit:
    """Motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] for `duration` [s]; the forcing's
    clock begins at `start` [s]. Raises ParameterError.

    Step lengths are binary fractions, so that times carry no round-off, and the state is carried
    with the rounding errors of its sums (compensated summation).
    """
    state = CompensatedState(finite("theta", theta), finite("theta_dot", theta_dot))
    positive("duration", duration)
    time, quantum = 0.0, 2.0 ** (math.ceil(math.log2(duration)) - 40)
    step = min(1.0 / max(rotor.rate(state.rate), 1.0 / duration), duration)
    rows, series = [_row(time, state)], []
    while time < duration:
        terms = _terms(rotor, start + time, state)
        step = min(_step(terms, step), 1.0 / max(rotor.rate(state.rate), 1.0 / duration))
        if not step > duration / MOST_STEPS:
            raise ParameterError(
                "duration", duration, f"shorter: the motion at {time} s is too fast"
            )
        step = quantum * math.floor(step / quantum)
        end = min(time + step, duration)
        step = end - time
        state = state.advanced(step, *_horner(terms, step))
        time = end
        rows.append(_row(time, state))
        series.append(terms)
    times, angles, rates, angles_low, rates_low = np.array(rows).T
    return Orbit(times, angles, rates, angles_low, rates_low, np.array(series))


def _row(time: float, state: CompensatedState) -> tuple[float, ...]:
    return time, state.position, state.rate, state.position_low, state.rate_low


def _terms(rotor: DrivenRotor, time: float, state: CompensatedState) -> list[float]:
    """Taylor coefficients of theta about `time` [s], degrees 1 to ORDER."""
    x, v = state.position, state.rate
    p2, pc, ps = rotor.sin2, rotor.cos, rotor.sin
    xi, k = rotor.damping_rate, rotor.stiffness
    forcing = _forcing_terms(rotor, time)
    linear = rotor.linear  # needs no sines, whose series would overflow at a large angle
    sine = [0.0 if linear else math.sin(x) + state.position_low * math.cos(x)]
    cosine = [0.0 if linear else math.cos(x) - state.position_low * math.sin(x)]
    theta, theta_dot = [x, v], [v]
    for n in range(ORDER - 1):
        a = forcing[n] - xi * theta_dot[n] - k * theta[n]
        if not linear:
            if n:
                _append(sine, cosine, theta_dot, n)
            a += pc * cosine[n] - ps * sine[n]
        if p2:
            a += 2 * p2 * sum(map(mul, sine, reversed(cosine)))
        theta_dot.append(a / (n + 1))
        theta.append(theta_dot[-1] / (n + 2))
    return theta[1:]


def _append(sine: list[float], cosine: list[float], theta_dot: list[float], n: int) -> None:
    """Coefficient `n` of sine and cosine of theta."""
    # both pair coefficient i of theta' with coefficient n-1-i of the other factor
    s = sum(map(mul, theta_dot, reversed(cosine))) / n
    c = -sum(map(mul, theta_dot, reversed(sine))) / n
    sine.append(s)
    cosine.append(c)


def _forcing_terms(rotor: DrivenRotor, time: float) -> list[float]:
    if rotor.autonomous:
        return [0.0] * ORDER
    phase, low = two_product(rotor.forcing_frequency, time)
    phase, carry = two_sum(phase, rotor.forcing_phase)
    low += carry
    s = math.sin(phase) + low * math.cos(phase)
    c = math.cos(phase) - low * math.sin(phase)
    scale, terms = rotor.forcing_amplitude, []
    for n in range(ORDER):
        terms.append(scale * (s, c, -s, -c)[n % 4])
        scale *= rotor.forcing_frequency / (n + 1)
    return terms


def _step(terms: list[float], guess: float) -> float:
    """Step [s] whose last terms are TRUNCATION of the largest one of the step `guess` [s]."""
    largest = max(abs(term) * guess**n for n, term in enumerate(terms[:8], start=1))
    return min(
        (TRUNCATION * largest / abs(terms[n - 1])) ** (1.0 / n) if terms[n - 1] else math.inf
        for n in (ORDER - 1, ORDER)
    )


def _horner(terms: list[float], step: float) -> tuple[float, float]:
    """Gains of theta by the degrees from 2 on, and of theta_dot by those from 1 on."""
    gain = gain_dot = 0.0
    for n in range(ORDER, 1, -1):
        gain = (gain + terms[n - 1]) * step
        gain_dot = (gain_dot + n * terms[n - 1]) * step
    return gain * step, gain_dot
