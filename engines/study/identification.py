"""Identification: finds parameters with which an engine's run fits the exact motion of a scene."""

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
"""Function from a place in a box (a fraction of each side), or None for the known parameter values,
to the differences that are fitted, shape (n,)."""
FAILED = 1e6  # misfit, in scales, of a run that is lost or has no exact answer
# distance on either side over which slopes are taken, as a fraction of the side
SLOPE_DISTANCE = 1e-3
# Parameters whose slopes have a larger condition number, and so a correlation beyond 0.9998, cannot
# be distinguished.
LARGEST_CONDITION = 1e2


@dataclass(frozen=True)
class Identified:
    """One identified parameter (SI units, radians)."""

    parameter: str
    true: float  # value of the exact motion
    identified: float  # value of the best fit
    low: float  # lower end of the interval that was searched
    high: float  # upper end of the interval that was searched
    deviation: float | None
    """Standard deviation that follows from the residual of the fit. None if no more numbers are
    fitted than there are parameters, or if the parameters cannot be separated."""
    correlation: Mapping[str, float]  # correlation with each of the other parameters

    @property
    def at_an_end(self) -> bool:
        """Whether the best value is an end of the interval: a better one may lie beyond."""
        return self.identified in (self.low, self.high)


@dataclass(frozen=True)
class Identification:
    """The parameters of the best fit, and the difference that remains."""

    scene: str
    method: str
    step: float  # [s], or relative tolerance
    fitted: tuple[str, ...]  # observables that are fitted
    samples: int  # number of values that are fitted
    parameters: tuple[Identified, ...]
    residual: float
    """Root mean square of the difference at the best fit, relative to the observables' scales."""
    residual_at_true: float  # root mean square of the difference with the known parameters
    runs: int  # number of runs made
    way: str = "search"  # "search", or the name of an engine's own fit

    @property
    def alike(self) -> bool:
        """Whether there are several parameters that the fitted observables do not tell apart."""
        return len(self.parameters) > 1 and not self.parameters[0].correlation


@dataclass(frozen=True)
class ParameterFit(RunRequest[Identification]):
    """A request for the value of a parameter with which a run fits the exact motion best."""

    label = "fitted"

    scene: str
    method: str
    step: float
    parameter: str
    low: float  # lower end of the interval that is searched
    high: float  # upper end of the interval that is searched
    budget: int  # largest number of runs
    changes: Changes = ()

    def made(self, scene: Scene, method: Method) -> Identification | None:
        """The best fit; None if no run can be fitted."""
        side = Side(self.parameter, self.low, self.high)
        around = box(self.scene, dict(self.changes), [side])
        try:
            return identify(around, case_of(scene), method, self.step, self.budget)
        except ParameterError:
            return None

    def work(self, scene: Scene, method: Method) -> float:
        """The approximate number of steps."""
        return self.budget * work_of(scene, method, (self.step,))


def identify(
    box: Box,
    known: Case,
    method: Method,
    step: float,
    budget: int,
    all_samples: bool = False,
    noise: float = 0.0,
    seed: int = 0,
    progress: Callable[[int, int, float], None] = lambda made, of, residual: None,
    way: str = "search",
) -> Identification:
    """The parameters in a box with which a run by `method` fits the exact motion of the case
    `known` best, found in at most `budget` runs, one of them with the parameters of that case.

    The quantities of interest are fitted, at the end or over the run as each is defined, or all of
    them over the whole run if `all_samples`. `noise` is the standard deviation of random numbers
    that are added to the exact values, relative to the quantities' scales. `way` is "search", or
    names a fit of the engine. Raises ParameterError if no run can be fitted, or if fewer numbers
    are fitted than there are parameters."""
    wanted = known.system.quantities(known)
    if all_samples:
        wanted = tuple(Quantity(q.observable, q.scale) for q in wanted)
    times = _times(known, method, step)
    size = sum(1 if q.when == "end" else times.size for q in wanted)
    if size < len(box.sides):
        raise ParameterError(
            "parameter",
            ",".join(side.name for side in box.sides),
            f"at most {size}, as many as numbers are fitted; --all-samples fits more",
        )
    added = noise * np.random.default_rng(seed).standard_normal(size)

    def residuals(place: Sequence[float] | None) -> Array:
        """The residuals of the run at a place of the box, or with the known values."""
        run = complete_run(known if place is None else box.case(place), method, step)
        return _difference(known, run, times, wanted) - added

    if way == "search":
        searched = _search(box, known, residuals, budget, progress)
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
        _parameters(box, known, searched, residuals),
        searched.cost,
        _size(residuals(None)),
        searched.runs,
        way,
    )


