"""What a step costs: measured alone, interleaved, as medians, and against a reference step."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from plumbob.engines.method import Method, Simulation, Stepping, Unsupported
from plumbob.engines.registry import engine_of, installed
from plumbob.models.scene import Case

Key = tuple[str, str]  # scene, method
TRIAL = 200  # steps of a trial, and the least that are timed
PIECES = 64  # of a scene, one of which is an adaptive solver's first trial
ENOUGH, CLOSE = 3, 0.02  # rounds after which times that differ by so little of them are enough
EVALUATIONS = 300  # from so many on, what one costs is within a few per cent of a long run's


@dataclass(frozen=True)
class Piece:
    """A simulation, and the first fraction of its duration that is timed."""

    simulation: Simulation
    fraction: float

    def stepped(self) -> Stepping:
        """Its steps alone."""
        return self.simulation.stepped(self.fraction)


@dataclass(frozen=True)
class Cost:
    """Time that a step computes for [ns], median over repeats, with the quartiles; the same over
    the reference step's; and how long the scene took to compile [s]."""

    ns_per_step: float
    low: float
    high: float
    ratio: float
    compile_seconds: float
    repeats: int


def costs(
    tasks: Sequence[tuple[Case, Method, float]],
    repeats: int = 5,
    budget: float = 0.05,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[Mapping[Key, Cost], float]:
    """Cost of each task (a scene, a method and a step), and the reference step's [ns per step].

    Every round times each task once, in turn, so that a slow spell of the machine touches all of
    them alike, but for those whose times are close to each other already; `budget` [s] limits how
    much of a long scene one round runs.
    """
    ready: dict[Key, Piece] = {}
    for case, method, step in tasks:
        if not installed(engine_of(method)):
            continue
        try:
            ready[case.scene.name, method.name] = _sized(case, method, step, budget)
        except Unsupported:
            continue
    rule = reference_step()
    times: dict[Key, list[float]] = {key: [] for key in ready}
    rules: list[float] = []
    for _ in range(repeats):
        rules.append(rule())
        for key, piece in ready.items():
            if _agree(times[key]):
                continue
            progress(" ".join(key))
            run = piece.stepped()
            if run.steps:
                times[key].append(1e9 * run.seconds / run.steps)
    unit = statistics.median(rules)
    return {
        key: _cost(values, unit, ready[key].simulation.compile_seconds)
        for key, values in times.items()
        if values
    }, unit


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


def _sized(case: Case, method: Method, step: float, budget: float) -> Piece:
    """The scene, compiled, and the fraction of it that takes about `budget` seconds to step,
    found by a trial, or for an adaptive method by trials of longer and longer pieces; raises
    Unsupported."""
    adaptive, duration = method.control == "tolerance", case.scene.duration
    simulation = engine_of(method).prepare(case, method, step)
    if not adaptive:
        fraction = min(1.0, TRIAL * step / duration)
        trial = simulation.stepped(fraction)
        pace = max(trial.seconds / max(trial.steps, 1), 1e-9)
        return Piece(simulation, min(1.0, max(fraction, budget / pace * step / duration)))
    fraction = 1.0 / PIECES
    while fraction < 1.0:
        run = simulation.stepped(fraction)
        if run.seconds >= budget and run.steps >= EVALUATIONS:
            break
        fraction = min(2.0 * fraction, 1.0)
    return Piece(simulation, fraction)


def _agree(values: Sequence[float]) -> bool:
    """Whether another time would tell nothing new."""
    return len(values) >= ENOUGH and max(values) - min(values) <= CLOSE * min(values)


def _cost(values: Sequence[float], unit: float, compile_seconds: float) -> Cost:
    middle = statistics.median(values)
    low, high = (
        (min(values), max(values))
        if len(values) < 4
        else (statistics.quantiles(values, n=4)[0], statistics.quantiles(values, n=4)[2])
    )
    return Cost(middle, low, high, middle / unit, compile_seconds, len(values))
