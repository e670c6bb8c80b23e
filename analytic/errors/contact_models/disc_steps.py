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
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, signal_differences

ROLLS = SoftPoint(time_constant=0.0, ratio=np.inf, pyramidal=False)
"""Mark of a contact by spring and damper whose friction ends a slip within a step."""
SPRING_PHASE_PER_STEP = 0.4  # angular frequency of the spring times the step
CONTACT_DAMPING_RATIO = 0.3  # damping ratio of the contact
MODEL_FRICTION = 1.0  # coefficient of friction in the models
# Ratio of friction's softness to the inverse mass. It follows from MuJoCo's impedance and impratio.
FRICTION_SOFTNESS = 9.999e-6
# Multiple of the input uncertainty that rounding in steps may reach. Calibrated: half of it is used
# (test_rolling_disc.py).
DISC_ROUNDING_FACTOR = 20.0


def rotation_axes(angles: Array) -> Array:
    """Returns the axes of the precession, the tilt and the spin as columns, shape (3, 3)."""
    cos_precession, cos_tilt = np.cos(angles[:2])
    sin_precession, sin_tilt = np.sin(angles[:2])
    precession = [0.0, 0.0, 1.0]
    tilt = [cos_precession, sin_precession, 0.0]
    spin = [sin_precession * sin_tilt, -cos_precession * sin_tilt, cos_tilt]
    return np.array([precession, tilt, spin]).T


def contact_jacobian(disc: RollingDisc, angles: Array, depth: float = 0.0) -> Array:
    """Returns the Jacobian of the contact point's velocity, shape (3, 6).

    The contact point is on the disc, `depth` [m] below the disc's lowest point. The six columns
    belong to the velocity of the disc's centre and to the rates of its `angles`.
    """
    axes = rotation_axes(angles)
    arm = np.cross(axes[:, 1], axes[:, 2]) * disc.radius - [0.0, 0.0, depth]
    return np.hstack([np.eye(3), np.cross(axes.T, arm).T])


def stepped_states(disc: RollingDisc, step: float, marks: Array) -> Array:
    """Returns angles and their rates after the numbers of steps `marks`, shape (6, n).

    The disc has unit mass. `step` is in [s]. At the start the contact carries the disc's weight. If
    the disc slips, the result is empty, shape (6, 0).
    """
    start = disc.motion.system.start
    static_depth = disc.gravity / (SPRING_PHASE_PER_STEP / step) ** 2
    height = disc.radius * np.sin(disc.tilt) - static_depth
    position = np.array([0, 0, height, *start[:3]])
    centre_velocity = -contact_jacobian(disc, start[:3])[:, 3:] @ start[3:]
    rates = np.array([*centre_velocity, *start[3:]])
    states = [start]
    for _ in range(int(marks[-1])):
        next_rates = _rates_after_contact(disc, step, position, rates)
        if next_rates is None:
            return np.empty((6, 0))
        rates = next_rates
        position = position + step * rates
        states.append(np.concatenate([position[3:], rates[3:]]))
    return np.asarray(np.array(states)[marks].T)


def _rates_after_contact(
    disc: RollingDisc, step: float, position: Array, rates: Array
) -> Array | None:
    """Returns the rates after the forces of a step; None if the disc slips.

    `position` is the position of the disc's centre [m] and the angles, `rates` are their rates,
    shape (6,) each.
    """
    square = disc.radius**2
    angles = position[3:]
    lowest = position[2] - disc.radius * np.sin(angles[1])  # height of the disc's lowest point
    contact = contact_jacobian(disc, angles, lowest / 2.0)  # halfway from there to the plane
    tangents = contact[:2]
    mobility = np.eye(6)
    mobility[3:, 3:] = np.linalg.inv(masses(0.0, angles)) / square
    normal_impulse = _normal_force(step, lowest, (contact @ rates)[2]) * step
    torques = step * square * np.array(moments(held=0.0, pull=0.0, q=angles, v=rates[3:]))
    free_impulses = np.array([0.0, 0.0, -disc.gravity * step, *torques])
    rates = rates + mobility @ (free_impulses + contact[2] * normal_impulse)
    inverse_mass = tangents @ mobility @ tangents.T + FRICTION_SOFTNESS * np.eye(2)
    friction_impulse = np.linalg.solve(inverse_mass, -tangents @ rates)
    if not np.hypot(*friction_impulse) <= MODEL_FRICTION * normal_impulse:
        return None
    return np.asarray(rates + mobility @ tangents.T @ friction_impulse)


def _normal_force(step: float, height: float, speed: float) -> float:
    """Returns the force [N] of spring and damper on a disc of 1 kg whose lowest point has the
    `height` [m], and whose contact point has the `speed` [m/s] upwards."""
    spring = (SPRING_PHASE_PER_STEP / step) ** 2
    damper = 2.0 * CONTACT_DAMPING_RATIO * SPRING_PHASE_PER_STEP / step
    return max(0.0, -spring * height - damper * speed)


def disc_errors(disc: RollingDisc) -> StepErrors:
    """Returns the errors of steps on a disc; empty for schemes and contacts unknown here."""

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the errors at `times` [s] and their uncertainty by rounding."""
        if scheme.contact is None:
            return smooth_errors(disc.motion).at_step(scheme, step, times)
        if scheme.contact != ROLLS or scheme.integrator != EULER:
            return {}
        states = stepped_states(disc, step, whole_steps(times, step))
        if not states.size:
            return {}
        exact = disc.motion.observe(times)
        errors = signal_differences(dict(zip(exact, states, strict=True)), exact)
        uncertainty = {}
        for name, doubt in disc.motion.uncertainty(times).items():
            uncertainty[name] = DISC_ROUNDING_FACTOR * (doubt + ULP * abs(exact[name]))
        return SteppedErrors(errors, uncertainty)

    return StepErrors(error)
