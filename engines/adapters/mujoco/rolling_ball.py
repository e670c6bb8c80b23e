"""The rolling ball in MuJoCo: slides along x and z, a hinge across, and one contact."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_rest,
    filled,
    with_contacts,
)
from plumbob.engines.method import Method, ModelError
from plumbob.models.rolling_ball.model import MODEL

# steps until a contact is at rest; a contact of 0.02 s needs 1000 steps of SLOW
SETTLING = 5000
SLOW = 1e-3  # [s] smallest step for finding the static depth of default contacts


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a RollingBall, at the static penetration of its contact. MuJoCo places a
    contact in the middle between the two surfaces. The geom is therefore larger by half of the
    penetration, and its centre lower by as much: the contact is one radius below the centre."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings, plane=True)
    tune = with_contacts(spec, profile, step)
    start = spec.key("start")
    if not profile.convergent:  # the depth of a default contact is the same at every step
        spec.option.timestep = max(step, SLOW)

    depth = settled_depth(spec, tune) / 2.0
    spec.geom("ball").size[0] += depth
    return Translation(spec, np.array([0.0, -depth, 0.0]), np.array(start.qvel), tune=tune)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds for convergent contacts, from the slip that friction's compliance leaves for one step,
    and from normal forces that change with the slip until the deflection has followed. Empty for
    soft contacts."""
    profile = contacts.profile(method.settings, plane=True)
    if not profile.convergent:
        return {}
    left = profile.slip_compliance(step) * problem.friction * problem.gravity
    pushed = profile.pushed(problem.friction, problem.scale)
    speed = {"slip": left, "coupling": pushed}
    spin = {name: 2.5 * error / problem.radius for name, error in speed.items()}
    x = {"slip": left * step, "coupling": pushed * duration}
    return {"x": x, "speed": speed, "spin": spin}


def settled_depth(spec: mujoco.MjSpec, tune: Callable[[mujoco.MjModel], None]) -> float:
    """Returns the static penetration of the contact [m]."""
    model = spec.compile()
    tune(model)
    return -float(at_rest(model, SETTLING)[1])
