"""Advice for what a reader simulates: for each kind of body, the setting for a wanted error at any
step, or at the reader's own step, from the runs of a study.

A setting is a method of MuJoCo at a step. It counts for a kind if the method may be recommended on
every usual scene of the kind, and if a run at the step or at a larger step bounds its error on each
of these scenes. An error of a setting is the largest on any of these scenes, at that step and at
all smaller steps: an error that crosses zero is small at one step by chance. Hard scenes do not
count. No step within 20 % of a limit of stability is advised.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median_high

from plumbob.engines.method import fits
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.extra_runs import StepRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import (
    DEFAULT_METHOD,
    RECOMMENDED_STEP,
    verdict_allows,
)
from plumbob.reports.advice.step_search import CHEAPER_RATIO, LIMIT_FRACTION
from plumbob.reports.advice.work_precision import error_or_infinity
from plumbob.reports.judge.verdict import Verdict

# Methods that may be advised, all with settings to copy. Equal cost and error: the first one.
ADVISED_METHODS = (
    DEFAULT_METHOD,
    "mujoco/implicitfast",
    "mujoco/rk4",
    "mujoco/rk4+midpoint",
    "mujoco/euler+coulomb",
    "mujoco/rk4+coulomb",
    "mujoco/euler+stiff",
)
# steps that a reader may choose [s]; None: any
CHOSEN_STEPS = (None, 1e-3, 2e-3, 5e-3, 1e-2)
CHOSEN_ERRORS = (0.1, 0.01, 0.001)
# steps that may be advised [s]: 1, 2 and 5 times a power of ten
ADVISED_STEPS = tuple(float(f"{m}e-{e}") for e in (6, 5, 4, 3, 2) for m in (1, 2, 5))


@dataclass(frozen=True)
class FurtherMotion:
    """A further motion of a body. The advice for it counts its scenes beside those of the kind, or
    its scenes alone."""

    name: str
    scenes: tuple[str, ...]  # patterns
    alone: bool = False


@dataclass(frozen=True)
class SimulatedKind:
    """A kind of body that a reader may simulate, with the patterns of its scenes."""

    name: str
    scenes: tuple[str, ...]
    further: tuple[FurtherMotion, ...] = ()


# The motion of a digital controller depends on its hold and delay more than on the integrator.
SERVOS = ("servo/*", "!servo/held-*")
SIMULATED_KINDS = (
    SimulatedKind(
        "slides",
        ("capsule-line/*", "capsule-train/*", "capsule-coast/translation"),
        (
            FurtherMotion(
                "turns",
                (
                    *("capsule-turn/0.3", "capsule-turn/heading-*", "capsule-plan/*"),
                    *("capsule-coast/rotation", "capsule-coast/spin"),
                ),
            ),
            FurtherMotion("slope", ("incline/stops",), alone=True),
        ),
    ),
    SimulatedKind(
        "arm",
        (
            *("simple-pendulum/free-*", "simple-pendulum/damped-*", "cone-pendulum/*"),
            *("linear-pendulum/*", "n-pendulum/*", *SERVOS),
        ),
        (
            FurtherMotion("held-control", ("simple-pendulum/forced-*",), alone=True),
            FurtherMotion("flies", ("free-body/*", "heavy-top/*")),
        ),
    ),
    SimulatedKind("servo", SERVOS),
    SimulatedKind(
        "grips",
        ("pinch/*", "incline/rest"),
        (FurtherMotion("stacks", ("stack/*",), alone=True),),
    ),
    SimulatedKind(
        "rolls",
        ("rolling-ball/*", "rolling-disc/*"),
        (
            FurtherMotion("bounces", ("bouncing-ball/*",), alone=True),
            FurtherMotion("strikes", ("rod-impact/*",), alone=True),
        ),
    ),
    SimulatedKind("loops", ("four-bar/*", "slider-crank/*")),
)


@dataclass(frozen=True)
class MethodRuns:
    """The runs of one method on one scene."""

    errors: Mapping[float, float]  # {step [s]: relative error}; infinite if the run diverged
    ns_per_step: float | None  # None if the method was not timed on the scene
    largest_stable_step: float  # [s]; infinite if no limit is known
    trusted: bool  # whether the method may be recommended on the scene


RunsOfStudy = Mapping[tuple[str, str], MethodRuns]  # by scene and method


@dataclass(frozen=True)
class AdvisedSetting:
    """A method at a step, with its largest error on the scenes of a kind and its cost."""

    method: str
    step: float  # [s]
    error: float  # relative
    scene: str  # scene with that error
    # [ns] median over the scenes of the time to compute a simulated second
    ns_per_second: float
    # [s] smallest limit of stability on the scenes; infinite if none is known
    stable_below: float


FurtherRuns = tuple[Sequence[AdvisedSetting], float]
"""The settings for a further motion, and the largest error of MuJoCo's default settings."""


