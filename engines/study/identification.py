"""The parameters with which an engine's run comes nearest to the exact motion of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.answer_cache import Same, exactly
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, NoAnswer, answering
from plumbob.engines.abilities import OwnFit
from plumbob.engines.box import Box, Side, box
from plumbob.engines.box_search import Searched, lowest
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import engine_of
from plumbob.engines.study.measurement import complete_run
from plumbob.engines.study.request import Changes, RunRequest, work_of
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Quantity, Scene

Residuals = Callable[[Sequence[float] | None], Array]
"""Of a place in a box, None of the true values: the differences that are fitted, shape (n,)."""
# misfit of a run that is lost, or has no exact answer: in scales, beyond all others
FAILED = 1e6
BESIDE = 1e-3  # of a side, over which slopes are taken
ALIKE = 1e2  # a condition beyond it, with a correlation beyond 0.9998: they are one


@dataclass(frozen=True)
class Identified:
    """One identified parameter (SI units, radians)."""

    parameter: str
    true: float  # of the exact motion
    identified: float
    low: float  # ends of the interval that was searched
    high: float
    deviation: float | None
    """Standard deviation that the residual of the fit gives it; None where as many numbers are
    fitted as there are parameters, or these cannot be separated."""
    correlation: Mapping[str, float]  # with the other parameters

    @property
    def at_an_end(self) -> bool:
        """Whether the best value is an end of the interval: a better one may lie beyond."""
        return self.identified in (self.low, self.high)


@dataclass(frozen=True)
class Identification:
    """The parameters of a best fit, and what is left of the difference."""

    scene: str
    method: str
    step: float  # [s], or relative tolerance
    fitted: tuple[str, ...]  # observables
    samples: int  # numbers that are fitted
    parameters: tuple[Identified, ...]
    residual: (
        float  # root mean square of the difference at the best fit, relative to the scales
    )
    residual_at_true: float  # with the true parameters
    runs: int
    way: str = "search"

    @property
    def alike(self) -> bool:
        """Whether there are several parameters, and what is fitted does not tell them apart."""
        return len(self.parameters) > 1 and not self.parameters[0].correlation


@dataclass(frozen=True)
class ParameterFit(RunRequest[Identification]):
    """A search for the value of a parameter with which a run fits the exact motion best."""

    label = "fitted"

    scene: str
    method: str
    step: float
    parameter: str
    low: float  # ends of the interval that is searched
    high: float
    budget: int  # runs
    changes: Changes = ()

    def made(self, scene: Scene, method: Method) -> Identification | None:
        """The best fit; None where runs are lost."""
        side = Side(self.parameter, self.low, self.high)
        around = box(self.scene, dict(self.changes), [side])
        try:
            return identify(around, case_of(scene), method, self.step, self.budget)
        except ParameterError:
            return None

    def work(self, scene: Scene, method: Method) -> float:
        """Roughly how many steps it takes."""
        return self.budget * work_of(scene, method, (self.step,))


def identify(
    box: Box,
    true: Case,
    method: Method,
    step: float,
    budget: int,
    all_samples: bool = False,
    noise: float = 0.0,
    seed: int = 0,
    progress: Callable[[int, int, float], None] = lambda made, of, residual: None,
    way: str = "search",
) -> Identification:
    """The place of a box whose run by `method` fits the exact motion of `true` best, in at most
    `budget` runs, one of them with the true values: the quantities of interest where each counts,
    or with `all_samples` over the whole run. `noise` is the standard deviation of what is added to
    the exact values, relative to the quantities' scales; `way` names a fit of the engine's own in
    place of the search. Raises ParameterError where nothing fits, or too little is fitted."""
    wanted = true.system.quantities(true)
    if all_samples:
        wanted = tuple(Quantity(q.observable, q.scale) for q in wanted)
    times = _times(true, method, step)
    size = sum(1 if q.when == "end" else times.size for q in wanted)
    if size < len(box.sides):
        raise ParameterError(
            "parameter",
            ",".join(side.name for side in box.sides),
            f"at most {size}, as many as numbers are fitted; --all-samples fits more",
        )
    added = noise * np.random.default_rng(seed).standard_normal(size)

    def residuals(at: Sequence[float] | None) -> Array:
        run = complete_run(true if at is None else box.case(at), method, step)
        return _difference(true, run, times, wanted) - added

    if way == "search":  # the true values among its first places where the box has them
        truth = [side.fraction(_true(true, side.name)) for side in box.sides]
        searched = lowest(
            lambda at: min(_size(residuals(at)), FAILED),
            len(box.sides),
            budget,
            FAILED,
            lambda made, cost: progress(made, budget, cost),
            [truth] if all(0.0 <= x <= 1.0 for x in truth) else [],
        )
    else:
        searched = _by_own(method, way, residuals, len(box.sides))
    if searched.place is None or searched.cost >= FAILED:
        raise ParameterError("within", [s.name for s in box.sides], "where a run ends")
    return Identification(
        box.scene,
        method.name,
        step,
        tuple(dict.fromkeys(q.observable for q in wanted)),
        size,
        _parameters(box, true, searched, residuals),
        searched.cost,
        _size(residuals(None)),
        searched.runs,
        way,
    )


def _by_own(method: Method, way: str, residuals: Residuals, p: int) -> Searched:
    """The answer of a fit of the engine's own from the middle of the box on; raises ParameterError
    where it has none of this name, it is not installed, or a run is lost."""
    fits = {a.way: a for a in engine_of(method).abilities if isinstance(a, OwnFit)}
    if way not in fits:
        names = ", ".join(["search", *fits])
        raise ParameterError("way", way, f"one of {names} with {method.name}")
    runs = 0

    def counted(place: Array) -> Array:
        nonlocal runs
        runs += 1
        return residuals(np.clip(place, 0.0, 1.0).tolist())

    try:
        with answering():
            place = fits[way].of(counted, np.full(p, 0.5))
            cost = _size(counted(place))
    except (NoAnswer, Unsupported) as why:
        raise ParameterError("way", way, f"one that can fit here ({why})") from None
    return Searched(tuple(place.tolist()), cost, runs, 0, "")


def _times(case: Case, method: Method, step: float) -> Array:
    """Times [s] of the samples of a run, shape (n,); raises ParameterError where it is lost."""
    try:
        with answering():
            return complete_run(case, method, step).times
    except NoAnswer as why:
        name = "step" if method.control == "step" else "rtol"
        raise ParameterError(name, step, f"one whose run can be fitted ({why})") from why


def _difference(true: Case, run: Trajectory, times: Array, wanted: Sequence[Quantity]) -> Array:
    """The wanted numbers of a run less those of the exact motion, over the scales, shape (n,), at
    `times` [s], which a solver that chooses its steps meets in no other run."""
    exact, _ = exactly(Same(true.reference), run.times.tobytes())
    parts = []
    for q in wanted:
        error = (run.observables[q.observable] - exact[q.observable]) / q.scale
        parts.append(error[-1:] if q.when == "end" else np.interp(times, run.times, error))
    return np.concatenate(parts)


def _true(case: Case, name: str) -> float:
    return float(case.scene.parameters.get(name, case.system.left_out.get(name, 0.0)))


def _size(residuals: Array) -> float:
    return float(np.sqrt(np.mean(residuals**2)))


def _parameters(
    box: Box, true: Case, searched: Searched, residuals: Residuals
) -> tuple[Identified, ...]:
    """The parameters at the place found, with the covariance of a linear fit about it."""
    assert searched.place is not None
    names = [side.name for side in box.sides]
    slopes = np.column_stack(
        [_slope(box, searched.place, k, residuals) for k in range(len(names))]
    )
    deviations, correlations = _spread(slopes, searched.cost)
    return tuple(
        Identified(
            side.name,
            _true(true, side.name),
            side.at(searched.place[k]),
            side.low,
            side.high,
            None if deviations is None else float(deviations[k]),
            {
                other: float(correlations[k, j])
                for j, other in enumerate(names)
                if j != k and correlations is not None
            },
        )
        for k, side in enumerate(box.sides)
    )


def _slope(box: Box, place: Sequence[float], k: int, residuals: Residuals) -> Array:
    """Derivative of the residuals by a parameter, shape (n,); 0 where a run beside it is lost."""
    side = box.sides[k]
    low = max(place[k] - BESIDE, 0.0)
    high = min(place[k] + BESIDE, 1.0)
    try:
        below, above = (residuals((*place[:k], x, *place[k + 1 :])) for x in (low, high))
    except NoAnswer:
        return 0.0 * residuals(place)
    return (above - below) / (side.at(high) - side.at(low))


def _spread(slopes: Array, residual: float) -> tuple[Array | None, Array | None]:
    """Standard deviations and correlations of a linear fit with these `slopes`, shape (n, p), and
    a root mean square `residual`; None where they are not determined."""
    n, p = slopes.shape
    if not slopes.any(axis=0).all():
        return None, None
    sizes = np.linalg.norm(slopes, axis=0)
    unit = slopes / sizes
    if np.linalg.cond(unit) > ALIKE:
        return None, None
    covariance = np.linalg.inv(unit.T @ unit)
    spread = np.sqrt(np.diag(covariance))
    deviations = residual * math.sqrt(n / (n - p)) * spread / sizes if n > p else None
    return deviations, covariance / np.outer(spread, spread)
