"""The stack in MuJoCo's terms: a slide along z a cube, and a contact a corner."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.held_bodies import corners
from plumbob.analytic.errors.contact_models.soft_friction import rates
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import Translation, filled, with_contacts
from plumbob.engines.method import Method, ModelError
from plumbob.models.stack.model import MODEL

scheme = contacts.scheme


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Stack at the static depths of its contacts."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings)
    tune = with_contacts(spec, profile, step)
    depths = np.cumsum([profile.depth(held, step) for held in corners(problem)])
    return Translation(
        spec,
        -depths,
        np.zeros(len(depths)),
        tune=tune,
    )


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Where the solver ends: by an acceleration of each cube, which its contact's stiffness turns
    into a depth."""
    profile = contacts.profile(method.settings)
    if (point := profile.point) is None:
        return {}
    off = math.sqrt(2.0 * float(profile.options.get("tolerance", contacts.SOLVED)))
    masses = problem.masses
    left = off * np.sqrt(masses.sum() / masses).sum() / rates(point, step)[0]
    return {"top": {"solver": float(left)}}
