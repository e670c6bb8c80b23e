"""An Euler step of a bob that a joint, solved for velocities, holds to its pivot.

Engines in the manner of Chipmunk move first, then solve the velocities. A pivot joint at the end of
a bob's weightless rod is not kept closed: with lengths in units of the rod and the complex plane
turning with it (1 outwards, i along theta), its opening Z and the pendulum take the step

    theta' = theta + D,  D = h w,      Z' = (1 - k) e^(-iD) Z + e^(-iD) (1 + iD) - 1,
    w' = w cos D + Im S + h (-(g/L) sin theta' + F cos D),    S = k (Z' - e^(-iD) Z) / h,

F the damping and forcing at the step's start. The joint pulls along the rod alone, by the tension

    T'/(m L) = (Re S + w sin D) / h + (g/L) cos theta' + F sin D.

k is the part of its opening that the joint closes in a step. With k = 1, Z follows the motion at
one step's distance and is of order h^2. With k = 1 - e^(-beta h), where the joint closes at a rate,
Z is h Q with Q' = -(beta + i w) Q + w^2/2: the rod is longer and energy is lost, both at order h.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.schemes import StepSeries
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.truncated_series import product, raised, sine_cosine
from plumbob.analytic.reference import Array

DRIFT = -60.0 * math.log(0.9)  # [1/s] at which Chipmunk's joints close unless told otherwise
CLOSING: Mapping[str, float] = MappingProxyType(
    {"jointed-euler": math.inf, "jointed-euler+drift": DRIFT}
)  # scheme -> rate [1/s], infinite where a joint closes in one step
Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class JointedStep:
    """Series in h of what a step makes of theta, theta_dot and the opening, and of the excess of
    the joint's pull over the tension of that state, per mass and length [1/s^2]."""

    theta: Array
    theta_dot: Array
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
    told = _lowered(slack + product(theta_dot, sine)).real + product(pushed, sine)
    return JointedStep(theta_next, dot_next, opened, told - product(dot_next, dot_next))


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
