"""The velocities that the body has left when the slider stops, which the source takes for zero."""

from __future__ import annotations

from dataclasses import dataclass

from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.capsule_turn.turns import (
    JUDGED,
    METHODS,
    epsilons,
    facts,
    judged_error,
    requests,
    turn,
)

SHOWN = 0.1  # epsilon of the summary


@dataclass(frozen=True)
class Left:
    """The exact motion at 2 tau, and the same by the formula."""

    epsilon: float
    rate: float  # omega [rad/s]
    rate_formula: float
    speed: float  # |v| of C [m/s]
    speed_formula: float
    time: float  # until all rests [s]

    @property
    def difference(self) -> float:
        """Relative, of the rate."""
        return self.rate / self.rate_formula - 1.0


@dataclass(frozen=True)
class LeftOver:
    """The velocities left at 2 tau, exact and in engines."""

    rows: tuple[Left, ...]
    shown: Left
    coefficient: float  # [rad/s²]: omega(2 tau) over tau
    engines: tuple[tuple[float, str, float, float], ...]  # epsilon, method, omega [rad/s], error
    judged: int = JUDGED


def numbers(study: Study) -> LeftOver:
    """omega and |v| at 2 tau over epsilon, exact, by the formula, and as engines have omega."""
    engines = tuple(
        (epsilon, method, facts(epsilon)["angular_velocity_at_stop"] + error, error)
        for epsilon in epsilons(study)
        for method in METHODS
        if (error := judged_error(study, epsilon, method, "stop", "heading_rate")) is not None
    )
    coefficient = turn(SHOWN).correction.left_at_stop.heading
    return LeftOver(tuple(_left(e) for e in EPSILONS), _left(SHOWN), coefficient, engines)


def _left(epsilon: float) -> Left:
    known = facts(epsilon)
    return Left(
        epsilon,
        known["angular_velocity_at_stop"],
        known["angular_velocity_at_stop_formula"],
        known["speed_at_stop"],
        known["speed_at_stop_formula"],
        known["rest_time"] - known["stop_time"],
    )


LEFT_OVER = Analysis("capsule_turn/left_over", numbers, requests)
