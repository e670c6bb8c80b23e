"""The relation of a rolling disc to rolling_disc.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.rolling_disc import RollingDisc
from plumbob.models.model_file import ModelFile


def fill(spec: Any, problem: RollingDisc) -> None:
    """Writes the numbers of a disc of mass 1 into an MjSpec of rolling_disc.xml. The disc rolls at
    the start: the rates of its angles determine the velocity of its centre."""
    from plumbob.analytic.errors.contact_models.disc_steps import contact_jacobian

    radius = problem.radius
    system = problem.motion.system
    start = spec.key("start")
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    spec.body("disc").inertia = [radius**2 / 4.0, radius**2 / 4.0, radius**2 / 2.0]
    spec.geom("rim").size = [radius, radius, 1e-6 * radius]
    spec.geom("disc").size[:2] = [radius, 0.02 * radius]
    start.qpos = [0.0, 0.0, radius * np.sin(problem.tilt), *system.position]
    contact_velocity = contact_jacobian(problem, np.array(system.position))[:, 3:] @ system.rate
    start.qvel = [*-contact_velocity, *system.rate]


def observe(problem: RollingDisc, qpos: Array, qvel: Array) -> Signals:
    """Returns Euler's angles, their rates, and the observables that follow from them. The file has
    three slides before the hinges."""
    states = np.concatenate([qpos[:, 3:], qvel[:, 3:]], axis=1)
    return problem.motion.system.observed(states.T)


MODEL = ModelFile(fill, observe)
