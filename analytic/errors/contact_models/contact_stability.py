"""Largest stable step of a body on soft contacts, by the modes of the body under a scheme."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.errors.smooth_motion.stepped_rotor import many_steps
from plumbob.analytic.errors.stability.largest_step import (
    jacobians,
    largest_step,
)
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, LINEARLY_IMPLICIT, STEPPED_SCHEMES, Scheme

# Squared ratios of a mode's to a contact's frequency, a wider range than any body has.
FREQUENCY_RATIOS = (1e-3, 1e6)


@dataclass(frozen=True)
class ContactSpring:
    """One direction of a regularised contact.

    At a depth x the contact requires the acceleration -`stiffness` x - `damping` x'. Its softness
    is `regularisation` times the inverse mass that acts on it.
    """

    stiffness: float  # [1/s^2]
    damping: float  # [1/s]
    regularisation: float = 0.0


def largest_contact_step(ratio: float, spring: ContactSpring, scheme: Scheme) -> float:
    """Returns the step [s] below which a mode of a body on its contacts is stable (eq. 9.2).

    `ratio` is the squared ratio of the mode's frequency to the frequency of one contact `spring`.
    If no theory covers the scheme, the step is infinite.
    """
    fraction = ratio / (ratio + spring.regularisation)
    damping = fraction * spring.damping
    stiffness = fraction * spring.stiffness
    rotor = DrivenRotor(damping_rate=damping, stiffness=stiffness)
    if scheme.integrator == LINEARLY_IMPLICIT:
        scheme = Scheme(EULER, implicit_damping=1.0)
    if scheme.integrator not in STEPPED_SCHEMES:
        return math.inf

    def matrices(steps: Array) -> Array:
        """Returns the matrix of one step of each size in `steps` [s], shape (n, 2, 2)."""
        return jacobians(*many_steps(rotor, (0.0, 0.0), scheme, steps), len(steps))

    return largest_step(matrices, np.roots([1.0, damping, stiffness]).astype(complex))


def largest_ratio(frequency_step: float, damping_ratio: float, scheme: Scheme) -> float:
    """Returns the largest squared ratio of a mode's to a contact's frequency that is stable.

    The contacts have a small impedance. `frequency_step` is the frequency of one contact times the
    step (eq. 9.3). If all FREQUENCY_RATIOS are stable, the result is infinite.
    """
    if scheme.integrator == EULER and not scheme.implicit_damping:
        return 4.0 / (frequency_step**2 + 4.0 * damping_ratio * frequency_step)
    # Time is measured in steps, so that the step is 1.
    spring = ContactSpring(frequency_step**2, 2.0 * damping_ratio * frequency_step)

    def log_stable_step(log_ratio: float) -> float:
        """Returns the logarithm of a mode's largest stable step: negative if 1 is unstable."""
        ratio = math.exp(log_ratio)
        mode = ContactSpring(ratio * spring.stiffness, ratio * spring.damping)
        return math.log(largest_contact_step(1.0, mode, scheme))

    lowest, highest = map(math.log, FREQUENCY_RATIOS)
    if log_stable_step(highest) > 0.0:
        return math.inf
    return math.exp(float(brentq(log_stable_step, lowest, highest, xtol=1e-9)))
