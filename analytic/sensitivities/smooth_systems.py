"""Pendulums, the free body and systems of n degrees of freedom as smooth motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.numerics.quad import quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import TINY
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity
from plumbob.analytic.sensitivities.smooth_motion import SmoothMotion, smooth_gradients
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, composed
from plumbob.analytic.systems.pendulums.rod_tension import tension
from plumbob.analytic.systems.simple_pendulum import SimplePendulum

ANGLE = ("theta", "theta_dot")


def gradients(
    equations: Callable[[Any], SmoothMotion], problems: Sequence[Neighbours[Any]], times: Array
) -> list[Sensitivity]:
    """Sensitivities at `times` [s], shape (n,), by each parameter, of problems whose `equations`
    are those of a smooth motion."""
    return smooth_gradients([one.each(equations) for one in problems], times)


def cone_pendulum(pendulum: ConePendulum) -> SmoothMotion:
    """Its state is (theta, theta_dot), with the start in 34 digits."""
    motion, tilt = pendulum.motion, pendulum.tilt
    begin = motion.closed_form
    speed = np.sqrt(2 * begin.kinetic / begin.inertia) * np.copysign(1.0, pendulum.theta_dot)
    if pendulum.excess is None:
        speed = quad(pendulum.theta_dot)
    start = np.array([quad(pendulum.theta), speed])
    return _rotor(motion.rotor, tilt, start, pendulum.reference, named)


def simple_pendulum(pendulum: SimplePendulum) -> SmoothMotion:
    """Its state is (theta, theta_dot), the start measured from the top where it is given so."""
    from_top = pendulum.theta_from_top
    angle = pendulum.theta if from_top is None else from_top

    def read(times: Array, states: Array) -> Mapping[str, Array]:
        if pendulum.linear:
            return named(times, states)
        theta, rate = states
        pull = tension(pendulum.length, pendulum.gravity, theta, rate, pendulum.mass)
        return {**named(times, states), "tension": pull}

    start = np.array([angle, pendulum.theta_dot])
    return _rotor(pendulum.rotor, 0.0, start, pendulum.motion, read)


def named(times: Array, states: Array) -> Mapping[str, Array]:
    """The state itself as observables."""
    return dict(zip(ANGLE, states, strict=True))


def _rotor(
    rotor: DrivenRotor,
    tilt: float,
    start: Array,
    motion: Reference,
    read: Callable[[Array, Array], Mapping[str, Array]],
) -> SmoothMotion:
    """A rotor whose angle is theta plus a `tilt` [rad]."""

    def slope(times: Array, states: Array) -> Array:
        theta, rate = states
        return np.stack([rate, rotor.acceleration(times, theta + tilt, rate)])

    def jacobian(times: Array, states: Array) -> Array:
        stiffness = rotor.slope(states[0] + tilt)
        zero = np.zeros_like(stiffness)
        damping = zero - rotor.damping_rate
        return np.array([[zero, zero + 1.0], [stiffness, damping]])

    def state(times: Array) -> Array:
        observed = motion.observe(times)
        return np.stack([observed[name] for name in ANGLE])

    fastest = float(np.abs(double_of(start)[1])) + 2 * rotor.rate()
    return SmoothMotion(start, slope, jacobian, state, fastest, read)


def double_of(start: Array) -> Array:
    """A start in doubles."""
    return np.asarray(start, dtype=np.float64)


def free_body(body: FreeBody) -> SmoothMotion:
    """Its state is the angular velocity and the attitude."""
    inertia = np.array(body.inertia)

    def slope(times: Array, states: Array) -> Array:
        rates, attitude = states[:3], states[3:]
        turning = np.concatenate([np.zeros_like(rates[:1]), rates])
        torque = np.cross((inertia * rates.T).T, rates, axis=0)
        return np.concatenate([(torque.T / inertia).T, composed(attitude, turning) / 2])

    def jacobian(times: Array, states: Array) -> Array:
        ahead = states[:, None] + 1j * TINY * np.eye(len(states))[:, :, None]
        return slope(times, ahead).imag / TINY

    def state(times: Array) -> Array:
        return np.concatenate(body.rotation.state(times))

    def read(times: Array, states: Array) -> Mapping[str, Array]:
        return dict(zip((*RATES, *ATTITUDE), states, strict=True))

    start = np.array([*body.angular_velocity, 1.0, 0.0, 0.0, 0.0])
    return SmoothMotion(start, slope, jacobian, state, 2 * body.fastest, read)


def certified(motion: CertifiedMotion) -> SmoothMotion:
    """A motion of n degrees of freedom, integrated in two ways."""
    system = motion.system
    names = (*system.coordinates, *system.rates)

    def state(times: Array) -> Array:
        observed = motion.observe(times)
        return np.stack([observed[name] for name in names])

    def read(times: Array, states: Array) -> Mapping[str, Array]:
        return system.observed(states)

    jacobian = system.jacobian(0.0, system.start[:, None])[..., 0]
    pace = 4 * float(np.abs(np.linalg.eigvals(jacobian)).max())
    return SmoothMotion(system.start, system.slope, system.jacobian, state, pace, read)


cone_pendulum_gradients = partial(gradients, cone_pendulum)
simple_pendulum_gradients = partial(gradients, simple_pendulum)
free_body_gradients = partial(gradients, free_body)
