"""The time after which the error of a method on a swing reaches a level, measured and predicted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.long_runs import LongRunSearch
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, as_expected
from plumbob.reports.analyses.measurements import study_plan
from plumbob.reports.judge.long_runs import judged_long_run
from plumbob.reports.records.claim import Claim

LONG_SWING = "simple-pendulum/free-large"  # scene of the long runs
# [s] step of the course notebook in models/simple_pendulum/README.md
SWING_STEP = 0.05
METHODS = ("mujoco/euler", "ode/leapfrog", "ode/rk4", "mujoco/rk4")
MAX_SWING_STEPS = 64_000  # steps after which every error is as large as the swing


def requests(plan: StudyPlan) -> Sequence[LongRunSearch]:
    """Returns a search for each of METHODS in the plan, on the swing at one step."""
    return tuple(
        LongRunSearch(LONG_SWING, method, SWING_STEP, MAX_SWING_STEPS)
        for method in METHODS
        if plan.has(LONG_SWING, method)
    )


def numbers(study: Study) -> Record | None:
    """Returns the judged long runs of a study; None if it holds none."""
    answers = {request: study.answer(request) for request in requests(study_plan(study))}
    judged = [
        judged_long_run(search, measured)
        for search, measured in answers.items()
        if measured and measured.times
    ]
    if not judged:
        return None
    surprises = [f"{run.search.method}: {run.surprise}" for run in judged if run.surprise]
    return Record(runs=[run.record() for run in judged], surprises=surprises)


def claims(numbers: Record) -> Claims:
    """Returns the checks that no time is unexpected, and that RK4 reaches the first error level
    later than leapfrog, and the last level earlier."""
    unexpected = as_expected(numbers.surprises)
    times = {run["method"]: _level_times(run) for run in numbers.runs}
    if not {"ode/rk4", "ode/leapfrog"} <= set(times):
        return unexpected
    rk4 = times["ode/rk4"]
    leapfrog = times["ode/leapfrog"]
    overtaken = rk4[0] > leapfrog[0] and rk4[-1] < leapfrog[-1]
    return (*unexpected, Claim("RK4 is right for longer, and then overtaken", overtaken))


def _level_times(run: Mapping[str, Any]) -> list[float]:
    """Returns the times [s] at which the error of a run reaches each level; infinite if it does
    not."""
    times = [level["measured"] for level in run["times"]]
    return [math.inf if time is None else time for time in times]


LONG_RUNS = Analysis("engines/long_runs", numbers, requests, claims)
