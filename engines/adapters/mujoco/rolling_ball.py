"""The rolling ball in MuJoCo: slides along x and z, a hinge across, and one contact."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_rest,
    filled,
    set_contacts,
)
from plumbob.engines.method import Method, ModelError
from plumbob.models.rolling_ball.model import MODEL

# Steps until a contact is at rest; with a time constant of 0.02 s it takes 1000 steps of SLOW
SETTLING = 5000
SLOW = 1e-3  # [s] smallest step for finding the static depth of default contacts


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a RollingBall, at the static penetration of its contact. MuJoCo places a
    contact in the middle between the two surfaces. The geom is therefore larger by half of the
    penetration, and its centre lower by as much: the contact is one radius below the centre."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings, plane=True)
    set_contacts(spec, profile, step)
    if not profile.convergent:  # the depth of a default contact is the same at every step
        spec.option.timestep = max(step, SLOW)
    model = spec.compile()
    profile.soften(model)
    penetration = -float(at_rest(model, SETTLING)[1])
    depth = penetration / 2.0
    spec.geom("ball").size[0] += depth
    qpos = np.array([0.0, -depth, 0.0])
    qvel = np.array(spec.key("start").qvel)
    return Translation(spec, qpos, qvel, tune=profile.soften)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on errors for convergent contacts, from the slip that friction's compliance leaves in
    a step, and from normal forces that change with the slip until the deflection has followed.
    Empty for soft contacts."""
    profile = contacts.profile(method.settings, plane=True)
    if not profile.convergent:
        return {}
    slip = profile.slip_compliance(step) * problem.friction * problem.gravity
    coupling = profile.pushed(problem.friction, problem.scale)
    speed = {"slip": slip, "coupling": coupling}
    spin = {reason: 2.5 * error / problem.radius for reason, error in speed.items()}
    displacement = {"slip": slip * step, "coupling": coupling * duration}
    return {"x": displacement, "speed": speed, "spin": spin}
