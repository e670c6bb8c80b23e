"""Cost of a step: the median of its time over the time of reference steps just before and after it.
Methods are timed in turn, and plumbob runs nothing else meanwhile."""

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
from plumbob.engines.trajectory import TimedSimulation
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene

Key = tuple[str, str]  # names of a scene and a method
Name = TypeVar("Name", bound=Hashable)
MIN_TIMED_STEPS = 200  # smallest number of steps that are timed
ROUND = 0.2  # [s] approximate time of a batch
STEPS_BESIDE_TIMING = 100  # number of reference steps before and after each timing
# A piece is timed until ENOUGH ratios about the median differ by at most RATIO_SCATTER. On a busy
# machine costs then scatter by 2.1 per cent; they scatter by 1.8 per cent if all rounds are made.
ENOUGH, RATIO_SCATTER = 3, 0.08
PART = 0.01  # fraction of a scene's duration with which timing an adaptive solver begins
EVALUATIONS = 300  # smallest number of evaluations: costs are then within a few per cent
# The cost that an engine claims may differ by this factor, either way, from the cost that its runs
# show. For plumbob's engines the ratio is 0.6 to 1.7, on a busy machine too.
HONEST = 3.0
LONG = 0.05  # [s] approximate processor time of a run that checks a claimed cost
SHORTEST_TIME_DIFFERENCE = 1e-4  # [s] a shorter difference of two runs is noise


@dataclass(frozen=True)
class TimedSteps:
    """A simulation, and the first fraction of its duration that is timed."""

    simulation: TimedSimulation
    fraction: float
    least: int = 1  # smallest number of steps or evaluations that a timing must have

    def stepped(self) -> Stepping:
        """Takes the steps of that fraction and returns their number and time."""
        return self.simulation.stepped(self.fraction)

    def longer(self, run: Stepping, budget: float) -> TimedSteps | None:
        """A longer piece if the `run` of this piece is too short to tell the cost of a step: it
        took less than half of `budget` [s], or too few steps. None if it is long enough."""
        if self.fraction >= 1.0 or not run.steps:
            return None
        if run.seconds >= budget / 2 and run.steps >= self.least:
            return None
        wanted = max(budget / max(run.seconds, 1e-9), self.least / run.steps)
        return replace(self, fraction=min(1.0, self.fraction * max(1.25, wanted)))


@dataclass(frozen=True)
class Cost:
    """The processor time of a step: the median over repeats, relative to reference steps."""

    ns_per_step: float  # `ratio` times the median reference step of the study [ns]
    low: float  # lower quartile [ns]
    high: float  # upper quartile [ns]
    ratio: float  # ratio of the step's time to the time of the reference steps beside it
    compile_seconds: float  # time that compiling the scene took [s]
    repeats: int  # number of timings

    def scaled(self, scale: float) -> Cost:
        """The cost in terms of another reference step, whose time is `scale` times as long."""
        return replace(
            self,
            ns_per_step=scale * self.ns_per_step,
            low=scale * self.low,
            high=scale * self.high,
        )


@dataclass(frozen=True)
class SceneCosts:
    """The costs of methods on a scene."""

    scene: str
    by_method: Mapping[str, Cost]
    reference_step: float  # median time of the reference step meanwhile [ns]


def costs(
    scene: Scene,
    timed: Sequence[tuple[Method, float]],
    repeats: int = 5,
    budget: float = 0.05,
) -> SceneCosts:
    """The costs of methods on a scene, each at its step. Methods that do not run the scene are left
    out. `budget` [s] limits the time of one timing, and with it the part of a long scene that is
    run."""
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
    """The cost of each piece, and the time of the reference step [ns].

    Each round times every piece once, in turn, except pieces whose times already agree. A time is
    divided by the time of the reference steps before and after it, so that a slow spell of the
    machine has no effect. A piece is made longer until it takes about half of `budget` [s]."""
    ready = dict(pieces)
    rule = reference_step(STEPS_BESIDE_TIMING)
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
    """The cost of a step of one world in a batch: the smallest of a few rounds, without
    compilation."""

    worlds: int  # number of worlds in the batch
    # Wall time of a step of all worlds, divided by the number of worlds [ns]
    ns_per_world_step: float
    device: str


def batch_costs(
    case: Case, method: Method, step: float, worlds: Sequence[int]
) -> tuple[BatchCost, ...]:
    """The costs for each number of worlds; raises ParameterError if the engine has no batches."""
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
    """A function that returns the time of a bare MuJoCo step of an empty model [ns], by which two
    machines, or two days, are compared."""
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
    """Returns the compiled scene with the fraction of its duration that is timed, from the start.
    Raises Unsupported."""
    simulation = engine_of(method).prepare(case, method, step)
    if method.control == "tolerance":
        return TimedSteps(simulation, PART, EVALUATIONS)
    return TimedSteps(
        simulation, min(1.0, MIN_TIMED_STEPS * step / case.scene.duration), MIN_TIMED_STEPS
    )


def false_cost(case: Case, method: Method, step: float) -> str:
    """Returns why the cost of a step that `stepped` claims is false: it differs by more than a
    factor HONEST from the processor time of a step in runs. Empty if the claim is true, or if the
    steps of a run are too cheap beside its set-up to tell. Raises Unsupported."""
    timed = partial(_run_and_claim, case, method, step)
    fraction = first_steps(case, method, step).fraction
    fraction = min(
        1.0, fraction * max(2.0, 2.0 * LONG / max(SHORTEST_TIME_DIFFERENCE, timed(fraction)[0]))
    )
    # Set-up takes the same time in both lengths: their difference has none of it.
    rounds = [[timed(fraction), timed(0.5 * fraction)] for _ in range(ENOUGH)]
    long, half = np.min(rounds, axis=0)
    seconds, steps, claimed_seconds, claimed_steps = long - half
    if (
        seconds < max(0.1 * long[0], SHORTEST_TIME_DIFFERENCE)
        or min(steps, claimed_steps) <= 0.0
    ):
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
    """Whether ENOUGH of the values, the median among them, are within RATIO_SCATTER of each other:
    another value would tell nothing new."""
    ordered = sorted(values)
    middle = (len(values) - 1) / 2
    return any(
        first <= middle <= first + ENOUGH - 1
        and ordered[first + ENOUGH - 1] <= (1.0 + RATIO_SCATTER) * ordered[first]
        for first in range(len(ordered) - ENOUGH + 1)
    )


def _cost(ratios: Sequence[float], unit: float, compile_seconds: float) -> Cost:
    """The cost with these ratios to a reference step that takes `unit` [ns]."""
    low, middle, high = statistics.quantiles(ratios, n=4) if len(ratios) > 1 else 3 * [*ratios]
    return Cost(
        ns_per_step=unit * middle,
        low=unit * low,
        high=unit * high,
        ratio=middle,
        compile_seconds=compile_seconds,
        repeats=len(ratios),
    )