def _search(
    box: Box,
    known: Case,
    residuals: Residuals,
    budget: int,
    progress: Callable[[int, int, float], None],
) -> Searched:
    """Searches the box for the smallest residuals. A place is a fraction of each side, from 0 to 1.
    The place of the known parameter values is tried first if it lies in the box."""
    known_place = [side.fraction(_parameter_value(known, side.name)) for side in box.sides]
    in_box = all(0.0 <= fraction <= 1.0 for fraction in known_place)
    return lowest(
        cost=lambda place: min(_size(residuals(place)), FAILED),
        sides=len(box.sides),
        budget=budget,
        failed=FAILED,
        progress=lambda runs, cost: progress(runs, budget, cost),
        first=[known_place] if in_box else [],
    )


def _by_own(method: Method, way: str, residuals: Residuals, p: int) -> Searched:
    """The result of an engine's own fit that starts in the middle of the box, of `p` parameters.
    Raises ParameterError if the engine has no fit of this name, the fit's package is missing, or a
    run is lost."""
    fits = {fit.way: fit for fit in engine_of(method).abilities_of(OwnFit)}
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
    """The times [s] of the samples of a run, shape (n,); raises ParameterError if it is lost."""
    try:
        with answering():
            return complete_run(case, method, step).times
    except NoAnswer as why:
        name = "step" if method.control == "step" else "rtol"
        raise ParameterError(name, step, f"one whose run can be fitted ({why})") from why


def _difference(
    known: Case, run: Trajectory, times: Array, wanted: Sequence[Quantity]
) -> Array:
    """The wanted quantities of a run less those of the exact motion of the case `known`, divided by
    their scales, shape (n,). They are interpolated to `times` [s]: a solver that chooses its steps
    has other times in each run."""
    exact, _ = exactly(Same(known.reference), run.times.tobytes())
    parts = []
    for q in wanted:
        error = (run.observables[q.observable] - exact[q.observable]) / q.scale
        parts.append(error[-1:] if q.when == "end" else np.interp(times, run.times, error))
    return np.concatenate(parts)


def _parameter_value(case: Case, name: str) -> float:
    """The value of a parameter in a case."""
    return float(case.scene.parameters.get(name, case.system.left_out.get(name, 0.0)))


def _size(residuals: Array) -> float:
    """The root mean square of residuals."""
    return float(np.sqrt(np.mean(residuals**2)))


def _parameters(
    box: Box, known: Case, searched: Searched, residuals: Residuals
) -> tuple[Identified, ...]:
    """The parameters at the best place, with the covariance of a linear fit about it."""
    place = searched.place
    assert place is not None
    slopes = np.column_stack([_slope(box, place, k, residuals) for k in range(len(box.sides))])
    deviations, correlations = _spread(slopes, searched.cost)
    identified = []
    for k, side in enumerate(box.sides):
        others = {}
        if correlations is not None:
            others = {
                other.name: float(correlations[k, j])
                for j, other in enumerate(box.sides)
                if j != k
            }
        identified.append(
            Identified(
                parameter=side.name,
                true=_parameter_value(known, side.name),
                identified=side.at(place[k]),
                low=side.low,
                high=side.high,
                deviation=None if deviations is None else float(deviations[k]),
                correlation=others,
            )
        )
    return tuple(identified)


def _slope(box: Box, place: Sequence[float], k: int, residuals: Residuals) -> Array:
    """The derivative of the residuals by parameter `k`, shape (n,); 0 if a run beside the place is
    lost."""
    side = box.sides[k]
    low = max(place[k] - SLOPE_DISTANCE, 0.0)
    high = min(place[k] + SLOPE_DISTANCE, 1.0)
    try:
        below, above = (residuals((*place[:k], x, *place[k + 1 :])) for x in (low, high))
    except NoAnswer:
        return 0.0 * residuals(place)
    return (above - below) / (side.at(high) - side.at(low))


def _spread(slopes: Array, residual: float) -> tuple[Array | None, Array | None]:
    """The standard deviations, shape (p,), and the correlations, shape (p, p), of a linear fit with
    these `slopes`, shape (n, p), and a root mean square `residual`. Each is None if it is not
    determined."""
    n, p = slopes.shape
    if not slopes.any(axis=0).all():
        return None, None
    sizes = np.linalg.norm(slopes, axis=0)
    unit = slopes / sizes
    if np.linalg.cond(unit) > LARGEST_CONDITION:
        return None, None
    covariance = np.linalg.inv(unit.T @ unit)
    spread = np.sqrt(np.diag(covariance))
    deviations = residual * math.sqrt(n / (n - p)) * spread / sizes if n > p else None
    return deviations, covariance / np.outer(spread, spread)
