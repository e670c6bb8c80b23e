"""Studies of findings' tests: with the extra runs that a finding declares, each made once."""

from dataclasses import replace
from functools import cache

import numpy as np

from plumbob.engines.abilities import Trimming
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.convergence import (
    ConvergenceStudy,
    chosen_step_sizes,
    convergence_study,
    steps_beside,
)
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.extra_runs import (
    DrawingRequest,
    ExtraRun,
    StepRun,
    StudyPlan,
    TrimmingRun,
)
from plumbob.engines.study.gradient import Gradient, Gradients, GradientSearch, TriedDifference
from plumbob.engines.study.identification import Identification, Identified, ParameterFit
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun
from plumbob.engines.study.measurement import Measurement, ObservedError, Prediction
from plumbob.engines.study.model_reading import ModelRead, ModelReading, read_model
from plumbob.engines.study.request import RunRequest
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.engines.study.stability import (
    MeasuredLimit,
    SceneLimits,
    StabilitySearch,
)
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import with_exact_numbers
from plumbob.reports.analyses.measurements import study_plan
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.reports.view.finding_text import read_findings

SAMPLES, ERROR = 240, 1e-6  # of invented runs


@cache
def made(request):
    """The result of a request, with the method found by its name."""
    if isinstance(request, ModelReading):
        return read_model(request)
    assert isinstance(request, RunRequest)
    return request.answer(find_method(request.method))


def declared(study, *requests):
    """A study with the extra runs that these declare for its plan, and no others."""
    wanted = [request for one in requests for request in one(study_plan(study))]
    return replace(study, extras={request: made(request) for request in wanted})


def numbers_of(analysis, ran=None):
    """The numbers of a study with the runs that the analysis declares."""
    return analysis.numbers(declared(ran or nothing(), analysis.requests))


def findings_of(own, study):
    """The findings of a section in a study."""
    return [found for find in own.findings if (found := formed(find, study)) is not None]


def formed(analysis, study):
    """The finding that an analysis and its template form of a study."""
    measured_numbers = analysis.numbers(study)
    if measured_numbers is None:
        return None
    numbers = with_exact_numbers(analysis, measured_numbers)
    (finding,) = read_findings(
        analysis.template, plain(numbers, FOR_TEMPLATES), tuple(analysis.claims(numbers))
    )
    return finding


def finding(analysis, study):
    """The same, where there is one."""
    found = formed(analysis, study)
    assert found is not None
    return found


def nothing():
    """An empty study in the quick profile."""
    return Study("quick", (), (), (), {}, 1.0)


@cache
def measured(scene, methods, *steps):
    """A scene with some methods at a few steps, and no costs; without steps, not run."""
    chosen = find_scene(scene)
    hows = [find_method(name) for name in methods]
    convergence = tuple(convergence_study(chosen, how, 100_000, steps) for how in hows if steps)
    return replace(nothing(), scenes=(chosen,), methods=tuple(hows), convergence=convergence)


def invented_study(wanted):
    """The quick study of every scene and method, with what `wanted` declares, and without a run:
    errors of first order, as predicted."""
    plan = StudyPlan("quick", find_scenes("*", "quick"), find_methods("*"))
    cost = Cost(1.0, 1.0, 1.0, 1.0, 0.0, 5)
    return replace(
        nothing(),
        scenes=plan.scenes,
        methods=plan.methods,
        convergence=_convergence(plan),
        costs={(s.name, m.name): cost for s, m in pairs(plan.scenes, plan.methods)},
        extras={request: _invented(request) for request in wanted(plan)},
        interest={s.name: system_of(s).quantities(case_of(s)) for s in plan.scenes},
    )


@cache
def _posed(name):
    scene = find_scene(name)
    return case_of(scene)


def _invented(request):
    """What an engine with a small, constant error would give."""
    if isinstance(request, TrimmingRun):
        return Trimming(3.0, 2.0, 1.0, True)
    if isinstance(request, ModelReading):
        return ModelRead(
            "1.0", "", (("gravity", "", (0.0, 0.0, -9.81)), ("timestep", "", (1e-3,)))
        )
    if isinstance(request, StabilitySearch):
        bracket = (0.1, 0.101) if request.by_runs else (None, None)
        return SceneLimits((MeasuredLimit("unstable", 0.1, *bracket, "of h omega = 2"),))
    if isinstance(request, ParameterFit):
        fit = Identified(request.parameter, 0.3, 0.3, request.low, request.high, None, {})
        fitted = ("displacement",)
        return Identification(
            request.scene, request.method, 1e-3, fitted, 1, (fit,), 0.0, 0.0, 1
        )
    if isinstance(request, GradientSearch):
        tried = TriedDifference(1e-3, 1.0, 0.0, 0.0, 1e-9, 1e-9)
        ways = [Gradient(of, request.by, "central", 1.0, 1e-3, 1.0, 0.0) for of in request.of]
        return Gradients(tuple(replace(way, tried=(tried,), cost=2.0) for way in ways))
    if isinstance(request, LongRunSearch):
        return MeasuredLongRun(0.05, 2.8, None, {0.01: 10.0}, 60.0, "not within 1200 steps")
    if isinstance(request, StepRun):
        return _measured(_posed(request.scene).scene, request.method, request.step)
    if isinstance(request, DrawingRequest):
        # The start alone is run: what observables do not show stays there.
        return replace(request, duration=1e-2).answer(find_method(request.method))
    if not isinstance(request, ExtraRun):
        raise AssertionError(f"the quick profile fits its own orders: {request}")
    case = _posed(request.scene)
    times = np.linspace(0.0, request.duration or case.scene.duration, SAMPLES)
    channels = {"contacts": np.full(SAMPLES, 3.0), "vertical_displacement": np.zeros(SAMPLES)}
    exact = case.reference.observe(times)
    seen = {name: values + ERROR for name, values in exact.items()}
    return Trajectory(times, seen, channels, steps=SAMPLES)


def _steps(scene, method, most):
    """The steps that a convergence study runs, coarse to fine."""
    beside = steps_beside(scene, method, most)
    return sorted((*chosen_step_sizes(scene, method, most), *beside), reverse=True)


def _convergence(plan):
    """A made-up study of every pair: errors of first order, as predicted."""
    found = []
    for scene, method in pairs(plan.scenes, plan.methods):
        runs = tuple(
            _measured(scene, method.name, step)
            for step in _steps(scene, method, most_steps(scene, plan.profile))
        )
        beside = steps_beside(scene, method, most_steps(scene, plan.profile))
        found.append(ConvergenceStudy(scene.name, method.name, runs, beside=beside))
    return tuple(found)


def _measured(scene, method, step):
    """A run with an error of first order, as predicted."""
    names = [observable.name for observable in system_of(scene).observables]
    predicted = Prediction(step, step, {1: step}, 0.0)
    error = ObservedError(step, step, 1e-16, 1.0, predicted=predicted)
    return Measurement(
        scene.name,
        method,
        step,
        "done",
        steps=1,
        duration=scene.duration,
        errors=dict.fromkeys(names, error),
    )
