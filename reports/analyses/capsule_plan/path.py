"""The figures of one plan: the path of the body from above, its heading over time, the slider."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import (
    SHOWN,
    names,
    plan_numbers,
    plan_of,
)

POINTS = 40  # of each manoeuvre
MARGIN = 0.06  # of the ground that a figure shows
ROUND = np.linspace(0.0, 2.0 * np.pi, 90)


def numbers(study: Study) -> Record | None:
    """The plan to be shown, or the first that the study has."""
    covered = names(study)
    if not covered:
        return None
    plan = plan_of(SHOWN if SHOWN in covered else covered[0])
    ends = zip(plan.ends, plan.manoeuvres, strict=True)
    shown = [0.0, *(float(end) for end, one in ends if one.kind in ("wait", "line"))]
    poses = [_pose(plan, time) for time in shown]
    radius = plan.limits.radius
    return Record(
        plan=plan_numbers(plan),
        pieces=[_piece(plan, manoeuvre) for manoeuvre in plan.manoeuvres],
        poses=poses,  # before, between and after turns and lines
        circle_x=radius * np.cos(ROUND),  # [m]: where the slider turns, in the body
        circle_y=radius * np.sin(ROUND),
        x_range=_axis_range([pose.x for pose in poses]),  # [m]
        y_range=_axis_range([pose.y for pose in poses]),
    )


def _piece(plan: Plan, manoeuvre: Manoeuvre) -> Record:
    """POINTS samples of the motion over one manoeuvre."""
    times = np.linspace(manoeuvre.start, manoeuvre.start + manoeuvre.duration, POINTS)
    state, slider = plan.motion.at(times), plan.slider(times)
    x, y = np.asarray(state.position).T
    return Record(
        kind=manoeuvre.kind,
        times=times,  # [s]
        x=x,  # [m], of the body's centre of mass
        y=y,
        heading=state.heading,  # [rad]
        slider_x=slider[:, 0],  # [m], in the body
        slider_y=slider[:, 1],
    )


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
