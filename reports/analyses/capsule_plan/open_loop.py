"""Plans run open-loop in engines: the pose's error at the end, by what caused it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import (
    SHOWN,
    names,
    plan_numbers,
    plan_of,
)
from plumbob.reports.analyses.capsule_plan.pose_errors import open_runs, run_of

DEFAULT = "mujoco/euler"  # its contacts' stiction drifts
METHODS = ("mujoco/euler+coulomb", "pymunk/feet", "mujoco/rk4+coulomb", DEFAULT)
QUICK = METHODS[:2]
STEP = 1e-3  # [s]
SMALLEST = 1e-12  # [m] and [rad]: where an error of zero is drawn


def methods(study: Study | StudyPlan) -> tuple[str, ...]:
    """The methods that run plans open-loop."""
    return METHODS if study.profile == "full" else QUICK


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each plan of the study, run open-loop to its end."""
    return [run_of(name, method, STEP) for name in names(plan) for method in methods(plan)]


def numbers(study: Study) -> Record | None:
    """The errors at the end by plan and method; None without a plan or an engine."""
    plans = names(study)
    runs = open_runs(study, plans, methods(study), STEP)
    if not runs:
        return None
    return Record(
        runs=runs,
        spans=[_span(method, runs) for method in dict.fromkeys(run.method for run in runs)],
        # [m]: slow motions' largest error with friction that converges
        slow=_slow(run for run in runs if run.method != DEFAULT),
        slow_default=_slow(run for run in runs if run.method == DEFAULT),  # and on default contacts
        first=plan_numbers(plan_of(plans[0])),
        # the plan that is drawn; empty where the study lacks it
        shown=SHOWN if SHOWN in plans else "",
        smallest=SMALLEST,
        step=STEP,
        quick=QUICK,
    )


def _span(method: str, runs: Sequence[Record]) -> Record:
    """The error of the place at the end of a method's plans [m]."""
    distances = [run.end.distance for run in runs if run.method == method]
    return Record(method=method, plans=len(distances), least=min(distances), largest=max(distances))


def _slow(runs: Iterable[Record]) -> float | None:
    """The largest part of an error that slow motions caused [m]."""
    return max((run.parts["slow"].distance for run in runs if "slow" in run.parts), default=None)


OPEN_LOOP = Analysis("capsule_plan/open_loop", numbers, requests)
