"""A stored study as columns: its pairs, runs, errors, budgets, parameters and recommendations."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.extra_runs import TrimmingRun
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.reports.advice.json_records import study_records, wanted_verdict
from plumbob.reports.advice.recommend import Choice, Recommendation
from plumbob.reports.columns.columns import Columns, columns_of
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.judge.verdict import Judgement
from plumbob.reports.records.page_records import records_of
from plumbob.reports.records.plain_data import FOR_JSON, plain
from plumbob.reports.view.method_results import Results, results_of
from plumbob.reports.view.site.views import DERIVATIVES_TEMPLATE

ColumnRow = dict[str, Any]
RunRecord = Mapping[str, Any]
RUN_KEYS = ("scene", "method", "step", "drawn", "verdict", "expected", "relative_error")


def run_columns(records: Sequence[RunRecord]) -> Columns:
    """Returns a row for each run from records as --json prints them."""
    rows = [{**record, "warnings": "; ".join(record["warnings"])} for record in records]
    return columns_of("runs", rows)


def error_columns(
    records: Sequence[RunRecord], units: Mapping[tuple[str, str], str]
) -> Columns:
    """Returns a row for each observable of each run from records as --json prints them. `units` are
    {(scene, observable): unit}."""
    rows = []
    for record in records:
        shared = {key: record.get(key) for key in (*RUN_KEYS, "steps", "ns_per_step")}
        rows += [{**shared, **row} for row in _observable_rows(record, units)] or [shared]
    return columns_of("errors", rows)


def _observable_rows(
    record: RunRecord, units: Mapping[tuple[str, str], str]
) -> Iterator[ColumnRow]:
    """Yields the errors of each observable of a run."""
    for name, error in record["errors"].items():
        yield {
            "observable": name,
            "unit": units.get((record["scene"], name), ""),
            "error": error,
            "error_at_end": record["errors_at_end"].get(name),
            "predicted_at_end": record["predicted"].get(name),
            "off_prediction": record["off_prediction"].get(name),
            "left_open": record["left_open"].get(name),
            "tolerance": record["tolerances"].get(name),
        }


class StudyColumns:
    """A study as tables; each is computed when it is first asked for.

    `pairs` has a row for each method on each scene, `runs` for each run, `errors` for each
    observable of each run, `budgets` for each term of their tolerances, `parameters` for each
    number of a scene, `recommendations` for each wanted error, `trims` for each trimmed model, and
    `derivatives` for each way to each derivative."""

    def __init__(self, study: Study | None, judged: Judgements | None = None) -> None:
        self._stored = study
        self._given = judged

    @property
    def study(self) -> Study:
        """The study; raises ParameterError if there is none."""
        if self._stored is None:
            raise ParameterError("path", None, "where `plumbob validate` has stored a study")
        return self._stored

    @cached_property
    def _judged(self) -> Judgements:
        """The verdicts on the study."""
        return judge_study(self.study) if self._given is None else self._given

    @cached_property
    def _records(self) -> list[ColumnRow]:
        """A record of each run, as --json prints it."""
        return study_records(self.study, self._judged)

    @cached_property
    def _units(self) -> dict[tuple[str, str], str]:
        """{(scene, observable): unit}."""
        scenes = [scene.name for scene in self.study.scenes]
        observed = [(name, self.study.observables(name)) for name in scenes]
        return {(name, o.name): o.unit for name, observables in observed for o in observables}

    @cached_property
    def runs(self) -> Columns:
        """A row for each run."""
        return run_columns(self._records)

    @cached_property
    def errors(self) -> Columns:
        """A row for each observable of each run."""
        return error_columns(self._records, self._units)

    @cached_property
    def budgets(self) -> Columns:
        """A row for each term of the tolerance of each observable of each run. Two terms of a
        tolerance may have the same name."""
        rows = []
        for run, judgement, drawn in self._judged_runs():
            shared = {
                "scene": run.scene,
                "method": run.method,
                "step": run.step,
                "drawn": drawn,
            }
            for name, tolerance in judgement.tolerances.items():
                unit = self._units.get((run.scene, name))
                about = {**shared, "observable": name, "unit": unit}
                for term in tolerance.terms:
                    reason = {"term": term.name, "value": term.value, "reason": term.reason}
                    rows.append(about | reason)
        return columns_of("budgets", rows)

    def _judged_runs(self) -> Iterator[tuple[Measurement, Judgement, bool]]:
        """Yields each run with its verdict, and whether its step was drawn at random."""
        for series in self.study.convergence:
            verdicts = self._judged[series.scene, series.method]
            for run, judgement in zip(series.measurements, verdicts.runs, strict=True):
                yield run, judgement, False
            if series.drawn is not None and verdicts.whole.drawn is not None:
                yield series.drawn, verdicts.whole.drawn, True

    @cached_property
    def trims(self) -> Columns:
        """A row for each timing of a model with and without the features that it can leave out."""
        timed = {r: a for r, a in self.study.extras.items() if isinstance(r, TrimmingRun) and a}
        rows = []
        for run, answer in timed.items():
            about = {"scene": run.scene, "method": run.method, "steps": run.steps}
            cost = self.study.costs.get((run.scene, run.method))
            # A method has one cost on a scene: the timings are scaled to that of the trimmed model.
            scale = cost.ns_per_step / answer.ns_trimmed if cost else 1.0
            names = ("ns_default", "ns_flags", "ns_trimmed")
            costs = {name: scale * getattr(answer, name) for name in names}
            about |= {"saved": answer.saved, "identical": answer.identical}
            rows.append({**about, **costs})
        return columns_of("trims", rows)

    @cached_property
    def derivatives(self) -> Columns:
        """A row for each derivative of a scene's final state by each way."""
        rows = []
        for analysis in self.study.analyses:
            if analysis.template == DERIVATIVES_TEMPLATE and analysis.numbers:
                rows += list(analysis.numbers["records"])
        return columns_of("derivatives", rows)

    @cached_property
    def pairs(self) -> Columns:
        """A row for each method on each scene."""
        methods = {method.name: method for method in self.study.methods}
        series = self.study.convergence
        return columns_of("pairs", [self._pair(s, methods[s.method]) for s in series])

    def _pair(self, series: ConvergenceStudy, method: Method) -> ColumnRow:
        """Returns the row of a method on a scene."""
        key = series.scene, series.method
        judged = self._judged[key].whole
        limit = self.study.step_limit(*key)
        return {
            "scene": series.scene,
            "method": series.method,
            "control": method.control,
            "verdict": judged.verdict,
            "expected": wanted_verdict(*key),
            "reason": judged.reason,
            "nominal_order": method.order,
            **self._orders(series),
            **self._orders_on_pages(key),
            **self._cost(key),
            "largest_step": None if limit is None else limit.step,
        }

    def _orders(self, series: ConvergenceStudy) -> ColumnRow:
        """Returns the observed and the predicted order of a method on a scene."""
        order, predicted = series.order, series.predicted_order
        row = {"predicted_order": predicted and predicted.slope}
        if order is None:
            return row
        ends = {"order_coarsest": order.steps[0], "order_finest": order.steps[-1]}
        slopes = {"order": order.slope, "order_low": order.low, "order_high": order.high}
        return {**row, **slopes, "order_steps": len(order.steps), **ends}

    @cached_property
    def _results(self) -> Results:
        """The results that pages show, by scene and method."""
        return results_of(self.study, records_of(self.study))

    def _orders_on_pages(self, key: tuple[str, str]) -> ColumnRow:
        """Returns the orders of the relative error at the end and of the largest one, which pages
        show beside these errors."""
        row: ColumnRow = {}
        result = self._results[key]
        shown_errors = {"at_end": result.at_end, "of_largest": result.on_the_way}
        for name, shown in shown_errors.items():
            if shown is not None:
                row[f"order_{name}"] = shown.order
                row[f"predicted_order_{name}"] = shown.predicted_order
        return row

    def _cost(self, key: tuple[str, str]) -> ColumnRow:
        """Returns the cost of a step of a method on a scene."""
        cost = self.study.costs.get(key)
        if cost is None:
            return {}
        return {
            "ns_per_step": cost.ns_per_step,
            "ns_low": cost.low,
            "ns_high": cost.high,
            "reference_steps": cost.ratio,
            "compile_seconds": cost.compile_seconds,
        }

    @cached_property
    def parameters(self) -> Columns:
        """A row for each parameter of each scene, and for each number that is exactly known."""
        rows = []
        scenes = records_of(self.study).scenes
        for scene in self.study.scenes:
            exact = scenes[scene.name].exact
            for known, numbers in ((False, scene.parameters), (True, exact and exact.facts)):
                rows += [
                    {"scene": scene.name, "name": name, "exact": known, **_value(value)}
                    for name, value in (numbers or {}).items()
                ]
        return columns_of("parameters", rows)

    @cached_property
    def recommendations(self) -> Columns:
        """A row for each method and step that is named for a wanted error on a scene."""
        rows = []
        for record in records_of(self.study).scenes.values():
            for answer in record.recommendations:
                rows += [_choice(answer, role, choice) for role, choice in _choices(answer)]
        return columns_of("recommendations", rows)


def _value(value: Any) -> ColumnRow:
    """Returns a parameter as a number, if it is one, and as text."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    text = value if isinstance(value, str) else json.dumps(plain(value, FOR_JSON))
    return {"value": value if is_number else None, "text": text}


def _choices(answer: Recommendation) -> Iterator[tuple[str, Choice]]:
    """Yields the choices of a recommendation with their roles."""
    single = {
        "choice": answer.choice,
        "runner-up": answer.runner_up,
        "best": answer.best,
        "surrogate": answer.surrogate,
    }
    yield from ((role, choice) for role, choice in single.items() if choice is not None)
    yield from (("in engine", choice) for choice in answer.by_engine)
    yield from (("default", choice) for choice in answer.defaults)


def _choice(answer: Recommendation, role: str, choice: Choice) -> ColumnRow:
    """Returns the row of a choice."""
    return {
        "scene": answer.scene,
        "wanted": answer.error,
        "wanted_absolute": answer.absolute,
        "observable": answer.observable,
        "unit": answer.unit,
        "role": role,
        "method": choice.method,
        "step": choice.step,
        "error": choice.error,
        "error_absolute": choice.absolute,
        "ns_per_second": choice.ns_per_second,
        "largest_step": choice.limit and choice.limit.step,
    }
