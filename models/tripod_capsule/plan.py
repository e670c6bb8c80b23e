"""capsule-plan: a plan that brings the capsule from one rest pose to another."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from functools import cache, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from plumbob.analytic.parameters import ParameterError, known, numbers
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.planner.problem import GOAL_POSES, PlanLimits, RestPose
from plumbob.analytic.systems.three_points.forces import plane_demand
from plumbob.models.quantities import pose_quantities
from plumbob.models.scene import Observable, Parameters, Scene, make_scene, step_sizes
from plumbob.models.tripod_capsule.parameters import (
    CAPSULE_PARAMETERS,
    CHECK,
    CHERNOUSKO_2020,
    capsule_system,
    plane_problem,
    read_capsule,
)
from plumbob.models.tripod_capsule.turn import TURN_OBSERVABLES

if TYPE_CHECKING:
    from plumbob.analytic.systems.planner.result import Plan, TrackName
    from plumbob.analytic.systems.planner.tracks import ArcName, SupportPair

LIMIT_NAMES = tuple(field.name for field in fields(PlanLimits))
CURVE = ("legs", "segments", "arc")  # parameters of the slider's curve, if it is not free
PLAN_PARAMETERS = (
    *CAPSULE_PARAMETERS,
    *LIMIT_NAMES,
    "to",
    "track",
    "start",
    "slider",
    "slider_at_end",
    *CURVE,
)
_POSE = "a pose [x, y, psi]"
PLAN_STEPS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
LONGEST_FINE = 10.0  # [s] longest plan that is run at the finest step
# Durations [s] of the plans on a free plane and on the curve: a little longer than the plans, and
# whole numbers of steps of every size.
_LASTING: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "near": (1.65, 6.95),
        "half-turn": (1.95, 24.35),
        "aside": (3.65, 14.75),
        "behind": (5.0, 6.15),
        "ahead": (3.65, 6.95),
    }
)
# [s] duration: a little longer than the plan to NEAR_GOAL on a free plane
TURNED_DURATION = 0.65
NEAR_GOAL = RestPose(0.01, 0.01, 0.1)  # goal so near that plans on the curve cost little
GOAL_POSE = (NEAR_GOAL.x, NEAR_GOAL.y, NEAR_GOAL.heading)
# For each curve: name, supports, arc, duration of the plan to NEAR_GOAL [s], and profile.
CURVED_PLANS: tuple[tuple[str, SupportPair, ArcName, float, Literal["quick", "full"]], ...] = (
    ("12", (1, 2), "shorter", 1.75, "full"),
    ("23-longer", (2, 3), "longer", 1.55, "quick"),
    ("31", (3, 1), "shorter", 1.75, "full"),
)


@cache
def _cached_plan(
    body: Capsule,
    goal: RestPose,
    limits: PlanLimits,
    track: TrackName,
    start: RestPose,
    **curve: Any,
) -> Plan:
    """Returns a plan, computed once for the same arguments."""
    from plumbob.analytic.systems.planner.construction import plan

    return plan(body, goal, limits, track, start, **curve)


def requested_plan(parameters: Parameters) -> Plan:
    """Returns the plan that parameters ask for, computed once; raises ParameterError."""
    from plumbob.analytic.systems.planner.tracks import checked_curve

    known(parameters, PLAN_PARAMETERS)
    slider = parameters.get("slider", (0.0, 0.0))
    start = _rest_pose("start", parameters.get("start", (0.0, 0.0, 0.0)), slider)
    goal = _rest_pose("to", parameters.get("to"), parameters.get("slider_at_end", slider))
    limits = PlanLimits(
        **{name: parameters[name] for name in LIMIT_NAMES if name in parameters}
    )
    track = parameters.get("track", "free")
    if track not in _TRACKS:
        raise ParameterError("track", track, "free or curve")
    curve = {name: parameters[name] for name in CURVE if name in parameters}
    if curve and track == "free":
        name = next(iter(curve))
        raise ParameterError(name, parameters[name], "left out where the track is free")
    legs, arc, segments = checked_curve(**curve)
    return _cached_plan(
        read_capsule(parameters),
        goal,
        limits,
        track,
        start,
        legs=legs,
        arc=arc,
        segments=segments,
    )


def _rest_pose(name: str, value: Any, slider: Any) -> RestPose:
    """Returns the pose of the parameter `name`, with the slider's place; raises ParameterError."""
    x, y, heading = numbers(name, value, (3,), _POSE)
    return RestPose(x, y, heading, slider)


def problem(parameters: Parameters) -> CapsuleProblem:
    """Returns the plan as a motion in the axes of its start; raises ParameterError."""
    plan = requested_plan(parameters)
    return plane_problem(plan, plan.motion, plan.start.heading)


