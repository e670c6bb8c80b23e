"""Plans run open-loop in engines: the final pose errors, split by the kind of manoeuvre."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product

import numpy as np

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import plan_numbers, plan_of, planned_scenes
from plumbob.reports.analyses.capsule_plan.pose_errors import (
    error_by_name,
    errors_by_kind,
    pose_errors,
    run_duration,
)
from plumbob.reports.analyses.measurements import case

DEFAULT = "mujoco/euler"  # method whose default contacts drift in stiction
METHODS = ("mujoco/euler+coulomb", "pymunk/feet", "mujoco/rk4+coulomb", DEFAULT)
QUICK = METHODS[:2]
STEP = 1e-3  # [s]


def runs(study: Study | StudyPlan) -> Sequence[ExtraRun]:
    """Returns an open-loop run of each plan with each method of the study's profile."""
    methods = METHODS if study.profile == "full" else QUICK
    return [
        ExtraRun(name, method, STEP, run_duration(plan_of(name), STEP))
        for name, method in product(planned_scenes(study), methods)
    ]


def numbers(study: Study) -> Record | None:
    """Returns the final pose errors by plan and method; None if no run came to rest."""
    errors = [_final_error(study, request) for request in runs(study)]
    ended = tuple(run for run in errors if run)
    if not ended:
        return None
    methods = dict.fromkeys(run.method for run in ended)
    return Record(
        runs=ended,
        spans=[_error_range(method, ended) for method in methods],
        # [m] largest error that slow motions cause with friction that converges, then by default
        slow=_largest_slow_error([run for run in ended if run.method != DEFAULT]),
        slow_default=_largest_slow_error([run for run in ended if run.method == DEFAULT]),
        first=plan_numbers(plan_of(ended[0].scene)),
        step=STEP,
        quick=QUICK,
    )


def _final_error(study: Study, request: ExtraRun) -> Record | None:
    """Returns the final pose error of a run, and the part that each kind of manoeuvre added; None
    if the run was not made or the body does not come to rest."""
    name = request.scene
    plan = plan_of(request.scene)
    recorded = study.answer(request)
    if recorded is None or len(recorded.times) < 2:
        return None
    after = pose_errors(plan, case(name).reference, recorded)
    if np.isnan(after[-1]).any():
        return None
    parts = {kind: error_by_name(error) for kind, error in errors_by_kind(plan, after).items()}
    return Record(scene=name, method=request.method, parts=parts, end=error_by_name(after[-1]))


def _error_range(method: str, runs: Sequence[Record]) -> Record:
    """Returns the range of a method's final position errors [m] over all plans."""
    distances = [run.end["distance"] for run in runs if run.method == method]
    return Record(
        method=method, plans=len(distances), least=min(distances), largest=max(distances)
    )


def _largest_slow_error(runs: Iterable[Record]) -> float | None:
    """Returns the largest position error [m] that slow motions caused; None if there are none."""
    slow = [run.parts["slow"]["distance"] for run in runs if "slow" in run.parts]
    return max(slow, default=None)


OPEN_LOOP = Analysis("capsule_plan/open_loop", numbers, runs)
