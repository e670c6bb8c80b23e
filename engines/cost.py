"""What a step costs: measured alone, interleaved, as medians, and against a yardstick."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from engines.method import Method, Simulation, Unsupported
from engines.registry import engine_of, installed
from models.scene import Scene, System

Key = tuple[str, str]  # scene, method


@dataclass(frozen=True)
class Cost:
    """Wall time of a step [ns], median over repeats, with the quartiles; the same over the
    yardstick's; and how long the scene took to compile [s]."""

    ns_per_step: float
    low: float
    high: float
    ratio: float
    compile_seconds: float
    repeats: int


def costs(
    tasks: Sequence[tuple[System, Scene, Method, float]],
    repeats: int = 5,
    budget: float = 0.05,
    told: Callable[[str], None] = lambda _: None,
) -> tuple[Mapping[Key, Cost], float]:
    """Cost of each task (a scene, a method and a step), and the yardstick's [ns per step].

    Every round times each task once, in turn, so that a slow spell of the machine touches all of
    them alike; `budget` [s] caps how much of a long scene one round runs.
    """
    ready: dict[Key, Simulation] = {}
    for system, scene, method, step in tasks:
        if not installed(engine_of(method)):
            continue
        short = _shortened(system, scene, method, step, budget)
        try:
            ready[scene.name, method.name] = engine_of(method).prepare(system, short, method, step)
        except Unsupported:
            continue
    rule = yardstick()
    times: dict[Key, list[float]] = {key: [] for key in ready}
    rules: list[float] = []
    for _ in range(repeats):
        rules.append(rule())
        for key, simulation in ready.items():
            told(" ".join(key))
            run = simulation.run()
            if run.steps:
                times[key].append(1e9 * run.seconds / run.steps)
    unit = statistics.median(rules)
    return {
        key: _cost(values, unit, ready[key].compile_seconds)
        for key, values in times.items()
        if values
    }, unit


def yardstick(steps: int = 10_000) -> Callable[[], float]:
    """A function that times a bare MuJoCo step of an empty model [ns]: what two machines, or two
    days, can be compared by."""
    import mujoco

    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    data = mujoco.MjData(model)

    def once() -> float:
        begin = time.perf_counter()
        mujoco.mj_step(model, data, nstep=steps)
        return 1e9 * (time.perf_counter() - begin) / steps

    once()
    return once


def _shortened(system: System, scene: Scene, method: Method, step: float, budget: float) -> Scene:
    """The scene cut to about `budget` seconds of wall time, by one trial run of a short piece."""
    if method.control == "tolerance":
        return scene
    piece = min(scene.duration, 2000 * step)
    trial = replace(scene, duration=piece)
    try:
        run = engine_of(method).prepare(system, trial, method, step).run()
    except Unsupported:
        return scene
    rate = run.seconds / max(run.steps, 1)
    wanted = budget / max(rate, 1e-9) * step
    return replace(scene, duration=min(scene.duration, max(wanted, piece)))


def _cost(values: Sequence[float], unit: float, compile_seconds: float) -> Cost:
    middle = statistics.median(values)
    low, high = (
        (min(values), max(values))
        if len(values) < 4
        else (statistics.quantiles(values, n=4)[0], statistics.quantiles(values, n=4)[2])
    )
    return Cost(middle, low, high, middle / unit, compile_seconds, len(values))
