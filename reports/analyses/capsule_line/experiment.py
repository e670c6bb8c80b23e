"""A bench experiment: the body to build, the motion to set, the displacement to expect, and its
uncertainty."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import MappingProxyType

import numpy as np

from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene
from plumbob.models.scene import Case
from plumbob.models.tripod_capsule.parameters import CHECK
from plumbob.models.tripod_capsule.plan import requested_plan
from plumbob.reports.analyses.analysis import Analysis, Record

BENCH_SCENE, REPEATED = "capsule-line/ca1", "capsule-train/ten"
SET = MappingProxyType({"w1": 38.0, "w2": 10.0, "t1": 0.03})  # [m/s^2], [s] set motion
# uncertainty of each parameter on a bench, in the parameter's unit
BENCH_UNCERTAINTIES = MappingProxyType(
    {
        "friction": 0.015,
        "body_mass": 1e-3,
        "slider_mass": 1e-3,
        "w1": 0.4,
        "w2": 0.1,
        "t1": 1e-4,
    }
)
ACCELERATION_RATIOS = (1.25, 1.5, 2.0, 3.0, 5.0)  # ratios of w1 to f g/mu at the same stroke
GOAL = (0.03, 0.01, 0.1)  # goal of the plan: x [m], y [m] and heading [rad]
BENCH_LIMITS = MappingProxyType({"acceleration": 40.0, "stroke": 0.1})


@cache
def bench_manoeuvre(w1: float, w2: float, t1: float) -> Case:
    """Returns the bench's manoeuvre along C-A1 with accelerations w1, w2 [m/s^2] and time t1
    [s]."""
    return case_of(scene(BENCH_SCENE, {"w1": w1, "w2": w2, "t1": t1}))


def predicted_displacement(case: Case) -> Record:
    """Returns the displacement by a manoeuvre and its uncertainty. A parameter contributes the
    exact derivative times the parameter's uncertainty; the contributions are added in
    quadrature."""
    motion = case.problem.motion
    end = np.array([motion.t2])
    gradient = exact_gradient(case, list(BENCH_UNCERTAINTIES), end, ["displacement"])
    rows = []
    for name, uncertainty in BENCH_UNCERTAINTIES.items():
        slope = float(gradient[name].values["displacement"][0])  # [m] per unit of the parameter
        row = Record(
            name=name,
            amount=float(getattr(motion, name, getattr(motion.capsule, name, math.nan))),
            known=uncertainty,
            slope=slope,
            part=abs(slope) * uncertainty,  # [m] contribution to the uncertainty
        )
        rows.append(row)
    facts = case.system.facts(case.problem)
    return Record(
        w1=motion.w1,
        t1=motion.t1,
        displacement=motion.displacement,  # [m]
        unsure=math.hypot(*(row.part for row in rows)),  # [m] uncertainty of the displacement
        stroke=motion.stroke,  # [m] stroke of the slider
        speed=motion.w1 * motion.t1,  # [m/s] largest speed of the slider
        force=facts["driving_force_peak"],  # [N]
        power=facts["driving_power_peak"],  # [W]
        t_star=motion.t_star,
        t2=motion.t2,
        rows=rows,
    )


def numbers() -> Record:
    """Returns the bench's parameters, its manoeuvre, other manoeuvres with the same stroke, ten
    repeated manoeuvres, and a plan to a pose."""
    usual = predicted_displacement(bench_manoeuvre(**SET))
    body = bench_manoeuvre(**SET).problem.motion.capsule
    w2 = SET["w2"]
    threshold = body.holding_acceleration
    others = []
    for ratio in ACCELERATION_RATIOS:
        w1 = ratio * threshold
        t1 = math.sqrt(2.0 * w2 * usual.stroke / (w1 * (w1 + w2)))  # eq. 18 for t1
        others.append(predicted_displacement(bench_manoeuvre(w1, w2, t1)))
    repeated = case_of(scene(REPEATED, dict(SET)))
    ten = repeated.system.facts(repeated.problem)
    return Record(
        usual=usual,
        others=others,
        ratios=ACCELERATION_RATIOS,
        w2=w2,
        threshold=threshold,  # [m/s^2] f g/mu
        mass_ratio=body.mass_ratio,
        bench=dict(CHECK),
        without_friction=-body.mass_ratio * usual.stroke,  # [m] displacement without friction
        count=ten["count"],
        total=ten["displacement"],  # [m] displacement by the repeated manoeuvres
        lasting=ten["t_rest"],  # [s] time until the body rests
        plan=plan_to_pose(),
    )


def plan_to_pose() -> Record:
    """Returns a plan within the bench's limits, and its distance from the goal if the friction is
    higher by its uncertainty."""
    plan = requested_plan({**CHECK, **BENCH_LIMITS, "to": GOAL})
    rougher = plan.capsule.friction + BENCH_UNCERTAINTIES["friction"]
    on_rough_ground = replace(plan, capsule=replace(plan.capsule, friction=rougher))
    distance, turn = on_rough_ground.error
    return Record(
        to=GOAL,
        limits=dict(BENCH_LIMITS),
        duration=plan.duration,  # [s]
        turns=plan.turns,
        lines=plan.lines,
        rougher=rougher,
        away=distance,  # [m] distance from the goal with that friction
        turned=turn,  # [rad] difference from the goal's heading
    )


EXPERIMENT = Analysis("capsule_line/experiment", exact=numbers)
