"""The cube on an incline in MuJoCo: three slides, and a contact at each corner."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.held_bodies import corner
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import Translation, filled, set_contacts
from plumbob.engines.method import Method, ModelError
from plumbob.models.incline.model import MODEL

scheme = contacts.scheme
DIRECTIONS = 3  # number of directions in which the cube can move


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of an Incline, whose cube starts at the static depth of its contacts. Gravity
    is tilted along the problem's heading and the plane is level, so that the contacts' axes lie
    along the axes of the plane."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings, plane=True)
    set_contacts(spec, profile, step)
    depth = profile.depth(corner(problem), step)
    return Translation(
        spec=spec,
        qpos=np.array([0.0, 0.0, -depth]),
        qvel=np.array(spec.key("start").qvel),
        tune=profile.soften,
    )


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on the errors of x and the speed. For convergent contacts: the drift of friction that
    holds, and normal forces that change with the slip until the deflection has followed. For soft
    contacts: the solver's tolerance."""
    profile = contacts.profile(method.settings, plane=True)
    if profile.point is not None:
        return contacts.drift_error(profile.point, corner(problem), duration, step, DIRECTIONS)
    largest_speed = abs(problem.speed) + problem.pull * duration
    drift = profile.slip_compliance(step) * problem.friction * problem.press
    speed = {"drift": drift, "coupling": profile.pushed(problem.friction, largest_speed)}
    return {"x": {why: error * duration for why, error in speed.items()}, "speed": speed}
