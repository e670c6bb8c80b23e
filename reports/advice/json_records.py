"""JSON records of runs, for other programs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.order import Order
from plumbob.engines.study.results import Study
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Judgement


def record(
    method: Method,
    run: Measurement,
    judgement: Judgement,
    order: Order | None,
    cost: Cost | None,
) -> dict[str, Any]:
    """Returns the record of one run: its errors by observable (SI), their bounds, verdict and
    cost."""
    per_step = (
        cost.ns_per_step if cost else (1e9 * run.seconds / run.steps if run.steps else None)
    )
    wanted = None if method.name == USER_METHOD else expected(run.scene, method.name).verdict
    wall = per_step * 1e-9 * run.steps if per_step else None
    return {
        "scene": run.scene,
        "method": run.method,
        "step": run.step,
        "relative_error": judgement.errors.get(run.step),
        "errors": {name: error.largest for name, error in run.errors.items()},
        "errors_at_end": {name: error.end for name, error in run.errors.items()},
        "predicted": {n: e.predicted.end for n, e in run.errors.items() if e.predicted},
        "tolerances": {name: bound.bound for name, bound in judgement.tolerances.items()},
        "budget": {
            name: {term.name: term.value for term in bound.terms}
            for name, bound in judgement.tolerances.items()
        },
        "invariants": run.invariants,
        "verdict": judgement.verdict,
        "expected": wanted,
        "reason": judgement.reason,
        "order": order and {"slope": order.slope, "low": order.low, "high": order.high},
        "steps": run.steps,
        "ns_per_step": per_step,
        "real_time_factor": run.duration / wall if wall else None,
        "compile_seconds": run.compile_seconds,
        "warnings": run.warnings,
    }


def records(
    study: Study, judged: Judgements, results: Sequence[UserResult] = ()
) -> list[dict[str, Any]]:
    """Returns one record a run, including the runs at drawn steps. If the user's own settings were
    run, the record at their own step also has the recommended replacements."""
    better = {result.scene: result for result in results}
    by_method = {method.name: method for method in study.methods}
    rows = []
    for c in study.convergence:
        both = judged[c.scene, c.method]
        cost = study.costs.get((c.scene, c.method))
        runs = list(zip(c.measurements, both.runs, strict=True))
        if c.drawn is not None and both.whole.drawn is not None:
            runs.append((c.drawn, both.whole.drawn))
        for m, judgement in runs:
            row = record(by_method[c.method], m, judgement, c.order, cost)
            rows.append(row | {"drawn": m is c.drawn})
            of = better.get(c.scene) if c.method == USER_METHOD else None
            if of and of.step == m.step:
                rows[-1]["at_equal_accuracy"] = of.at_equal_accuracy
                rows[-1]["at_no_greater_cost"] = of.better
    return rows


def plain(value: Any) -> Any:
    """Returns `value` as plain JSON data: arrays as lists, dataclasses by their fields, numbers
    that are not finite as null."""

    def known(of: Any) -> Any:
        if is_dataclass(of):
            return {field.name: getattr(of, field.name) for field in fields(of)}
        return of.tolist() if hasattr(of, "tolist") else dict(of)

    return json.loads(json.dumps(value, default=known), parse_constant=lambda _: None)
