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
from plumbob.reports.advice.advice import Question, advise, full_model_choices
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.work_precision import error_or_infinity, work_precision_points
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Verdict

USER_ENGINE = "mujoco/"  # prefix of the methods of the user's own engine


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
    results = []
    for series in study.convergence:
        if series.method != USER_METHOD or not series.measurements:
            continue
        if series.measurements[0].status in ("done", "diverged"):
            results.append(_user_result(study, scenes[series.scene], series, judged))
    return tuple(results)


def _user_result(
    study: Study, scene: Scene, series: ConvergenceStudy, judged: Judgements
) -> UserResult:
    """Returns the result of the user's settings on one scene."""
    run = series.measurements[0]
    quantities = study.quantities(scene.name)
    # With the scale 1 the error of the leading quantity is in its own unit.
    leading = replace(quantities[0], scale=1.0)
    units = {o.name: o.unit for o in study.observables(scene.name)}
    relative = error_or_infinity(run, quantities)
    cost = math.inf
    for point in work_precision_points(study, scene.name):
        if point.method == USER_METHOD:
            cost = point.ns_per_second
            break
    done = [m for m in series.measurements if m.status == "done"]
    finest = None
    if done and done[-1] is not run:
        finest = done[-1].step, error_or_infinity(done[-1], (leading,))
    same_setting = {
        other.method
        for other in study.convergence
        if _is_user_setting(other, run, leading.observable)
    }
    others = tuple(method for method in study.methods if method.name not in same_setting)
    # Any finite error is better than a run that diverged.
    allowed = min(max(relative, sys.float_info.min), sys.float_info.max)
    asked = Question(scene.name, (scene,), others, allowed)
    choices = full_model_choices(asked, study, judged)
    better = [c for c in choices if c.ns_per_second <= cost and c.error < relative]
    better.sort(key=lambda c: (c.error, c.ns_per_second))
    equal = advise(asked, study, judged=judged).recommendation.by_engine
    return UserResult(
        scene=scene.name,
        observable=leading.observable,
        unit=units[leading.observable],
        step=run.step,
        error=error_or_infinity(run, (leading,)),
        relative=relative,
        ns_per_second=cost,
        verdict=judged[scene.name, USER_METHOD].whole.verdict,
        finest=finest,
        at_equal_accuracy=_first_choices(equal),
        better=_first_choices(better),
    )


def _is_user_setting(series: ConvergenceStudy, run: Measurement, leading: str) -> bool:
    """Whether a method is the user's setting on a scene. It is if it bears the user's name, or if
    it is a method of the user's engine whose error at the step of the user's `run` agrees to 1e-12.
    `leading` is the observable of that error."""
    if series.scene != run.scene:
        return False
    if series.method == USER_METHOD:
        return True
    if run.status != "done" or not series.method.startswith(USER_ENGINE):
        return False
    user_error = run.errors[leading].end
    same_step = (m for m in series.measurements if m.step == run.step and m.status == "done")
    errors = (measurement.errors[leading].end for measurement in same_step)
    return any(math.isclose(error, user_error, rel_tol=1e-12) for error in errors)


def _first_choices(choices: Sequence[Choice]) -> Instead:
    """Returns the first of all choices, and the first choice in the user's engine."""
    in_user_engine = (c for c in choices if c.method.startswith(USER_ENGINE))
    return Instead(next(in_user_engine, None), next(iter(choices), None))
