"""The numbers of a rolling disc in rolling_disc.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.rolling_disc import RollingDisc
from plumbob.models.model_file import ModelFile


def fill(spec: Any, problem: RollingDisc) -> None:
    """Write the numbers of a disc of mass 1 into an MjSpec of rolling_disc.xml. It starts where it
    rolls: the velocity of its centre follows from its angles' rates."""
    from plumbob.analytic.errors.contact_models.disc_steps import contact_jacobian

    radius = problem.radius
    system = problem.motion.system
    start = spec.key("start")
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    spec.body("disc").inertia = [radius**2 / 4.0, radius**2 / 4.0, radius**2 / 2.0]
    spec.geom("rim").size = [radius, radius, 1e-6 * radius]
    spec.geom("disc").size[:2] = [radius, 0.02 * radius]
    start.qpos = [0.0, 0.0, radius * np.sin(problem.tilt), *system.position]
    held = contact_jacobian(problem, np.array(system.position))[:, 3:] @ system.rate
    start.qvel = [*-held, *system.rate]


def observe(problem: RollingDisc, qpos: Array, qvel: Array) -> Signals:
    """Euler's angles, their rates and what follows from them; three slides come before the
    hinges."""
    states = np.concatenate([qpos[:, 3:], qvel[:, 3:]], axis=1)
    return problem.motion.system.observed(states.T)


MODEL = ModelFile(fill, observe)
