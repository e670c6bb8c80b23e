"""A run, or a convergence study, as an assertion, for a test of one's own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.study.runner import most_steps
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.expectations import as_expected, expected, run_as_expected
from plumbob.reports.judge.verdict import Judgement, Verdict, judge, judged


def check(
    scene: str,
    method: str,
    step: float | None = None,
    changes: Mapping[str, Any] | None = None,
    *,
    expect: Verdict | None = None,
) -> Judgement:
    """Run `scene` with `method` at `step` [s] (or relative tolerance), or without one at the step
    sizes of the quick profile, as `plumbob validate` does, and return the judgement. Raises
    AssertionError with the table when the verdict is not as declared, or not `expect` where that is
    given, and ParameterError for a name or number that does not fit.

    >>> check("cone-pendulum/rotating-base", "ode/rk4", step=1e-3).verdict
    'pass'
    """
    chosen, how = find_scene(scene, changes), find_method(method)
    case = case_of(chosen)
    if step is None:
        runs = convergence_study(chosen, how, most_steps(chosen, "quick"))
        both = judged(runs, case.system, how)
        judgement, found = both.whole, tuple(zip(runs.measurements, both.runs, strict=True))
        good = as_expected(chosen, how, judgement)
    else:
        one, _ = measure(case, how, step)
        judgement = judge(one, case.system, how)
        found = ((one, judgement),)
        # A test that a step outside the asymptotic range cannot fail would claim nothing.
        claims = judgement.verdict != "pre-asymptotic" or expected(chosen.name, how.name).allows(
            judgement
        )
        good = claims and run_as_expected(how, chosen.name, judgement)
    if judgement.verdict == "missing":
        good = False
    if judgement.verdict == expect if expect is not None else good:
        return judgement
    wanted = expected(chosen.name, how.name)
    reason = judgement.reason or wanted.reason or "within tolerance"
    at = "" if step is None else f" at {step:g}"
    head = f"{chosen.name} with {how.name}{at}: {judgement.verdict}"
    lines = [f"{head}, expected {expect or wanted.verdict} ({reason})"]
    for measured, verdict in found:
        lines += _lines(measured, verdict)
    raise AssertionError("\n".join(lines))


def _lines(found: Measurement, judgement: Judgement) -> Iterator[str]:
    """Errors of a run, with the terms of their tolerances."""
    yield f"  at {found.step:g}: {judgement.verdict}"
    for name, error in found.errors.items():
        yield f"  {name}: error {error.largest:.3e}"
        if (bound := judgement.tolerances.get(name)) is not None:
            for term in bound.terms:
                yield f"    {term.value:.3e} {bound.unit}  {term.name}: {term.reason}"
