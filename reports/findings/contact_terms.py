"""Predicted error of a line manoeuvre's displacement, term by term [m]: the step's, and what soft
contacts add to it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.line_step_error import step_error
from plumbob.engines.adapters.mujoco.contact_profiles import PROFILES
from plumbob.reports.findings.measurements import problem

LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def step_term(scene: str, step: float) -> float:
    """-phi (1 - phi)(mu w2 + f g) dt^2/2 [m], phi the fraction of t_star/dt; with the velocity's
    corner at t1 where that is off the grid."""
    return float(step_error(problem(scene).motion, step, "mean"))


def deflection_term(scene: str, step: float) -> float:
    """-f times the vertical displacement of the common centre of mass until t_star [m] on contacts
    of the profile coulomb: while it moves down, the plane carries less than the weight."""
    posed = problem(scene)
    seen = posed.reference.observe(np.array([0.0, posed.motion.t_star]))
    squares = np.sum([seen[load] ** 2 for load in LOADS], axis=0)
    body = posed.setup.capsule
    compliance = PROFILES["coulomb"].sag_compliance(step) / (body.body_mass + body.slider_mass)
    return float(-body.friction * compliance * (squares[1] - squares[0]) / body.weight)


def stiction_drift_full(scene: str, step: float) -> float:
    """Drift of regularised stiction on three contacts of the profile coulomb, while friction holds
    m w2 until t2 [m]."""
    body = problem(scene).setup.capsule
    both = body.body_mass + body.slider_mass
    return PROFILES["coulomb"].slip_compliance(step) / both / 3 * _held(scene)


def stiction_drift_reduced(scene: str, step: float) -> float:
    """The same on a joint's friction loss [m]."""
    from plumbob.engines.adapters.mujoco.capsule_reduced import creep

    body = problem(scene).setup.capsule
    return creep(step) / (body.body_mass + body.slider_mass) * _held(scene)


def _held(scene: str) -> float:
    """Force that friction holds, times how long [N s]."""
    line = problem(scene).motion
    return float(line.capsule.slider_mass * line.w2 * (line.t2 - line.t_star))
