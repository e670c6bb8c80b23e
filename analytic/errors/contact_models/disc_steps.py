"""Errors of steps on a disc that rolls.

Two models are stepped: schemes on the disc's smooth equations; or semi-implicit Euler on a disc
with six coordinates whose contact is a spring and damper with friction that ends all slip.
"""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.errors.smooth_motion.stepped_system import smooth_errors
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme, SoftPoint
from plumbob.analytic.systems.rolling_disc import RollingDisc, masses, moments
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, apart

ROLLS = SoftPoint(time_constant=0.0, ratio=np.inf, pyramidal=False)
"""Mark of a contact by spring and damper whose friction ends a slip within a step."""
RATE, DAMPING = 0.4, 0.3  # angular frequency of the spring times the step; damping ratio
FRICTION = 1.0  # coefficient of friction in the models
YIELDS = 9.999e-6  # softness of friction over the inverse mass, by impedance and impratio
# Multiple of the input uncertainty that rounding in steps may reach. Calibrated: half of it is used
# (test_rolling_disc.py).
ROUNDED = 20.0


def turning(angles: Array) -> Array:
    """Returns the axes of the precession, the tilt and the spin as columns, shape (3, 3)."""
    (a, c) = np.cos(angles[:2])
    (b, d) = np.sin(angles[:2])
    return np.array([[0.0, a, b * d], [0.0, b, -a * d], [1.0, 0.0, c]])


def rolling(disc: RollingDisc, angles: Array, depth: float = 0.0) -> Array:
    """Returns the Jacobian of the contact point's velocity, shape (3, 6).

    The contact point is on the disc, `depth` [m] below the disc's lowest point. The six columns
    belong to the velocity of the disc's centre and to the rates of its `angles`.
    """
    axes = turning(angles)
    arm = np.cross(axes[:, 1], axes[:, 2]) * disc.radius - [0.0, 0.0, depth]
    return np.hstack([np.eye(3), np.cross(axes.T, arm).T])


def stepped(disc: RollingDisc, step: float, marks: Array) -> Array:
    """Returns angles and their rates after the numbers of steps `marks`, shape (6, n).

    The disc has unit mass. `step` is in [s]. If the disc slips, the result is empty, shape (6, 0).
    """
    start = disc.motion.system.start
    square = disc.radius**2
    spring = (RATE / step) ** 2
    place = np.array(
        [0, 0, disc.radius * np.sin(disc.tilt) - disc.gravity / spring, *start[:3]]
    )
    rates = np.array([*-rolling(disc, start[:3])[:, 3:] @ start[3:], *start[3:]])
    states = [np.concatenate([place[3:], rates[3:]])]
    mobility = np.eye(6)
    for _ in range(int(marks[-1])):
        angles = place[3:]
        low = place[2] - disc.radius * np.sin(angles[1])
        ends = rolling(disc, angles, low / 2.0)
        mobility[3:, 3:] = np.linalg.inv(masses(0.0, angles)) / square
        push = max(0.0, -spring * low - 2.0 * DAMPING * RATE / step * (ends @ rates)[2]) * step
        turned = step * square * np.array(moments(0.0, 0.0, angles, rates[3:]))
        impulses = np.array([0.0, 0.0, -disc.gravity * step, *turned]) + ends[2] * push
        rates = rates + mobility @ impulses
        held = np.linalg.solve(
            ends[:2] @ mobility @ ends[:2].T + YIELDS * np.eye(2), -ends[:2] @ rates
        )
        if not np.hypot(*held) <= FRICTION * push:  # the disc slips
            return np.empty((6, 0))
        rates = rates + mobility @ ends[:2].T @ held
        place = place + step * rates
        states.append(np.concatenate([place[3:], rates[3:]]))
    return np.asarray(np.array(states)[marks].T)


def disc_errors(disc: RollingDisc) -> StepErrors:
    """Returns the errors of steps on a disc; empty for schemes and contacts unknown here."""

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        if scheme.contact is None:
            return smooth_errors(disc.motion).at_step(scheme, step, times)
        if scheme.contact != ROLLS or scheme.integrator != EULER:
            return {}
        states = stepped(disc, step, whole_steps(times, step))
        if not states.size:
            return {}
        exact = disc.motion.observe(times)
        doubt = disc.motion.uncertainty(times)
        return SteppedErrors(
            apart(dict(zip(exact, states, strict=True)), exact),
            {name: ROUNDED * (x + ULP * abs(exact[name])) for name, x in doubt.items()},
        )

    return StepErrors(error)
