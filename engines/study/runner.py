"""Runs a study: many scenes with many methods, errors and extra runs in parallel, costs alone."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from plumbob.engines.added import one_line
from plumbob.engines.method import Method, Stepping, meant
from plumbob.engines.registry import find_engine
from plumbob.engines.study.convergence import (
    SEED,
    ConvergenceStudy,
    chosen_step_sizes,
    steps_beside,
    timed_run,
)
from plumbob.engines.study.cost import Cost, Key, costs
from plumbob.engines.study.extra_runs import (
    ExtraConvergence,
    ExtraRun,
    Request,
    Requests,
    RunRequest,
    StudyPlan,
    TrimmingRun,
    convergence_with,
    is_of,
    make,
    nothing_more,
)
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.model_reading import ModelReading, read_model
from plumbob.engines.study.provenance import machine, provenance, version_of, versions_of
from plumbob.engines.study.results import Study
from plumbob.engines.study.unfinished import Piece, Pieces, Unkept, key_of
from plumbob.engines.study.working import GENEROUS, LEAST, Progress, Task, Working, worked_out
from plumbob.engines.workers import Work, Workers, workers_of
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene

if TYPE_CHECKING:
    from concurrent.futures import Executor

Profile = str  # "quick" or "full"
MOST_STEPS = MappingProxyType({"quick": 25_000, "full": 1_000_000})
"""Of one run; quick: 50 s at MuJoCo's own 2 ms."""
_REPEATS = MappingProxyType({"quick": 5, "full": 9})
# [s] for one timing: medians scatter by what else the machine does, at 1 ms as much as at 4 ms, and
# from 2 ms on a cold start is a few per cent at most.
_BUDGET = MappingProxyType({"quick": 0.002, "full": 0.05})
TOGETHER = 64  # costs that are measured in turns, and lost together
_READINGS, _READING_WORK = "models", 1e3  # of a model file, roughly
_ADAPTIVE_WORK = 1e5  # equivalent number of steps for the tolerances of an adaptive method, roughly


@dataclass(frozen=True)
class _Timing:
    """A cost to be measured, and its key in a store."""

    key: str
    scene: Scene
    method: Method
    step: float
    run: Stepping  # the whole run, as its error was measured


def run_study(
    scenes: Sequence[Scene],
    methods: Sequence[Method],
    profile: Profile = "quick",
    jobs: int | Workers = 1,
    executor: Executor | None = None,
    progress: Progress = lambda what, done, total: None,
    timed: bool = True,
    requests: Requests = nothing_more,
    command: str = "",
    kept: Pieces | None = None,
    seed: int = SEED,
) -> Study:
    """Measure every method on every scene, and make what `requests` asks for beside it, in this
    process or, for two `jobs` and more, in so many others, or in those given; `executor`, where
    given, runs the error half in their place (a Dask client's will do); `progress` is called with
    what is being done; `command` is what repeats the study; each piece is kept in `kept` at once,
    and those that are there are not measured again; `seed` draws one more step for each pair.
    Timings, of costs and of trimmed models, are made alone, after the rest. What two processes have
    died of, or hung at, has the status "missing"."""
    begin = time.perf_counter()
    plan = StudyPlan(profile, tuple(scenes), tuple(methods))
    chosen = pairs(scenes, methods)
    with workers_of(jobs) as workers:
        if executor is None and min(workers.count, len(chosen)) > 1:
            workers.begin(len(chosen), __name__)
        asked = tuple(dict.fromkeys(requests(plan)))
        errors: dict[Hashable, Task] = {
            (scene.name, method.name): _convergence_task(scene, method, profile, asked, seed)
            for scene, method in chosen
        }
        errors |= {
            request: _extra_task(request, plan)
            for request in asked
            if not isinstance(request, TrimmingRun) and not any(is_of(request, *p) for p in chosen)
        }
        trims: dict[Hashable, Task] = {
            request: _extra_task(request, plan)
            for request in asked
            if isinstance(request, TrimmingRun)
        }
        kept = kept or Unkept()
        kept.begin(
            key_of(profile, timed, plan.scenes, plan.methods, seed),
            [task.key for task in (*errors.values(), *trims.values())],
        )
        several = min(workers.count, len(errors)) > 1
        work = Working(workers if several else None, kept, progress, [])
        pieces = worked_out(errors, work, executor)
        convergence = [
            _convergence(pieces[scene.name, method.name], scene, method, profile)
            for scene, method in chosen
        ]
        between = time.perf_counter()
        taken = sum(piece.seconds for piece in pieces.values()) / max(workers.count, 1)
        with kept.alone():
            pieces |= worked_out(trims, work, count=1)
            timings = _cost_pieces(convergence, plan, work) if timed else {}
    measured, unit = _together(timings)
    extras = {request: result for piece in pieces.values()
              for request, result in (piece.extras or {}).items()}  # fmt: skip
    return Study(
        profile, plan.scenes, plan.methods, tuple(convergence), measured, unit,
        {"errors": max(between - begin, taken), "costs": time.perf_counter() - between},
        {scene.name: system_of(scene).observables for scene in scenes},
        {scene.name: system_of(scene).quantities(case_of(scene)) for scene in scenes},
        {request: extras.get(request) for request in asked},
        provenance(command), seed,
    )  # fmt: skip


