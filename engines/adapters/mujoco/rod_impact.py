"""The falling rod in MuJoCo: two slides and a hinge, and a contact at each end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.errors.contact_models.impacts import IMPACT_IMPEDANCE, soft_impact
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_start,
    filled,
    with_contacts,
)
from plumbob.engines.method import Method, ModelError
from plumbob.models.rod_impact.model import MODEL

scheme = contacts.scheme
NAMES = ("x", "z", "angle")


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a RodImpact. With convergent contacts friction is the profile's; the
    spring and damper of the normal act on the mass that the end of the rod has at the impact."""
    spec = filled(mjcf, MODEL, problem)
    for pair in spec.pairs:
        pair.solref = soft_impact(problem.restitution, step).solref
        pair.solimp[:2] = [IMPACT_IMPEDANCE] * 2
    profile = contacts.profile(method.settings, plane=True)
    own = [(pair, pair.solref.copy()) for pair in spec.pairs]
    with_contacts(spec, profile, step)

    def tune(model: mujoco.MjModel) -> None:
        if profile.convergent:
            model.body_invweight0[1:] = problem.weights[2] * profile.softening

    for pair, solref in own:
        pair.solref = solref * profile.softening * (1 - contacts.IMPEDANCE * profile.convergent)
    return at_start(
        spec,
        tune=tune,
        whole=spec.copy(),
    )


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds for convergent contacts, from the compliance of friction; empty for soft contacts."""
    profile = contacts.profile(method.settings, plane=True)
    if not profile.convergent:
        return {}
    speed = profile.slip_compliance(step) / step * problem.impact.impulses[1] * problem.friction
    way = speed * duration / problem.mass * max(1.0, 6.0 / problem.length)
    return {name: {"compliance": way} for name in NAMES}
