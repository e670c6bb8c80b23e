"""A study: many scenes with many methods, errors in parallel, costs alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from plumbob.engines.method import Method, meant
from plumbob.engines.study.convergence import (
    ConvergenceStudy,
    chosen_step_sizes,
    convergence_study,
    own_steps,
)
from plumbob.engines.study.cost import Cost, Key, costs
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Observable, Scene

if TYPE_CHECKING:  # who reads a stored study starts no processes
    from concurrent.futures import Executor

Profile = str  # "quick" or "full"
MOST_STEPS = MappingProxyType({"quick": 25_000, "full": 1_000_000})
"""Of one run; quick: 50 s at MuJoCo's own 2 ms."""
_REPEATS = MappingProxyType({"quick": 5, "full": 9})
_BUDGET = MappingProxyType({"quick": 0.004, "full": 0.05})  # [s] of wall time for one timing


@dataclass(frozen=True)
class Study:
    """Everything that was measured: errors of each method on each scene, and costs."""

    profile: Profile
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    convergence: tuple[ConvergenceStudy, ...]
    costs: Mapping[Key, Cost]
    reference_step: float  # [ns] of a bare step of an empty model, in this study
    seconds: Mapping[str, float]  # wall time of the two halves, "errors" and "costs"
    leads: Mapping[str, Observable] = field(default_factory=dict)
    """The leading observable of each scene, for who would rather not load every system."""

    def leading(self, scene: str) -> Observable:
        """The observable that orders and verdicts of a scene lead with."""
        if scene in self.leads:
            return self.leads[scene]
        return system_of(next(s for s in self.scenes if s.name == scene)).observables[0]


def run_study(
    scenes: Sequence[Scene],
    methods: Sequence[Method],
    profile: Profile = "quick",
    jobs: int = 1,
    executor: Executor | None = None,
    told: Callable[[str, int, int], None] = lambda what, done, total: None,
    timed: bool = True,
) -> Study:
    """Measure every method on every scene; `executor`, where given, runs the error half in place
    of `jobs` processes (a Dask client's will do); `told` hears what is being done."""
    begin = time.perf_counter()
    chosen = pairs(scenes, methods)
    convergence = _convergence_studies(chosen, profile, jobs, executor, told)
    between = time.perf_counter()
    measured: Mapping[Key, Cost] = {}
    unit = float("nan")
    if timed:
        cases = {scene.name: case_of(scene) for scene in scenes}
        by_method = {method.name: method for method in methods}
        tasks = [
            (cases[c.scene], by_method[c.method], step)
            for c in convergence
            if (step := _typical(c, by_method[c.method])) is not None
        ]
        measured, unit = costs(
            tasks, _REPEATS[profile], _BUDGET[profile], lambda what: told(what, 0, 0)
        )
    return Study(
        profile, tuple(scenes), tuple(methods), tuple(convergence), measured, unit,
        {"errors": between - begin, "costs": time.perf_counter() - between},
        {scene.name: system_of(scene).observables[0] for scene in scenes},
    )  # fmt: skip


def most_steps(scene: Scene, profile: Profile) -> int:
    """The most steps that a run of a scene may take: fewer in a hurry where a step is dear."""
    most = MOST_STEPS[profile]
    return int(most / system_of(scene).weight) if profile == "quick" else most


def _convergence_studies(
    chosen: Sequence[tuple[Scene, Method]],
    profile: Profile,
    jobs: int,
    executor: Executor | None,
    told: Callable[[str, int, int], None],
) -> list[ConvergenceStudy]:
    """The convergence of all pairs, in their order; this process is one of the `jobs`, for it is there
    already, while another has to load everything first."""
    most = [most_steps(scene, profile) for scene, _ in chosen]
    # The long ones first, so that nobody is left with one at the end.
    order = sorted(range(len(chosen)), key=lambda i: -_work(*chosen[i], most[i]))
    found: dict[int, ConvergenceStudy] = {}

    def begun(i: int) -> None:
        told(f"{chosen[i][0].name} {chosen[i][1].name}", len(found), len(chosen))

    with _pool(executor, min(jobs, len(chosen)) - 1) as pool:
        if pool is None:
            for i, pair in enumerate(chosen):
                begun(i)
                found[i] = convergence_study(*pair, most[i])
            return list(found.values())
        waiting = {i: pool.submit(convergence_study, *chosen[i], most[i]) for i in order}
        for i in order:  # what nobody has begun yet
            if executor is None and waiting[i].cancel():
                begun(i)
                found[i] = convergence_study(*chosen[i], most[i])
        for i in order:
            if i not in found:
                begun(i)
                found[i] = waiting[i].result()
    return [found[i] for i in range(len(chosen))]


def joined(study: Study, more: Study) -> Study:
    """A study with what another says of its own methods, whose costs are brought to the first one's
    machine, or day, by the two reference_steps."""
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


def _pool(executor: Executor | None, jobs: int) -> AbstractContextManager[Executor | None]:
    if executor is not None:
        return nullcontext(executor)
    if jobs < 1:
        return nullcontext(None)
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    return ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn"))


def _work(scene: Scene, method: Method, most: int) -> float:
    """Roughly how long a convergence_study takes: the steps of its step_sizes, dearer in Python than in C."""
    if method.control == "tolerance":
        return 1e5
    steps = sum(scene.duration / h for h in chosen_step_sizes(scene, method, most))
    return steps * system_of(scene).weight * (1.0 if method.engine == "mujoco" else 2.0)


def _typical(found: ConvergenceStudy, method: Method) -> float | None:
    """The step that a method's cost is measured at: the first of its own, or the middle one of
    those that worked."""
    done = [m.step for m in found.measurements if m.status == "done"]
    if not done:
        return None
    return done[0 if own_steps(method) else len(done) // 2]
