"""The relation of a chain of rods to n_pendulum.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.n_pendulum import NPendulum
from plumbob.models.model_file import ModelFile


def fill(spec: Any, chain: NPendulum) -> None:
    """Writes the numbers of a chain into an MjSpec of n_pendulum.xml, and gives it as many rods as
    the chain has."""
    spec.option.gravity = [0.0, 0.0, -chain.gravity]
    rod_above = None
    length_above = 0.0
    rods = zip(chain.each("masses"), chain.each("lengths"), strict=True)
    for number, (mass, length) in enumerate(rods, start=1):
        rod = spec.body(f"rod_{number}") or _add_rod(rod_above, number)
        rod.pos = [0.0, 0.0, -length_above]
        rod.mass = mass
        rod.ipos = [0.0, 0.0, -length / 2]
        rod.inertia = [mass * length**2 / 12] * 3
        rod.first_geom().fromto = [0.0, 0.0, 0.0, 0.0, 0.0, -length]
        rod_above = rod
        length_above = length
    extra_rod = spec.body(f"rod_{len(chain.angles) + 1}")
    if extra_rod is not None:
        spec.delete(extra_rod)
    start = spec.key("start")
    start.qpos = np.diff(chain.each("angles"), prepend=0.0)
    start.qvel = np.diff(chain.each("angular_velocities"), prepend=0.0)


def _add_rod(above: Any, number: int) -> Any:
    """Adds one more rod to the rod `above`, with a geom of the same type; returns the rod."""
    rod = above.add_body(name=f"rod_{number}")
    rod.add_joint(name=f"hinge_{number}", axis=[0.0, -1.0, 0.0])
    rod.add_geom(type=above.first_geom().type, size=[0.015, 0.0, 0.0], mass=0.0)
    rod.explicitinertial = True
    return rod


def observe(chain: NPendulum, qpos: Array, qvel: Array) -> Signals:
    """Returns the angles of the rods from the vertical, their rates, and the tip's place."""
    return chain_observables(chain.motion.system, qpos, qvel)


def chain_observables(system: SmoothSystem, qpos: Array, qvel: Array) -> Signals:
    """Returns the observables of a chain. A hinge of the file has the angle from the rod above; a
    coordinate of the system has the angle from the vertical."""
    states = np.concatenate([np.cumsum(qpos, axis=1), np.cumsum(qvel, axis=1)], axis=1)
    return system.observed(states.T)


MODEL = ModelFile(fill, observe)
