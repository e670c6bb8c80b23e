"""Errors of Euler steps on a rod that strikes the floor.

Two contacts are stepped: MuJoCo's spring and damper along the normal, with friction that ends a
slip within its step; and pymunk's impulses, which are solved in turns.
"""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.impacts import (
    hard_impulses,
    held_impulses,
    soft_impact,
)
from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.rod_impact import RodImpact
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, signal_differences

# Ratio of the radius of a rod's end to the rod's length in pymunk: contacts begin at this radius.
ROD_END_RADIUS = 1e-12
# calibrated bound on the factor by which an impact amplifies rounding: the largest that was
# measured is a fifth of it
IMPACT_AMPLIFICATION = 1e3


def stepped_places(rod: RodImpact, scheme: Scheme, step: float, marks: Array) -> Array:
    """Returns the place x, z of the rod's centre [m] and the rod's angle [rad] after the numbers of
    steps `marks`, shape (3, n). A scheme that moves positions first is pymunk's, with pymunk's
    contact; otherwise scheme and contact are MuJoCo's."""
    position_first = scheme.position_first
    start_height = rod.height + rod.length / 2.0 * np.sin(rod.angle)
    place = np.array([0.0, start_height, rod.angle])
    rates = np.array([rod.speed, 0.0, 0.0])
    places = [place]
    for _ in range(int(marks[-1])):
        if position_first:
            place = place + step * rates
        rates = _rates_after_contact(rod, position_first, step, place, rates)
        rates = rates - [0.0, step * rod.gravity, 0.0]
        if not position_first:
            place = place + step * rates
        places.append(place)
    return np.asarray(np.array(places)[marks].T)


def _rates_after_contact(
    rod: RodImpact, hard: bool, step: float, place: Array, rates: Array
) -> Array:
    """Returns the rates of a rod after the floor's impulse on its lower end in a step [s].

    `place` is x, z and the angle of the rod, `rates` are the rates before the impulse, shape (3,)
    each. The contact is pymunk's if it is `hard`, else MuJoCo's.
    """
    half = rod.length / 2.0
    lowest = place[1] - half * np.sin(place[2])  # [m] height of the lower end
    if lowest >= (ROD_END_RADIUS * rod.length if hard else 0.0):
        return rates
    mobility = np.diag([1.0, 1.0, 3.0 / half**2]) / rod.mass
    # pymunk's contact is at the rod's end, MuJoCo's halfway between end and floor.
    arm = place[1] - (lowest if hard else lowest / 2.0)
    jacobian = np.array([[1.0, 0.0, arm], [0.0, 1.0, -half * np.cos(place[2])]])
    velocity = jacobian @ rates
    inverse_masses = jacobian @ mobility @ jacobian.T
    if hard:
        fall = step * rod.gravity
        impulses = hard_impulses(velocity, inverse_masses, rod.friction, fall, rod.restitution)
    else:
        contact = soft_impact(rod.restitution, step)
        acceleration = contact.contact_acceleration(lowest, velocity[1])
        normal_impulse = acceleration / rod.weights[2] * step
        impulses = held_impulses(velocity, inverse_masses, rod.friction, normal_impulse)
    return np.asarray(rates + mobility @ jacobian.T @ impulses)


def rod_errors(rod: RodImpact) -> StepErrors:
    """Returns the errors of steps on a rod.

    The errors are empty for schemes that are not stepped here, and for soft contacts, whose
    friction does not end a slip within its step. They are empty, too, if pymunk's rod jams: pymunk
    then reuses the impulses of the step before.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the errors of place and angle at `times` [s], with the rounding that an impact
        amplifies."""
        reuses_impulses = scheme.position_first and rod.impact.jams
        if scheme.integrator != EULER or scheme.contact is not None or reuses_impulses:
            return {}
        exact = rod.observe(times)
        places = stepped_places(rod, scheme, step, whole_steps(times, step))
        errors = signal_differences(dict(zip(exact, places, strict=True)), exact)
        uncertainty = {
            name: IMPACT_AMPLIFICATION * ULP * (1 + abs(x)) for name, x in exact.items()
        }
        return SteppedErrors(errors, uncertainty)

    return StepErrors(error)
