"""Predicted error of a line manoeuvre's displacement, term by term [m]: the step's, and what soft
contacts add to it."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.soft_contact import SoftContact
from plumbob.analytic.errors.sliding_motion.sliding_errors import step_error
from plumbob.engines.abilities import ContactRecord
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.reports.analyses.measurements import case, problem

LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def step_term(scene: str, step: float) -> float:
    """-phi (1 - phi)(mu w2 + f g) dt^2/2 [m], phi the fraction of t_star/dt; with the velocity's
    corner at t1 where that is off the grid."""
    return float(step_error(problem(scene).motion, step))


def contact_of(scene: str, method: str, step: float) -> SoftContact:
    """The record of a method's contacts at `step` [s]."""
    chosen = find_method(method)
    record = engine_of(chosen).ability(ContactRecord)
    contact = None if record is None else record.of(case(scene), chosen, step)
    assert isinstance(contact, SoftContact), method
    return contact


def deflection_term(scene: str, contact: SoftContact) -> float:
    """-f times the vertical displacement of the common centre of mass until t_star [m], by contact
    deflection: while it moves down, the plane carries less than the weight."""
    posed = problem(scene)
    observed = posed.reference.observe(np.array([0.0, posed.motion.t_star]))
    squares = np.sum([observed[load] ** 2 for load in LOADS], axis=0)
    body = posed.setup.capsule
    compliance = 0.0 if contact.normal is None else contact.normal.compliance
    return float(-body.friction * compliance * (squares[1] - squares[0]) / body.weight)


def stiction_drift(scene: str, contact: SoftContact) -> float:
    """Drift of regularised stiction while friction holds m w2 until t2 [m]: on three contacts, or
    on a joint's friction loss."""
    line, parts = problem(scene).motion, 1 if contact.normal is None else 3
    held = line.capsule.slider_mass * line.w2 * (line.t2 - line.t_star)
    return float(contact.slip_compliance / parts * held)
