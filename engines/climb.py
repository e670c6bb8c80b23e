"""One method on one scene, from coarse steps to fine, until the error has reached its floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analytic.reference import Array
from engines.measurement import Measurement, floor, measure
from engines.method import Method
from engines.order import Order, fit_order
from engines.trajectory import Trajectory
from models.registry import system_of
from models.scene import Scene

TRACE = 160  # points of an error curve: as many as a plot can show


@dataclass(frozen=True)
class Trace:
    """Error of the leading observable over time, at the finest step that was run."""

    step: float
    times: tuple[float, ...]
    values: tuple[float, ...]  # of the observable
    errors: tuple[float, ...]  # signed


@dataclass(frozen=True)
class Climb:
    """The measurements of one method on one scene, coarse to fine, and the order they show."""

    scene: str
    method: str
    measurements: tuple[Measurement, ...]
    order: Order | None = None  # of the error of the leading observable, largest over the run
    foretold_order: Order | None = None  # the same fit to what theory foretells at those steps
    trace: Trace | None = None
    cut: bool = False  # the finest steps were left out: they would have taken too many


def climb(scene: Scene, method: Method, most_steps: int, ladder: tuple[float, ...] = ()) -> Climb:
    """Run `scene` with `method` down its ladder (or the one given), leaving out steps that would
    take more than `most_steps`, and stopping two rungs after the error is within its floor."""
    system = system_of(scene)
    exact = system.reference(system.problem(scene.parameters))
    leading = system.observables[0].name
    rungs = ladder or method.ladder or scene.steps
    taken: list[Measurement] = []
    trace = None
    at_floor = 0
    cut = False
    for step in rungs:
        if method.control == "step" and scene.duration / step > most_steps:
            cut = True
            continue
        if step > scene.duration:
            continue
        found, run = measure(system, scene, method, step, exact)
        taken.append(found)
        if found.status in ("unsupported", "missing"):
            break
        if found.status != "done":
            continue
        assert run is not None
        trace = _trace(step, run, leading, exact.observe(run.times)[leading])
        error = found.errors[leading]
        at_floor += error.largest <= 3.0 * floor(error, found.steps)
        if at_floor > 2:
            break
    return Climb(
        scene.name, method.name, tuple(taken), *_orders(taken, leading, method), trace, cut
    )


def _orders(
    taken: list[Measurement], leading: str, method: Method
) -> tuple[Order | None, Order | None]:
    done = [m for m in taken if m.status == "done"]
    if method.order is None or not done:
        return None, None
    errors = [m.errors[leading] for m in done]
    order = fit_order(
        [m.step for m in done],
        [e.largest for e in errors],
        [floor(e, m.steps) for e, m in zip(errors, done, strict=True)],
    )
    if order is None or any(e.foretold is None for e in errors):
        return order, None
    same = [
        (m.step, e.foretold.largest)
        for m, e in zip(done, errors, strict=True)
        if m.step in order.steps and e.foretold is not None
    ]
    return order, fit_order([s for s, _ in same], [v for _, v in same], [0.0] * len(same))


def _trace(step: float, run: Trajectory, leading: str, truth: Array) -> Trace:
    kept = np.unique(np.linspace(0, len(run.times) - 1, TRACE).astype(int))
    values = run.observables[leading]
    return Trace(
        step,
        tuple(run.times[kept].tolist()),
        tuple(values[kept].tolist()),
        tuple((values - truth)[kept].tolist()),
    )
