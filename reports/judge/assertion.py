"""Assertions for a user's tests: on one run, or on a convergence study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    accurate,
    expected,
    run_surprise,
    surprise,
)
from plumbob.reports.judge.verdict import Judged, Judgement, judge, judged


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
    is not the declared one. With `step` [s] (or relative tolerance) it judges one run; without, it
    runs the convergence study of the quick profile, as `plumbob validate` does. If `expect` is
    given, it replaces the declared verdict. If `within` is given, the relative error at `step`, or
    at the finest step, must not exceed it. `changes` replaces parameters of the scene. At one step,
    a known limit's error must lie within a factor of two of the range that its convergence study
    spans. The error's text has the errors and the terms of their tolerances. Raises ParameterError
    for an unknown name or a number out of range.

    >>> check("cone-pendulum/rotating-base", "ode/rk4", step=1e-3).verdict
    'predicted'
    """
    if within is not None:
        positive("within", within)
    chosen = find_scene(scene, changes)
    how = find_method(method)
    if step is None:
        runs, both = judged_runs(chosen, how, "quick")
        judgement = both.whole
        rows = tuple(zip(runs.measurements, both.runs, strict=True))
        why = surprise(chosen, how, judgement)
    else:
        case = case_of(chosen)
        run, _ = measure(case, how, step)
        judgement = judge(run, case.system, how, case.system.quantities(case))
        rows = ((run, judgement),)
        why = run_surprise(chosen, how, judgement)
    if within is not None:
        judgement = accurate(judgement, within)
        why = INACCURATE if judgement.verdict == "inaccurate" else why
    wanted = expected(chosen.name, how.name)
    # A step outside the asymptotic range and a missing engine claim nothing: a test that they
    # cannot fail would claim nothing either.
    nothing = judgement.verdict in ("pre-asymptotic", "missing")
    met = within is not None and bool(judgement.errors)
    if nothing and not met and not wanted.allows(judgement):
        why = f"{judgement.verdict}, expected {wanted.verdict}"
    if expect is not None:
        why = f"{judgement.verdict}, expected {expect}"
        why = "" if judgement.verdict == present(expect) else why
    if not why:
        return judgement
    reason = judgement.reason or wanted.reason or "within tolerance"
    at = "" if step is None else f" at {step:g}"
    lines = [f"{chosen.name} with {how.name}{at}: {why} ({reason})"]
    for measured, verdict in rows:
        lines += _lines(measured, verdict)
    raise AssertionError("\n".join(lines))


def judged_runs(scene: Scene, method: Method, profile: str) -> tuple[ConvergenceStudy, Judged]:
    """Runs a scene with a method at all step sizes of a profile, as `plumbob validate` does;
    returns the study and its verdicts."""
    runs = convergence_study(scene, method, most_steps(scene, profile), seed=SEED)
    case = case_of(scene)
    return runs, judged(runs, case.system, method, case.system.quantities(case))


def _lines(run: Measurement, judgement: Judgement) -> Iterator[str]:
    """Yields the errors of a run as lines of text, with the terms of their tolerances."""
    yield f"  at {run.step:g}: {judgement.verdict}"
    for name, error in run.errors.items():
        yield f"  {name}: error {error.largest:.3e}"
        if bound := judgement.tolerances.get(name):
            for term in bound.terms:
                yield f"    {term.value:.3e} {bound.unit}  {term.name}: {term.reason}"
