"""The pinched cube in MuJoCo: slides, and two fingertips on slides with motors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.held_bodies import FINGERTIP_RADIUS, fingertip
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.incline import DIRECTIONS
from plumbob.engines.adapters.mujoco.translation import Translation, filled, set_contacts
from plumbob.engines.method import Method, ModelError, Unsupported
from plumbob.models.pinch.model import MODEL

scheme = contacts.scheme


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a Pinch, in the frame of the hand, at the static depth of its contacts.
    The push is a gravity: the fingers do not move along it. Raises Unsupported if the contacts are
    too deep."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings, plane=True)
    set_contacts(spec, profile, step)
    depth = profile.depth(fingertip(problem), step)
    if profile.convergent and depth > FINGERTIP_RADIUS * problem.size:
        raise Unsupported("at this step the contacts are too deep")
    qpos = np.array([0.0, 0.0, 0.0, depth, depth])
    return Translation(spec, qpos, np.zeros(5), tune=profile.soften)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on the errors of slip and speed: the drift of convergent contacts, or the solver's
    tolerance for soft contacts."""
    profile = contacts.profile(method.settings, plane=True)
    held = fingertip(problem)
    if profile.point is None:
        drift = profile.slip_compliance(step) * held.weight * problem.load
        return {"slip": {"drift": drift * duration}, "speed": {"drift": drift}}
    inertia = DIRECTIONS + 2.0 * problem.finger_mass / problem.mass
    bounds = contacts.drift_error(profile.point, held, duration, step, inertia)
    return {"slip": bounds["x"], "speed": bounds["speed"]}