def _convergence(piece: Piece, scene: Scene, method: Method, profile: Profile) -> ConvergenceStudy:
    """The convergence study of a pair; where it was given up, one run that is missing."""
    if piece.convergence is not None:
        return piece.convergence
    steps = chosen_step_sizes(scene, method, most_steps(scene, profile))
    step = steps[0] if steps else scene.duration
    given_up = Measurement(scene.name, method.name, step, "missing", reason=piece.lost)
    return ConvergenceStudy(scene.name, method.name, (given_up,))


def _cost_pieces(
    convergence: Sequence[ConvergenceStudy], plan: StudyPlan, work: Working
) -> dict[Key, Piece]:
    """The cost of each method on each scene that it ran, timed in turns, some scenes at a time."""
    by_scene = {scene.name: scene for scene in plan.scenes}
    by_method = {method.name: method for method in plan.methods}
    how, here = (_REPEATS[plan.profile], _BUDGET[plan.profile]), machine()
    timings: dict[Key, _Timing] = {}
    for c in convergence:
        scene, method = by_scene[c.scene], by_method[c.method]
        if (chosen := timed_run(c, method)) is not None:
            step, run = chosen.step, Stepping(chosen.steps, chosen.seconds)
            key = key_of("cost", scene, method, step, how, versions_of(method), here)
            timings[c.scene, c.method] = _Timing(key, scene, method, step, run)
    keys = {timing.key: name for name, timing in timings.items()}
    found = {keys[key]: piece for key, piece in work.kept.there(list(keys)).items()}
    batches = _batches({n: t for n, t in timings.items() if n not in found}, work.workers)
    while batches:
        batch = batches.pop(0)
        given = _timed_by(batch, how, work, f"costs, {len(found)} of {len(timings)}")
        if given is None and len(batch) > 1:  # which of them it was, each alone tells
            batches = [{name: timing} for name, timing in batch.items()] + batches
            continue
        found |= dict.fromkeys(batch, Piece(lost=work.lost[-1])) if given is None else given
        work.kept.keep_all(
            {t.key: (f"cost of {' '.join(name)}", found[name]) for name, t in batch.items()}
        )
    return found


def _batches(timings: Mapping[Key, _Timing], workers: Workers | None) -> list[dict[Key, _Timing]]:
    """Costs that are measured in turns: of scenes, whole, of which one worker knows the models."""
    who = {n[0]: 0 if workers is None else workers.who(n[0]) or 0 for n in timings}
    batches: list[dict[Key, _Timing]] = [{}]
    for name in sorted(timings, key=lambda name: who[name[0]]):
        scenes = {scene for scene, _ in batches[-1]}
        another = any(who[scene] != who[name[0]] for scene in scenes)
        if another or (len(batches[-1]) >= TOGETHER and name[0] not in scenes):
            batches.append({})
        batches[-1][name] = timings[name]
    return batches


def _timed_by(
    batch: Mapping[Key, _Timing], how: tuple[int, float], work: Working, label: str
) -> Mapping[Key, Piece] | None:
    """The costs of some methods on some scenes; None where two processes have ended at it."""
    if not batch:
        return {}
    work.progress(label, 0, 0)
    arguments = (list(batch.values()), *how)
    if work.workers is None:
        return _timed(*arguments)
    found: list[Mapping[Key, Piece]] = []
    limit, (scene, _) = LEAST + GENEROUS * len(batch) * how[0] * how[1], next(iter(batch))
    waiting = [(label, Work(_timed, arguments, limit, scene))]
    work.workers.work_out(
        lambda _: waiting.pop() if waiting else None,
        lambda _, given: found.append(given),
        lambda _, why: work.lost.append(why),
        count=1,
    )
    return found[0] if found else None


def _timed(timings: Sequence[_Timing], repeats: int, budget: float) -> Mapping[Key, Piece]:
    """The costs of methods on scenes, each at its step; no cost where the engine runs it not."""
    runs = {(t.scene.name, t.method.name): t.run for t in timings}
    tasks = [(case_of(t.scene), t.method, t.step) for t in timings]
    found, unit = costs(tasks, repeats, budget, runs=runs)
    return {name: Piece(cost=found.get(name), reference_step=unit) for name in runs}


