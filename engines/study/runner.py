"""Runs a study: many scenes with many methods, errors and extra runs in parallel, costs alone."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from plumbob.engines.method import Method, meant
from plumbob.engines.registry import find_engine
from plumbob.engines.study.checkpoint import Checkpoint, key_of, measured_into
from plumbob.engines.study.convergence import (
    SEED,
    ConvergenceStudy,
    chosen_step_sizes,
    steps_beside,
    study_with_true_cost,
    timed_run,
)
from plumbob.engines.study.cost import SceneCosts, costs
from plumbob.engines.study.extra_runs import Requests, StudyPlan
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.model_reading import ModelReading, read_model
from plumbob.engines.study.provenance import machine, provenance, version_of, versions_of
from plumbob.engines.study.request import Request, RunRequest, work_of
from plumbob.engines.study.results import Analysed, Study, TaskResult, assembled
from plumbob.engines.study.scheduler import PREDICTED, Progress, study_task, worked_out
from plumbob.engines.workers import Task, Workers, workers_of
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene

Profile = str  # "quick" or "full"
Analyse = Callable[[Study, Workers], tuple[Analysed, ...]]
MOST_STEPS = MappingProxyType({"quick": 25_000, "full": 1_000_000})
"""Of one run; quick: 50 s at MuJoCo's own 2 ms."""
_REPEATS = MappingProxyType({"quick": 5, "full": 9})
# [s] for one timing: medians scatter by what else the machine does, at 1 ms as much as at 4 ms, and
# from 2 ms on a cold start is a few per cent at most.
_BUDGET = MappingProxyType({"quick": 0.002, "full": 0.05})
_READING_WORK = 1e3  # of a model file, roughly


def run_study(
    scenes: Sequence[Scene],
    methods: Sequence[Method],
    profile: Profile = "quick",
    jobs: int | Workers = 1,
    executor: Executor | None = None,
    progress: Progress = lambda what, done, total: None,
    timed: bool = True,
    requests: Requests = lambda plan: (),
    command: str = "",
    kept: Checkpoint | None = None,
    seed: int = SEED,
    analyse: Analyse = lambda study, workers: (),
) -> Study:
    """Measure every method on every scene, and make what `requests` asks for beside it, in this
    process or, for two `jobs` and more, in so many others, or in those given; `executor`, where
    given, runs the error half in their place (a Dask client's will do); `progress` is called with
    what is being done; `command` is what repeats the study; each result is kept in `kept` at once,
    and those that are there are not measured again; `seed` draws one more step for each pair;
    `analyse` works out what is stored beside the measurements. Timings, of costs and of trimmed
    models, are made alone, after the rest. Tasks that crash or time out twice are "missing"."""
    plan = StudyPlan(profile, tuple(scenes), tuple(methods))
    chosen = pairs(scenes, methods)
    opened = measured_into(None) if kept is None else nullcontext(kept)
    with workers_of(jobs) as workers, opened as kept:
        if executor is None and min(workers.count, len(chosen)) > 1:
            workers.begin(len(chosen), __name__)
        asked = tuple(dict.fromkeys(requests(plan)))
        errors = [convergence_task(*pair, profile, seed) for pair in chosen]
        errors += [_extra_task(request, plan) for request in asked if not request.timed]
        trims = [_extra_task(request, plan) for request in asked if request.timed]
        goes_on = kept.begin(
            key_of(profile, timed, plan.scenes, plan.methods, seed),
            [task.key for task in (*errors, *trims)],
        )
        # What ended an earlier process, or may end one, is worked out in another than this.
        elsewhere = goes_on or any(find_engine(m.engine).distribution for m in plan.methods)
        here = workers if elsewhere or min(workers.count, len(errors)) > 1 else None
        found = worked_out(errors, kept, executor or here, progress, workers.count)
        ran = [of.answer for of in found.values() if isinstance(of.answer, ConvergenceStudy)]
        for task in (*trims, *(_cost_tasks(ran, plan) if timed else ())):
            found |= worked_out([task], kept, here, progress)
        study = Study(
            profile,
            plan.scenes,
            plan.methods,
            reference_step=_reference_step(found.values()),
            provenance=provenance(command),
            seed=seed,
        )
        study = assembled(study.described(), found.values())
        progress("analyses", 0, 0)
        study = replace(study, analyses=analyse(study, workers))
        kept.complete(study, found)
    return study


