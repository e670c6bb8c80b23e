"""The falling rod in MuJoCo: two slides and a hinge, and a contact at each end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models.impacts import IMPACT_IMPEDANCE, soft_impact
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_start,
    filled,
    set_contacts,
)
from plumbob.engines.method import Method, ModelError
from plumbob.models.rod_impact.model import MODEL

scheme = contacts.scheme
NAMES = ("x", "z", "angle")


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a RodImpact. With convergent contacts friction is the profile's; the
    spring and damper of the normal act on the mass that the end of the rod has at the impact."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings, plane=True)
    for pair in spec.pairs:
        pair.solimp[:2] = [IMPACT_IMPEDANCE] * 2
    set_contacts(spec, profile, step)
    solref = np.array(soft_impact(problem.restitution, step).solref)
    for pair in spec.pairs:
        hardening = 1 - contacts.IMPEDANCE * profile.convergent
        pair.solref = solref * profile.softening * hardening

    def tune(model: mujoco.MjModel) -> None:
        """Sets the inverse weight of the rod to that of its end at the impact."""
        if profile.convergent:
            model.body_invweight0[1:] = problem.weights[2] * profile.softening

    return at_start(spec, tune=tune)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds for convergent contacts, from the compliance of friction; empty for soft contacts."""
    profile = contacts.profile(method.settings, plane=True)
    if not profile.convergent:
        return {}
    momentum = (
        profile.slip_compliance(step) / step * problem.impact.impulses[1] * problem.friction
    )
    bound = momentum * duration / problem.mass * max(1.0, 6.0 / problem.length)
    return {name: {"compliance": bound} for name in NAMES}