@dataclass(frozen=True)
class DefaultErrors:
    """The smallest and the largest error of MuJoCo's default settings on the scenes of a kind."""

    step: float  # [s]
    smallest: float
    smallest_scene: str
    largest: float
    largest_scene: str
    ns_per_second: float


@dataclass(frozen=True)
class FurtherAdvice:
    """The advised setting if a body moves in a further way too; None if no run tells."""

    name: str
    setting: AdvisedSetting | None
    reached: bool  # whether the setting has the wanted error, or less
    default_error: float  # error of MuJoCo's default settings; infinite if no run tells

    @property
    def helps(self) -> bool:
        """Whether the setting has the wanted error, or at least that of the default settings."""
        setting = self.setting
        return setting is not None and (self.reached or setting.error <= self.default_error)


@dataclass(frozen=True)
class KindAdvice:
    """The advice for one choice of a step and a wanted error."""

    step: float | None  # [s] the reader's step; None: any
    error: float  # wanted
    setting: AdvisedSetting | None  # at the reader's step; None if no run tells its error there
    reached: bool  # whether `setting` has the wanted error, or less
    elsewhere: AdvisedSetting | None
    """A setting at another step that has the wanted error where `setting` has not, or that is
    cheaper by CHEAPER_RATIO; the most accurate one if nothing has the wanted error."""
    further: tuple[FurtherAdvice, ...]


@dataclass(frozen=True)
class AdvisedKind:
    """A kind of body with MuJoCo's default errors and the advice for each choice."""

    name: str
    scenes: tuple[Scene, ...]  # usual scenes that were run
    hard: tuple[Scene, ...]  # hard scenes, which do not count
    defaults: DefaultErrors
    advice: tuple[KindAdvice, ...]


def step_requests(plan: StudyPlan) -> tuple[StepRun, ...]:
    """Returns the runs at MuJoCo's default step that a plan lacks: of each method that may be
    advised, on each usual scene of a kind."""
    patterns = [pattern for kind in SIMULATED_KINDS for pattern in kind.scenes]
    further = [motion for kind in SIMULATED_KINDS for motion in kind.further]
    patterns += [pattern for motion in further for pattern in motion.scenes]
    lacking = [
        s for s in usual_scenes(plan.scenes, patterns) if RECOMMENDED_STEP not in s.steps
    ]
    # Every study runs the default method at this step.
    names = [name for name in ADVISED_METHODS if name != DEFAULT_METHOD]
    return tuple(
        StepRun(scene.name, name, RECOMMENDED_STEP)
        for scene in lacking
        for name in names
        if plan.has(scene.name, name)
    )


def usual_scenes(scenes: Iterable[Scene], patterns: Sequence[str]) -> tuple[Scene, ...]:
    """Returns the scenes of these patterns that are neither hard nor without friction."""
    return tuple(scene for scene in _matching(scenes, patterns) if not _is_unusual(scene))


def advised_kinds(
    study: Study, verdicts: Mapping[tuple[str, str], Verdict]
) -> tuple[AdvisedKind, ...]:
    """Returns the advice for each kind of body whose scenes were run with MuJoCo's default method
    and with a setting that may be advised. `verdicts` are by scene and method."""
    runs = {
        (series.scene, series.method): _method_runs(
            study, series, verdicts[series.scene, series.method]
        )
        for series in study.convergence
        if series.method in ADVISED_METHODS
    }
    ran = [scene for scene in study.scenes if (scene.name, DEFAULT_METHOD) in runs]
    kinds = (_advised_kind(kind, ran, runs) for kind in SIMULATED_KINDS)
    return tuple(kind for kind in kinds if kind)


