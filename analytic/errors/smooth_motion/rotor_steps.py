"""One step of each scheme on the driven rotor, of numbers, arrays, or power series in the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.truncated_series import moved, over_one_plus, product, sine_cosine
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED, TABLEAUX, Scheme
from plumbob.analytic.tableau import Moved, along

Advance = Callable[..., tuple[Any, Any]]
READ_AT = MappingProxyType(
    {"start": 0.0, "midpoint": 0.5}
)  # where in a step a held control is read


@dataclass(frozen=True)
class Equation:
    """The equation of motion as a step reads it, and the arithmetic of what it steps."""

    undamped: Callable[[Any, float, Any], Any]
    """Acceleration without damping, by the step's start t, a fraction of the step, and theta."""
    damping: Any  # [1/s]
    stiffness: Any  # [1/s^2]
    moved: Moved
    divided: Callable[[Any, Any, Any], Any]
    """A value over 1 + a h + b h^2, by a and b."""


def advance(scheme: Scheme, equation: Equation) -> Advance:
    """The step of a `scheme` of STEPPED, (t, theta, theta_dot) -> (theta, theta_dot)."""
    move, undamped, damping = equation.moved, equation.undamped, equation.damping

    def whole(t: Any, fraction: float, x: Any, v: Any) -> Any:
        return undamped(t, fraction, x) - damping * v

    def runge_kutta(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        def slopes(fraction: float, state: Sequence[Any]) -> tuple[Any, Any]:
            return state[1], whole(t, fraction, *state)

        x, v = TABLEAUX[scheme.integrator].advanced(slopes, (x, v), move)
        return x, v

    def leapfrog(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        # Half a kick, a drift, half a kick whose damping is implicit: a damped step is symmetric.
        v = move(v, whole(t, 0.0, x, v), 1.0, 2.0)
        x = move(x, v, 1.0, 1.0)
        v = move(v, undamped(t, 1.0, x), 1.0, 2.0)
        return x, equation.divided(v, damping / 2, 0.0)

    def position_first(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        x = move(x, v, 1.0, 1.0)
        return x, move(v, whole(t, 0.0, x, v), 1.0, 1.0)

    part = float(scheme.implicit_damping)
    explicit, implicit = (1.0 - part) * damping, part * damping
    spring = equation.stiffness if scheme.implicit_spring else 0.0

    def euler(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        v = move(v, undamped(t, 0.0, x) - explicit * v, 1.0, 1.0)
        if part:
            v = equation.divided(v, implicit, spring)
        return move(x, v, 1.0, 1.0), v

    if scheme.integrator == EULER:
        return position_first if scheme.position_first else euler
    return leapfrog if scheme.integrator == LEAPFROG else runge_kutta


def in_series(rotor: DrivenRotor, times: Array, control: str = "continuous") -> Equation:
    """The equation for series in h, shape (degree + 1, ...), of steps that begin at `times` [s]."""
    held = READ_AT.get(control)

    def undamped(_: Any, fraction: float, theta: Array) -> Array:
        total = -rotor.stiffness * theta
        if not rotor.linear:
            sine, cosine = sine_cosine(theta)
            total += rotor.cos * cosine - rotor.sin * sine
            if rotor.sin2:
                total += 2 * rotor.sin2 * product(sine, cosine)
        if not rotor.autonomous:
            turn = 1j * rotor.forcing_frequency * (fraction if held is None else held)
            phase = rotor.forcing_frequency * times + rotor.forcing_phase
            term: Any = rotor.forcing_amplitude * np.exp(1j * phase)
            for n in range(len(theta)):
                total[n] += np.imag(term)
                term = term * turn / (n + 1)
        return total

    return Equation(undamped, rotor.damping_rate, rotor.stiffness, moved, over_one_plus)


def in_numbers(
    rotor: DrivenRotor, given: Sequence[Any], scheme: Scheme, step: Any, library: Any
) -> Equation:
    """The equation for numbers or arrays in a `step` [s]: its terms are those of `rotor`, their
    coefficients `given` in its order; `library` has the functions: math or numpy."""
    sin2, across, down, damping, *_, stiffness = given
    sin, cos, twice = library.sin, library.cos, 2.0 * sin2
    push = _forcing(rotor, given, scheme.control, step, sin)

    def pull(x: Any) -> Any:
        if rotor.linear:
            return -stiffness * x
        sine = sin(x)
        turning = (twice * sine + across) * cos(x) - down * sine
        return turning - stiffness * x if rotor.stiffness else turning

    return Equation(
        (lambda t, fraction, x: pull(x))
        if rotor.autonomous
        else (lambda t, fraction, x: pull(x) + push(t, fraction)),
        damping,
        stiffness,
        along(step),
        lambda x, a, b: x / (1.0 + step * (a + step * b)),
    )


def _forcing(
    rotor: DrivenRotor, given: Sequence[Any], control: str, step: Any, sin: Callable[[Any], Any]
) -> Callable[[Any, float], Any]:
    """The forcing's acceleration by a step's start and a fraction of the step, as `control` reads
    it; arguments as those of `in_numbers`."""
    amplitude, frequency, phase = given[4:7]
    lag = READ_AT[control] * step if control in READ_AT else None
    if control == "mean" and rotor.forcing_frequency:
        lag = 0.5 * step
        amplitude = amplitude * sin(lag * frequency) / (lag * frequency)

    def push(t: Any, fraction: float) -> Any:
        later = fraction * step if lag is None else lag
        return amplitude * sin(frequency * (t + later) + phase)

    return push


def exact(rotor: DrivenRotor, times: Array, theta: Array, theta_dot: Array) -> tuple[Array, Array]:
    """Series of the motion itself after h, whose degrees follow from the acceleration's, each from
    lower ones."""
    equation, x, v = in_series(rotor, times), theta.copy(), theta_dot.copy()
    for n in range(1, len(theta)):
        slope = equation.undamped(None, 1.0, x[:n]) - rotor.damping_rate * v[:n]
        v[n] += slope[-1] / n
        x[n] += v[n - 1] / n
    return x, v


@dataclass(frozen=True)
class RotorStep:
    """A scheme's step on a rotor as a series."""

    scheme: Scheme

    @property
    def order(self) -> int:
        """Order of the global error."""
        assert self.scheme.order is not None
        return self.scheme.order

    @property
    def symmetric(self) -> bool:
        """Whether its error has even powers of h only."""
        return self.scheme.integrator == LEAPFROG and self.scheme.control != "start"

    def order_on(self, rotor: DrivenRotor) -> int:
        """Order of the global error on `rotor`: a forcing held over the step may lower it."""
        held = READ_AT.get(self.scheme.control)
        if rotor.autonomous or held is None:
            return self.order
        return min(self.order, 2 if held == 0.5 else 1)

    def advance(self, rotor: DrivenRotor, times: Array, *state: Array) -> tuple[Array, Array]:
        """Series of theta and theta_dot after steps that begin at `times` [s]."""
        return advance(self.scheme, in_series(rotor, times, self.scheme.control))(None, *state)


def rotor_step(scheme: Scheme) -> RotorStep | None:
    """The step of `scheme` on a rotor; None where it is not known as a series."""
    if scheme.control == "mean" or scheme.joint_closing_rate is not None:
        return None
    return RotorStep(scheme) if scheme.integrator in STEPPED else None


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
