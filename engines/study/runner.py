"""Runs a study: many scenes with many methods, errors and extra runs in parallel, costs alone."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from plumbob.engines.method import Method, meant
from plumbob.engines.study.convergence import (
    ConvergenceStudy,
    chosen_step_sizes,
    own_steps,
)
from plumbob.engines.study.cost import Cost, Key, costs
from plumbob.engines.study.extra_runs import (
    ExtraConvergence,
    ExtraRun,
    Request,
    Requests,
    Result,
    StudyPlan,
    TrimmingRun,
    convergence_with,
    is_of,
    make,
    nothing_more,
)
from plumbob.engines.study.provenance import provenance
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene

if TYPE_CHECKING:  # reading a stored study starts no processes
    from concurrent.futures import Executor

Profile = str  # "quick" or "full"
Progress = Callable[[str, int, int], None]  # what is being done, how many are done, of how many
MOST_STEPS = MappingProxyType({"quick": 25_000, "full": 1_000_000})
"""Of one run; quick: 50 s at MuJoCo's own 2 ms."""
_REPEATS = MappingProxyType({"quick": 5, "full": 9})
_BUDGET = MappingProxyType({"quick": 0.004, "full": 0.05})  # [s] of wall time for one timing
_ADAPTIVE_WORK = 1e5  # equivalent number of steps for the tolerances of an adaptive method, roughly


@dataclass(frozen=True)
class _Task:
    """A piece of work for one process, and roughly how many steps of a pendulum it takes."""

    label: str
    work: float
    do: Callable[..., Any]
    arguments: tuple[Any, ...]

    def done(self) -> Any:
        """Its result, worked out here and now."""
        return self.do(*self.arguments)


def run_study(
    scenes: Sequence[Scene],
    methods: Sequence[Method],
    profile: Profile = "quick",
    jobs: int = 1,
    executor: Executor | None = None,
    progress: Progress = lambda what, done, total: None,
    timed: bool = True,
    requests: Requests = nothing_more,
    command: str = "",
) -> Study:
    """Measure every method on every scene, and make what `requests` asks for beside it; `executor`,
    where given, runs the error half in place of `jobs` processes (a Dask client's will do);
    `progress` is called with what is being done; `command` is what repeats the study. Timings, of
    costs and of trimmed models, are made alone, after the rest."""
    begin = time.perf_counter()
    plan = StudyPlan(profile, tuple(scenes), tuple(methods))
    asked = tuple(dict.fromkeys(requests(plan)))
    chosen = pairs(scenes, methods)
    tasks: dict[Hashable, _Task] = {
        (scene.name, method.name): _convergence_task(scene, method, profile, asked)
        for scene, method in chosen
    }
    tasks |= {
        request: _extra_task(request, plan)
        for request in asked
        if not isinstance(request, TrimmingRun) and not any(is_of(request, *p) for p in chosen)
    }
    results = _worked_out(tasks, jobs, executor, progress)
    convergence = []
    for scene, method in chosen:
        found, recordings = results[scene.name, method.name]
        convergence.append(found)
        results |= recordings
    between = time.perf_counter()
    results |= _trimmings(asked, plan, progress)
    measured, unit = _costs(convergence, plan, progress) if timed else ({}, float("nan"))
    return Study(
        profile, plan.scenes, plan.methods, tuple(convergence), measured, unit,
        {"errors": between - begin, "costs": time.perf_counter() - between},
        {scene.name: system_of(scene).observables for scene in scenes},
        {scene.name: system_of(scene).quantities(case_of(scene)) for scene in scenes},
        {request: results[request] for request in asked},
        provenance(command),
    )  # fmt: skip


def _trimmings(
    asked: Sequence[Request], plan: StudyPlan, progress: Progress
) -> dict[Hashable, Result]:
    """The timings of trimmed models, one after the other."""
    found: dict[Hashable, Result] = {}
    for request in asked:
        if isinstance(request, TrimmingRun):
            progress(f"{request.scene} {request.method}", 0, 0)
            found[request] = make(request, plan.method(request.method))
    return found


