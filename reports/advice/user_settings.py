"""Results of a user's own settings in a study, with choices that are more accurate or cheaper."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.advice import Question, advise, every_choice
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.work_precision import error_of, points
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Verdict

HERE = "mujoco/"  # prefix of the methods of the user's own engine


@dataclass(frozen=True)
class Instead:
    """A recommendation in place of the user's settings: in the user's engine, and in any engine."""

    here: Choice | None
    anywhere: Choice | None


@dataclass(frozen=True)
class UserResult:
    """The result of the user's settings on one scene, with better choices from the same study."""

    scene: str
    observable: str
    unit: str
    step: float  # [s] step of the user's settings
    error: float  # error of the observable at that step; infinite if the run diverged
    relative: float  # largest relative error of the quantities of interest in that run
    ns_per_second: float  # [ns] wall time per simulated second; infinite if the run diverged
    verdict: Verdict  # verdict on all steps that were run
    # The smallest step [s] that was run, and the observable's error there; None: the user's step.
    finest: tuple[float, float] | None
    at_equal_accuracy: Instead  # the cheapest choice with an error no larger
    better: Instead  # the most accurate choice that costs no more


def user_results(study: Study, judged: Judgements) -> tuple[UserResult, ...]:
    """Returns a study's results for the user's settings, one a scene. A scene without a run of
    these settings is left out."""
    scenes = {scene.name: scene for scene in study.scenes}
    return tuple(
        _of_scene(study, scenes[c.scene], c, judged)
        for c in study.convergence
        if c.method == USER_METHOD and c.measurements
        if c.measurements[0].status in ("done", "diverged")
    )


def _of_scene(
    study: Study, scene: Scene, runs: ConvergenceStudy, judged: Judgements
) -> UserResult:
    """Returns the result of the user's settings on one scene."""
    run = runs.measurements[0]
    about = study.quantities(scene.name)
    first = replace(about[0], scale=1.0)  # its error is in its own unit
    unit = next(o.unit for o in study.observables(scene.name) if o.name == first.observable)
    relative = error_of(run, about)
    prices = [p.ns_per_second for p in points(study, scene.name) if p.method == USER_METHOD]
    price = prices[0] if prices else math.inf
    last = next((m for m in reversed(runs.measurements) if m.status == "done"), None)
    same = {c.method for c in study.convergence if _same(c, run, first.observable)}
    others = tuple(m for m in study.methods if m.name not in same)
    # Any finite error is better than a run that diverged.
    within = min(max(relative, sys.float_info.min), sys.float_info.max)
    asked = Question(scene.name, (scene,), others, within)
    cheaper = [c for c in every_choice(asked, study, judged) if c.ns_per_second <= price]
    better = [c for c in cheaper if c.error < relative]
    better.sort(key=lambda c: (c.error, c.ns_per_second))
    equal = advise(asked, study, judged=judged).recommendation.by_engine
    return UserResult(
        scene.name,
        first.observable,
        unit,
        run.step,
        error_of(run, (first,)),
        relative,
        price,
        judged[scene.name, USER_METHOD].whole.verdict,
        (last.step, error_of(last, (first,))) if last and last is not run else None,
        _first(equal),
        _first(better),
    )


def _same(other: ConvergenceStudy, run: Measurement, leading: str) -> bool:
    """Whether a method is the user's setting on a scene. It is if it bears the user's name, or if
    it is a method of the user's engine whose error at the same step agrees to 1e-12."""
    if other.scene != run.scene:
        return False
    if other.method == USER_METHOD:
        return True
    if run.status != "done" or not other.method.startswith(HERE):
        return False
    error = run.errors[leading].end
    return any(
        m.step == run.step
        and m.status == "done"
        and math.isclose(m.errors[leading].end, error, rel_tol=1e-12)
        for m in other.measurements
    )


def _first(choices: Sequence[Choice]) -> Instead:
    """Returns the first of all choices, and the first choice in the user's engine."""
    here = (c for c in choices if c.method.startswith(HERE))
    return Instead(next(here, None), next(iter(choices), None))
