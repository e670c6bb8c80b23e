"""The relation of a simple or linear pendulum to simple_pendulum.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.models.idealisations import Idealisations
from plumbob.models.largest import largest_pendulum_rates
from plumbob.models.model_file import Controls, ModelFile


def fill(spec: Any, problem: SimplePendulum) -> None:
    """Writes the numbers of a pendulum into an MjSpec of simple_pendulum.xml. A linear pendulum has
    the same hinge, with a spring in place of gravity."""
    pendulum = problem.started
    length = pendulum.length
    moment = pendulum.mass * length**2
    bob = spec.body("bob")
    joint = spec.joint("theta")
    spec.option.gravity = [0.0, 0.0, 0.0 if pendulum.linear else -pendulum.gravity]
    bob.mass = pendulum.mass
    bob.ipos = [0.0, 0.0, -length]
    joint.damping = first_coefficient(joint.damping, pendulum.damping_rate * moment)
    if pendulum.linear:
        stiffness = pendulum.mass * pendulum.gravity * length
        joint.stiffness = first_coefficient(joint.stiffness, stiffness)
    # The control is an angular acceleration [rad/s^2].
    spec.actuator("forcing").gear[0] = moment
    spec.geom("rod").fromto = [0.0, 0.0, -length, 0.0, 0.0, 0.0]
    spec.geom("bob").pos = [0.0, 0.0, -length]
    start = spec.key("start")
    start.qpos = [pendulum.theta]
    start.qvel = [pendulum.theta_dot]


def first_coefficient(template: Any, value: float) -> Any:
    """Returns `value` in the shape of a joint's damping or stiffness. This is a number, or since
    MuJoCo 3.17 the coefficients of a polynomial, constant first."""
    if np.ndim(template) == 0:
        return value
    return [value, *[0.0] * (len(template) - 1)]


def ideal(problem: SimplePendulum) -> Idealisations:
    """Returns the pendulum's idealisation: its bob is a point."""
    return Idealisations(points=("bob",))


def observe(problem: SimplePendulum, qpos: Array, qvel: Array) -> Signals:
    """Returns the angle and its rate."""
    return hinge_angle(qpos, qvel)


def hinge_angle(qpos: Array, qvel: Array) -> Signals:
    """Returns the angle and the rate of a model's last joint, a hinge."""
    return {"theta": qpos[:, -1], "theta_dot": qvel[:, -1]}


def controls(problem: SimplePendulum) -> Controls | None:
    """Returns the angular acceleration by the forcing [rad/s^2]; None without forcing."""
    if problem.forcing_amplitude == 0.0:
        return None
    return lambda times: problem.started.rotor.forcing(times)[:, None]


def forces(
    problem: SimplePendulum, qpos: Array, qvel: Array, joints: Array, touching: Array
) -> Signals:
    """Returns the tension of the rod: the force by which the hinge pulls the bob. At the start it
    is the tension of a rigid rod."""
    if problem.linear:
        return {}
    theta = qpos[:, 0]
    inwards = np.stack([-np.sin(theta), np.zeros(len(theta)), np.cos(theta)], axis=1)
    pull = (joints[:, 0] * inwards).sum(axis=1)
    rigid = problem.length * qvel[:, 0] ** 2 + problem.gravity * np.cos(theta)
    return {"tension": np.where(np.isnan(pull), problem.mass * rigid, pull)}


MODEL = ModelFile(
    fill=fill,
    observe=observe,
    ideal=ideal,
    controls=controls,
    largest=lambda problem: largest_pendulum_rates(problem.started),
    forces=forces,
)