def _costs(
    convergence: Sequence[ConvergenceStudy], plan: StudyPlan, progress: Progress
) -> tuple[Mapping[Key, Cost], float]:
    """Cost of each method on each scene that it ran, and the reference step's [ns]."""
    cases = {scene.name: case_of(scene) for scene in plan.scenes}
    by_method = {method.name: method for method in plan.methods}
    tasks = [
        (cases[c.scene], by_method[c.method], step)
        for c in convergence
        if (step := _typical(c, by_method[c.method])) is not None
    ]
    return costs(
        tasks, _REPEATS[plan.profile], _BUDGET[plan.profile], lambda what: progress(what, 0, 0)
    )


def most_steps(scene: Scene, profile: Profile) -> int:
    """The most steps that a run of a scene may take: in the quick profile fewer where a step is
    expensive."""
    most = MOST_STEPS[profile]
    return int(most / system_of(scene).weight) if profile == "quick" else most


def _convergence_task(
    scene: Scene, method: Method, profile: Profile, asked: Sequence[Request]
) -> _Task:
    """The convergence study of a pair, with the recordings of it that are asked for."""
    most = most_steps(scene, profile)
    work = _work(scene, method, chosen_step_sizes(scene, method, most))
    own = [request for request in asked if is_of(request, scene, method)]
    return _Task(f"{scene.name} {method.name}", work, convergence_with, (scene, method, most, own))


def _extra_task(request: ExtraRun | ExtraConvergence, plan: StudyPlan) -> _Task:
    steps = request.steps if isinstance(request, ExtraConvergence) else (request.step,)
    scene, method = find_scene(request.scene), plan.method(request.method)
    if request.duration is not None:
        scene = replace(scene, duration=request.duration)
    return _Task(
        f"{scene.name} {method.name}", _work(scene, method, steps), make, (request, method)
    )


def _worked_out(
    tasks: Mapping[Hashable, _Task], jobs: int, executor: Executor | None, progress: Progress
) -> dict[Hashable, Any]:
    """The results of all tasks; this process is one of the `jobs`, for it is there already, while
    another has to load everything first."""
    # The long ones first, so that nobody is left with one at the end.
    order = sorted(tasks, key=lambda key: -tasks[key].work)
    found: dict[Hashable, Any] = {}

    def begun(key: Hashable) -> None:
        progress(tasks[key].label, len(found), len(tasks))

    with pool_of(executor, min(jobs, len(tasks)) - 1) as pool:
        if pool is None:
            for key, task in tasks.items():
                begun(key)
                found[key] = task.done()
            return found
        with _interrupts_held():
            waiting = {key: pool.submit(tasks[key].do, *tasks[key].arguments) for key in order}
        for key in order:  # what nobody has begun yet
            if executor is None and waiting[key].cancel():
                begun(key)
                found[key] = tasks[key].done()
        for key in order:
            if key not in found:
                begun(key)
                found[key] = waiting[key].result()
    return found


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


@contextmanager
def pool_of(executor: Executor | None, jobs: int) -> Iterator[Executor | None]:
    """The executor, or a pool of processes, which end at once where an error or an interrupt does;
    None for no jobs."""
    if executor is not None or jobs < 1:
        yield executor
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            yield pool
        except BaseException:
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
            raise


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Processes that begin meanwhile never see an interrupt (SIGINT), which a terminal sends to all
    of them; it reaches this one afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _work(scene: Scene, method: Method, steps: Sequence[float]) -> float:
    """Roughly how long runs take with these steps: a step costs more in Python than in C."""
    if method.control == "tolerance":
        return _ADAPTIVE_WORK
    count = sum(scene.duration / h for h in steps)
    return count * system_of(scene).weight * (1.0 if method.engine == "mujoco" else 2.0)


def _typical(found: ConvergenceStudy, method: Method) -> float | None:
    """The step that a method's cost is measured at: the first of its own, or the middle one of
    those that worked."""
    done = [m.step for m in found.measurements if m.status == "done"]
    if not done:
        return None
    return done[0 if own_steps(method) else len(done) // 2]
