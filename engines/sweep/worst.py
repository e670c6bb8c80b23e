"""The worst point of a box of parameters: a search, and a check of the exact answer there."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import NoAnswer
from plumbob.engines.box import Box
from plumbob.engines.box_search import lowest
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed, methods
from plumbob.engines.sweep.sweep import run_error
from plumbob.models.scene import Case

DIVERGED_SCORE = 1e30  # score of a run that diverged
FINE_STEPS = (1e-4, 5e-5)  # [s] steps of other methods that check the exact answer
SURE = 0.1  # largest uncertainty of the exact answer, as a fraction of the error found
Score = Callable[[Case, Method, float], float]
SearchProgress = Callable[[int, int, float], None]
"""Number of runs, budget of runs, worst score so far -> nothing."""


@dataclass(frozen=True)
class ConfirmedScore:
    """Another computation of the same motion, and its distance from the exact answer."""

    method: str
    step: float  # [s], or relative tolerance
    distance: float  # relative error of that computation against the exact answer


@dataclass(frozen=True)
class Found:
    """The worst point that a search found."""

    box: Box
    method: str
    step: float  # [s], or relative tolerance
    parameters: Mapping[str, Any]  # varied parameters at the worst point
    score: float  # quantity that the search maximised: the relative error by default
    error: float  # relative error of the run there; infinite if it diverged
    runs: int  # number of runs made
    without: int  # number of runs whose scene has no exact answer or is unsupported: no error
    certificate: ConfirmedScore | None  # None if no other computation runs the scene

    @property
    def certain(self) -> bool:
        """Whether another computation confirms the exact answer to within SURE of the error."""
        return self.certificate is not None and self.certificate.distance <= SURE * self.error


def search(
    box: Box,
    method: Method,
    step: float,
    budget: int,
    score: Score = run_error,
    progress: SearchProgress = lambda runs, budget, worst: None,
) -> Found:
    """The place in a box with the largest `score` of a method, its relative error unless another
    score is given, that at most `budget` runs find. Raises ParameterError if no place has a
    score."""
    searched = lowest(
        cost=lambda place: -min(score(box.case(place), method, step), DIVERGED_SCORE),
        sides=len(box.sides),
        budget=budget,
        failed=0.0,
        progress=lambda runs, cost: progress(runs, budget, -cost),
    )
    place = searched.place
    if place is None:
        names = [side.name for side in box.sides]
        raise ParameterError("within", names, f"such that an error exists ({searched.why})")
    largest = -searched.cost
    if largest >= DIVERGED_SCORE:
        largest = math.inf
    case = box.case(place)
    parameters = {
        side.name: side.at(fraction) for side, fraction in zip(box.sides, place, strict=True)
    }
    return Found(
        box=box,
        method=method.name,
        step=step,
        parameters=parameters,
        score=largest,
        error=largest if score is run_error else run_error(case, method, step),
        runs=searched.runs,
        without=searched.without,
        certificate=certificate(case, method),
    )


def certificate(case: Case, tried: Method) -> ConfirmedScore | None:
    """The computation by another method that comes nearest to the exact answer; None if no other
    method runs the case. Integrations with a tight tolerance are tried first and, if there are
    none, engines at fine steps."""
    others = [
        method
        for method in methods()
        if method.name != tried.name
        and method.engine != "exact"
        and meant(method, case.scene)
        and installed(engine_of(method))
        and not method.surrogate
    ]
    adaptive = [
        (method, method.step_sizes[-1]) for method in others if method.control == "tolerance"
    ]
    fixed = product([method for method in others if method.control == "step"], FINE_STEPS)
    computations = _distances(case, adaptive) or _distances(case, fixed)
    return min(computations, key=lambda computation: computation.distance, default=None)


def _distances(case: Case, runs: Iterable[tuple[Method, float]]) -> list[ConfirmedScore]:
    """The computations of a case, by methods with steps, that have a finite distance from the exact
    answer."""
    computations = []
    for method, step in runs:
        try:
            distance = run_error(case, method, step)
        except (NoAnswer, Unsupported):
            continue
        if math.isfinite(distance):
            computations.append(ConfirmedScore(method.name, step, distance))
    return computations
