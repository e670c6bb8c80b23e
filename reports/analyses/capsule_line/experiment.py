"""An experiment for a bench: what to build and to set, and what is to be seen, and how well."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import MappingProxyType

import numpy as np

from plumbob.engines.study.results import Study
from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene
from plumbob.models.scene import Case
from plumbob.models.tripod_capsule.parameters import CHECK
from plumbob.models.tripod_capsule.plan import requested_plan
from plumbob.reports.analyses.analysis import Analysis, Record

LINE, REPEATED = "capsule-line/ca1", "capsule-train/ten"
SET = MappingProxyType({"w1": 38.0, "w2": 10.0, "t1": 0.03})  # [m/s^2], [s]
KNOWN = MappingProxyType(  # within what a bench knows or holds a parameter, in its unit
    {
        "friction": 0.015,
        "body_mass": 1e-3,
        "slider_mass": 1e-3,
        "w1": 0.4,
        "w2": 0.1,
        "t1": 1e-4,
    }
)
RATIOS = (1.25, 1.5, 2.0, 3.0, 5.0)  # of w1 over f g/mu, at one stroke
TO = (0.03, 0.01, 0.1)
LIMITS = MappingProxyType({"acceleration": 40.0, "stroke": 0.1})


@cache
def line(w1: float, w2: float, t1: float) -> Case:
    """The bench's manoeuvre along C-A1."""
    return case_of(scene(LINE, {"w1": w1, "w2": w2, "t1": t1}))


def seen(case: Case) -> Record:
    """The displacement by a manoeuvre, and the part of each parameter in its uncertainty: the exact
    derivative times what is known of it, added as squares."""
    motion = case.problem.motion
    end = np.array([motion.t2])
    slopes = exact_gradient(case, list(KNOWN), end, ["displacement"])
    rows = [
        Record(
            name=name,
            amount=float(getattr(motion, name, getattr(motion.capsule, name, math.nan))),
            known=known,
            slope=float(slopes[name].values["displacement"][0]),  # [m] per unit
            part=abs(float(slopes[name].values["displacement"][0])) * known,  # [m]
        )
        for name, known in KNOWN.items()
    ]
    demand = case.system.facts(case.problem)
    return Record(
        w1=motion.w1,
        t1=motion.t1,
        displacement=motion.displacement,  # [m]
        unsure=math.hypot(*(row.part for row in rows)),  # [m]
        stroke=motion.stroke,  # [m], of the slider
        speed=motion.w1 * motion.t1,  # [m/s], its largest
        force=demand["driving_force_peak"],  # [N]
        power=demand["driving_power_peak"],  # [W]
        t_star=motion.t_star,
        t2=motion.t2,
        rows=rows,
    )


def numbers(study: Study) -> Record:
    """The bench, one manoeuvre, others of its stroke, ten of them, and a plan to a pose."""
    usual = seen(line(**SET))
    body = line(**SET).problem.motion.capsule
    w2 = SET["w2"]
    threshold = body.holding_acceleration
    others = []
    for ratio in RATIOS:
        w1 = ratio * threshold
        t1 = math.sqrt(2.0 * w2 * usual.stroke / (w1 * (w1 + w2)))  # eq. 18 for t1
        others.append(seen(line(w1, w2, t1)))
    repeated = case_of(scene(REPEATED, dict(SET)))
    ten = repeated.system.facts(repeated.problem)
    return Record(
        usual=usual,
        others=others,
        ratios=RATIOS,
        w2=w2,
        threshold=threshold,  # [m/s^2]: f g/mu
        mass_ratio=body.mass_ratio,
        bench=dict(CHECK),
        without_friction=-body.mass_ratio * usual.stroke,  # [m]
        count=ten["count"],
        total=ten["displacement"],  # [m]
        lasting=ten["t_rest"],  # [s]
        plan=to_pose(),
    )


def to_pose() -> Record:
    """A plan within the bench's limits, and how far from its goal it ends where friction is higher
    by what is known of it."""
    plan = requested_plan({**CHECK, **LIMITS, "to": TO})
    rougher = plan.capsule.friction + KNOWN["friction"]
    away, turned = replace(plan, capsule=replace(plan.capsule, friction=rougher)).error
    return Record(
        to=TO,
        limits=dict(LIMITS),
        duration=plan.duration,  # [s]
        turns=plan.turns,
        lines=plan.lines,
        rougher=rougher,
        away=away,  # [m]
        turned=turned,  # [rad]
    )


EXPERIMENT = Analysis("capsule_line/experiment", numbers)
