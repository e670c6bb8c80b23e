"""The velocities that the body has left when the slider stops, which the source takes for zero."""

from __future__ import annotations

from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.turns import (
    facts,
    turn,
)

SHOWN = 0.1  # epsilon of the summary


def numbers(study: Study) -> Record:
    """omega and |v| at 2 tau over epsilon, exact and by the formula."""
    coefficient = float(turn(SHOWN).correction.rate_coefficients[2])
    return Record(
        rows=[_left(e) for e in EPSILONS],
        shown=_left(SHOWN),
        coefficient=coefficient,  # [rad/s²]: omega(2 tau) over tau
    )


def _left(epsilon: float) -> Record:
    """The exact motion at 2 tau, and the same by the formula."""
    known = facts(epsilon)
    rate, rate_formula = (known[f"angular_velocity_at_stop{of}"] for of in ("", "_formula"))
    return Record(
        epsilon=epsilon,
        rate=rate,  # omega [rad/s]
        rate_formula=rate_formula,
        speed=known["speed_at_stop"],  # |v| of C [m/s]
        speed_formula=known["speed_at_stop_formula"],
        time=known["rest_time"] - known["stop_time"],  # until all rests [s]
        difference=rate / rate_formula - 1.0,  # relative
    )


LEFT_OVER = Analysis("capsule_turn/left_over", numbers)
