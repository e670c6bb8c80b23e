"""A convergence study: one method on one scene, from coarse to fine steps, down to round-off."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Reference
from plumbob.engines.method import Method
from plumbob.engines.study.cost import held_to_cost
from plumbob.engines.study.measurement import (
    REFERENCE_STEP,
    Measurement,
    floor,
    measure,
    reference_run,
    unpredicted,
)
from plumbob.engines.study.order import Order, fit_order
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene

TRACE = 160  # number of points of an error curve: as many as a plot can show
DEFAULT = ("mujoco/euler", 2e-3)  # MuJoCo's default settings: method and step [s]
PER_OCTAVE, OCTAVES = 3, 5  # steps an octave, and octaves, of a method that no theory covers
TIMED = 200  # smallest number of steps of a run that is timed: fewer take too little time
FURTHER = 8  # factor on the largest number of steps for a method with its own steps
SEED = 1  # default seed of the steps that are drawn at random


@dataclass(frozen=True)
class Trace:
    """The error of the leading observable over time, at the finest step that was run."""

    step: float  # [s]
    times: tuple[float, ...]  # [s]
    values: tuple[float, ...]  # values of the observable
    errors: tuple[float, ...]  # signed errors of the observable


@dataclass(frozen=True)
class ConvergenceStudy:
    """The measurements of one method on one scene, coarse to fine, and the order they show."""

    scene: str
    method: str
    measurements: tuple[Measurement, ...]
    order: Order | None = None  # order of the largest error of the leading observable
    predicted_order: Order | None = None  # the same fit to the predicted errors at those steps
    trace: Trace | None = None
    cut: bool = False  # whether the finest step sizes were left out, as too many steps
    drawn: Measurement | None = None
    """A run at a step that is drawn at random. It is judged, and used for nothing else."""
    beside: tuple[float, ...] = ()  # [s] steps of runs that do not count for order and plateau


def convergence_study(
    scene: Scene,
    method: Method,
    most_steps: int,
    step_sizes: tuple[float, ...] = (),
    seed: int | None = None,
) -> ConvergenceStudy:
    """Runs a scene with a method from coarse to fine steps: the given step sizes, or those of the
    method or the scene, without runs of more than `most_steps`. It stops two step sizes after the
    error has reached its floor. If no theory covers the method, further steps between these are
    run. The step at which methods are compared is always run. If a `seed` is given, one more step
    is run, which the seed chooses at random."""
    case = case_of(scene)
    leading = case.system.observables[0].name
    chosen = chosen_step_sizes(scene, method, most_steps, step_sizes)
    beside = () if step_sizes else steps_beside(scene, method, most_steps)
    measurements, finest, at_floor = _measured(case, method, chosen, beside)
    cut = at_floor <= 2 and len(chosen) < len(
        chosen_step_sizes(scene, method, math.inf, step_sizes)
    )
    trace = _trace(*finest, leading, case.reference) if finest else None
    measurements.sort(key=lambda m: -m.step)
    listed = [m for m in measurements if m.step not in beside]
    another = None if seed is None else drawn_step(listed, scene, method, seed)
    drawn = None if another is None else measure(case, method, another)[0]
    orders = _orders(listed, leading, method)
    return ConvergenceStudy(
        scene.name, method.name, tuple(measurements), *orders, trace, cut, drawn, beside
    )


def study_with_true_cost(
    scene: Scene, method: Method, most_steps: int, seed: int
) -> ConvergenceStudy:
    """A convergence study of a scene with a method. If the engine claims a false cost, the run at
    whose step the cost would be measured is replaced by one that counts as cut short."""
    study = convergence_study(scene, method, most_steps, seed=seed)
    timed = timed_run(study, method)
    if timed is None:
        return study
    judged = held_to_cost(case_of(scene), method, timed)
    runs = (judged if run is timed else run for run in study.measurements)
    return replace(study, measurements=tuple(runs))


def _measured(
    case: Case,
    method: Method,
    chosen: tuple[float, ...],
    beside: tuple[float, ...],
) -> tuple[list[Measurement], tuple[float, Trajectory] | None, int]:
    """The measurements; the step and the run of the finest measurement that has an error of the
    leading observable; and the number of these errors that are at their floor."""
    leading = case.system.observables[0].name
    measurements: list[Measurement] = []
    finest: tuple[float, Trajectory] | None = None
    at_floor, dense = 0, False
    waiting = sorted((*chosen, *beside), reverse=True)
    while waiting:
        step = waiting.pop(0)
        measurement, run = measure(case, method, step)
        measurements.append(measurement)
        if measurement.status in ("unsupported", "missing"):
            break
        if measurement.status != "done":
            continue
        if not dense and unpredicted((measurement,), method):
            dense = True
            waiting += steps_between(chosen, case.scene.duration, own_steps(method))
            waiting = sorted(set(waiting) - {m.step for m in measurements}, reverse=True)
        assert run is not None
        error = measurement.errors.get(leading)
        if error is None:
            continue
        finest = step, run
        if step not in beside and error.largest <= 3.0 * floor(error, measurement.steps):
            at_floor += 1
        if at_floor > 2:
            waiting = [h for h in waiting if h == REFERENCE_STEP]
    return measurements, finest, at_floor


def drawn_step(
    taken: Sequence[Measurement], scene: Scene, method: Method, seed: int
) -> float | None:
    """A step [s], or a tolerance, drawn at random between the steps of the runs `taken`, each
    octave with the same probability. The finest octave, whose runs cost most, is left out if there
    are several. None if fewer than two runs reached their end."""
    done = [m.step for m in taken if m.status == "done"]
    if len(done) < 2 or own_steps(method):
        return None
    coarse = max(done)
    fine = min(done)
    if method.control == "step" and coarse > 4.0 * fine:
        fine *= 2.0
    draw = random.Random(f"{seed} {scene.name} {method.name}")
    return math.exp(draw.uniform(math.log(fine), math.log(coarse)))


def chosen_step_sizes(
    scene: Scene, method: Method, most_steps: float, step_sizes: tuple[float, ...] = ()
) -> tuple[float, ...]:
    """The steps [s], or tolerances, that a convergence study may run, coarse to fine: the given
    step sizes, or else the method's, or else the scene's. Steps longer than the scene are left out,
    and steps of which the scene takes more than `most_steps`. The step that a user asks about
    always stays: the first of a method's own steps, and MuJoCo's default step for its default
    method."""
    listed = step_sizes or method.step_sizes or scene.steps
    if method.control == "tolerance":
        return listed
    asked = math.nan
    most = most_steps
    if own_steps(method):
        asked = method.step_sizes[0]
        most = FURTHER * most_steps
    elif method.name == DEFAULT[0] and not step_sizes:
        asked = DEFAULT[1]
        listed = tuple(sorted({*listed, asked}, reverse=True))
    short = (step for step in listed if step <= scene.duration)
    return tuple(step for step in short if scene.duration / step <= most or step == asked)


def steps_beside(scene: Scene, method: Method, most_steps: float) -> tuple[float, ...]:
    """The step [s] at which methods are compared, as a tuple. It is empty if that step is one of
    the chosen step sizes, or if a run takes more than FURTHER times `most_steps`."""
    chosen = chosen_step_sizes(scene, method, most_steps)
    if method.control == "tolerance" or own_steps(method) or REFERENCE_STEP in chosen:
        return ()
    fits = 1.0 <= scene.duration / REFERENCE_STEP <= FURTHER * most_steps
    return (REFERENCE_STEP,) if fits else ()


def steps_between(steps: tuple[float, ...], duration: float, own: bool) -> tuple[float, ...]:
    """Incommensurate steps [s], PER_OCTAVE an octave, down to the finest of `steps`: over at least
    OCTAVES octaves, as long as `duration` [s] has eight steps. If the method brings its `own`
    steps, the octaves of these steps alone."""
    finest = min(steps)
    coarsest = max(steps)
    if not own:
        coarsest = max(coarsest, min(finest * 2.0**OCTAVES, duration / 8.0))
    count = math.floor(PER_OCTAVE * math.log2(coarsest / finest) + 1e-9)
    return tuple(finest * 2.0 ** (k / PER_OCTAVE) for k in range(count, 0, -1))


def own_steps(method: Method) -> bool:
    """Whether a method brings its own fixed steps, as a user's settings do. The first of them is
    the step that the user asks about."""
    return method.control == "step" and bool(method.step_sizes)


def timed_run(found: ConvergenceStudy, method: Method) -> Measurement | None:
    """The run at whose step a method's cost is measured, or None.

    If a method brings its own steps, the run at the first of them. Else the run at which errors are
    shown, if it is long enough to be timed. Else, and for adaptive solvers, the middle one of the
    runs that reached their end. None if the engine makes false claims about its runs."""
    if any(run.status == "cut-short" for run in found.measurements):
        return None
    done = [run for run in found.measurements if run.status == "done"]
    if own_steps(method) or not done:
        return done[0] if done else None
    shown = reference_run(done, method)
    if method.control == "step" and shown and shown.duration >= TIMED * shown.step:
        return shown
    return done[len(done) // 2]


def _orders(
    taken: list[Measurement], leading: str, method: Method
) -> tuple[Order | None, Order | None]:
    """The order of the errors of the leading observable, and the order of the predicted errors at
    the same steps. Each is None if it cannot be fitted."""
    done = {
        run.step: (run.errors[leading], run.steps) for run in taken if leading in run.errors
    }
    if method.order is None:
        return None, None
    floors = [floor(error, steps) for error, steps in done.values()]
    order = fit_order(list(done), [error.largest for error, _ in done.values()], floors)
    predicted = {
        step: error.predicted.largest for step, (error, _) in done.items() if error.predicted
    }
    if order is None or len(predicted) < len(done):
        return order, None
    sizes = [predicted[step] for step in order.steps]
    return order, fit_order(order.steps, sizes, np.zeros(len(sizes)))


def _trace(step: float, run: Trajectory, leading: str, exact: Reference) -> Trace:
    """The error of the leading observable at TRACE samples of a run with a step [s]."""
    kept = np.unique(np.linspace(0, len(run.times) - 1, TRACE).astype(int))
    times = run.times[kept]
    values = run.observables[leading][kept]
    errors = values - exact.observe(times)[leading]
    return Trace(step, tuple(times.tolist()), tuple(values.tolist()), tuple(errors.tolist()))
