"""The falling rod in MuJoCo's terms: two slides and a hinge, and a contact at each end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models.impacts import IMPEDANCE, soft_impact
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_start,
    read,
    with_contacts,
)
from plumbob.engines.method import Method, ModelError

scheme = contacts.scheme
NAMES = ("x", "z", "angle")


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a RodImpact. A convergent profile keeps its friction, and has the normal's spring
    and damper on the mass that the end has at the impact."""
    spec = whole(mjcf, problem, step)
    profile = contacts.profile(method.settings, plane=True)
    own = [(pair, pair.solref.copy()) for pair in spec.pairs]
    with_contacts(spec, profile, step)

    def tune(model: mujoco.MjModel) -> None:
        if profile.convergent:
            model.body_invweight0[1:] = problem.weights[2] * profile.softening

    for pair, solref in own:
        pair.solref = solref * profile.softening * (1 - contacts.IMPEDANCE * profile.convergent)
    return at_start(
        spec, lambda qpos, qvel: (dict(zip(NAMES, qpos.T, strict=True)), {}), tune=tune
    )


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """A bound for a convergent profile: what friction's compliance leaves of all friction."""
    profile = contacts.profile(method.settings, plane=True)
    if not profile.convergent:
        return {}
    speed = profile.slip_compliance(step) / step * problem.impact.impulses[1] * problem.friction
    way = speed * duration / problem.mass * max(1.0, 6.0 / problem.length)
    return {name: {"compliance": way} for name in NAMES}


def whole(mjcf: Path, problem: Any, step: float = 1e-3) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, and contacts for a `step` [s]."""
    spec = read(mjcf, problem.gravity)
    half = problem.length / 2.0
    rod = spec.body("rod")
    start = spec.key("start")
    begun = problem.observe(np.zeros(1))
    rod.mass = problem.mass
    rod.inertia = [problem.mass * problem.length**2 / 12.0] * 3
    spec.geom("rod").fromto = [-half, 0.0, 0.0, half, 0.0, 0.0]
    for side, pair in zip((-half, half), spec.pairs, strict=True):
        spec.geom(pair.geomname2).pos = [side, 0.0, 0.0]
        pair.friction[:2] = [problem.friction] * 2
        pair.condim = 3 if problem.friction else 1
        pair.solref = soft_impact(problem.restitution, step).solref
        pair.solimp[:2] = [IMPEDANCE] * 2
    start.qpos = [begun[name][0] for name in NAMES]
    start.qvel = [problem.speed, 0.0, 0.0]
    return spec
