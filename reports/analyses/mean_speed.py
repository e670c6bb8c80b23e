"""How fast repeated manoeuvres can go: the optimum in closed form, and engines at it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

from plumbob.analytic.systems.manoeuvres import mean_speed
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.parameters import CHECK, capsule
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import covers

SCENES = ("capsule-train/thousand", "capsule-train/ten")  # the longer one, where it was run
SCENE, STEP, COUNT = SCENES[1], 1e-3, 5
METHODS = ("mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/side", "pymunk/feet")
STROKE, PUSH = 0.2, 10.0  # [m], and w1 over f g/mu
CHECKED = 0.0817786125  # [m]: the stroke of the check manoeuvre


@cache
def best() -> RepeatedLine:
    """The fastest manoeuvres of STROKE with w1 of PUSH f g/mu, started on the grid of steps."""
    body = capsule(CHECK)
    line = mean_speed.fastest(body, PUSH * body.holding_acceleration, STROKE)
    lasting = RepeatedLine(line, COUNT).period
    return RepeatedLine(line, COUNT, 1.0, math.ceil(lasting / STEP) * STEP - lasting)


def changes() -> Changes:
    """The same as changes of SCENE."""
    manoeuvre = best().manoeuvre
    parameters = {name: getattr(manoeuvre, name) for name in ("w1", "w2", "t1", "start")}
    return (*parameters.items(), ("count", COUNT), ("fraction", 1.0), ("pause", best().pause))


def request(method: str) -> ExtraRun:
    """The run of the fastest manoeuvres with a method."""
    lasting = COUNT * round(best().period / STEP) * STEP
    return ExtraRun(SCENE, method, STEP, lasting, changes())


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The fastest manoeuvres, with the methods that a study has."""
    if not any(covers(plan, name) for name in SCENES):
        return ()
    planned = {method.name for method in plan.methods}
    return [request(name) for name in METHODS if name in planned]


def numbers(study: Study) -> Record | None:
    """The optimum and its limits, with the engines at it; None where the study repeats nothing."""
    if not any(covers(study, name) for name in SCENES):
        return None
    body, many = capsule(CHECK), best()
    holding = body.holding_acceleration
    low, high = mean_speed.longest_stroke(body, 0.0)
    return Record(
        # of the check manoeuvre
        checked=mean_speed.mean_speed(body, 3 * holding, 0.8 * holding, CHECKED, 0.9),
        pushed=RepeatedLine(many.manoeuvre, 1).mean_speed,  # with w1 of `push`
        limit=mean_speed.fastest_speed(body, STROKE),  # with w1 without bound
        most=mean_speed.fastest_speed(body, high - low),  # and the stroke too
        longest=high - low,  # [m]: the longest stroke
        paused=many.mean_speed,  # with a pause to the next step
        runs=tuple(_reached(study, many)),
        stroke=STROKE,  # [m]
        check_stroke=CHECKED,  # [m]
        push=PUSH,
        count=COUNT,
        step=STEP,  # [s]
    )


def _reached(study: Study, exact: RepeatedLine) -> list[Record]:
    """The mean speed of a method's run [m/s], and its relative error."""
    rows = []
    for method in METHODS:
        if request(method) in study.extras and (run := study.answer(request(method))):
            speed = abs(float(run.observables["displacement"][-1] / run.times[-1]))
            rows.append(Record(method=method, speed=speed, error=speed / exact.mean_speed - 1))
    return rows


MEAN_SPEED = Analysis("capsule_train/mean_speed", numbers, requests)
