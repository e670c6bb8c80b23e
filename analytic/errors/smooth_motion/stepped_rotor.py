"""The driven rotor as schemes step it, also in plain numbers, for steps that no series reaches.

A plain scheme's state is theta and theta_dot. Where a joint, solved for velocities, holds the bob,
it is theta, its rate w, and in the complex plane turning with the rod (1 outwards, i along theta)
the bob's velocity V and the joint's opening Z, both in units of the bob's distance d from the
joint. A bob of moment of inertia I = j m L^2, L its length as a pendulum, has d = s L with
s (1 - s) = j. The joint closes the part k of Z in a step h; F is the damping and forcing at the
step's start, U the velocity before the joint acts:

    D = h w,     theta' = theta + D,     Z' = e^(-iD) ((1 - k) Z + 1 + iD) - 1,
    U = e^(-iD) (V + i h F / s) + h (g / (s L)) (cos theta' - i sin theta'),
    w' = w + s (Im U - w + k Im Z' / h),                 V' = i w' - k Z' / h,
    T/(m L) = s Re(U + k Z' / h) / h.

The joint's impulse h T is added up in doubles: its rounding turns the bob by 1/I, but moves it by
1/m alone, and so does not last.

Imaginary parts of 1e-30 of their size step along as a derivative (Squire and Trapp 1998, SIAM
Review 40, 110): by the start and every coefficient at once.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import asdict, astuple, dataclass, replace
from functools import cached_property, lru_cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    READ_AT,
    Advance,
    Equations,
    Parts,
    advance,
    states_after,
)
from plumbob.analytic.numerics.arithmetic import ROUNDOFF, ULP
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor, forces
from plumbob.analytic.numerics.smooth.smooth_system import TINY
from plumbob.analytic.reference import KEPT, Array
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED, Scheme

FORCE_ROUNDINGS = 8.0  # of a force, whose parts an engine adds up along its own way
FORCES = (0, 1, 2, 4, 7)  # the rotor's coefficients that are accelerations at 1 rad
Complex = npt.NDArray[np.complex128]


def equations_of(
    rotor: DrivenRotor, scheme: Scheme, step: Any, library: Any = np, by: Any = 1.0
) -> Equations:
    """The equation in a `step` [s], a number, an array or a series: its coefficients are those of
    `rotor` times `by`; `library` has the functions, cmath or numpy."""
    p = SimpleNamespace(**{name: value * by for name, value in asdict(rotor).items()})
    if scheme.control == "mean" and rotor.forcing_frequency:
        half = 0.5 * step * p.forcing_frequency
        p.forcing_amplitude = p.forcing_amplitude * library.sin(half) / half
    force = forces(rotor, library)
    part = float(scheme.implicit_damping)
    implicit = part * p.damping_rate, p.stiffness if scheme.implicit_spring else 0.0
    if scheme.integrator == LEAPFROG:  # so that a damped step is symmetric
        implicit = p.damping_rate, 0.0
    return Equations(
        partial(force, p),
        1,
        (lambda state: implicit) if part or scheme.integrator == LEAPFROG else None,
    )


def in_series(scheme: Scheme) -> bool:
    """Whether the error of `scheme` on a rotor is known as a series in the step."""
    jointed = scheme.control == "mean" or scheme.joint_closing_rate is not None
    return scheme.integrator in STEPPED and not jointed


def orders(scheme: Scheme, rotor: DrivenRotor, terms: int) -> range:
    """Powers of the step in so many `terms` of the error on `rotor`, even ones alone of a symmetric
    scheme; a forcing held over the step may lower the first."""
    assert scheme.order is not None
    held = READ_AT.get(scheme.control)
    first = scheme.order
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
    # as EULER reads it anyway
    at_start = scheme.integrator == EULER and scheme.control == "start"
    control = "continuous" if rotor.autonomous or at_start else scheme.control
    return replace(scheme, control=control, implicit_damping=damping, implicit_spring=spring)


@lru_cache(maxsize=KEPT)  # the same for all methods of one scene
def orbit(
    rotor: DrivenRotor,
    start: tuple[float, float],
    scheme: Scheme,
    step: float,
    marks: bytes,
    sizes: tuple[float, ...],
) -> Complex | None:
    """States from `start`, theta [rad] and theta_dot [rad/s], after increasing numbers of steps
    `marks`, shape (d, n), and in the imaginary parts TINY times their response to a unit in the
    last place of each coefficient, and to the roundings of a step of a motion of these `sizes`;
    None where they exceed the range of the sine."""
    take, state = _stepper(rotor, 1.0 + 1j * TINY * ULP, start, scheme, step, cmath)
    # Towards rest, since a stronger pull and a smaller swing both make a pendulum faster.
    nudges = zip(state, _rounded(rotor, scheme, step, *sizes), strict=False)
    state = [x - 1j * TINY * math.copysign(size, x.real) for x, size in nudges]
    try:
        return np.array(
            states_after(take, state, step, np.frombuffer(marks, dtype=np.int64).tolist())
        ).T
    except (ValueError, OverflowError, ZeroDivisionError):  # the sine of infinity
        return None


def _rounded(
    rotor: DrivenRotor, scheme: Scheme, step: float, theta: float, rate: float
) -> list[float]:
    """Roundings of the largest state, up to `theta` [rad] and `rate` [rad/s], and of a step: of
    each number of a state."""
    force = sum(abs(astuple(rotor)[i]) for i in FORCES)
    angle = ROUNDOFF * theta + ULP * step * rate
    speed = ROUNDOFF * rate
    speed += FORCE_ROUNDINGS * ULP * step * force
    turned = 0.0
    if scheme.jointed_moment:  # what an impulse lacks turns the bob
        turned = ULP * step * (rate**2 + force) / scheme.jointed_moment
    # of a joint the bob's velocity, and an opening, which rounds as lengths do
    return [angle, speed + turned, ROUNDOFF * rate, ULP, ULP, 0.0]


def many_steps(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, steps: Array
) -> tuple[Advance, Parts]:
    """The step of a `scheme` of STEPPED for many sizes at once, `steps` [s] of shape (n,), on
    arrays of that shape, and the state it begins with: the numbers of `start` and, with a joint,
    the bob's velocity, the opening's two parts and the pull."""
    # All of one type: numpy converts a number or a real array anew in each operation.
    steps = steps.astype(complex)
    return _stepper(rotor, np.ones_like(steps), start, scheme, steps, np)


def _stepper(
    rotor: DrivenRotor,
    by: Any,
    start: tuple[float, float],
    scheme: Scheme,
    step: Any,
    library: Any,
) -> tuple[Advance, Parts]:
    """The step, of a time and a state, and the state it begins with; arguments as those of
    `equations_of`."""
    equations = equations_of(rotor, scheme, step, library, by)
    if scheme.joint_closing_rate is None:
        return advance(scheme, equations, step), start
    closing = scheme.joint_closing_rate
    (theta, theta_dot) = start
    joint = _Joint(
        None if rotor.conservative and not rotor.cos else equations.acceleration,
        READ_AT.get(scheme.control, 0.0),
        rotor.sin * by,
        step,
        0.0 if math.isinf(closing) else library.exp(-closing * step),
        (1.0 + math.sqrt(1.0 - 4.0 * scheme.jointed_moment)) / 2.0,
        library,
    )
    a = b = 0.0 * step
    if math.isinf(closing):  # as open as the step before would have left it
        before = step * (theta_dot - step * float(rotor.acceleration(0.0, theta, theta_dot)))
        a, b = joint.turned(before, (1.0, before))
        a = a - 1.0
    pull = theta_dot**2 + joint.weight * math.cos(theta)
    return joint, (theta, theta_dot, theta_dot - joint.rate * b, a, b, pull)


@dataclass(frozen=True)
class _Joint:
    """The step of a bob that a joint holds (module docstring)."""

    acceleration: Callable[..., Parts] | None  # but for the weight
    lag: float  # of a forcing, in steps
    weight: Any  # g/L [1/s^2]
    step: Any  # h [s]
    kept: Any  # 1 - k
    part: float  # s
    library: Any

    @cached_property
    def rate(self) -> Any:
        """k / h [1/s]."""
        return (1.0 - self.kept) / self.step

    def turned(self, angle: Any, *vectors: tuple[Any, Any]) -> list[Any]:
        """The parts of vectors in axes that turn by an angle."""
        c = self.library.cos(angle)
        s = self.library.sin(angle)
        return [x for out, aside in vectors for x in (c * out + s * aside, c * aside - s * out)]

    def __call__(self, time: Any, state: Parts) -> Parts:
        x, w, v, a, b, _ = state
        turn = self.step * w
        rate = self.rate
        lever = self.step / self.part
        if self.acceleration is not None:
            v = v + lever * self.acceleration(time + self.lag * self.step, (0.0,), (w,))[0]
        opened = 1.0 + self.kept * a, turn + self.kept * b
        outwards, along, a, b = self.turned(turn, (-rate * a, v), opened)
        x = x + turn
        a = a - 1.0
        outwards = outwards + lever * self.weight * self.library.cos(x)
        along = along - lever * self.weight * self.library.sin(x)
        w = w + self.part * (along - w + rate * b)
        return x, w, w - rate * b, a, b, (outwards + rate * a) / lever
