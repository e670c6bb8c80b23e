"""Extra runs that analyses ask for: recordings, and timings of trimmed models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from plumbob.analytic.reference import NoAnswer
from plumbob.engines.abilities import Ablation, CompilesScenes, Trimming
from plumbob.engines.drawn_mechanism import SceneDrawing
from plumbob.engines.method import Method, meant
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import Measurement, complete_run, measure
from plumbob.engines.study.request import Changes, Request, RunRequest, work_of
from plumbob.engines.trajectory import Trajectory, last_sample
from plumbob.models.registry import case_of
from plumbob.models.scene import Scene

# samples of the coordinates of a drawing: those that no observable shows change slowly
DRAWING_SAMPLES = 401


@dataclass(frozen=True)
class ExtraRun(RunRequest[Trajectory]):
    """One run whose recorded observables a finding shows."""

    scene: str
    method: str
    step: float  # [s], or the relative tolerance of an adaptive method
    duration: float | None = None
    changes: Changes = ()
    settings: Changes = ()  # changed settings of the method
    end_alone: bool = False  # whether only the last sample is stored

    def made(self, scene: Scene, method: Method) -> Trajectory | None:
        """The run; None if it diverges or has no exact answer."""
        changed = replace(method, settings={**method.settings, **dict(self.settings)})
        try:
            run = complete_run(case_of(scene), changed, self.step)
        except NoAnswer:
            return None
        return last_sample(run) if self.end_alone else run

    def work(self, scene: Scene, method: Method) -> float:
        """The approximate number of steps."""
        return work_of(scene, method, (self.step,))


@dataclass(frozen=True)
class StepRun(RunRequest[Measurement]):
    """A measured run at one more step than the scene's own. Its errors have no bounds, and it gets
    no verdict."""

    label = "one more step"

    scene: str
    method: str
    step: float  # [s]

    def made(self, scene: Scene, method: Method) -> Measurement | None:
        """The measured run; None if double precision does not determine the exact motion."""
        try:
            measurement, _ = measure(case_of(scene), method, self.step, theory=False)
        except NoAnswer:
            return None
        return measurement

    def work(self, scene: Scene, method: Method) -> float:
        """The approximate number of steps."""
        return work_of(scene, method, (self.step,))


@dataclass(frozen=True)
class DrawingRequest(RunRequest[SceneDrawing]):
    """A request for a scene as its replay draws it, up to `duration` [s] if it is given. The method
    is one of the engine that compiles the scene's model file."""

    label, as_planned = "drawing", True

    scene: str
    method: str
    duration: float | None = None
    samples: int = DRAWING_SAMPLES

    def made(self, scene: Scene, method: Method) -> SceneDrawing | None:
        """The drawing; raises Unsupported if the scene's system has no model file."""
        compiles = engine_of(method).ability(CompilesScenes)
        assert compiles is not None
        return compiles.drawing(
            case_of(replace(scene, duration=self.duration or scene.duration)), self.samples
        )


@dataclass(frozen=True)
class TrimmingRun(RunRequest[Trimming]):
    """A timing of a model, both complete and trimmed of pipeline stages and parts: `steps` steps of
    `step` [s], the median of `repeats` timings."""

    label, timed = "trimmed", True

    scene: str
    method: str
    step: float
    steps: int
    repeats: int

    def made(self, scene: Scene, method: Method) -> Trimming | None:
        """The timing; None if the engine cannot trim models."""
        ablation = engine_of(method).ability(Ablation)
        if ablation is None:
            return None
        return ablation.measure(case_of(scene), method, self.step, self.steps, self.repeats)


@dataclass(frozen=True)
class StudyPlan:
    """The runs of a study before they are made, from which an analysis knows what else it needs."""

    profile: str  # "quick" or "full"
    scenes: tuple[Scene, ...]
    methods: tuple[Method, ...]

    def method(self, name: str) -> Method:
        """The method of that name in the plan, such as a user's settings, or else a registered
        method; raises ParameterError if there is none."""
        planned = (method for method in self.methods if method.name == name)
        return next(planned, None) or find_method(name)

    def scene(self, request: RunRequest[Any]) -> Scene:
        """The scene on which a request is answered; raises ParameterError."""
        planned = (s for s in self.scenes if s.name == request.scene and request.as_planned)
        return next(planned, None) or request.posed()

    def has(self, scene: str, method: str | None = None) -> bool:
        """Whether a scene is in the plan and, if a method is named, the plan runs it on the
        scene."""
        by_name = {s.name: s for s in self.scenes}
        if scene not in by_name or method is None:
            return scene in by_name
        return any(m.name == method and meant(m, by_name[scene]) for m in self.methods)


Requests = Callable[[StudyPlan], Sequence[Request[Any]]]
