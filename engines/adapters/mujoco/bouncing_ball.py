"""The bouncing ball in MuJoCo: a slide along z, and a contact with spring and damper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbob.analytic.errors.contact_models.impacts import IMPACT_IMPEDANCE, soft_impact
from plumbob.engines.adapters.mujoco.translation import Translation, at_start, filled
from plumbob.engines.method import Method
from plumbob.models.bouncing_ball.model import MODEL


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a BouncingBall, whose z is the height of the ball's lowest point [m]."""
    spec = filled(mjcf, MODEL, problem)
    impact = soft_impact(problem.restitution, step)
    ball = spec.geom("ball")
    ball.solref = impact.solref
    ball.solimp[:2] = [IMPACT_IMPEDANCE, IMPACT_IMPEDANCE]
    return at_start(spec)
