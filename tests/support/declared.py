"""Studies of findings' tests: with the extra runs that a finding declares, each made once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.extra_runs import Request, Requests, Result, StudyPlan, make
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene


@cache
def made(request: Request) -> Result:
    """The result of a request, with the method found by its name."""
    return make(request, find_method(request.method))


def plan_of(study: Study) -> StudyPlan:
    """The planned runs of a study."""
    return StudyPlan(study.profile, study.scenes, study.methods)


def declared(study: Study, *requests: Requests) -> Study:
    """A study with the extra runs that these declare for its plan, and no others."""
    wanted = [request for one in requests for request in one(plan_of(study))]
    return replace(study, extras={request: made(request) for request in wanted})


def nothing() -> Study:
    """An empty study in the quick profile."""
    return Study("quick", (), (), (), {}, 1.0, {"errors": 0.0, "costs": 0.0})


@cache
def measured(scene: str, methods: Sequence[str], *steps: float) -> Study:
    """A scene with some methods at a few steps, and no costs; without steps, not run."""
    chosen, hows = find_scene(scene), [find_method(name) for name in methods]
    convergence = tuple(convergence_study(chosen, how, 100_000, steps) for how in hows if steps)
    return replace(nothing(), scenes=(chosen,), methods=tuple(hows), convergence=convergence)
