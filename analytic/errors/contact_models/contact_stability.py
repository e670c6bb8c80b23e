"""The largest step at which a body on soft contacts holds: its modes under a scheme."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.errors.stability.largest_step import largest_step
from plumbob.analytic.errors.stability.linear_steps import LinearSystem, step_matrices
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme

RATIOS = (1e-3, 1e6)  # of a body's modes to one contact, squared: wider than any body's


@dataclass(frozen=True)
class ContactSpring:
    """One direction of a contact: it asks for the acceleration -`stiffness` x - `damping` x' at a
    depth x, and yields by `regularisation` times its own inverse weight."""

    stiffness: float  # [1/s^2]
    damping: float  # [1/s]
    regularisation: float = 0.0


def largest_contact_step(effect: Array, springs: Sequence[ContactSpring], scheme: Scheme) -> float:
    """The step [s] of `scheme` below which all that touches at once holds (eq. 9.2). `effect` is
    the acceleration of each of n directions of contacts by a force in each, over the contacts'
    inverse weights, shape (n, n); of one mode alone it is the square of its frequency over one
    contact's. Infinite for a scheme that is not known here."""
    yielding, stiffness, damping = np.array(
        [(spring.regularisation, spring.stiffness, spring.damping) for spring in springs]
    ).T
    answer = effect @ np.linalg.pinv(effect + np.diag(yielding))
    system = LinearSystem(np.eye(len(springs)), answer * damping, answer * stiffness)
    matrices = step_matrices(system, scheme)
    return math.inf if matrices is None else largest_step(matrices, system.rates)


def largest_ratio(frequency_step: float, damping_ratio: float, scheme: Scheme) -> float:
    """The largest square of the ratio of a mode's frequency to one contact's at which a `scheme` is
    stable, contacts of small impedance: `frequency_step` is one's frequency times the step
    (eq. 9.3)."""
    if scheme.integrator == EULER and not scheme.implicit_damping:
        return 4.0 / (frequency_step**2 + 4.0 * damping_ratio * frequency_step)
    spring = ContactSpring(frequency_step**2, 2.0 * damping_ratio * frequency_step)

    def margin(logarithm: float) -> float:
        ratio = math.exp(logarithm)
        mode = ContactSpring(ratio * spring.stiffness, ratio * spring.damping)
        return math.log(largest_contact_step(np.eye(1), (mode,), scheme))

    low, high = map(math.log, RATIOS)
    if margin(high) > 0.0:
        return math.inf
    return math.exp(float(brentq(margin, low, high, xtol=1e-9)))
