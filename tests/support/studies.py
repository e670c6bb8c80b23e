"""Studies for tests of reports: a small measured one, and made-up ones."""

from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import pytest

from plumbob.engines.registry import engines
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Measurement, ObservedError, Prediction
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses import analyses_of, requests
from plumbob.reports.analyses.page_numbers import verdict_on
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.tests.sharing.shared import shared

SCENE = "cone-pendulum/rotating-base"
SCENES = ",".join(f"cone-pendulum/{n}" for n in ("rotating-base", "above-*", "fast-platform"))
COMMAND = f"plumbob validate --scenes '{SCENES}' --profile quick"
NS = 1000.0  # [ns] of a step, and of an evaluation


def remeasured(study, change):
    """The study with each of its measurements as `change` makes it."""
    convergence = (
        replace(c, measurements=tuple(map(change, c.measurements))) for c in study.convergence
    )
    return replace(study, convergence=tuple(convergence))


@dataclass(frozen=True)
class Asked(Mapping[Request[Any], Any]):
    """Results of declared requests, with a record of those that were looked up."""

    results: Mapping[Request[Any], Any]
    looked_up: set[Request[Any]] = field(default_factory=set)

    def __getitem__(self, request):
        found = self.results[request]
        self.looked_up.add(request)
        return found

    def __iter__(self):
        return iter(self.results)

    def __len__(self):
        return len(self.results)


@contextmanager
def no_engine():
    """Engines that raise when a run is prepared or timed."""

    def refuses(*arguments):
        raise AssertionError("an engine was run")

    with pytest.MonkeyPatch.context() as patched:
        for engine in engines().values():
            for name in ("prepare", "trimming"):
                patched.setitem(engine.__dict__, name, refuses)
        yield


@cache
def quick():
    """Some scenes of the cone pendulum, with a method of each kind, measured once a run."""
    return shared("quick-study", measured_quick)


def measured_quick():
    """The same, measured, with a record of the extra runs that its analyses looked up."""
    scenes = find_scenes(SCENES, "quick")
    methods = find_methods("mujoco/euler,ode/leapfrog,ode/rk4,ode/dop853")
    study = run_study(scenes, methods, requests=requests, command=COMMAND)
    asked = replace(study, extras=Asked(study.extras))
    with no_engine():
        return replace(asked, analyses=analyses_of(asked))


def made_up(errors, ns=()):
    """A study of one scene: for each method its step sizes, and the error at a step; an infinite
    error is a run that diverged. `ns` are the costs of a step, 1000 ns without."""
    scene = find_scene(SCENE)
    convergence = tuple(
        ConvergenceStudy(
            SCENE, method.name, tuple(_run(method, step, error(step)) for step in steps)
        )
        for method, steps, error in errors
    )
    per_step = ns or [NS] * len(errors)
    costs = {
        (SCENE, method.name): Cost(value, value, value, value / NS, 0.0, 5)
        for (method, _, _), value in zip(errors, per_step, strict=True)
    }
    methods = tuple(method for method, _, _ in errors)
    return Study("quick", (scene,), methods, convergence, costs, NS)


def bits(run):
    """All that a recording says, equal only to what is the same to the last bit."""
    arrays = {"": run.times, **run.observables, **run.channels}
    seen = [(name, array.dtype, array.tobytes()) for name, array in arrays.items()]
    return seen, run.steps, run.seconds, run.diverged_at, run.warnings


def recorded(study):
    """A study with the records that its pages take, in place of all analyses of it."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("plumbob.reports.analyses.section", lambda system: None)
        return replace(study, analyses=analyses_of(study))


def verdicts(study):
    """The verdicts on everything that a study measured, as pages take them."""
    judged = judge_study(study)
    return {(c.scene, c.method): verdict_on(study, c, judged) for c in study.convergence}


def _run(method, step, error):
    if error == float("inf"):
        return Measurement(SCENE, method.name, step, "diverged")
    duration = find_scene(SCENE).duration
    steps = round(duration / step) if method.control == "step" else round(100 / step**0.2)
    predicted = Prediction(
        error, error, {1: error}, 0.0
    )  # a series in the step, as a smooth motion has
    found = {
        n: ObservedError(error, error, 1e-16, 1.0, predicted=predicted)
        for n in ("theta", "theta_dot")
    }
    return Measurement(
        SCENE, method.name, step, "done", errors=found, duration=duration, steps=steps
    )
