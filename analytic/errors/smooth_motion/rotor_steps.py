"""One step of each fixed-step scheme on the driven rotor, as a power series in the step h."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.truncated_series import (
    moved,
    over_one_plus,
    product,
    raised,
    sine_cosine,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED, TABLEAUX, Scheme
from plumbob.analytic.tableau import Tableau

Pair = tuple[Array, Array]  # series of theta and of theta_dot, shape (degree + 1, ...)


@dataclass(frozen=True)
class StepSeries:
    """The equation of motion read by series in h, for steps that begin at many times at once."""

    rotor: DrivenRotor
    times: Array  # [s], any shape
    control: float | None = None  # forcing is held at its value at t + control h; None: it is not

    def undamped(self, fraction: float, theta: Array) -> Array:
        """Series of the acceleration at t + fraction h, damping left out."""
        rotor = self.rotor
        total = -rotor.stiffness * theta
        if not rotor.linear:
            sine, cosine = sine_cosine(theta)
            total += rotor.cos * cosine - rotor.sin * sine
            if rotor.sin2:
                total += 2 * rotor.sin2 * product(sine, cosine)
        if not rotor.autonomous:
            total += self._forcing(fraction if self.control is None else self.control, len(theta))
        return total

    def acceleration(self, fraction: float, theta: Array, theta_dot: Array) -> Array:
        """Series of the acceleration at t + fraction h."""
        return self.undamped(fraction, theta) - self.rotor.damping_rate * theta_dot

    def _forcing(self, fraction: float, length: int) -> Array:
        phase = self.rotor.forcing_frequency * self.times + self.rotor.forcing_phase
        terms: list[Any] = [self.rotor.forcing_amplitude * np.exp(1j * phase)]
        for n in range(1, length):
            terms.append(terms[-1] * (1j * self.rotor.forcing_frequency * fraction / n))
        return np.imag(terms)


def exact(step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
    """Series of the motion itself after h, whose degrees follow from the acceleration's, each from
    lower ones."""
    x, v = theta.copy(), theta_dot.copy()
    for n in range(1, len(theta)):
        v[n] += step.acceleration(1.0, x[:n], v[:n])[-1] / n
        x[n] += v[n - 1] / n
    return x, v


def semi_implicit_euler(step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
    """v1 = v + h a(t, theta, v); theta1 = theta + h v1."""
    theta_dot = theta_dot + raised(step.acceleration(0.0, theta, theta_dot))
    return theta + raised(theta_dot), theta_dot


def damped_euler(part: float, step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
    """As `semi_implicit_euler`, but a `part` p of damping acts on v1: v1 = (v + h a_0(t, theta, v))
    /(1 + p xi h), a_0 the acceleration without that part."""
    rest = step.undamped(0.0, theta) - (1 - part) * step.rotor.damping_rate * theta_dot
    theta_dot = over_one_plus(theta_dot + raised(rest), part * step.rotor.damping_rate)
    return theta + raised(theta_dot), theta_dot


def sprung_euler(step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
    """As `damped_euler`, but the spring pulls at theta1 too: v1 = (v + h a_0(t, theta))/(1 + xi h
    + k h^2), by the recursion of a quotient's power series."""
    pushed = theta_dot + raised(step.undamped(0.0, theta))
    rotor = step.rotor
    for n in range(1, len(pushed)):
        pushed[n] -= rotor.damping_rate * pushed[n - 1]
        if n > 1:
            pushed[n] -= rotor.stiffness * pushed[n - 2]
    return theta + raised(pushed), pushed


def position_first_euler(step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
    """theta1 = theta + h v; v1 = v + h a(t, theta1, v): the adjoint order, damping and forcing
    still read at the start; the first order of an engine that moves before it solves velocities."""
    moved = theta + raised(theta_dot)
    return moved, theta_dot + raised(step.acceleration(0.0, moved, theta_dot))


def leapfrog(step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
    """Kick, drift, kick, each kick half a step: v = v + h/2 a(t, theta, v); theta1 = theta + h v;
    v1 = (v + h/2 a(t + h, theta1, 0)) / (1 + xi h/2), which keeps a damped step symmetric."""
    half = theta_dot + raised(step.acceleration(0.0, theta, theta_dot)) / 2
    theta = theta + raised(half)
    return theta, over_one_plus(
        half + raised(step.undamped(1.0, theta)) / 2, step.rotor.damping_rate / 2
    )


def runge_kutta(tableau: Tableau) -> Callable[[StepSeries, Array, Array], Pair]:
    """A Runge-Kutta method, the forcing read at its nodes."""

    def advance(step: StepSeries, theta: Array, theta_dot: Array) -> Pair:
        def slopes(fraction: float, state: Sequence[Array]) -> Pair:
            return state[1], step.acceleration(fraction, *state)

        after, rate = tableau.advanced(slopes, (theta, theta_dot), moved)
        return after, rate

    return advance


@dataclass(frozen=True)
class RotorStep:
    """A scheme's step on a rotor: the order of its global error, the step as a power series, how it
    reads the forcing."""

    order: int
    advance: Callable[[StepSeries, Array, Array], Pair]
    symmetric: bool = False  # its error has even powers of h only
    control: float | None = None  # as in StepSeries

    def order_on(self, rotor: DrivenRotor) -> int:
        """Order of the global error on `rotor`: a forcing held over the step may lower it."""
        if rotor.autonomous or self.control is None:
            return self.order
        return min(self.order, 2 if self.control == 0.5 else 1)


def rotor_step(scheme: Scheme) -> RotorStep | None:
    """The step of `scheme` on a rotor; None where it is not known as a series."""
    known = scheme.integrator in STEPPED
    if not known or scheme.control == "mean" or scheme.joint_closing_rate is not None:
        return None
    assert scheme.order is not None
    control = {"start": 0.0, "midpoint": 0.5}.get(scheme.control)
    if scheme.integrator in TABLEAUX:
        return RotorStep(scheme.order, runge_kutta(TABLEAUX[scheme.integrator]), control=control)
    if scheme.integrator == LEAPFROG:
        return RotorStep(scheme.order, leapfrog, control in (None, 0.5), control)
    advance = semi_implicit_euler
    if scheme.position_first:
        advance = position_first_euler
    elif scheme.implicit_damping:
        damped = partial(damped_euler, scheme.implicit_damping)
        advance = sprung_euler if scheme.implicit_spring else damped
    return RotorStep(scheme.order, advance, control=control)


def simplest(scheme: Scheme, rotor: DrivenRotor) -> Scheme:
    """The scheme without those of its variants that change nothing on `rotor`: methods that differ
    in them alone have the same errors there."""
    if scheme.integrator not in STEPPED:
        return scheme
    spring = scheme.implicit_spring and rotor.stiffness != 0.0
    damping = spring or (scheme.implicit_damping if rotor.damping_rate else 0.0)
    at_start = scheme.integrator == EULER and scheme.control == "start"  # as EULER reads it anyway
    control = "continuous" if rotor.autonomous or at_start else scheme.control
    return replace(scheme, control=control, implicit_damping=damping, implicit_spring=spring)
