"""Records of regularised contacts, the same for all engines.

The model error of such contacts is bounded in `soft_contact_bounds`. Derivations: THEORY.md,
section 9.
"""

from __future__ import annotations

from dataclasses import dataclass

from plumbob.analytic.schemes import EULER
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

DEPTH_ROUNDINGS = 16  # roundings of a support's position by turning and moving the body
# Both factors are calibrated: tests/sensitivity/test_contact_calibration.py fails if either is
# larger or smaller.
QUASI_STATIC_FACTOR = 2.0  # factor on quasi-static errors, for lag and overshoot of contacts
OVERSHOOT_FACTOR = 6.0  # factor on inertial loads, for the overshoot of weakly damped tilt


@dataclass(frozen=True)
class NormalContact:
    """A contact along its normal: a spring and a damper that are integrated explicitly."""

    compliance: float  # c [m/N]: deflection per normal force
    coupling: float  # kappa [kg]: a slip acceleration a changes N by kappa f a
    frequency_step: float  # natural frequency of one contact times the step
    damping_ratio: float
    tilt_inertia: float  # I_a [kg m^2]: inertia of the body about a horizontal axis
    height: float = 0.0  # h [m]: height of the body's centre of mass above the plane


@dataclass(frozen=True)
class SoftContact:
    """Contacts, or a joint's dry friction, regularised at one step; adapters describe them so."""

    step: float  # [s]
    slip_compliance: float  # [m/(s N)] drift of a sticking support per friction force
    solver_tolerance: float  # [m^2/s^4] smallest decrease of the cost per mass a^2/2, then stop
    armature: float  # A [kg]: added inertia of the slider's joint
    normal: NormalContact | None = None  # None for friction in a joint: nothing deflects
    integrator: str = EULER  # EULER or RK4

    @property
    def contact_rate(self) -> float:
        """Bound on the rate [1/s] of a body's modes on three contacts; 0 without deflection.

        The frequency of a mode is at most sqrt(6) times the frequency of one contact. Modes are
        damped, so that a factor of 2 is enough.
        """
        return 0.0 if self.normal is None else 2 * self.normal.frequency_step / self.step


def without_formula(problem: CapsuleProblem) -> bool:
    """Returns whether the capsule moves in the plane without a closed form."""
    return bool(problem.motion.kind == "plane")
