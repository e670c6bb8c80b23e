"""Runs that analyses need beside the study's own, as data, and how each is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from plumbob.analytic.parameters import ParameterError, known
from plumbob.engines.abilities import Ablation, Trimming
from plumbob.engines.box import Side, box
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy, convergence_study
from plumbob.engines.study.gradient import Gradients, GradientSearch, gradients
from plumbob.engines.study.identification import Identification, identify
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun, long_run
from plumbob.engines.study.measurement import not_asked_for
from plumbob.engines.study.model_reading import ModelRead, ModelReading
from plumbob.engines.study.stability import (
    PredictedLimits,
    Stability,
    StabilitySearch,
    StepPrediction,
    predicted_limits,
    stability,
)
from plumbob.engines.trajectory import Trajectory, last_sample, lost
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene

MOST_STEPS = 25_000  # of a run in an extra convergence study: the quick profile's limit
Changes = tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class ExtraRun:
    """One run whose recording a finding shows."""

    scene: str
    method: str
    step: float  # [s], or the relative tolerance of an adaptive method
    duration: float | None = None  # [s]; None: the scene's own
    changes: Changes = ()  # parameters changed, as `--set` has them; hashable values
    settings: Changes = ()  # settings of the method changed; hashable values
    end_alone: bool = False  # its last sample alone is kept


@dataclass(frozen=True)
class ExtraConvergence:
    """A convergence study over step sizes [s] of a finding's own choice."""

    scene: str
    method: str
    steps: tuple[float, ...]
    duration: float | None = None  # [s]; None: the scene's own


@dataclass(frozen=True)
class TrimmingRun:
    """A timing of a model, complete and trimmed of pipeline stages and parts: `steps` steps of
    `step` [s], the median of `repeats`."""

    scene: str
    method: str
    step: float
    steps: int
    repeats: int


@dataclass(frozen=True)
class ParameterFit:
    """A search for the value of a parameter with which a run fits the exact motion best."""

    scene: str
    method: str
    step: float
    parameter: str
    low: float  # ends of the interval that is searched
    high: float
    budget: int  # runs
    changes: Changes = ()


RunRequest = (
    ExtraRun
    | ExtraConvergence
    | TrimmingRun
    | StabilitySearch
    | StepPrediction
    | LongRunSearch
    | GradientSearch
    | ParameterFit
)
Request = RunRequest | ModelReading
Measured = (
    Trajectory
    | ConvergenceStudy
    | Trimming
    | Stability
    | PredictedLimits
    | MeasuredLongRun
    | Gradients
    | Identification
)
Result = Measured | ModelRead | None
ANSWERS: Mapping[type[Request], type[Any]] = MappingProxyType(
    {
        ExtraRun: Trajectory,
        ExtraConvergence: ConvergenceStudy,
        TrimmingRun: Trimming,
        ModelReading: ModelRead,
        StabilitySearch: Stability,
        StepPrediction: PredictedLimits,
        GradientSearch: Gradients,
        ParameterFit: Identification,
        LongRunSearch: MeasuredLongRun,
    }
)


class UndeclaredRun(LookupError):
    """A run that is asked of a study and was not declared to it."""


@dataclass(frozen=True)
class StudyPlan:
    """The runs of a study before it is made: from it an analysis knows what else it needs."""

    profile: str  # "quick" or "full"
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]

    def method(self, name: str) -> Method:
        """The method of that name: the plan's, as a user's own settings are, or a registered one;
        raises ParameterError."""
        return next((m for m in self.methods if m.name == name), None) or find_method(name)

    def has(self, scene: str, method: str | None = None) -> bool:
        """Whether a scene is in the plan, and that method with it."""
        by_name = {s.name: s for s in self.scenes}
        if scene not in by_name or method is None:
            return scene in by_name
        return any(m.name == method and meant(m, by_name[scene]) for m in self.methods)


Requests = Callable[[StudyPlan], Sequence[Request]]


def nothing_more(plan: StudyPlan) -> Sequence[Request]:
    """No requests: those of an analysis of the study's own runs alone."""
    return ()