def _together(pieces: Mapping[Key, Piece]) -> tuple[Mapping[Key, Cost], float]:
    """All costs in the time of one reference step [ns], the median of those beside them."""
    units = [p.reference_step for p in pieces.values() if math.isfinite(p.reference_step)]
    unit = statistics.median(units) if units else math.nan
    found: dict[Key, Cost] = {}
    for name, piece in pieces.items():
        if (cost := piece.cost) is not None:
            scale = unit / piece.reference_step
            found[name] = replace(
                cost, ns_per_step=scale * cost.ns_per_step, low=scale * cost.low,
                high=scale * cost.high,
            )  # fmt: skip
    return found, unit


def most_steps(scene: Scene, profile: Profile) -> int:
    """The most steps that a run of a scene may take: in the quick profile fewer where a step is
    expensive."""
    most = MOST_STEPS[profile]
    return int(most / system_of(scene).weight) if profile == "quick" else most


def _convergence_task(
    scene: Scene, method: Method, profile: Profile, asked: Sequence[Request], seed: int
) -> Task:
    """The convergence study of a pair, with the recordings of it that are asked for."""
    most, work = most_steps(scene, profile), predicted_work(scene, method, profile)
    own = [r for r in asked if isinstance(r, ExtraRun) and is_of(r, scene, method)]
    key = key_of("errors", scene, method, most, own, versions_of(method), seed)
    about = scene, method, most, own, seed
    return Task(f"{scene.name} {method.name}", key, scene.name, work, _pair, about)


def _pair(scene: Scene, method: Method, most: int, own: Sequence[ExtraRun], seed: int) -> Piece:
    try:
        found, recordings = convergence_with(scene, method, most, own, seed)
    except Exception as error:
        return _given_up(scene, error)
    return Piece(found, {request: run for request, run in recordings.items()})


def _given_up(scene: Scene, error: Exception) -> Piece:
    """What a defect in the exact motion or the theory of an added system leaves: a piece without
    results. Raises an error that is plumbob's own."""
    if not (package := system_of(scene).distribution):
        raise error
    return Piece(lost=f"the system of the package {package} raises {one_line(error)}")


def _extra_task(request: Request, plan: StudyPlan) -> Task:
    if isinstance(request, ModelReading):
        return _reading_task(request)
    scene, method = find_scene(request.scene), plan.method(request.method)
    label = f"{scene.name} {method.name}"
    where: Mapping[str, str] = {}
    if isinstance(request, TrimmingRun):
        work = float(request.steps * request.repeats * system_of(scene).weight)
        label, where = f"{label}, trimmed", machine()
    else:
        steps = request.steps if isinstance(request, ExtraConvergence) else (request.step,)
        if request.duration is not None:
            scene = replace(scene, duration=request.duration)
        work = _work(scene, method, steps)
    kind = type(request).__name__
    key = key_of(kind, request, scene, method, versions_of(method), where)
    return Task(label, key, scene.name, work, _extra, (request, method))


def _extra(request: RunRequest, method: Method) -> Piece:
    try:
        return Piece(extras={request: make(request, method)})
    except Exception as error:
        return _given_up(find_scene(request.scene), error)


def _reading_task(request: ModelReading) -> Task:
    label = f"{request.model} {request.engine}"
    key = key_of(ModelReading.__name__, request, version_of(find_engine(request.engine)))
    return Task(label, key, _READINGS, _READING_WORK, _reading, (request,))


def _reading(request: ModelReading) -> Piece:
    return Piece(extras={request: read_model(request)})


def joined(study: Study, more: Study) -> Study:
    """A study with what another says of its own methods, whose costs are brought to the first one's
    machine, or day, by the two reference steps."""
    scale = study.reference_step / more.reference_step
    names = {method.name for method in more.methods}
    found = {
        key: replace(
            cost, ns_per_step=scale * cost.ns_per_step, low=scale * cost.low, high=scale * cost.high
        )
        for key, cost in more.costs.items()
    }
    return replace(
        study,
        methods=(*more.methods, *(m for m in study.methods if m.name not in names)),
        convergence=(*more.convergence, *(c for c in study.convergence if c.method not in names)),
        costs={**study.costs, **found},
    )


def pairs(scenes: Sequence[Scene], methods: Sequence[Method]) -> list[tuple[Scene, Method]]:
    """Every scene with every method that is meant for it."""
    return [(scene, method) for scene in scenes for method in methods if meant(method, scene)]


def predicted_work(scene: Scene, method: Method, profile: Profile) -> float:
    """Roughly how many steps of a pendulum the runs of a pair take."""
    most = most_steps(scene, profile)
    steps = (*chosen_step_sizes(scene, method, most), *steps_beside(scene, method, most))
    return _work(scene, method, steps)


def _work(scene: Scene, method: Method, steps: Sequence[float]) -> float:
    """Roughly how long runs take with these steps: a step costs more in Python than in C."""
    if method.control == "tolerance":
        return _ADAPTIVE_WORK
    count = sum(scene.duration / h for h in steps)
    return count * system_of(scene).weight * (1.0 if method.engine == "mujoco" else 2.0)
