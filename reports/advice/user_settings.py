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
from plumbob.reports.judge.verdict import Judgement

HERE = "mujoco/"  # methods that are other settings of the user's own engine


@dataclass(frozen=True)
class Instead:
    """What to use in place of a setting: in the user's engine, and in any."""

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
    judgement: Judgement  # on all steps that were run
    finest: tuple[float, float] | None  # the smallest step [s] that was run, and the error there
    at_equal_accuracy: Instead  # the cheapest with an error no larger
    better: Instead  # the most accurate that costs no more


def user_results(study: Study, judged: Judgements) -> tuple[UserResult, ...]:
    """What a study, with its verdicts, says of the user's settings, a scene each; scenes that they
    did not run are left out."""
    if all(method.name != USER_METHOD for method in study.methods):
        return ()
    others = {m.name: m for m in study.methods if m.name != USER_METHOD}
    found = {scene.name: points(study, scene.name) for scene in study.scenes}
    rest = replace(
        study,
        methods=tuple(others.values()),
        convergence=tuple(
            c
            for c in study.convergence
            if c.method in others
            and trusted(judged, c.scene, of_method(found[c.scene], others[c.method]), c.method)
        ),
    )
    return tuple(
        _of_scene(study, rest, c, judged[c.scene, USER_METHOD].whole)
        for c in study.convergence
        if c.method == USER_METHOD and c.measurements
        if c.measurements[0].status in ("done", "diverged")
    )


def _of_scene(study: Study, rest: Study, found: ConvergenceStudy, judged: Judgement) -> UserResult:
    own = found.measurements[0]
    about = study.quantities(found.scene)
    first = replace(about[0], scale=1.0)  # in its own unit
    unit = next(o.unit for o in study.observables(found.scene) if o.name == first.observable)
    relative = error_of(own, about)
    rest = replace(
        rest, convergence=tuple(c for c in rest.convergence if not _same(c, own, first.observable))
    )
    prices = [p.ns_per_second for p in points(study, found.scene) if p.method == USER_METHOD]
    price = prices[0] if prices else math.inf
    last = next((m for m in reversed(found.measurements) if m.status == "done"), None)
    return UserResult(
        found.scene,
        first.observable,
        unit,
        own.step,
        error_of(own, (first,)),
        relative,
        price,
        judged,
        (last.step, error_of(last, (first,))) if last and last is not own else None,
        _at_equal_accuracy(rest, found.scene, relative),
        _better(rest, found.scene, relative, price),
    )


def _same(other: ConvergenceStudy, own: Measurement, leading: str) -> bool:
    """Whether another method of the user's engine does to the last bits what the user's setting
    does: it is that very setting, by another name."""
    if own.status != "done" or other.scene != own.scene or not other.method.startswith(HERE):
        return False
    error = own.errors[leading].end
    return any(
        m.step == own.step and m.status == "done"
        and math.isclose(m.errors[leading].end, error, rel_tol=1e-12)
        for m in other.measurements
    )  # fmt: skip


def _at_equal_accuracy(rest: Study, scene: str, error: float) -> Instead:
    # Beside a run that diverged any error at all is as good.
    within = min(max(error, sys.float_info.min), sys.float_info.max)
    found = cheapest(rest, scene, within)
    return Instead(
        next((c for c in found.by_engine if c.method.startswith(HERE)), None), found.choice
    )


def _better(rest: Study, scene: str, error: float, price: float) -> Instead:
    methods = {m.name: m for m in rest.methods if m.scheme.integrator != EXACT and not m.surrogate}
    scale = rest.quantities(scene)[0].scale
    found = [
        p
        for p in points(rest, scene)
        if p.method in methods and p.ns_per_second <= price and p.error < error
    ]

    def most_exact(start: str) -> Choice | None:
        best: Point | None = min(
            (p for p in found if p.method.startswith(start)),
            key=lambda p: (p.error, p.ns_per_second),
            default=None,
        )
        return chosen(methods[best.method], best, scale) if best else None

    return Instead(most_exact(HERE), most_exact(""))


def instead(own: Sequence[UserResult]) -> dict[tuple[str, str, float], dict[str, Any]]:
    """The same as plain data, by scene, method and step."""
    return {
        (found.scene, USER_METHOD, found.step): {
            "at_equal_accuracy": asdict(found.at_equal_accuracy),
            "at_no_greater_cost": asdict(found.better),
        }
        for found in own
    }