def _method_runs(study: Study, series: ConvergenceStudy, verdict: Verdict) -> MethodRuns:
    """Returns the runs of one method on one scene, with the one more that `step_requests` made."""
    quantities = study.quantities(series.scene)
    more = study.extras.get(StepRun(series.scene, series.method, RECOMMENDED_STEP))
    measurements = [*series.measurements, *([more] if more else [])]
    ended = [run for run in measurements if run.status in ("done", "diverged")]
    cost = study.costs.get((series.scene, series.method))
    limit = study.step_limit(series.scene, series.method)
    return MethodRuns(
        errors={run.step: error_or_infinity(run, quantities) for run in ended},
        ns_per_step=cost.ns_per_step if cost else None,
        largest_stable_step=limit.step if limit else math.inf,
        trusted=verdict_allows(verdict, series.measurements, quantities),
    )


def _advised_kind(
    kind: SimulatedKind, ran: Sequence[Scene], runs: RunsOfStudy
) -> AdvisedKind | None:
    """Returns the advice for one kind, from the scenes that were run; None if there is none."""
    usual = usual_scenes(ran, kind.scenes)
    defaults = _default_errors([scene.name for scene in usual], runs)
    settings = kind_settings([scene.name for scene in usual], runs)
    if defaults is None or not settings:
        return None
    further = {
        motion.name: _further_runs([s.name for s in _scenes_of(motion, usual, ran)], runs)
        for motion in kind.further
        if usual_scenes(ran, motion.scenes)
    }
    return AdvisedKind(
        name=kind.name,
        scenes=usual,
        hard=tuple(s for s in _matching(ran, kind.scenes) if _is_unusual(s)),
        defaults=defaults,
        advice=tuple(
            _kind_advice(settings, further, step, error)
            for step in CHOSEN_STEPS
            for error in CHOSEN_ERRORS
        ),
    )


def _scenes_of(
    motion: FurtherMotion, usual: Sequence[Scene], ran: Sequence[Scene]
) -> tuple[Scene, ...]:
    """Returns the scenes that count for a further motion."""
    own = usual_scenes(ran, motion.scenes)
    return own if motion.alone else (*usual, *own)


def _further_runs(scenes: Sequence[str], runs: RunsOfStudy) -> FurtherRuns:
    """Returns the settings for the scenes of a further motion, and the largest error of MuJoCo's
    default settings on them; infinite if no run tells."""
    defaults = _default_errors(scenes, runs)
    return kind_settings(scenes, runs), defaults.largest if defaults else math.inf


def kind_settings(scenes: Sequence[str], runs: RunsOfStudy) -> tuple[AdvisedSetting, ...]:
    """Returns every setting that may be advised for these scenes."""
    settings = list[AdvisedSetting]()
    for method in ADVISED_METHODS:
        of_method = [runs.get((scene, method)) for scene in scenes]
        trusted = [one for one in of_method if one and one.trusted and one.ns_per_step]
        if not scenes or len(trusted) < len(scenes):
            continue
        by_scene = dict(zip(scenes, trusted, strict=True))
        stable_below = min(one.largest_stable_step for one in trusted)
        cost = median_high(one.ns_per_step or 0.0 for one in trusted)
        for step in ADVISED_STEPS:
            bounds = {scene: error_bound(one, step) for scene, one in by_scene.items()}
            worst = max(bounds, key=lambda scene: bounds[scene])
            was_run = any(_run_at(one, step) for one in trusted)
            if was_run and bounds[worst] < math.inf and step < LIMIT_FRACTION * stable_below:
                settings.append(
                    AdvisedSetting(
                        method=method,
                        step=step,
                        error=bounds[worst],
                        scene=worst,
                        ns_per_second=cost / step,
                        stable_below=stable_below,
                    )
                )
    return tuple(settings)


