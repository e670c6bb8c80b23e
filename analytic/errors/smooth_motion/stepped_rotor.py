"""Steps of schemes on the driven rotor, in numbers, arrays or series.

In plain schemes the state is theta and theta_dot. If the bob is held by a joint that is solved for
velocities, the state is theta, its rate w, the bob's velocity V and the joint's opening Z. V and Z
are complex numbers in the plane that turns with the rod (1 points outwards, i along theta), in
units of the bob's distance d from the joint. A bob with the moment of inertia I = j m L^2, where L
is its length as a pendulum, has d = s L with s (1 - s) = j. The joint closes the fraction k of Z in
a step h. F is the damping and forcing at the step's start, U the velocity before the joint acts:

    D = h w,     theta' = theta + D,     Z' = e^(-iD) ((1 - k) Z + 1 + iD) - 1,
    U = e^(-iD) (V + i h F / s) + h (g / (s L)) (cos theta' - i sin theta'),
    w' = w + s (Im U - w + k Im Z' / h),                 V' = i w' - k Z' / h,
    T/(m L) = s Re(U + k Z' / h) / h.

The joint's impulse h T is summed in doubles. Its rounding turns the bob by 1/I, an error that
lasts. It moves the bob by 1/m, an error that the joint corrects.

Imaginary parts of 1e-30 of their size carry a derivative through the steps (Squire and Trapp 1998,
SIAM Review 40, 110): by the start and by all coefficients at once.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from functools import cached_property, lru_cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    READ_AT,
    Equations,
    SchemeStep,
    StateParts,
    scheme_step,
    states_after,
)
from plumbob.analytic.numerics.arithmetic import ROUNDOFF, ULP
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor, rotor_acceleration
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.reference import CACHED_RESULTS, Array
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED_SCHEMES, Scheme

FORCE_ROUNDINGS = 8.0  # roundings of a force, whose parts an engine sums in an order of its own
# indices of the rotor's coefficients that are accelerations at an angle of 1 rad
ACCELERATION_COEFFICIENTS = (0, 1, 2, 4, 7)
ComplexPhases = npt.NDArray[np.complex128]


def rotor_equations(
    rotor: DrivenRotor, scheme: Scheme, step: Any, library: Any = np, by: Any = 1.0
) -> Equations:
    """Returns the equation of a rotor for steps of `step` [s], a number, an array or a series.

    The coefficients are the rotor's times `by`. `library`, cmath or numpy, has the functions.
    """
    p = SimpleNamespace(**{name: value * by for name, value in asdict(rotor).items()})
    if scheme.control == "mean" and rotor.forcing_frequency:
        half_turn = 0.5 * step * p.forcing_frequency
        p.forcing_amplitude = p.forcing_amplitude * library.sin(half_turn) / half_turn
    acceleration = partial(rotor_acceleration(rotor, library), p)
    if scheme.integrator == LEAPFROG:  # all damping is implicit, so that the step is symmetric
        damping, stiffness = p.damping_rate, 0.0
    elif scheme.implicit_damping:
        damping = float(scheme.implicit_damping) * p.damping_rate
        stiffness = p.stiffness if scheme.implicit_spring else 0.0
    else:
        return Equations(acceleration, 1)
    return Equations(acceleration, 1, lambda state: (damping, stiffness))


def has_series(scheme: Scheme) -> bool:
    """Returns whether the error of `scheme` on a rotor has a known series in the step."""
    jointed = scheme.control == "mean" or scheme.joint_closing_rate is not None
    return scheme.integrator in STEPPED_SCHEMES and not jointed


def error_orders(scheme: Scheme, rotor: DrivenRotor, terms: int) -> range:
    """Returns the powers of the step in the first `terms` of the error on `rotor`.

    A symmetric scheme has even powers only. A forcing held over the step may lower the first power.
    """
    assert scheme.order is not None
    held = READ_AT.get(scheme.control)
    first = scheme.order
    if not rotor.autonomous and held is not None:
        first = min(first, 2 if held == 0.5 else 1)
    stride = 2 if scheme.integrator == LEAPFROG and scheme.control != "start" else 1
    return range(first, first + stride * terms, stride)


def simplest_scheme(scheme: Scheme, rotor: DrivenRotor) -> Scheme:
    """Returns the scheme without the variants that change nothing on `rotor`.

    Methods that differ only in such variants then share their results.
    """
    if scheme.integrator not in STEPPED_SCHEMES:
        return scheme
    spring = scheme.implicit_spring and rotor.stiffness != 0.0
    damping = spring or (scheme.implicit_damping if rotor.damping_rate else 0.0)
    # EULER reads a continuous control at the start of a step anyway.
    at_start = scheme.integrator == EULER and scheme.control == "start"
    control = "continuous" if rotor.autonomous or at_start else scheme.control
    return replace(scheme, control=control, implicit_damping=damping, implicit_spring=spring)


@lru_cache(maxsize=CACHED_RESULTS)  # all methods of one scene share the result
def stepped_orbit(
    rotor: DrivenRotor,
    start: tuple[float, float],
    scheme: Scheme,
    step: float,
    marks: bytes,
    sizes: tuple[float, ...],
    slow_marks: int,
) -> ComplexPhases | None:
    """Returns stepped states, shape (d, n); None if they exceed the range of the sine.

    Steps begin at `start`, theta [rad] and theta_dot [rad/s]. `marks` are increasing numbers of
    steps, the bytes of integers. The imaginary parts are IMAGINARY_STEP times the response of the
    states to rounding. Each coefficient is changed by a unit in the last place, and one or two
    states by the rounding of a step, for a motion whose largest theta and theta_dot are `sizes`.

    The first of these states is the start. If `slow_marks` is not zero, the second follows after so
    many marks, where the motion is fast: a rounding there changes the energy by far more than a
    rounding at a start next to a saddle.
    """
    advance, state = _stepper(
        rotor, 1.0 + 1j * IMAGINARY_STEP * ULP, start, scheme, step, cmath
    )
    roundings = _state_rounding(rotor, scheme, step, *sizes)
    counts = np.frombuffer(marks, dtype=np.int64).tolist()
    slow, fast = counts[:slow_marks], counts[slow_marks:]
    try:
        state = _nudged(rotor, 0.0, state, roundings)
        states = states_after(advance, state, step, slow or fast)
        if slow:
            state = _nudged(rotor, slow[-1] * step, states[-1], roundings)
            states += states_after(advance, state, step, fast, slow[-1])
        return np.array(states).T
    except (ValueError, OverflowError, ZeroDivisionError):  # cmath raises for a diverged state
        return None


def _nudged(
    rotor: DrivenRotor, time: float, state: StateParts, roundings: Sequence[float]
) -> list[Any]:
    """Returns a state at a `time` [s] in which each number is changed by its rounding, one of
    `roundings`. The changes are imaginary parts: IMAGINARY_STEP times the rounding.

    All changes reduce the energy: the rate falls, and the angle moves along the force. At rest the
    rate changes along the force, too. A stronger pull also reduces the energy, relative to the
    pull. Therefore the effects of the changed coefficients and of several changed states add up.
    """
    theta, rate, *joint = state
    (force,) = rotor_acceleration(rotor, cmath)(rotor, time, (theta,), (rate,))
    subtracted_signs = -force.real, rate.real or -force.real, *(part.real for part in joint)
    changes = []
    for part, sign, rounding in zip(state, subtracted_signs, roundings, strict=False):
        changes.append(part - 1j * IMAGINARY_STEP * math.copysign(rounding, sign))
    return changes


def _state_rounding(
    rotor: DrivenRotor, scheme: Scheme, step: float, theta: float, rate: float
) -> list[float]:
    """Returns the rounding of each number of a state in a step, as absolute values.

    The motion reaches up to `theta` [rad] and `rate` [rad/s].
    """
    force = sum(abs(astuple(rotor)[i]) for i in ACCELERATION_COEFFICIENTS)
    theta_rounding = ROUNDOFF * theta + ULP * step * rate
    rate_rounding = ROUNDOFF * rate + FORCE_ROUNDINGS * ULP * step * force
    if scheme.jointed_moment:  # the rounding of the joint's impulse turns the bob
        rate_rounding += ULP * step * (rate**2 + force) / scheme.jointed_moment
    # The last four are for a joint: the bob's velocity, the opening's two parts, which round as
    # lengths do, and the pull.
    return [theta_rounding, rate_rounding, ROUNDOFF * rate, ULP, ULP, 0.0]


def many_steps(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, steps: Array
) -> tuple[SchemeStep, StateParts]:
    """Returns the step of a `scheme` of STEPPED_SCHEMES for many sizes at once, and the initial
    state.

    `steps` [s] has the shape (n,), and so have the parts of a state after a step. The initial state
    is `start` and, with a joint, the bob's velocity, the opening's two parts and the pull.
    """
    # All arrays are complex: numpy would convert a number or a real array in each operation.
    steps = steps.astype(complex)
    return _stepper(rotor, np.ones_like(steps), start, scheme, steps, np)


def _stepper(
    rotor: DrivenRotor,
    by: Any,
    start: tuple[float, float],
    scheme: Scheme,
    step: Any,
    library: Any,
) -> tuple[SchemeStep, StateParts]:
    """Returns the step of a scheme on a rotor and the initial state.

    `start` is theta [rad] and theta_dot [rad/s]. The other arguments are as in `rotor_equations`.
    """
    equations = rotor_equations(rotor, scheme, step, library, by)
    if scheme.joint_closing_rate is None:
        return scheme_step(scheme, equations, step), start
    closing = scheme.joint_closing_rate
    theta, theta_dot = start
    weight_only = rotor.conservative and not rotor.cos
    joint = _Joint(
        acceleration=None if weight_only else equations.acceleration,
        lag=READ_AT.get(scheme.control, 0.0),
        weight=rotor.sin * by,
        step=step,
        kept=0.0 if math.isinf(closing) else library.exp(-closing * step),
        part=(1.0 + math.sqrt(1.0 - 4.0 * scheme.jointed_moment)) / 2.0,
        library=library,
    )
    opening_out = opening_along = 0.0 * step
    if math.isinf(closing):  # the joint is as open as an earlier step would have left it
        earlier_rate = theta_dot - step * float(rotor.acceleration(0.0, theta, theta_dot))
        turn = step * earlier_rate
        opening_out, opening_along = joint.turned(turn, (1.0, turn))
        opening_out = opening_out - 1.0
    bob_velocity = theta_dot - joint.rate * opening_along
    pull = theta_dot**2 + joint.weight * math.cos(theta)
    return joint, (theta, theta_dot, bob_velocity, opening_out, opening_along, pull)


@dataclass(frozen=True)
class _Joint:
    """The step of a bob that a joint holds (module docstring)."""

    acceleration: Callable[..., StateParts] | None  # damping and forcing, without the weight
    lag: float  # fraction of a step after which the forcing is read
    weight: Any  # g/L [1/s^2]
    step: Any  # h [s]
    kept: Any  # 1 - k
    part: float  # s
    library: Any  # cmath or numpy

    @cached_property
    def rate(self) -> Any:
        """Rate k / h [1/s] at which the joint closes."""
        return (1.0 - self.kept) / self.step

    def turned(self, angle: Any, *vectors: tuple[Any, Any]) -> list[Any]:
        """Returns the components of `vectors` in axes that have turned by an `angle` [rad]."""
        cosine = self.library.cos(angle)
        sine = self.library.sin(angle)
        components = []
        for outwards, along in vectors:
            components.append(cosine * outwards + sine * along)
            components.append(cosine * along - sine * outwards)
        return components

    def __call__(self, time: Any, state: StateParts) -> StateParts:
        """Returns the state after a step: theta, w, the imaginary part of V, the real and imaginary
        parts of Z, and the joint's pull T/(m L)."""
        theta, w, v_along, z_out, z_along, _ = state
        turn = self.step * w
        rate = self.rate
        lever = self.step / self.part
        if self.acceleration is not None:
            (push,) = self.acceleration(time + self.lag * self.step, (0.0,), (w,))
            v_along = v_along + lever * push
        velocity = -rate * z_out, v_along
        opening = 1.0 + self.kept * z_out, turn + self.kept * z_along
        u_out, u_along, z_out, z_along = self.turned(turn, velocity, opening)
        theta = theta + turn
        z_out = z_out - 1.0
        u_out = u_out + lever * self.weight * self.library.cos(theta)
        u_along = u_along - lever * self.weight * self.library.sin(theta)
        w = w + self.part * (u_along - w + rate * z_along)
        return theta, w, w - rate * z_along, z_out, z_along, (u_out + rate * z_out) / lever
