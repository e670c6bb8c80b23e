"""What is predicted of the line manoeuvre's final displacement, term by term [m]: the step's, and
what MuJoCo's models add to it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.line_step_error import step_error
from plumbob.analytic.errors.soft_contact import SoftContact
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.findings.capsule.runs import problem

LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def sawtooth(scene: str, step: float) -> float:
    """-phi (1 - phi)(mu w2 + f g) dt^2/2 [m], phi the fraction of t_star/dt; with the bend at t1
    where that is off the grid."""
    return float(step_error(problem(scene).motion, step, "mean"))


def contact_of(scene: str, method: str, step: float) -> SoftContact:
    """The record of a method's contacts at `step` [s]."""
    chosen = find_method(method)
    model = engine_of(chosen).contact_model
    found = None if model is None else model(case_of(find_scene(scene)), chosen, step)
    assert isinstance(found, SoftContact), method
    return found


def sinking(scene: str, contact: SoftContact) -> float:
    """-f times the way that the common centre of mass sinks on its contacts until t_star [m]: while
    it sinks, it weighs less."""
    posed = problem(scene)
    seen = posed.reference.observe(np.array([0.0, posed.motion.t_star]))
    squares = np.sum([seen[load] ** 2 for load in LOADS], axis=0)
    body = posed.setup.capsule
    compliance = 0.0 if contact.normal is None else contact.normal.compliance
    return float(-body.friction * compliance * (squares[1] - squares[0]) / body.weight)


def creep(scene: str, contact: SoftContact) -> float:
    """Way that friction yields while it holds m w2 until t2 [m]: on three contacts, or on a
    joint's friction loss."""
    parts = 1 if contact.normal is None else 3
    return contact.slip_compliance / parts * _held(scene)


def _held(scene: str) -> float:
    """Force that friction holds, times how long [N s]."""
    line = problem(scene).motion
    return float(line.capsule.slider_mass * line.w2 * (line.t2 - line.t_star))