def facts(problem: CapsuleProblem) -> Mapping[str, Any]:
    """Returns the plan's manoeuvres, its duration, and the distance of the exact motion's end from
    the goal."""
    plan = problem.motion
    distance, angle = plan.error
    return {
        "t_rest": plan.duration,
        "turns": plan.turns,
        "lines": plan.lines,
        "manoeuvres": len(plan.manoeuvres),
        "position_error": distance,
        "heading_error": angle,
        **plane_demand(plan.motion).facts(),
        "ends": np.asarray(plan.ends),
    }


def structure(problem: CapsuleProblem) -> tuple[str, ...]:
    """Returns the kinds of the plan's manoeuvres, in order, with the number of pieces of the
    slider's path in each."""
    manoeuvres = problem.motion.manoeuvres
    return tuple(f"{each.kind} {len(each.path.pieces)}" for each in manoeuvres)


_scene = partial(
    make_scene, system="capsule-plan", steps=PLAN_STEPS, base=CHECK, source=CHERNOUSKO_2020
)


def _pose_scene(case: str, goal: RestPose, track: TrackName) -> Scene:
    """Returns the scene of the plan to a pose on a track."""
    free_duration, curve_duration = _LASTING[case]
    duration = free_duration if track == "free" else curve_duration
    slider = "on a free plane" if track == "free" else "along the source's single curve"
    half_turn = " (half a turn)" if abs(abs(goal.heading) - math.pi) < 1e-9 else ""
    return _scene(
        f"{case}-{track}",
        f"to {goal.x:g}, {goal.y:g} m and {goal.heading:.4g} rad{half_turn}, the slider {slider}",
        duration,
        to=(goal.x, goal.y, goal.heading),
        track=track,
        steps=PLAN_STEPS if duration <= LONGEST_FINE else PLAN_STEPS[:-1],
        profile="quick" if (case, track) == ("near", "free") else "full",
    )


_BESIDE = f"to {NEAR_GOAL.x:g}, {NEAR_GOAL.y:g} m and {NEAR_GOAL.heading:g} rad"


def _turned_scene(angle: float) -> Scene:
    """Returns the scene of the plan to NEAR_GOAL with start and goal turned by `angle`
    [degrees]."""
    radians = math.radians(angle)
    goal = NEAR_GOAL.place * cmath.rect(1.0, radians)
    return _scene(
        f"heading-{angle:03.0f}",
        f"{_BESIDE} on a free plane, all of it turned by {angle:g} degrees",
        TURNED_DURATION,
        start=(0.0, 0.0, radians),
        to=(goal.real, goal.imag, radians + NEAR_GOAL.heading),
    )


_TRACKS: tuple[TrackName, ...] = ("free", "curve")
_ALL_OR_NOTHING = "mu is nearly 0 or 1: the actuator's reaction is all or nothing"
SCENES = (
    *(_pose_scene(case, goal, track) for case, goal in GOAL_POSES for track in _TRACKS),
    *(
        _scene(
            f"beside-curve-{case}",
            f"{_BESIDE}, the slider along C-A{legs[0]}, the {arc} arc and C-A{legs[1]}",
            lasting,
            profile,
            to=GOAL_POSE,
            track="curve",
            legs=legs,
            arc=arc,
        )
        for case, legs, arc, lasting, profile in CURVED_PLANS
    ),
    *(_turned_scene(angle) for angle in (30.0, 45.0)),
    _scene(
        "light-slider",
        "m/M = 1e-3: to 0.01, 0.01 mm and 0.1 mrad",
        0.04,
        steps=step_sizes(1e-4, 5e-6),
        hard=_ALL_OR_NOTHING,
        slider_mass=1e-3,
        acceleration=2e4,
        to=(1e-5, 1e-5, 1e-4),
    ),
    _scene(
        "heavy-slider",
        "m/M = 1e3: 0.1 m straight on",
        1.2,
        hard=_ALL_OR_NOTHING,
        slider_mass=1e3,
        radius=0.08,
        to=(0.1, 0.0, 0.0),
    ),
)

SYSTEM = capsule_system(
    name="capsule-plan",
    rank=4,
    title="Capsule brought to a pose",
    # A place is the leading observable: a plan of lines alone keeps its heading.
    observables=(*TURN_OBSERVABLES[:2], Observable("heading", "rad"), *TURN_OBSERVABLES[2:]),
    parameters=PLAN_PARAMETERS,
    scenes=SCENES,
    default="near-free",
    problem=problem,
    facts=facts,
    interest=pose_quantities,
    start=(),
    structure=structure,
    left_out=asdict(PlanLimits()),
)
