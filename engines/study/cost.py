"""Cost of a step: measured alone, interleaved, against reference steps just before and after,
as medians."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import Batches
from plumbob.engines.method import Method, Stepping, Unsupported
from plumbob.engines.processor_time import processor_time
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.trajectory import Timed
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene

Key = tuple[str, str]  # scene, method
Name = TypeVar("Name", bound=Hashable)
LEAST = 200  # steps that are timed
ROUND = 0.2  # [s], about, of a batch
BESIDE = 100  # reference steps before and after each timing
# Ratios about the median that are enough where they differ by no more: on a machine that others
# use, costs then scatter by 2.1 per cent, and with all rounds by 1.8.
ENOUGH, CLOSE = 3, 0.08
PART = 0.01  # of the duration of a scene, that an adaptive solver begins with
EVALUATIONS = 300  # from so many on, what one costs is within a few per cent of a long run's
# The cost that an engine claims may differ by this factor, either way, from the cost that its runs
# show. For the engines here the ratio is 0.6 to 1.7 on a machine that others use, too.
HONEST = 3.0
LONG = 0.05  # [s] of processor time that the steps of such a run take, about
SHORT = 1e-4  # [s]: a shorter difference of two runs is noise


@dataclass(frozen=True)
class TimedSteps:
    """A simulation, and the first fraction of its duration that is timed."""

    simulation: Timed
    fraction: float
    least: int = 1  # steps or evaluations that represent the scene

    def stepped(self) -> Stepping:
        """Its steps alone."""
        return self.simulation.stepped(self.fraction)

    def longer(self, run: Stepping, budget: float) -> TimedSteps | None:
        """A longer piece where this one's `run` tells too little of what a step costs: it took
        less than half of `budget` [s], or too few steps."""
        if self.fraction >= 1.0 or not run.steps:
            return None
        if run.seconds >= budget / 2 and run.steps >= self.least:
            return None
        wanted = max(budget / max(run.seconds, 1e-9), self.least / run.steps)
        return replace(self, fraction=min(1.0, self.fraction * max(1.25, wanted)))


@dataclass(frozen=True)
class Cost:
    """Time that a step computes for, over that of the reference steps beside it: median over
    repeats; the same in the time of the run's median reference step [ns], with the quartiles; and
    how long the scene took to compile [s]."""

    ns_per_step: float
    low: float
    high: float
    ratio: float
    compile_seconds: float
    repeats: int

    def scaled(self, scale: float) -> Cost:
        """The same in the time of another reference step, `scale` times as long."""
        return replace(
            self,
            ns_per_step=scale * self.ns_per_step,
            low=scale * self.low,
            high=scale * self.high,
        )


@dataclass(frozen=True)
class SceneCosts:
    """Costs on a scene by method, and the time of the reference step beside them [ns]."""

    scene: str
    by_method: Mapping[str, Cost]
    reference_step: float


def costs(
    scene: Scene,
    timed: Sequence[tuple[Method, float]],
    repeats: int = 5,
    budget: float = 0.05,
) -> SceneCosts:
    """Costs of methods on a scene, each at its step; none where the engine runs it not. `budget`
    [s] limits how much of a long scene one round runs."""
    case = case_of(scene)
    ready = dict[str, TimedSteps]()
    for method, step in timed:
        if installed(engine_of(method)):
            with suppress(Unsupported):
                ready[method.name] = first_steps(case, method, step)
    return SceneCosts(scene.name, *in_turns(ready, repeats, budget))


def in_turns(
    pieces: Mapping[Name, TimedSteps],
    repeats: int = 5,
    budget: float = 0.05,
) -> tuple[Mapping[Name, Cost], float]:
    """Cost of each piece, and the reference step's [ns per step]. Every round times each once, in
    turn, but for those whose times are close to each other already. Each time is divided by that of
    the reference steps before and after it, so that a slow spell of the machine has no effect. A
    piece gets longer until it takes about half of `budget` [s]."""
    ready = dict(pieces)
    rule = reference_step(BESIDE)
    ratios: dict[Name, list[float]] = {key: [] for key in ready}
    rules = [rule()]
    for _ in range(repeats):
        for key in ready:
            if _agree(ratios[key]):
                continue
            run = ready[key].stepped()
            while longer := ready[key].longer(run, budget):
                ready[key], run = longer, longer.stepped()
            rules.append(rule())
            if run.steps:
                beside = (rules[-2] + rules[-1]) / 2.0
                ratios[key].append(1e9 * run.seconds / run.steps / beside)
    unit = statistics.median(rules)
    return {
        key: _cost(values, unit, ready[key].simulation.compile_seconds)
        for key, values in ratios.items()
        if values
    }, unit


@dataclass(frozen=True)
class BatchCost:
    """Cost of a step of one of so many worlds that run beside each other [ns of wall time]: the
    least of a few rounds, after what is compiled."""

    worlds: int
    ns_per_world_step: float
    device: str


def batch_costs(
    case: Case, method: Method, step: float, worlds: Sequence[int]
) -> tuple[BatchCost, ...]:
    """Cost by the number of worlds; raises ParameterError where the engine has no batches."""
    able = engine_of(method).ability(Batches)
    if not worlds:
        return ()
    if able is None:
        raise ParameterError("worlds", method.name, "a method of an engine with batches")
    rows = []
    for count in worlds:
        device, seconds = able.of(case, method, step, count)
        seconds(1)
        steps = max(1, round(ROUND / seconds(1)))
        taken = min(seconds(steps) for _ in range(ENOUGH))
        rows.append(BatchCost(count, 1e9 * taken / (steps * count), device))
    return tuple(rows)


def reference_step(steps: int = 2_000) -> Callable[[], float]:
    """A function that times a bare MuJoCo step of an empty model [ns]: what two machines, or two
    days, can be compared by."""
    import mujoco

    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    data = mujoco.MjData(model)

    def once() -> float:
        begin = time.thread_time()
        mujoco.mj_step(model, data, nstep=steps)
        return 1e9 * (time.thread_time() - begin) / steps

    once()
    return once


def first_steps(case: Case, method: Method, step: float) -> TimedSteps:
    """The scene, compiled, and the first fraction of it that is timed; raises Unsupported."""
    simulation = engine_of(method).prepare(case, method, step)
    if method.control == "tolerance":
        return TimedSteps(simulation, PART, EVALUATIONS)
    return TimedSteps(simulation, min(1.0, LEAST * step / case.scene.duration), LEAST)


def false_cost(case: Case, method: Method, step: float) -> str:
    """Returns why the cost of a step that `stepped` claims is false: it differs by more than a
    factor HONEST from the processor time of a step in runs. Empty if the claim is true, or if the
    steps of a run are too cheap beside its set-up to tell. Raises Unsupported."""
    timed = partial(_run_and_claim, case, method, step)
    fraction = first_steps(case, method, step).fraction
    fraction = min(1.0, fraction * max(2.0, 2.0 * LONG / max(SHORT, timed(fraction)[0])))
    # Set-up takes the same time in both lengths: their difference has none of it.
    rounds = [[timed(fraction), timed(0.5 * fraction)] for _ in range(ENOUGH)]
    long, half = np.min(rounds, axis=0)
    seconds, steps, claimed_seconds, claimed_steps = long - half
    if seconds < max(0.1 * long[0], SHORT) or min(steps, claimed_steps) <= 0.0:
        return ""
    claimed = 1e9 * claimed_seconds / claimed_steps
    shown = 1e9 * seconds / steps
    if max(claimed, shown) <= HONEST * min(claimed, shown):
        return ""
    runs = f"its runs take {shown:.3g} ns of processor time"
    return f"stepped() claims {claimed:.3g} ns a step, {runs}"


def _run_and_claim(
    case: Case, method: Method, step: float, fraction: float
) -> tuple[float, float, float, float]:
    """Processor time [s] and number of steps of a run over the first `fraction` of the duration,
    then the time [s] and number of steps that `stepped` claims for that run."""
    short = case.lasting(fraction * case.scene.duration, samples=2)
    simulation = engine_of(method).prepare(short, method, step)
    begin = processor_time()
    run = simulation.run()
    taken = processor_time() - begin
    claim = simulation.stepped(1.0)
    return taken, run.steps, claim.seconds, claim.steps


def held_to_cost(case: Case, method: Method, run: Measurement) -> Measurement:
    """Returns the `run`. If a package adds its engine and the engine claims a false cost, returns a
    measurement without results that says so."""
    checked = engine_of(method).distribution and run.status == "done"
    why = false_cost(case, method, run.step) if checked else ""
    return Measurement(run.scene, run.method, run.step, "cut-short", why) if why else run


def _agree(values: Sequence[float]) -> bool:
    """Whether another ratio would tell nothing new: ENOUGH of them, the median among them, are
    within CLOSE of each other."""
    ordered = sorted(values)
    middle = (len(values) - 1) / 2
    return any(
        first <= middle <= first + ENOUGH - 1
        and ordered[first + ENOUGH - 1] <= (1.0 + CLOSE) * ordered[first]
        for first in range(len(ordered) - ENOUGH + 1)
    )


def _cost(ratios: Sequence[float], unit: float, compile_seconds: float) -> Cost:
    low, middle, high = statistics.quantiles(ratios, n=4) if len(ratios) > 1 else 3 * [*ratios]
    return Cost(unit * middle, unit * low, unit * high, middle, compile_seconds, len(ratios))