def error_bound(runs: MethodRuns, step: float) -> float:
    """Returns the largest error at a step and at all smaller steps. Without a run at the step, the
    next larger step that was run counts; infinite if there is none."""
    not_smaller = [h for h in runs.errors if h >= step * (1.0 - 1e-9)]
    if not not_smaller:
        return math.inf
    return max(error for h, error in runs.errors.items() if h <= min(not_smaller))


def _run_at(runs: MethodRuns, step: float) -> bool:
    """Returns whether a step was run."""
    return any(math.isclose(h, step, rel_tol=1e-9) for h in runs.errors)


def _default_errors(scenes: Sequence[str], runs: RunsOfStudy) -> DefaultErrors | None:
    """Returns the errors of MuJoCo's default settings at their step; None without such a run on
    each scene, or without its cost."""
    of_default = {scene: runs[scene, DEFAULT_METHOD] for scene in scenes}
    errors = {name: one.errors.get(RECOMMENDED_STEP) for name, one in of_default.items()}
    costs = [one.ns_per_step for one in of_default.values()]
    known = {name: error for name, error in errors.items() if error is not None}
    if not scenes or len(known) < len(scenes) or not all(costs):
        return None
    best, worst = (extreme(known, key=lambda name: known[name]) for extreme in (min, max))
    return DefaultErrors(
        step=RECOMMENDED_STEP,
        smallest=known[best],
        smallest_scene=best,
        largest=known[worst],
        largest_scene=worst,
        ns_per_second=median_high(cost or 0.0 for cost in costs) / RECOMMENDED_STEP,
    )


def _kind_advice(
    settings: Sequence[AdvisedSetting],
    further: Mapping[str, FurtherRuns],
    step: float | None,
    error: float,
) -> KindAdvice:
    """Returns the advice for a step and a wanted error."""
    setting, reached = _best(settings, step, error)
    anywhere, anywhere_reached = _best(settings, None, error)
    elsewhere = None
    if setting is None or (anywhere_reached and not reached):
        elsewhere = anywhere
    elif anywhere and anywhere_reached:
        cheaper = CHEAPER_RATIO * anywhere.ns_per_second <= setting.ns_per_second
        elsewhere = anywhere if cheaper else None
    return KindAdvice(
        step=step,
        error=error,
        setting=setting,
        reached=reached,
        elsewhere=elsewhere,
        further=tuple(
            _further_advice(
                name, settings_for, default, (setting or elsewhere or settings[0]).step, error
            )
            for name, (settings_for, default) in further.items()
        ),
    )


def _further_advice(
    name: str,
    settings: Sequence[AdvisedSetting],
    default_error: float,
    step: float,
    error: float,
) -> FurtherAdvice:
    """Returns the advice for a further motion at the step of the kind's own setting, or else at a
    smaller step; at any step if no smaller one was run. `default_error` is the error of MuJoCo's
    default settings."""
    setting, reached = _best(settings, step, error)
    if not reached:
        smaller = [one for one in settings if one.step <= step * (1.0 + 1e-9)]
        setting, reached = _best(smaller or settings, None, error)
    return FurtherAdvice(name, setting, reached, default_error)


def _best(
    settings: Sequence[AdvisedSetting], step: float | None, error: float
) -> tuple[AdvisedSetting | None, bool]:
    """Returns the cheapest setting at a step, or at any, that has the wanted error, and True. If
    none has, returns the most accurate setting, or None, and False."""
    at_step = [s for s in settings if step is None or math.isclose(s.step, step, rel_tol=1e-9)]
    reaching = [s for s in at_step if s.error <= error]
    if reaching:
        return min(reaching, key=lambda s: (s.ns_per_second, s.error)), True
    return min(at_step, key=lambda s: (s.error, s.ns_per_second), default=None), False


def _matching(scenes: Iterable[Scene], patterns: Sequence[str]) -> list[Scene]:
    """Returns the scenes whose names match a pattern, and none that leaves them out."""
    return [scene for scene in scenes if fits(scene.name, tuple(patterns))]


def _is_unusual(scene: Scene) -> bool:
    """Returns whether a scene is hard or frictionless, and so not typical of a robot."""
    return bool(scene.hard) or scene.parameters.get("friction") == 0.0
