"""JSON records of runs, for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.order import Order
from plumbob.engines.study.repeating import RepeatedPair
from plumbob.engines.study.results import Study
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Judgement


def run_record(
    method: Method,
    run: Measurement,
    judgement: Judgement,
    order: Order | None,
    cost: Cost | None,
) -> dict[str, Any]:
    """Returns the record of one run: its errors by observable (SI), their bounds, verdict and
    cost."""
    ns_per_step = None
    if cost:
        ns_per_step = cost.ns_per_step
    elif run.steps:
        ns_per_step = 1e9 * run.seconds / run.steps
    wall_seconds = ns_per_step * 1e-9 * run.steps if ns_per_step else None
    errors = run.errors
    tolerances = judgement.tolerances
    budget = {}
    for name, bound in tolerances.items():
        budget[name] = {term.name: term.value for term in bound.terms}
    return {
        "scene": run.scene,
        "method": run.method,
        "step": run.step,
        "relative_error": judgement.errors.get(run.step),
        "errors": {name: error.largest for name, error in errors.items()},
        "errors_at_end": {name: error.end for name, error in errors.items()},
        "predicted": {n: e.predicted.end for n, e in errors.items() if e.predicted},
        "off_prediction": {n: e.predicted.difference for n, e in errors.items() if e.predicted},
        "left_open": {n: e.left_open for n, e in errors.items() if e.predicted},
        "tolerances": {name: bound.bound for name, bound in tolerances.items()},
        "budget": budget,
        "invariants": run.invariants,
        "verdict": judgement.verdict,
        "expected": wanted_verdict(run.scene, method.name),
        "reason": judgement.reason,
        "order": order and {"slope": order.slope, "low": order.low, "high": order.high},
        "steps": run.steps,
        "ns_per_step": ns_per_step,
        "real_time_factor": run.duration / wall_seconds if wall_seconds else None,
        "compile_seconds": run.compile_seconds,
        "warnings": run.warnings,
    }


def wanted_verdict(scene: str, method: str) -> str | None:
    """Returns the verdict that is expected of a method on a scene; None for a user's settings."""
    return None if method == USER_METHOD else expected(scene, method).verdict


def study_records(
    study: Study,
    judged: Judgements,
    results: Sequence[UserResult] = (),
    repeated: Sequence[RepeatedPair] = (),
) -> list[dict[str, Any]]:
    """Returns one record a run, including the runs at drawn steps. If the user's own settings were
    run, the record at their own step also has the recommended replacements. If pairs were repeated,
    their records say whether all bits of the pair were the same."""
    same_bits = {(pair.scene, pair.method): pair.difference is None for pair in repeated}
    user_results = {result.scene: result for result in results}
    methods = {method.name: method for method in study.methods}
    records = []
    for series in study.convergence:
        verdicts = judged[series.scene, series.method]
        cost = study.costs.get((series.scene, series.method))
        runs = list(zip(series.measurements, verdicts.runs, strict=True))
        if series.drawn is not None and verdicts.whole.drawn is not None:
            runs.append((series.drawn, verdicts.whole.drawn))
        for run, judgement in runs:
            record = run_record(methods[series.method], run, judgement, series.order, cost)
            record["drawn"] = run is series.drawn
            if repeated:
                record["same_bits"] = same_bits[series.scene, series.method]
            result = None
            if series.method == USER_METHOD:
                result = user_results.get(series.scene)
            if result and result.step == run.step:
                record["at_equal_accuracy"] = result.at_equal_accuracy
                record["at_no_greater_cost"] = result.better
            records.append(record)
    return records
