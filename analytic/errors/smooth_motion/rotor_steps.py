"""One step of each scheme on the driven rotor, of numbers, arrays, or power series in the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED, TABLEAUX, Scheme
from plumbob.analytic.tableau import along

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
    step: Any  # [s]

    def divided(self, value: Any, linear: Any, square: Any) -> Any:
        """A value over 1 + a h + b h^2."""
        return value / (1.0 + self.step * (linear + self.step * square))

    def slope(self, t: Any, fraction: float, x: Any, v: Any) -> Any:
        """The acceleration."""
        return self.undamped(t, fraction, x) - self.damping * v


def advance(scheme: Scheme, equation: Equation) -> Advance:
    """The step of a `scheme` of STEPPED, (t, theta, theta_dot) -> (theta, theta_dot)."""
    move, undamped, damping = along(equation.step), equation.undamped, equation.damping

    def runge_kutta(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        def slopes(fraction: float, state: Sequence[Any]) -> tuple[Any, Any]:
            return state[1], equation.slope(t, fraction, *state)

        x, v = TABLEAUX[scheme.integrator].advanced(slopes, (x, v), move)
        return x, v

    def leapfrog(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        # Half a kick, a drift, half a kick whose damping is implicit: a damped step is symmetric.
        v = move(v, equation.slope(t, 0.0, x, v), 1.0, 2.0)
        x = move(x, v, 1.0, 1.0)
        v = move(v, undamped(t, 1.0, x), 1.0, 2.0)
        return x, equation.divided(v, damping / 2, 0.0)

    def position_first(t: Any, x: Any, v: Any) -> tuple[Any, Any]:
        x = move(x, v, 1.0, 1.0)
        return x, move(v, equation.slope(t, 0.0, x, v), 1.0, 1.0)

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


def equation_of(
    rotor: DrivenRotor, given: Sequence[Any], scheme: Scheme, step: Any, library: Any
) -> Equation:
    """The equation in a `step` [s], a number, an array or a series: its terms are those of `rotor`,
    their coefficients `given` in its order; `library` has the functions: math or numpy."""
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
        step,
    )


def _forcing(
    rotor: DrivenRotor, given: Sequence[Any], control: str, step: Any, sin: Callable[[Any], Any]
) -> Callable[[Any, float], Any]:
    """The forcing's acceleration by a step's start and a fraction of the step, as `control` reads
    it; arguments as those of `equation_of`."""
    amplitude, frequency, phase = given[4:7]
    lag = READ_AT[control] * step if control in READ_AT else None
    if control == "mean" and rotor.forcing_frequency:
        lag = 0.5 * step
        amplitude = amplitude * sin(lag * frequency) / (lag * frequency)

    def push(t: Any, fraction: float) -> Any:
        later = fraction * step if lag is None else lag
        return amplitude * sin(frequency * (t + later) + phase)

    return push


def in_series(scheme: Scheme) -> bool:
    """Whether the error of `scheme` on a rotor is known as a series in the step."""
    jointed = scheme.control == "mean" or scheme.joint_closing_rate is not None
    return scheme.integrator in STEPPED and not jointed


def orders(scheme: Scheme, rotor: DrivenRotor, terms: int) -> range:
    """Powers of the step in so many `terms` of the error on `rotor`, even ones alone of a symmetric
    scheme; a forcing held over the step may lower the first."""
    assert scheme.order is not None
    held, first = READ_AT.get(scheme.control), scheme.order
    if not rotor.autonomous and held is not None:
        first = min(first, 2 if held == 0.5 else 1)
    stride = 2 if scheme.integrator == LEAPFROG and scheme.control != "start" else 1
    return range(first, first + stride * terms, stride)


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
