"""Sensitivities of pendulums and the free body, from the equations of their smooth motions."""

from __future__ import annotations

from functools import partial

import numpy as np

from plumbob.analytic.numerics.quad import quad
from plumbob.analytic.numerics.rotor.orbit import rotor_motion, smooth_system
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.sensitivities.smooth_motion import smooth_gradients
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.free_body.equations import free_rotation
from plumbob.analytic.systems.simple_pendulum import SimplePendulum


def cone_pendulum(pendulum: ConePendulum) -> SmoothMotion:
    """Returns the smooth motion of a cone pendulum, with the state (theta, theta_dot) and its start
    in 34 digits."""
    motion = pendulum.motion
    begin = motion.closed_form
    speed = np.sqrt(2 * begin.kinetic / begin.inertia) * np.copysign(1.0, pendulum.theta_dot)
    if pendulum.excess is None:
        speed = quad(pendulum.theta_dot)
    start = np.array([quad(pendulum.theta), speed])
    system = smooth_system(motion.rotor, pendulum.theta, float(speed), pendulum.tilt)
    return rotor_motion(motion.rotor, system, pendulum.reference, start)


def simple_pendulum(pendulum: SimplePendulum) -> SmoothMotion:
    """Returns the smooth motion of a simple pendulum, with the state (theta, theta_dot).

    If the initial angle is given from the top, the start of the motion is, too.
    """
    from_top = pendulum.theta_from_top
    angle = pendulum.theta if from_top is None else from_top
    start = np.array([angle, pendulum.theta_dot])
    return rotor_motion(pendulum.rotor, pendulum.system, pendulum.motion, start)


cone_pendulum_gradients = partial(smooth_gradients, cone_pendulum)
simple_pendulum_gradients = partial(smooth_gradients, simple_pendulum)
free_body_gradients = partial(smooth_gradients, free_rotation)
