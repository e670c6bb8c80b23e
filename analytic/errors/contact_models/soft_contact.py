"""Regularised contacts as theory sees them: one record, whichever engine they belong to.

What such contacts add to the exact motion, apart from the step's own error, is bounded in
`soft_contact_bounds`. Derivations: THEORY.md, section 9.
"""

from __future__ import annotations

from dataclasses import dataclass

from plumbob.analytic.schemes import EULER
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

DEPTH_ROUNDINGS = 16  # of the place of a support, turned and moved
# Calibrated; tests/sensitivity/test_contact_calibration.py holds both from both sides.
QUASI_STATIC_FACTOR = 2.0  # on a quasi-static error, for contacts that lag behind and overshoot
OVERSHOOT_FACTOR = 6.0  # on the loads that inertia takes: overshoot of weakly damped tilt


@dataclass(frozen=True)
class NormalContact:
    """A contact along its normal: a spring and a damper that are integrated explicitly."""

    compliance: float  # c: deflection [m] per normal force [N]
    coupling: float  # kappa [kg]: a slip acceleration a changes N by kappa f a
    frequency_step: float  # natural frequency of one contact times the step
    damping_ratio: float
    tilt_inertia: float  # I_a: of the body, across the vertical [kg m^2]
    height: float = 0.0  # h: of the body's centre of mass above the plane [m]


@dataclass(frozen=True)
class SoftContact:
    """Contacts, or a joint's dry friction, regularised at one step: all that theory needs to know
    of them. An adapter fills it in for its engine."""

    step: float  # [s]
    slip_compliance: float  # drift [m/s] of what sticks per friction force on it [N]
    solver_tolerance: float  # the solver ends when its cost per mass, a^2/2, falls by less
    armature: float  # A: added inertia of the slider's joint [kg]
    normal: NormalContact | None = None  # None where friction is a joint's: nothing deflects
    integrator: str = EULER  # of the steps, or RK4

    @property
    def contact_rate(self) -> float:
        """Largest rate [1/s] of a body on three contacts, with a margin (its modes have at most
        sqrt(6) times one contact's frequency, and are damped)."""
        return 0.0 if self.normal is None else 2 * self.normal.frequency_step / self.step


def without_formula(problem: CapsuleProblem) -> bool:
    """Whether the motion is one of the plane that has no closed form."""
    return bool(problem.motion.kind == "plane")
