"""Runs a study: many scenes with many methods. Errors and extra runs are measured in parallel,
costs one after the other."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from plumbob.engines.method import Method, meant
from plumbob.engines.registry import find_engine
from plumbob.engines.study.checkpoint import Checkpoint, key_of, measured_into, measured_shard
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
from plumbob.engines.study.results import Analysed, Study, TaskResult, assembled_study
from plumbob.engines.study.scheduler import (
    PREDICTED,
    Progress,
    study_task,
    work_by_group,
    worked_out,
)
from plumbob.engines.study.shard import Shard
from plumbob.engines.study.store import Listed
from plumbob.engines.workers import Task, Workers, workers_of
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene

Profile = str  # "quick" or "full"
Analyse = Callable[[Study, Workers], tuple[Analysed, ...]]
MAX_STEPS_OF_PROFILE = MappingProxyType({"quick": 25_000, "full": 1_000_000})
"""Largest number of steps of one run; in the quick profile 50 s at MuJoCo's default step."""
_REPEATS = MappingProxyType({"quick": 5, "full": 9})  # number of timings of a cost
# [s] time of one timing. Medians scatter by what else the machine does, at 1 ms as much as at 4 ms;
# from 2 ms on the first steps, which are slower, change a timing by a few per cent at most.
_BUDGET = MappingProxyType({"quick": 0.002, "full": 0.05})
_READING_WORK = 1e3  # approximate number of steps that take as long as reading a model file


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
    shard: Shard | None = None,
) -> Study:
    """Measures every method on every scene, answers the `requests`, and returns the study.

    - `jobs`: number of processes, or workers; with one job this process does the work.
    - `executor`: does the tasks that are not timed in place of the workers, such as Dask's.
    - `progress`: called with the description of a task, the number of tasks done, and of all tasks.
    - `timed`: whether costs are measured. Timings are made after the rest, one at a time.
    - `command`: the command that repeats the study.
    - `kept`: stores each result at once; results that it holds are not measured again.
    - `seed`: draws one more step for each pair.
    - `analyse`: computes the numbers of findings.
    - `shard`: measures only this shard's scenes, and computes no findings.

    Tasks that crash or time out twice are "missing"."""
    plan = StudyPlan(profile, tuple(scenes), tuple(methods))
    pair_count = len(pairs(scenes, methods))
    opened = measured_into(None) if kept is None else nullcontext(kept)
    with workers_of(jobs) as workers, opened as kept:
        if executor is None and min(workers.count, pair_count) > 1:
            workers.begin(pair_count, __name__)
        errors, trims = _tasks(plan, requests(plan), seed)
        every_task = (*errors, *trims)
        if shard is not None:
            groups = shard.parts(work_by_group(every_task))
            errors, trims = (_in_groups(tasks, groups) for tasks in (errors, trims))
        plan_key = key_of(profile, timed, plan.scenes, plan.methods, seed)
        goes_on = kept.begin(plan_key, [task.key for task in (*errors, *trims)])
        # A study that is resumed, or an engine of another package, may end the process that runs
        # it.
        elsewhere = goes_on or any(find_engine(m.engine).distribution for m in plan.methods)
        here = workers if elsewhere or min(workers.count, len(errors)) > 1 else None
        found = worked_out(errors, kept, executor or here, progress, workers.count)
        ran = [of.answer for of in found.values() if isinstance(of.answer, ConvergenceStudy)]
        timings = [*trims, *_cost_tasks(ran, plan)] if timed else trims
        for task in timings:
            found |= worked_out([task], kept, here, progress)
        head = Study(
            profile, plan.scenes, plan.methods, provenance=provenance(command), seed=seed
        )
        if shard is not None:
            listed = tuple((task.key, task.instead("").scene) for task in every_task)
            shared_plan = key_of(plan_key, [task.label for task in every_task])
            measured = measured_shard(shard, shared_plan, found)
            kept.complete_shard(measured, Listed(head, listed), found)
            return assembled_study(head, found.values())
        return complete_study(head, found, kept, workers, analyse, progress)


def _tasks(
    plan: StudyPlan, requests: Sequence[Request[Any]], seed: int
) -> tuple[list[Task], list[Task]]:
    """The tasks of a plan but its costs: those that run side by side, and those that are timed."""
    asked = tuple(dict.fromkeys(requests))
    errors = [
        convergence_task(*pair, plan.profile, seed) for pair in pairs(plan.scenes, plan.methods)
    ]
    errors += [_extra_task(request, plan) for request in asked if not request.timed]
    return errors, [_extra_task(request, plan) for request in asked if request.timed]


