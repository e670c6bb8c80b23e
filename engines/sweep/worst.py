"""The worst point of a box of parameters: a search, and how sure the exact answer is there."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import NoAnswer
from plumbob.engines.box import Box
from plumbob.engines.box_search import lowest
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed, methods
from plumbob.engines.sweep.sweep import run_error
from plumbob.models.scene import Case

DIVERGED = 1e30  # what a run that diverged counts as in the search
# [s] at which another fixed-step computation is held against the answer
FINE_STEPS = (1e-4, 5e-5)
SURE = 0.1  # of the error found: what the exact answer may be off for the finding to be certain
Score = Callable[[Case, Method, float], float]
Progress = Callable[[int, int, float], None]  # runs made, of how many, the worst so far


@dataclass(frozen=True)
class Certificate:
    """Another computation of the same motion, and how far from the exact answer it ends."""

    method: str
    step: float  # [s], or relative tolerance
    distance: float  # relative, as errors are


@dataclass(frozen=True)
class Found:
    """The worst that a search found."""

    box: Box
    method: str
    step: float  # [s], or relative tolerance
    parameters: Mapping[str, Any]  # those of the box, at the worst point
    score: float  # what was searched for there: the relative error, or what was asked for
    error: float  # relative, of the run there; infinite where it diverged
    runs: int
    without: int  # of these had no error: no exact answer, or no model
    certificate: Certificate | None  # None where no other computation runs the scene

    @property
    def certain(self) -> bool:
        """Whether the exact answer is confirmed there to well below the error found."""
        return self.certificate is not None and self.certificate.distance <= SURE * self.error


def search(
    box: Box,
    method: Method,
    step: float,
    budget: int,
    score: Score = run_error,
    progress: Progress = lambda made, of, worst: None,
) -> Found:
    """The place in a box at which a method's `score`, its relative error unless another is given,
    is the largest, in at most `budget` runs. Raises ParameterError where no place has one."""
    searched = lowest(
        lambda at: -min(score(box.case(at), method, step), DIVERGED),
        len(box.sides),
        budget,
        0.0,
        lambda made, cost: progress(made, budget, -cost),
    )
    if searched.place is None:
        raise ParameterError(
            "within", [s.name for s in box.sides], f"such that an error exists ({searched.why})"
        )
    at = searched.place
    largest = -searched.cost
    if largest >= DIVERGED:
        largest = math.inf
    case = box.case(at)
    return Found(
        box,
        method.name,
        step,
        {s.name: s.at(x) for s, x in zip(box.sides, at, strict=True)},
        largest,
        largest if score is run_error else run_error(case, method, step),
        searched.runs,
        searched.without,
        certificate(case, method),
    )


def certificate(case: Case, tried: Method) -> Certificate | None:
    """The computation nearest to the exact answer of those by other methods: integrations of the
    equations of motion with a tight tolerance or, where there is none, engines at fine steps; None
    where nothing else runs the case."""
    others = [
        m
        for m in methods()
        if m.name != tried.name
        and m.engine != "exact"
        and meant(m, case.scene)
        and installed(engine_of(m))
        and not m.surrogate
    ]
    adaptive = [(m, m.step_sizes[-1]) for m in others if m.control == "tolerance"]
    fixed = [(m, h) for m in others if m.control == "step" for h in FINE_STEPS]
    found = _distances(case, adaptive) or _distances(case, fixed)
    return min(found, key=lambda one: one.distance, default=None)


def _distances(case: Case, tried: Sequence[tuple[Method, float]]) -> list[Certificate]:
    found = []
    for method, step in tried:
        try:
            distance = run_error(case, method, step)
        except (NoAnswer, Unsupported):
            continue
        if math.isfinite(distance):
            found.append(Certificate(method.name, step, distance))
    return found
