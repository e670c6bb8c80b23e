"""Assertions for a user's tests: on one run, or on a convergence study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain, starmap
from typing import Any

from plumbob.analytic.parameters import positive
from plumbob.engines.method import Method, present
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import SEED, ConvergenceStudy, convergence_study
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.study.runner import most_steps
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.judge.expectations import (
    INACCURATE,
    Expectation,
    expected,
    require_accuracy,
    run_surprise,
    surprise,
)
from plumbob.reports.judge.verdict import JudgedMethod, Judgement, judge, judge_method


def check(
    scene: str,
    method: str,
    step: float | None = None,
    changes: Mapping[str, Any] | None = None,
    *,
    within: float | None = None,
    expect: str | None = None,
) -> Judgement:
    """Judges `scene` with `method` and returns the judgement; raises AssertionError if the verdict
    is not the declared one. With `step` [s] (or relative tolerance) it judges one run, as
    `run_surprise` does; without, it runs the convergence study of the quick profile, as `plumbob
    validate` does. If `expect` is given, it replaces the declared verdict. If `within` is given,
    the relative error at `step`, or at the finest step, must not exceed it. `changes` replaces
    parameters of the scene. The error's text has the errors and the terms of their tolerances.
    Raises ParameterError for an unknown name or a number out of range.

    >>> check("cone-pendulum/rotating-base", "ode/rk4", step=1e-3).verdict
    'predicted'
    """
    __tracebackhide__ = True  # pytest shows the line of the user's test alone
    if within is not None:
        positive("within", within)
    chosen_scene = find_scene(scene, changes)
    chosen_method = find_method(method)
    if step is None:
        study, judged = judged_runs(chosen_scene, chosen_method, "quick")
        judgement = judged.whole
        rows = tuple(zip(study.measurements, judged.runs, strict=True))
        message = surprise(chosen_scene, chosen_method, judgement)
    else:
        case = case_of(chosen_scene)
        run, _ = measure(case, chosen_method, step)
        judgement = judge(run, case.system, chosen_method, case.system.quantities(case))
        rows = ((run, judgement),)
        message = run_surprise(chosen_scene, chosen_method, judgement)
    expectation = expected(chosen_scene.name, chosen_method.name)
    if within is not None:
        judgement = require_accuracy(judgement, within)
    if expect is not None:
        message = f"{judgement.verdict}, expected {expect}"
        if judgement.verdict == present(expect):
            message = ""
    elif judgement.verdict == "inaccurate":
        message = INACCURATE
    elif within is None or not judgement.errors:
        message = _no_proof(judgement, expectation) or message
    if not message:
        return judgement
    reason = judgement.reason or expectation.reason or "within tolerance"
    at_step = "" if step is None else f" at {step:g}"
    heading = f"{chosen_scene.name} with {chosen_method.name}{at_step}: {message} ({reason})"
    raise AssertionError("\n".join(chain([heading], *starmap(_run_lines, rows))))


def _no_proof(judgement: Judgement, expectation: Expectation) -> str:
    """Message if a verdict proves nothing about the engine and is not a declared one; else empty.
    `surprise` lets a step outside the asymptotic range and a missing engine pass. A user's test
    must not: if it passed without the engine, it would prove nothing either."""
    proves_nothing = judgement.verdict in ("pre-asymptotic", "missing")
    if not proves_nothing or expectation.allows(judgement):
        return ""
    return f"{judgement.verdict}, expected {expectation.verdict}"


def judged_runs(
    scene: Scene, method: Method, profile: str
) -> tuple[ConvergenceStudy, JudgedMethod]:
    """Runs a scene with a method at all step sizes of a profile, as `plumbob validate` does;
    returns the study and its verdicts."""
    study = convergence_study(scene, method, most_steps(scene, profile), seed=SEED)
    case = case_of(scene)
    return study, judge_method(study, case.system, method, case.system.quantities(case))


def _run_lines(run: Measurement, judgement: Judgement) -> Iterator[str]:
    """Yields the errors of a run as lines of text, with the terms of their tolerances."""
    yield f"  at {run.step:g}: {judgement.verdict}"
    for name, error in run.errors.items():
        yield f"  {name}: error {error.largest:.3e}"
        bound = judgement.tolerances.get(name)
        if bound is None:
            continue
        for term in bound.terms:
            yield f"    {term.value:.3e} {bound.unit}  {term.name}: {term.reason}"