def _in_groups(tasks: Sequence[Task], groups: Collection[str]) -> list[Task]:
    """The tasks whose groups are among `groups`."""
    return [task for task in tasks if task.group in groups]


def complete_study(
    head: Study,
    results: Mapping[str, TaskResult],
    kept: Checkpoint,
    workers: Workers,
    analyse: Analyse,
    progress: Progress = lambda what, done, total: None,
) -> Study:
    """Returns the study `head` with its results and the numbers of its findings, and stores it."""
    study = replace(head, reference_step=_reference_step(results.values()))
    study = assembled_study(study.described(), results.values())
    progress("analyses", 0, 0)
    study = replace(study, analyses=analyse(study, workers))
    kept.complete(study, results)
    return study


def _reference_step(results: Iterable[TaskResult]) -> float:
    """The time of the reference step [ns]: the median over the scenes whose costs were measured."""
    units = [of.answer.reference_step for of in results if isinstance(of.answer, SceneCosts)]
    return statistics.median(units) if units else math.nan


def _cost_tasks(studies: Sequence[ConvergenceStudy], plan: StudyPlan) -> Iterator[Task]:
    """Yields a task for each scene: the costs of the methods that ran the scene, timed in turn."""
    repeats_and_budget = _REPEATS[plan.profile], _BUDGET[plan.profile]
    for scene in plan.scenes:
        timed: list[tuple[Method, float]] = []
        for study in studies:
            method = plan.method(study.method)
            run = timed_run(study, method) if study.scene == scene.name else None
            if run:
                timed.append((method, run.step))
        if timed:
            inputs = [(method, step, versions_of(method)) for method, step in timed]
            yield study_task(
                label=f"costs of {scene.name}",
                key=key_of("cost", scene, inputs, repeats_and_budget, machine()),
                group=scene.name,
                work=len(timed) * math.prod(repeats_and_budget) / PREDICTED,
                blank=TaskResult(scene=scene.name),
                do=costs,
                arguments=(scene, timed, *repeats_and_budget),
            )


def most_steps(scene: Scene, profile: Profile) -> int:
    """The largest number of steps of a run of a scene. In the quick profile it is smaller for
    scenes whose steps are expensive."""
    most = MAX_STEPS_OF_PROFILE[profile]
    return int(most / system_of(scene).weight) if profile == "quick" else most


def convergence_task(scene: Scene, method: Method, profile: Profile, seed: int) -> Task:
    """The task of measuring the convergence of a scene with a method. If the task is given up, its
    result is a study with one missing run."""
    most = most_steps(scene, profile)
    steps = chosen_step_sizes(scene, method, most)
    beside = steps_beside(scene, method, most)
    names = scene.name, method.name

    def missing(why: str) -> ConvergenceStudy:
        run = Measurement(*names, steps[0] if steps else scene.duration, "missing", why)
        return ConvergenceStudy(*names, (run,))

    return study_task(
        label=" ".join(names),
        key=key_of("errors", scene, method, steps, beside, versions_of(method), seed),
        group=scene.name,
        work=predicted_work(scene, method, profile),
        blank=TaskResult(scene=scene.name),
        do=study_with_true_cost,
        arguments=(scene, method, most, seed),
        given_up=missing,
    )


def _extra_task(request: Request[Any], plan: StudyPlan) -> Task:
    """The task of answering a request of an analysis."""
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
    """The study with the results of a second one, `more`, in place of its own for the methods of
    the second. Costs of the second study are scaled by the ratio of the two reference steps: it may
    have run on another machine, or another day."""
    scale = study.reference_step / more.reference_step
    names = {method.name for method in more.methods}
    scaled_costs = {key: cost.scaled(scale) for key, cost in more.costs.items()}
    return replace(
        study,
        methods=(*more.methods, *(m for m in study.methods if m.name not in names)),
        convergence=(
            *more.convergence,
            *(c for c in study.convergence if c.method not in names),
        ),
        costs={**study.costs, **scaled_costs},
    )


def pairs(scenes: Sequence[Scene], methods: Sequence[Method]) -> list[tuple[Scene, Method]]:
    """All pairs of a scene and a method that is meant for it."""
    return [(scene, method) for scene in scenes for method in methods if meant(method, scene)]


def predicted_work(scene: Scene, method: Method, profile: Profile) -> float:
    """Returns the predicted work of all runs of a scene with a method. The unit of work is one
    step of a simple pendulum."""
    most = most_steps(scene, profile)
    steps = (*chosen_step_sizes(scene, method, most), *steps_beside(scene, method, most))
    return work_of(scene, method, steps)
