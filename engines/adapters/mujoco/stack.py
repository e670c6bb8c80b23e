"""The stack in MuJoCo: a slide along z for each cube, and a contact for each corner."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.held_bodies import corners
from plumbob.analytic.errors.contact_models.soft_friction import rates
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import Translation, filled, set_contacts
from plumbob.engines.method import Method, ModelError
from plumbob.models.stack.model import MODEL

scheme = contacts.scheme


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a Stack, at the static depths of its contacts."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings)
    set_contacts(spec, profile, step)
    depths = np.cumsum([profile.depth(held, step) for held in corners(problem)])
    return Translation(spec, -depths, np.zeros(len(depths)), tune=profile.soften)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The bound on the height of the top from the solver's tolerance: it leaves each cube an
    acceleration, which the stiffness of the contact turns into a depth. Empty for convergent
    contacts."""
    profile = contacts.profile(method.settings)
    point = profile.point
    if point is None:
        return {}
    tolerance = float(profile.options.get("tolerance", contacts.SOLVED))
    masses = problem.masses
    accelerations = math.sqrt(2.0 * tolerance) * np.sqrt(masses.sum() / masses).sum()
    depth = accelerations / rates(point, step)[0]
    return {"top": {"solver": float(depth)}}
