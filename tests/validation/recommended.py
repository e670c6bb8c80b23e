"""Is a recommendation true? Fresh runs at and below its step, and a search for a cheaper one."""

import math
import random
from dataclasses import dataclass, replace

from plumbob.analytic.theory import no_theory
from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.measurement import measure
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import case_of, scenes
from plumbob.reports.advice.advice import Question, advise
from plumbob.reports.advice.recommend import CLOSED_FORM, Choice, may_recommend
from plumbob.reports.advice.work_precision import error_or_infinity
from plumbob.reports.judge.study_verdicts import judge_study

BELOW = (1.0, 0.995, 0.98, 0.96, 0.92, 0.85)  # of the recommended step
CHEAPER = 1.5  # what a cheaper choice would be cheaper by, more than
# times that is more: steps have three digits, and errors at the very bound count too
MORE = 1.02
FINE = 1.04  # ratio of the smaller steps that a cheaper choice has to reach the error at
BESIDE = 17  # of them, down to half: with contacts errors scatter from step to step
LOOSEST, TIGHTEST, TOLERANCES = 0.1, 1e-12, 1.8  # of a search over tolerances, and their ratio


@dataclass(frozen=True)
class Held:
    """A recommendation, its worst error in fresh runs, and what is cheaper and as good."""

    scene: str
    wanted: float
    choice: Choice | None
    worst: (
        float  # over the recommended step and five slightly smaller ones; nan without a choice
    )
    missed: tuple[tuple[str, float, float], ...]  # method, step, how many times cheaper


def random_pairs(count, pattern="*", seed=7):
    """Quick scenes with relative errors between 1e-6 and 3e-2."""
    chosen = scenes(pattern, "quick")
    draw = random.Random(seed)
    return [(draw.choice(chosen), 10.0 ** draw.uniform(-6.0, -1.5)) for _ in range(count)]


def every_method():
    """All methods that are installed."""
    return tuple(m for m in find_methods() if installed(engine_of(m)))


def held(scene, wanted, methods, kept=None):
    """Ask, and hold the answer against fresh runs; the study that it is from, too, of which `kept`
    has the errors."""

    def run(scene, method, step):
        return measure(case_of(scene), method, step, theory=False)[0]

    study = run_study([scene], methods, kept=kept)
    answer = advise(Question(scene.name, (scene,), tuple(methods), wanted), study, run)
    choice = answer.recommendation.choice
    by_name = {m.name: m for m in methods}
    worst = math.nan
    if choice is not None:
        worst = worst_error(study, scene, by_name[choice.method], choice.step)
    limit = choice.ns_per_second / CHEAPER if choice is not None else math.inf
    missed = tuple(cheaper(study, scene, wanted, limit, answer.evidence.runs))
    return Held(scene.name, wanted, choice, worst, missed), study


def worst_error(study, scene, method, step):
    """The largest error at a step and five slightly smaller ones."""
    about = study.quantities(scene.name)
    return max(error_or_infinity(_run(scene, method, part * step), about) for part in BELOW)


def cheaper(study, scene, wanted, limit, runs=None):
    """Full models that reach the error for less than `limit` [ns per simulated second]: method,
    step, and how many times cheaper than a choice of CHEAPER times that. None that is above a step
    of `runs`, or of the study, which does not reach it: a step that does by chance is no choice."""
    judged = judge_study(study)
    runs_of = {c.method: c.measurements for c in study.convergence}
    for method in study.methods:
        price = study.costs.get((scene.name, method.name))
        if (
            price is None
            or method.surrogate
            or not meant(method, scene)
            or method.scheme.integrator == CLOSED_FORM
            or not may_recommend(
                judged.get((scene.name, method.name)),
                runs_of.get(method.name, ()),
                study.quantities(scene.name),
            )
        ):
            continue
        unit = price.ratio * study.reference_step
        about = study.quantities(scene.name)
        if method.control == "tolerance":
            yield from _looser(scene, method, wanted, limit, unit, study)
            continue
        known = [
            m for c in study.convergence if c.method == method.name for m in c.measurements
        ]
        known += (runs or {}).get((scene.name, method.name), {}).values()
        failing = min(
            (m.step for m in known if not error_or_infinity(m, about) <= wanted),
            default=math.inf,
        )
        # Any larger step has these among the smaller ones that it has to reach the error at.
        step = MORE * unit / limit if math.isfinite(limit) else min(scene.steps)
        if step <= min(failing, scene.duration / 8) and all(
            error_or_infinity(_run(scene, method, step / FINE**k), about) <= wanted
            for k in range(BESIDE + 1)
        ):
            yield method.name, step, MORE * CHEAPER


def _looser(scene, method, wanted, limit, unit, study):
    tolerance = max(TIGHTEST, min(method.step_sizes))
    about = study.quantities(scene.name)
    reached = None
    while tolerance < LOOSEST:
        found = _run(scene, method, tolerance)
        if not error_or_infinity(found, about) <= wanted:
            break
        reached = tolerance, found.steps * unit / found.duration
        tolerance *= TOLERANCES
    if reached is not None and reached[1] < limit:
        yield method.name, reached[0], CHEAPER * limit / reached[1]


def _run(scene, method, step):
    return measure(replace(case_of(scene), errors=no_theory(None)), method, step)[0]
