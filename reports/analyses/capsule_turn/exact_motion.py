"""The exact motion of a turn: the formula's next term, and a support that stops for a moment."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.modes import modes_of, slip_speeds
from plumbob.reports.analyses.capsule_turn.turns import facts, turn

CHECKED = MappingProxyType(
    {0.3: -0.9068671274, 0.1: -0.9888885424, 0.03: -0.9989925407, 0.01: -0.9998879884}
)  # the body angle at 2 tau [rad] by epsilon
SLOPES = slice(1, 5)  # of EPSILONS: where a fourth order is far above rounding
SLENDER = MappingProxyType(
    {"inertia": 0.002, "radius": 0.12, "angular_acceleration": 130.0, "half_time": 0.08}
)  # the check body's masses nearer to C: a support is easier to move one way than the other
SIDES = (1e-6, 1e-5, 1e-4, 1e-3)  # [s] before and after
Rows = Sequence[Sequence[float]] | Array


@dataclass(frozen=True)
class FormulaErrors:
    """Exact body angle less that of a formula [rad], for each of EPSILONS."""

    stop: tuple[float, ...]  # at 2 tau
    rest: tuple[float, ...]

    @property
    def slopes(self) -> Mapping[str, float]:
        """Slopes of log error against log epsilon, from 0.1 to 0.003."""
        sizes = np.log(np.abs(np.column_stack([self.stop, self.rest])[SLOPES]))
        stop, end = np.polyfit(np.log(EPSILONS[SLOPES]), sizes, 1)[0]
        return {"stop": stop, "rest": end}


def formulas() -> tuple[FormulaErrors, FormulaErrors]:
    """Errors of eq. 32, and of it with its next term."""
    corrected = _errors("body_angle_corrected", "body_angle_corrected_at_rest")
    return _errors("body_angle_formula", "body_angle_formula"), corrected


def _errors(at_stop: str, at_rest: str) -> FormulaErrors:
    turns = [facts(epsilon) for epsilon in EPSILONS]
    return FormulaErrors(
        tuple(known["body_angle"] - known[at_stop] for known in turns),
        tuple(known["body_angle_at_rest"] - known[at_rest] for known in turns),
    )


@dataclass(frozen=True)
class SecondOrder:
    """The formula's next term: in theory, and in the exact motion."""

    stop: float  # coefficient of epsilon^2 [rad] at 2 tau, from theory
    rest: float
    formula: FormulaErrors
    corrected: FormulaErrors
    checks: Rows  # epsilon, the body angle at 2 tau [rad], computed, their difference
    epsilons: tuple[float, ...] = EPSILONS

    @property
    def measured(self) -> Mapping[str, float]:
        """The same coefficients at the smallest epsilon, from the exact motion."""
        last = EPSILONS[-1] ** 2
        return {"stop": self.formula.stop[-1] / last, "rest": self.formula.rest[-1] / last}

    @property
    def factor(self) -> float:
        """K of an error K epsilon^4 ln(1/epsilon) + B epsilon^4 at rest, from the two smallest."""
        small = zip(self.corrected.rest[-2:], EPSILONS[-2:], strict=True)
        larger, smaller = (error / epsilon**4 for error, epsilon in small)
        return (smaller - larger) / math.log(EPSILONS[-2] / EPSILONS[-1])


def second_order(study: Study) -> SecondOrder:
    """The check values, the formulas' errors, and the coefficients."""
    turned = turn(0.1)
    scale = turned.characteristic_time**2
    stop, end = turned.correction.at_stop.heading, turned.correction.at_rest.heading
    angles = [(e, known, facts(e)["body_angle"]) for e, known in CHECKED.items()]
    checks = tuple((e, known, angle, angle - known) for e, known, angle in angles)
    return SecondOrder(scale * stop, scale * end, *formulas(), checks)


def motion() -> ThreePointMotion:
    """A turn of a body with little inertia, in which a support stops and leaves at once."""
    scene = find_scene("capsule-turn", SLENDER)
    single = case_of(scene).problem.motion.single
    assert isinstance(single, ThreePointMotion)
    return single


def touching(study: Study) -> Record:
    """The slip speed on either side of the stop."""
    single, tau = motion(), SLENDER["half_time"]
    modes, sides = modes_of(single, tau), np.array(SIDES)
    events = zip(single.events, modes.stays, strict=True)
    touch = next(event for event, stay in events if stay.again and stay.support)
    times = np.array([touch.time, *(touch.time - sides), *(touch.time + sides)])
    at, *speeds = slip_speeds(single, times)[touch.support]
    before, after = np.reshape(speeds, (2, -1))
    rows = np.column_stack([sides, before, after, before / sides, after / sides])
    return Record(
        time=touch.time / tau,  # over tau
        support=touch.support + 1,
        speed=float(at),  # there [m/s]
        sides=rows,  # time [s], slip speeds so long before and after, and those over the time
        modes=modes,
        parameters=SLENDER,
    )


SECOND_ORDER = Analysis("capsule_turn/second_order", second_order)
TOUCH = Analysis("capsule_turn/touch", touching)
