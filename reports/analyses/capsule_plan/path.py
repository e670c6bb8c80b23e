"""The figures of one plan: the path of the body from above, its heading over time, the slider."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import (
    SHOWN,
    PlanNumbers,
    names,
    plan_numbers,
    plan_of,
)

POINTS = 40  # of each manoeuvre
MARGIN = 0.06  # of the ground that a figure shows
ROUND = np.linspace(0.0, 2.0 * np.pi, 90)


@dataclass(frozen=True)
class PathSegment:
    """Samples of the motion over one manoeuvre, each array of POINTS."""

    kind: str
    times: Array  # [s]
    x: Array  # [m], of the body's centre of mass
    y: Array
    heading: Array  # [rad]
    slider_x: Array  # [m], in the body
    slider_y: Array


@dataclass(frozen=True)
class Path:
    """One plan, drawn."""

    plan: PlanNumbers
    pieces: tuple[PathSegment, ...]
    poses: tuple[Record, ...]  # before, between and after turns and lines
    circle_x: Array  # [m]: where the slider turns, in the body
    circle_y: Array

    @property
    def x_range(self) -> tuple[float, float]:
        """Ends of an axis [m] that shows all poses."""
        return _axis_range([pose.x for pose in self.poses])

    @property
    def y_range(self) -> tuple[float, float]:
        """The same across."""
        return _axis_range([pose.y for pose in self.poses])


def numbers(study: Study) -> Path | None:
    """The plan to be shown, or the first that the study has."""
    covered = names(study)
    if not covered:
        return None
    plan = plan_of(SHOWN if SHOWN in covered else covered[0])
    ends = zip(plan.ends, plan.manoeuvres, strict=True)
    shown = [0.0, *(float(end) for end, one in ends if one.kind in ("wait", "line"))]
    radius = plan.limits.radius
    return Path(
        plan_numbers(plan),
        tuple(_piece(plan, manoeuvre) for manoeuvre in plan.manoeuvres),
        tuple(_pose(plan, time) for time in shown),
        radius * np.cos(ROUND),
        radius * np.sin(ROUND),
    )


def _piece(plan: Plan, manoeuvre: Manoeuvre) -> PathSegment:
    times = np.linspace(manoeuvre.start, manoeuvre.start + manoeuvre.duration, POINTS)
    state, slider = plan.motion.at(times), plan.slider(times)
    x, y = np.asarray(state.position).T
    return PathSegment(manoeuvre.kind, times, x, y, state.heading, *slider.T)


def _pose(plan: Plan, time: float) -> Record:
    """The triangle of the supports at rest, a closed loop that begins at A1."""
    at = plan.motion.at(np.array([time]))
    supports = plan.capsule.supports
    corners = np.array([complex(*point) for point in (*supports, supports[0])])
    placed = complex(*at.position[0]) + corners * np.exp(1j * at.heading[0])
    return Record(
        time=time,  # [s]
        x=placed.real,  # [m]
        y=placed.imag,
    )


def _axis_range(values: list[Array]) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    return low - MARGIN * (high - low), high + MARGIN * (high - low)


PATH = Analysis("capsule_plan/path", numbers)
