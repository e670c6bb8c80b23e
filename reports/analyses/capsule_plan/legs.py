"""Plans along different slider tracks: every pair of lines C-Ai with either arc, and other
tracks."""

from __future__ import annotations

import itertools
import math

import numpy as np

from plumbob.analytic.systems.planner.result import Plan
from plumbob.analytic.systems.planner.tracks import (
    ArcName,
    LineSegment,
    SegmentEnds,
    SupportPair,
)
from plumbob.models.tripod_capsule.parameters import CHECK
from plumbob.models.tripod_capsule.plan import CURVED_PLANS, GOAL_POSE, requested_plan
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import capsule_plan_of, plan_numbers

SUPPORT_PAIRS: tuple[SupportPair, ...] = ((1, 2), (2, 3), (3, 1))
ARCS: tuple[ArcName, ...] = ("shorter", "longer")
# tracks that belong to no support: (ends of the arc, line segments), with segments away from
# C, on both sides of C, and short ones
PIECES: tuple[tuple[SegmentEnds, tuple[LineSegment, ...]], ...] = (
    ((0.3, 1.1), ((0.4, 0.02, 0.08), (2.1, -0.05, 0.05))),
    ((2.0, -0.4), ((-2.6, 0.01, 0.11), (1.9, -0.09, -0.03))),
    ((-3.0, -2.6), ((0.9, -0.02, 0.02), (2.4, 0.0, 0.04))),
)
SCENES = tuple(f"capsule-plan/beside-curve-{case}" for case, *_ in CURVED_PLANS)
SLIDER = ((0.05, 0.02), (-0.04, 0.06))  # [m] slider positions at the start and at the end
SLIDER_PATH_POINTS = 400  # points of the slider's path


def plans() -> tuple[Plan, ...]:
    """Returns plans to the same pose: along each pair of lines with the shorter and the longer arc,
    and along the tracks of PIECES."""
    common = {**CHECK, "to": GOAL_POSE, "track": "curve"}
    curves = itertools.product(SUPPORT_PAIRS, ARCS)
    return (
        *(requested_plan({**common, "legs": legs, "arc": arc}) for legs, arc in curves),
        *(
            requested_plan({**common, "arc": arc, "segments": segments})
            for arc, segments in PIECES
        ),
    )


def numbers() -> Record:
    """Returns the plans along all tracks, with their slider paths and errors."""
    all_plans = plans()
    corners = np.array(all_plans[0].capsule.supports)
    curves = tuple(_plan_with_path(plan) for plan in all_plans)
    times = [plan.duration for plan in all_plans if not plan.segments]
    moved = requested_plan(
        {**CHECK, "to": GOAL_POSE, "slider": SLIDER[0], "slider_at_end": SLIDER[1]}
    )
    return Record(
        curves=curves,
        supports=np.vstack([corners, corners[:1]]),  # [m] closed triangle, shape (4, 2)
        second=plan_numbers(capsule_plan_of(SCENES[1])),  # plan of the second of `scenes`
        slider=SLIDER,
        replaced=plan_numbers(moved),  # plan that moves the slider to another position
        misplaced=math.dist(moved.path.end, SLIDER[1]),  # [m] error of that slider position
        scenes=SCENES,
        # [m] or [rad] largest pose error of an exact motion
        worst=max(max(curve.plan.distance, curve.plan.angle) for curve in curves),
        # ratio of the longest to the shortest duration, among plans along lines to supports
        slowest=max(times) / min(times),
    )


def _plan_with_path(plan: Plan) -> Record:
    """Returns the numbers of a plan, and the slider's path in the body [m], shape
    (SLIDER_PATH_POINTS, 2)."""
    times = np.linspace(0.0, plan.duration, SLIDER_PATH_POINTS)
    return Record(plan=plan_numbers(plan), path=plan.path.places(times))


LEGS = Analysis("capsule_plan/legs", exact=numbers)
