"""A user's own settings in a study: their error at their own step, and what would be better."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import EXACT, Choice, cheapest, chosen, trusted
from plumbob.reports.advice.work_precision import Point, error_of, of_method, points
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Verdict

HERE = "mujoco/"  # methods that are other settings of the user's own engine


@dataclass(frozen=True)
class Instead:
    """A recommendation in place of a setting: in the user's engine, and in any."""

    here: Choice | None
    anywhere: Choice | None


@dataclass(frozen=True)
class UserResult:
    """One scene with the user's settings, and what the same study knows to be better."""

    scene: str
    observable: str
    unit: str
    step: float  # [s], the user's own
    error: float  # of the observable at that step; infinite where the run diverged
    relative: float  # the error of that run, of all quantities of interest
    ns_per_second: float  # [ns] of wall time per simulated second; infinite where it diverged
    verdict: Verdict  # on all steps that were run
    finest: tuple[float, float] | None  # the smallest step [s] that was run, and the error there
    at_equal_accuracy: Instead  # the cheapest with an error no larger
    better: Instead  # the most accurate that costs no more


def user_results(study: Study, judged: Judgements) -> tuple[UserResult, ...]:
    """A study's results for the user's settings, a scene each; scenes that they did not run are
    left out."""
    if all(method.name != USER_METHOD for method in study.methods):
        return ()
    others = {m.name: m for m in study.methods if m.name != USER_METHOD}
    by_scene = {scene.name: points(study, scene.name) for scene in study.scenes}
    other = replace(
        study,
        methods=tuple(others.values()),
        convergence=tuple(
            c
            for c in study.convergence
            if c.method in others
            and trusted(judged, c.scene, of_method(by_scene[c.scene], others[c.method]), c.method)
        ),
    )
    return tuple(
        _of_scene(study, other, c, judged[c.scene, USER_METHOD].whole.verdict)
        for c in study.convergence
        if c.method == USER_METHOD and c.measurements
        if c.measurements[0].status in ("done", "diverged")
    )


def _of_scene(study: Study, other: Study, runs: ConvergenceStudy, verdict: Verdict) -> UserResult:
    run = runs.measurements[0]
    about = study.quantities(runs.scene)
    first = replace(about[0], scale=1.0)  # in its own unit
    unit = next(o.unit for o in study.observables(runs.scene) if o.name == first.observable)
    relative = error_of(run, about)
    other = replace(
        other,
        convergence=tuple(c for c in other.convergence if not _same(c, run, first.observable)),
    )
    prices = [p.ns_per_second for p in points(study, runs.scene) if p.method == USER_METHOD]
    price = prices[0] if prices else math.inf
    last = next((m for m in reversed(runs.measurements) if m.status == "done"), None)
    return UserResult(
        runs.scene,
        first.observable,
        unit,
        run.step,
        error_of(run, (first,)),
        relative,
        price,
        verdict,
        (last.step, error_of(last, (first,))) if last and last is not run else None,
        _at_equal_accuracy(other, runs.scene, relative),
        _better(other, runs.scene, relative, price),
    )


def _same(other: ConvergenceStudy, run: Measurement, leading: str) -> bool:
    """Whether another method of the user's engine gives the same bits as the user's setting: it is
    the same setting under another name."""
    if run.status != "done" or other.scene != run.scene or not other.method.startswith(HERE):
        return False
    error = run.errors[leading].end
    return any(
        m.step == run.step and m.status == "done"
        and math.isclose(m.errors[leading].end, error, rel_tol=1e-12)
        for m in other.measurements
    )  # fmt: skip


def _at_equal_accuracy(other: Study, scene: str, error: float) -> Instead:
    # Any finite error is better than a run that diverged.
    within = min(max(error, sys.float_info.min), sys.float_info.max)
    best = cheapest(other, scene, within)
    return Instead(
        next((c for c in best.by_engine if c.method.startswith(HERE)), None), best.choice
    )


def _better(other: Study, scene: str, error: float, price: float) -> Instead:
    methods = {m.name: m for m in other.methods if m.scheme.integrator != EXACT and not m.surrogate}
    scale = other.quantities(scene)[0].scale
    cheaper = [
        p
        for p in points(other, scene)
        if p.method in methods and p.ns_per_second <= price and p.error < error
    ]

    def most_exact(start: str) -> Choice | None:
        best: Point | None = min(
            (p for p in cheaper if p.method.startswith(start)),
            key=lambda p: (p.error, p.ns_per_second),
            default=None,
        )
        return chosen(methods[best.method], best, scale) if best else None

    return Instead(most_exact(HERE), most_exact(""))


def instead(results: Sequence[UserResult]) -> dict[tuple[str, str, float], dict[str, Any]]:
    """The same as plain data, by scene, method and step."""
    return {
        (result.scene, USER_METHOD, result.step): {
            "at_equal_accuracy": asdict(result.at_equal_accuracy),
            "at_no_greater_cost": asdict(result.better),
        }
        for result in results
    }
