"""The runs that a scene's replay shows beside the exact motion: default and recommended
settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.engines.method import USER_METHOD, Method, meant
from plumbob.engines.study.convergence import DEFAULT
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.records import notation

OWN_SETTINGS, RECOMMENDED_SETTINGS = "your settings", "recommended settings"
ON_LINE = ("mujoco/euler+coulomb", "mujoco/euler+stiff")  # methods whose contacts converge
# for other systems: with contacts, and without them; one reads a control at mid-step
SMOOTH_METHODS = (*ON_LINE, "mujoco/rk4+midpoint", "mujoco/rk4")
# for turning bodies: RK4's error is up to 100 times less
IN_PLANE = (
    "mujoco/rk4+coulomb",
    *ON_LINE,
)
PLANE_SYSTEMS = ("capsule-coast", "capsule-plan", "capsule-turn")
MIN_REPLAY_STEPS = 100  # fewest steps of a run in a replay
MOST_SECONDS, MOST_SWINGS, MOST_MANOEUVRES = 100.0, 40, 10  # [s], periods, and repetitions
EXACT_ENGINE = "exact"  # engine of the closed forms, whose runs equal the exact motion


@dataclass(frozen=True)
class ShownRun:
    """A run that a replay shows, its name, and the reason that it is shown (empty: none)."""

    run: ExtraRun
    name: str
    words: str


def shown_seconds(scene: Scene) -> float:
    """Returns the duration of a scene's replay [s]: at most MOST_SWINGS periods, MOST_MANOEUVRES
    repeated manoeuvres or, for other motions, MOST_SECONDS.

    The motion of a capsule is solved only if it is repeated, since a plan takes seconds."""
    if system_of(scene).family != "capsule":
        case = case_of(scene)
        period = case.system.facts(case.problem).get("period")
        longest = MOST_SWINGS * period if period else MOST_SECONDS
        return float(min(scene.duration, longest))
    if scene.parameters.get("count", 1) <= MOST_MANOEUVRES:
        return scene.duration
    manoeuvre = case_of(scene).problem.motion.period
    return float(min(scene.duration, MOST_MANOEUVRES * manoeuvre))


def shown_runs(plan: StudyPlan, scene: Scene) -> Sequence[ShownRun]:
    """Returns the two runs that a scene's replay shows, at the same step: the default settings or
    the user's, and the recommended settings. If the plan lacks these, its first methods are shown.

    A scene that differs from the registered scene of its name has no runs, because a request names
    the registered scene."""
    registered = find_scene(scene.name)
    if (registered.parameters, registered.duration) != (scene.parameters, scene.duration):
        return ()
    known = {method.name: method for method in plan.methods if meant(method, scene)}
    seconds = shown_seconds(scene)
    steps = [step for step in scene.steps if MIN_REPLAY_STEPS * step <= seconds]
    step = max(steps, default=min(scene.steps))
    if seconds >= MIN_REPLAY_STEPS * REFERENCE_STEP:
        step = REFERENCE_STEP
    recommended = [name for name in _recommended_methods(scene) if name in known]
    words = dict.fromkeys(recommended[:1], RECOMMENDED_SETTINGS)
    if USER_METHOD in known:
        step = known[USER_METHOD].step_sizes[0]
        words = {USER_METHOD: OWN_SETTINGS, **words}
    elif DEFAULT[0] in known:
        usual = "default settings" + " but for the step" * (step != DEFAULT[1])
        words = {DEFAULT[0]: usual, **words}
    simulated = [name for name, method in known.items() if method.engine != EXACT_ENGINE]
    others = [name for name in simulated if name not in words]
    words |= dict.fromkeys(others[: 2 - len(words)], "")
    duration = None if seconds == scene.duration else seconds
    return [
        _shown_run(scene, known[name], text, step, duration) for name, text in words.items()
    ]


def _recommended_methods(scene: Scene) -> tuple[str, ...]:
    """Returns the recommended methods for a scene, the best first."""
    if system_of(scene).family == "capsule":
        return IN_PLANE if scene.system in PLANE_SYSTEMS else ON_LINE
    return SMOOTH_METHODS


def _shown_run(
    scene: Scene, method: Method, words: str, step: float, duration: float | None
) -> ShownRun:
    """Returns the run of a method on a scene with its name. A method with a tolerance runs at the
    middle one of its tolerances in place of `step` [s]."""
    if method.control == "tolerance":
        step = method.step_sizes[len(method.step_sizes) // 2]
    text = notation.seconds(step) if method.control == "step" else f"rtol {step:g}"
    run = ExtraRun(scene.name, method.name, step, duration)
    return ShownRun(run, f"{method.name}, {text}", words)
