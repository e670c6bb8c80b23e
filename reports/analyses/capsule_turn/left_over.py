"""The residual velocities of the body when the slider stops; the source assumes that they are
zero."""

from __future__ import annotations

from plumbob.models.tripod_capsule.turn import TURN_EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.turns import check_turn, facts

SUMMARY_EPSILON = 0.1  # epsilon in the summary of the finding


def numbers() -> Record:
    """Returns omega and |v| at 2 tau for each epsilon, from the exact motion and by the formula."""
    coefficient = float(check_turn(SUMMARY_EPSILON).correction.rate_coefficients[2])
    return Record(
        rows=[_residual_velocities(epsilon) for epsilon in TURN_EPSILONS],
        shown=_residual_velocities(SUMMARY_EPSILON),
        coefficient=coefficient,  # [rad/s²] ratio of omega(2 tau) to tau
    )


def _residual_velocities(epsilon: float) -> Record:
    """Returns the velocities at 2 tau for one epsilon, from the exact motion and by the formula."""
    known = facts(epsilon)
    rate = known["angular_velocity_at_stop"]
    rate_formula = known["angular_velocity_at_stop_formula"]
    return Record(
        epsilon=epsilon,
        rate=rate,  # [rad/s] omega
        rate_formula=rate_formula,
        speed=known["speed_at_stop"],  # [m/s] |v| of C
        speed_formula=known["speed_at_stop_formula"],
        time=known["rest_time"] - known["stop_time"],  # [s] from the slider's stop to rest
        difference=rate / rate_formula - 1.0,  # relative error of the formula for omega
    )


LEFT_OVER = Analysis("capsule_turn/left_over", exact=numbers)