def _reference_step(results: Iterable[TaskResult]) -> float:
    """Time [ns] of the reference step: the median of those beside costs."""
    units = [of.answer.reference_step for of in results if isinstance(of.answer, SceneCosts)]
    return statistics.median(units) if units else math.nan


def _cost_tasks(studies: Sequence[ConvergenceStudy], plan: StudyPlan) -> Iterator[Task]:
    """The costs of the methods on each scene that they ran, timed in turns: a task a scene."""
    how = _REPEATS[plan.profile], _BUDGET[plan.profile]
    for scene in plan.scenes:
        ran = [(of, plan.method(of.method)) for of in studies if of.scene == scene.name]
        timed = [(method, run.step) for of, method in ran if (run := timed_run(of, method))]
        if timed:
            of = [(method, step, versions_of(method)) for method, step in timed]
            yield study_task(
                f"costs of {scene.name}",
                key_of("cost", scene, of, how, machine()),
                scene.name,
                len(of) * math.prod(how) / PREDICTED,
                TaskResult(scene=scene.name),
                costs,
                (scene, timed, *how),
            )


def most_steps(scene: Scene, profile: Profile) -> int:
    """The most steps that a run of a scene may take: in the quick profile fewer where a step is
    expensive."""
    most = MOST_STEPS[profile]
    return int(most / system_of(scene).weight) if profile == "quick" else most


def convergence_task(scene: Scene, method: Method, profile: Profile, seed: int) -> Task:
    """The convergence study of a pair; one run that is missing where it is given up."""
    most = most_steps(scene, profile)
    steps = chosen_step_sizes(scene, method, most)
    beside = steps_beside(scene, method, most)
    names = scene.name, method.name

    def missing(why: str) -> ConvergenceStudy:
        run = Measurement(*names, steps[0] if steps else scene.duration, "missing", why)
        return ConvergenceStudy(*names, (run,))

    return study_task(
        " ".join(names),
        key_of("errors", scene, method, steps, beside, versions_of(method), seed),
        scene.name,
        predicted_work(scene, method, profile),
        TaskResult(scene=scene.name),
        study_with_true_cost,
        (scene, method, most, seed),
        missing,
    )


def _extra_task(request: Request[Any], plan: StudyPlan) -> Task:
    kind = type(request).__name__
    if isinstance(request, ModelReading):
        label = f"a model file {request.engine}"
        blank = TaskResult(request=request)
        key = key_of(kind, request, version_of(find_engine(request.engine)))
        return study_task(label, key, "models", _READING_WORK, blank, read_model, (request,))
    assert isinstance(request, RunRequest)
    scene = plan.scene(request)
    method = plan.method(request.method)
    label = ", ".join(filter(None, (f"{scene.name} {method.name}", request.label)))
    where = machine() if request.timed else {}
    key = key_of(kind, request, scene, method, versions_of(method), where)
    blank = TaskResult(request=request, scene=request.scene if request.of_pair else "")
    work = request.work(scene, method)
    return study_task(label, key, scene.name, work, blank, request.answer, (method, scene))


def joined(study: Study, more: Study) -> Study:
    """A study with what another says of its own methods, whose costs are brought to the first one's
    machine, or day, by the two reference steps."""
    scale = study.reference_step / more.reference_step
    names = {method.name for method in more.methods}
    found = {key: cost.scaled(scale) for key, cost in more.costs.items()}
    return replace(
        study,
        methods=(*more.methods, *(m for m in study.methods if m.name not in names)),
        convergence=(
            *more.convergence,
            *(c for c in study.convergence if c.method not in names),
        ),
        costs={**study.costs, **found},
    )


def pairs(scenes: Sequence[Scene], methods: Sequence[Method]) -> list[tuple[Scene, Method]]:
    """Every scene with every method that is meant for it."""
    return [(scene, method) for scene in scenes for method in methods if meant(method, scene)]


def predicted_work(scene: Scene, method: Method, profile: Profile) -> float:
    """Roughly how many steps of a pendulum the runs of a pair take."""
    most = most_steps(scene, profile)
    steps = (*chosen_step_sizes(scene, method, most), *steps_beside(scene, method, most))
    return work_of(scene, method, steps)