def make(request: RunRequest, method: Method) -> Result:
    """The result of a request, whose method is `method`; None where the engine is missing, the
    method is not meant for the scene or does not support it, or the run diverged. Raises
    ParameterError."""
    scene = _scene(request)
    if isinstance(request, ExtraRun):
        return _recording(request, scene, method)
    if not installed(engine_of(method)) or not meant(method, scene):
        return None
    if isinstance(request, StabilitySearch):
        return stability(scene, method)
    if isinstance(request, StepPrediction):
        return predicted_limits(scene, method)
    if isinstance(request, GradientSearch):
        return gradients(case_of(scene), method, request)
    if isinstance(request, ParameterFit):
        return _fit(request, scene, method)
    if isinstance(request, LongRunSearch):
        return long_run(scene, method, request)
    if isinstance(request, ExtraConvergence):
        return convergence_study(scene, method, MOST_STEPS, request.steps)
    ablation = engine_of(method).ability(Ablation)
    if ablation is None:
        return None
    try:
        case = case_of(scene)
        return ablation.measure(case, method, request.step, request.steps, request.repeats)
    except Unsupported:
        return None


def _fit(request: ParameterFit, scene: Scene, method: Method) -> Identification | None:
    """The best fit; None where the method does not support the scene, or its runs are lost."""
    side = Side(request.parameter, request.low, request.high)
    around = box(request.scene, dict(request.changes), [side])
    try:
        return identify(around, case_of(scene), method, request.step, request.budget)
    except (Unsupported, ParameterError):
        return None


def _recording(request: ExtraRun, scene: Scene, method: Method) -> Trajectory | None:
    if not installed(engine_of(method)) or not meant(method, scene):
        return None
    changed = replace(method, settings={**method.settings, **dict(request.settings)})
    try:
        run = engine_of(method).prepare(case_of(scene), changed, request.step).run()
    except Unsupported:
        return None
    whole = _whole(run, scene, changed, request.step)
    return last_sample(whole) if whole and request.end_alone else whole


def _whole(run: Trajectory, scene: Scene, method: Method, step: float) -> Trajectory | None:
    """A run that reached its end, with numbers alone and the samples that were asked for."""
    if lost(run) or not_asked_for(case_of(scene), method, step, run):
        return None
    return run


def convergence_with(
    scene: Scene, method: Method, most_steps: int, asked: Sequence[Request], seed: int
) -> tuple[ConvergenceStudy, dict[Request, Result]]:
    """The convergence study of a pair, and what is `asked` for of the same pair: recordings, those
    of its own runs where the steps are the same, others run beside them, and predicted limits."""
    recorded = [request for request in asked if isinstance(request, ExtraRun)]
    runs: dict[float, Trajectory | None] = {}

    def keep(step: float, run: Trajectory) -> None:
        if any(request.step == step for request in recorded):
            runs[step] = _whole(run, scene, method, step)

    found = convergence_study(scene, method, most_steps, keep=keep, seed=seed)
    for request in recorded:
        if request.step not in runs:
            runs[request.step] = _recording(request, scene, method)
    results: dict[Request, Result] = {request: runs[request.step] for request in recorded}
    if StepPrediction(scene.name, method.name) in asked:
        results[StepPrediction(scene.name, method.name)] = predicted_limits(scene, method)
    return found, results


def is_of(request: Request, scene: Scene, method: Method) -> bool:
    """Whether a request is of this very scene with this very method: one more run, kept whole, or
    what theory predicts of its steps."""
    if isinstance(request, ModelReading):
        return False
    if (request.scene, request.method) != (scene.name, method.name):
        return False
    if not isinstance(request, ExtraRun) or request.changes or request.settings:
        return isinstance(request, StepPrediction)
    if request.duration is not None or request.end_alone:
        return False
    usual = find_scene(scene.name)
    return (usual.parameters, usual.duration) == (scene.parameters, scene.duration)


def _scene(request: RunRequest) -> Scene:
    """The scene of a request, with its parameters and its duration; raises ParameterError."""
    scene = find_scene(request.scene)
    if isinstance(request, ExtraRun | GradientSearch | ParameterFit) and request.changes:
        system, changes = system_of(scene), dict(request.changes)
        known(changes, system.parameters)
        scene = replace(scene, parameters=system.change(scene.parameters, changes))
    if isinstance(request, ExtraRun | ExtraConvergence) and request.duration is not None:
        scene = replace(scene, duration=request.duration)
    return scene


def looked_up(extras: Mapping[Request, Result], request: Request) -> Result:
    """The result that a study has for a request; raises UndeclaredRun where it was not declared."""
    try:
        return extras[request]
    except KeyError:
        raise UndeclaredRun(
            f"no finding declared {request}: add it to the `requests` of the section that shows it"
        ) from None
