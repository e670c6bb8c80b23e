"""The cheapest method and step for a scene, or for the hardest of a family of scenes.

A study of the scenes judges every method. The answer uses the runs of the study, and more runs at
steps between and below the study's. The tables of a page use the study alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

from plumbob.analytic.parameters import positive
from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Quantities, Study
from plumbob.engines.study.stability import SmallestLimit
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.advice.recommend import (
    CLOSED_FORM_INTEGRATOR,
    DEFAULT_METHOD,
    RECOMMENDED_STEP,
    Choice,
    Recommendation,
    may_recommend,
)
from plumbob.reports.advice.step_search import Evidence, cheapest_choices
from plumbob.reports.judge.study_verdicts import Judgements, judge_study

SEARCH_SECONDS = 45.0  # [s] computing time, roughly, of the search for steps
SECONDS_PER_SCENE = 5.0  # [s] computing time that each further scene of a family adds
MakeRun = Callable[[Scene, Method, float], Measurement]


@dataclass(frozen=True)
class Question:
    """A question for the cheapest method: the scenes, the methods, and the wanted error."""

    name: str
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]
    error: float  # relative, or in the unit of the observable
    absolute: bool = False
    # Name of the observable whose absolute error is meant; None: the first quantity of interest.
    observable: str | None = None

    def quantities(self, study: Study, scene: str) -> Quantities:
        """Returns the quantities of a scene whose errors count. For a relative error they are the
        scene's quantities of interest; for an absolute error they are those of
        `quantities_in_units`."""
        of_interest = study.quantities(scene)
        if not self.absolute:
            return of_interest
        return quantities_in_units(of_interest, self.observable)


def quantities_in_units(of_interest: Quantities, observable: str | None) -> Quantities:
    """Returns the one quantity whose absolute error counts: an observable with the scale 1, by
    default the observable of the first quantity of interest. If the observable counts at the end
    only as a quantity of interest, its error at the end counts."""
    name = observable or of_interest[0].observable
    for quantity in of_interest:
        if quantity.observable == name:
            return (replace(quantity, scale=1.0),)
    return (Quantity(name, 1.0),)


@dataclass(frozen=True)
class RecommendationSearch:
    """The recommendation, the evidence for it, and whether the search was cut short."""

    recommendation: Recommendation
    evidence: Evidence
    cut_short: bool


def advise(
    asked: Question,
    study: Study,
    run: MakeRun | None = None,
    judged: Judgements | None = None,
) -> RecommendationSearch:
    """Returns the cheapest method and step that reach an error on every scene asked about. `study`
    is a study of the scenes; `run` makes more runs. Without `run`, the measured runs alone count.
    `judged` are the study's verdicts, if they are known already. Raises ParameterError for an error
    that is not positive."""
    evidence = _study_evidence(asked, study)
    evidence.run = run
    evidence.seconds = SEARCH_SECONDS + SECONDS_PER_SCENE * (len(asked.scenes) - 1)
    methods = _trusted_methods(asked, study, evidence, judged)
    full_models = [method for method in methods if not method.surrogate]
    choices = cheapest_choices(evidence, full_models, asked.error)
    choice = choices[0] if choices else None
    best = None
    if choice is None:
        measured = _allowed_choices(evidence, full_models)
        best = min(measured, key=lambda c: (c.error, c.ns_per_second), default=None)
    surrogate = None
    if choice is not None:
        surrogates = [method for method in methods if method.surrogate]
        surrogate = _cheaper_surrogate(evidence, surrogates, asked.error, choice)
    first_scene = asked.scenes[0].name
    observable = evidence.quantities[first_scene][0].observable
    units = {o.name: o.unit for o in study.observables(first_scene)}
    recommendation = Recommendation(
        scene=asked.name,
        observable=observable,
        unit=units[observable],
        error=asked.error,
        absolute=asked.error * evidence.scale,
        choice=choice,
        runner_up=choices[1] if len(choices) > 1 else None,
        by_engine=_cheapest_by_engine(choices),
        best=best,
        defaults=tuple(_default_choices(asked, evidence, choice)),
        surrogate=surrogate,
    )
    return RecommendationSearch(recommendation, evidence, evidence.seconds <= 0.0)


def _cheaper_surrogate(
    evidence: Evidence, surrogates: Sequence[Method], error: float, choice: Choice
) -> Choice | None:
    """Returns the cheapest surrogate that reaches the error; None if none is cheaper than
    `choice`."""
    cheapest = cheapest_choices(evidence, surrogates, error, choice.ns_per_second)
    if cheapest and cheapest[0].ns_per_second < choice.ns_per_second:
        return cheapest[0]
    return None


def _cheapest_by_engine(choices: Sequence[Choice]) -> tuple[Choice, ...]:
    """Returns the first choice of each engine; `choices` are sorted by cost."""
    by_engine: dict[str, Choice] = {}
    for choice in choices:
        by_engine.setdefault(choice.method.partition("/")[0], choice)
    return tuple(by_engine.values())


def study_recommendation(
    study: Study, scene: Scene, error: float, judged: Judgements | None = None
) -> Recommendation:
    """Returns the recommendation for one scene and a relative error, from the runs of a study
    alone; raises ParameterError for an error that is not positive."""
    asked = Question(scene.name, (scene,), study.methods, error)
    return advise(asked, study, judged=judged).recommendation


def full_model_choices(asked: Question, study: Study, judged: Judgements) -> list[Choice]:
    """Returns every run of a full model, made on all scenes asked about, that may be
    recommended."""
    evidence = _study_evidence(asked, study)
    methods = _trusted_methods(asked, study, evidence, judged)
    return _allowed_choices(evidence, [method for method in methods if not method.surrogate])


def _allowed_choices(evidence: Evidence, methods: Sequence[Method]) -> list[Choice]:
    """Returns the runs of these methods at steps that the limits of stability allow."""
    choices: list[Choice] = []
    for method in methods:
        choices += evidence.choices(method, evidence.step_bound(method))
    return choices


def _default_choices(
    asked: Question, evidence: Evidence, choice: Choice | None
) -> list[Choice]:
    """Returns the runs with MuJoCo's default settings, and with the chosen method at MuJoCo's
    default step, if these runs were made."""
    names = [DEFAULT_METHOD]
    if choice is not None and choice.method != DEFAULT_METHOD:
        names.append(choice.method)
    defaults: list[Choice] = []
    for name in names:
        for method in asked.methods:
            if method.name != name or method.control != "step":
                continue
            if not _is_timed_simulation(method, evidence):
                continue
            error = evidence.errors(method).get(RECOMMENDED_STEP, math.inf)
            if RECOMMENDED_STEP in evidence.common_steps(method) and math.isfinite(error):
                defaults.append(evidence.choice(method, RECOMMENDED_STEP, error))
    return defaults


def _study_evidence(asked: Question, study: Study) -> Evidence:
    """Returns the runs, costs and limits that a study has of the scenes; raises ParameterError for
    an error that is not positive."""
    positive("absolute" if asked.absolute else "error", asked.error)
    pairs = [
        (scene.name, method.name) for scene, method in product(asked.scenes, asked.methods)
    ]
    runs: dict[tuple[str, str], dict[float, Measurement]] = {pair: {} for pair in pairs}
    for series in study.convergence:
        if (series.scene, series.method) in runs:
            ended = [run for run in series.measurements if run.status in ("done", "diverged")]
            runs[series.scene, series.method] = {run.step: run for run in ended}
    limits: dict[tuple[str, str], SmallestLimit] = {}
    for pair in pairs:
        limit = study.step_limit(*pair)
        if limit:
            limits[pair] = limit
    return Evidence(
        scenes=asked.scenes,
        quantities={scene.name: asked.quantities(study, scene.name) for scene in asked.scenes},
        costs={pair: cost.ns_per_step for pair, cost in study.costs.items()},
        runs=runs,
        limits=limits,
    )


def _is_timed_simulation(method: Method, evidence: Evidence) -> bool:
    """Whether a method simulates all scenes, rather than evaluate a closed form, and was timed on
    them."""
    if method.scheme.integrator == CLOSED_FORM_INTEGRATOR:
        return False
    return all((scene.name, method.name) in evidence.costs for scene in evidence.scenes)


def _trusted_methods(
    asked: Question, study: Study, evidence: Evidence, judged: Judgements | None
) -> list[Method]:
    """Returns the methods that may be recommended: no scene shows a reason against them."""
    verdicts = judge_study(study) if judged is None else judged

    def recommended_on(scene: Scene, method: Method) -> bool:
        pair = scene.name, method.name
        runs = list(evidence.runs[pair].values())
        return may_recommend(verdicts.get(pair), runs, study.quantities(scene.name))

    trusted = []
    for method in asked.methods:
        stable = _is_timed_simulation(method, evidence) and evidence.step_bound(method) > 0.0
        if stable and all(recommended_on(scene, method) for scene in asked.scenes):
            trusted.append(method)
    return trusted
