"""What is predicted of the line manoeuvre's final displacement, term by term [m]: the step's, and
what MuJoCo's models add to it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.sliding_errors import step_error
from plumbob.engines.adapters.mujoco.contact_profiles import ContactProfile
from plumbob.reports.findings.capsule.runs import problem

LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def sawtooth(scene: str, step: float) -> float:
    """-phi (1 - phi)(mu w2 + f g) dt^2/2 [m], phi the fraction of t_star/dt; with the bend at t1
    where that is off the grid."""
    return float(step_error(problem(scene).motion, step, "mean"))


def sinking(scene: str, step: float, contact: ContactProfile) -> float:
    """-f times the way that the common centre of mass sinks on its contacts until t_star [m]: while
    it sinks, it weighs less."""
    posed = problem(scene)
    seen = posed.reference.observe(np.array([0.0, posed.motion.t_star]))
    squares = np.sum([seen[load] ** 2 for load in LOADS], axis=0)
    body = posed.setup.capsule
    yields = contact.sag_compliance(step) / (body.body_mass + body.slider_mass)
    return float(-body.friction * yields * (squares[1] - squares[0]) / body.weight)


def creep_of_coulomb(scene: str, step: float, contact: ContactProfile) -> float:
    """Way that friction yields on three contacts while it holds m w2 until t2 [m]."""
    body = problem(scene).setup.capsule
    both = body.body_mass + body.slider_mass
    return contact.slip_compliance(step) / both / 3 * _held(scene)


def creep_of_reduced(scene: str, step: float) -> float:
    """The same on a joint's friction loss [m]."""
    from plumbob.engines.adapters.mujoco.capsule_reduced import creep

    body = problem(scene).setup.capsule
    return creep(step) / (body.body_mass + body.slider_mass) * _held(scene)


def _held(scene: str) -> float:
    """Force that friction holds, times how long [N s]."""
    line = problem(scene).motion
    return float(line.capsule.slider_mass * line.w2 * (line.t2 - line.t_star))
