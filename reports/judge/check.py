"""One run as an assertion, for a test of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.verdict import Judgement, judge


def check(
    scene: str, method: str, step: float, changes: Mapping[str, Any] | None = None
) -> Judgement:
    """Run `scene` with `method` at `step` [s] (or relative tolerance) and return its judgement;
    raises AssertionError with the table when the verdict is not as expected, and ParameterError
    for a name or number that does not fit.

    >>> check("cone-pendulum/rotating-base", "ode/rk4", step=1e-3).verdict
    'pass'
    """
    chosen, how = find_scene(scene, changes), find_method(method)
    case = case_of(chosen)
    found, _ = measure(case, how, step)
    judgement = judge(found, case.system, how)
    wanted = expected(chosen.name, how.name)
    if not wanted.allows(judgement):
        reason = judgement.reason or wanted.reason or "within tolerance"
        head = f"{chosen.name} with {how.name} at {step:g}: {judgement.verdict}"
        lines = [f"{head}, expected {wanted.verdict} ({reason})"]
        for name, error in found.errors.items():
            lines.append(f"  {name}: error {error.largest:.3e}")
            if (bound := judgement.tolerances.get(name)) is not None:
                lines += [
                    f"    {term.value:.3e} {bound.unit}  {term.name}: {term.reason}"
                    for term in bound.terms
                ]
        raise AssertionError("\n".join(lines))
    return judgement
