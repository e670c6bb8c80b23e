"""Which runs a scene's replay shows beside the exact answer: default and recommended settings."""

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
from plumbob.reports.view import notation

OWN, RECOMMENDED = "your settings", "recommended settings"
SMOOTH = ("mujoco/rk4+midpoint", "mujoco/rk4")  # a control read at mid-step, where there is one
ON_LINE = ("mujoco/euler+coulomb", "mujoco/euler+stiff")  # contacts that converge
IN_PLANE = ("mujoco/rk4+coulomb", *ON_LINE)  # turning: RK4 is up to 100 times as accurate
PLANE = ("capsule-coast", "capsule-plan", "capsule-turn")
LEAST_STEPS = 100  # of a run that a replay shows
MOST_SECONDS, MOST_SWINGS, MOST_MANOEUVRES = 100.0, 40, 10  # [s], periods, and repetitions
EXACT = "exact"  # the engine of closed forms, which are the exact answer


@dataclass(frozen=True)
class ShownRun:
    """A run that a replay shows, its name, and why that one."""

    run: ExtraRun
    name: str
    words: str


def shown_seconds(scene: Scene) -> float:
    """How much of a scene's motion is replayed [s]: of many swings the first forty, of a thousand
    manoeuvres the first ten, of other motions a hundred seconds. Works out no motion in the plane
    but one that is repeated: a plan of it takes seconds."""
    if system_of(scene).family != "capsule":
        case = case_of(scene)
        period = case.system.facts(case.problem).get("period")
        return float(min(scene.duration, MOST_SWINGS * period if period else MOST_SECONDS))
    if scene.parameters.get("count", 1) <= MOST_MANOEUVRES:
        return scene.duration
    return float(min(scene.duration, MOST_MANOEUVRES * case_of(scene).problem.motion.period))


def shown_runs(plan: StudyPlan, scene: Scene) -> Sequence[ShownRun]:
    """The two runs that a scene's replay shows, at one step: default settings, or the user's own,
    and the recommended ones; of a plan without these its first methods. None where the scene is not
    the registered one of that name, which a request names."""
    registered = find_scene(scene.name)
    if (registered.parameters, registered.duration) != (scene.parameters, scene.duration):
        return ()
    known = {m.name: m for m in plan.methods if meant(m, scene)}
    seconds = shown_seconds(scene)
    step = max((h for h in scene.steps if LEAST_STEPS * h <= seconds), default=min(scene.steps))
    if seconds >= LEAST_STEPS * REFERENCE_STEP:
        step = REFERENCE_STEP
    words = {name: RECOMMENDED for name in [n for n in _best(scene) if n in known][:1]}
    if USER_METHOD in known:
        step = known[USER_METHOD].step_sizes[0]
        words = {USER_METHOD: OWN, **words}
    elif DEFAULT[0] in known:
        usual = "default settings" + " but for the step" * (step != DEFAULT[1])
        words = {DEFAULT[0]: usual, **words}
    others = [n for n, method in known.items() if method.engine != EXACT and n not in words]
    words |= dict.fromkeys(others[: 2 - len(words)], "")
    lasting = None if seconds == scene.duration else seconds
    return [_shown(scene, known[name], of, step, lasting) for name, of in words.items()]


def _best(scene: Scene) -> tuple[str, ...]:
    """The methods that are recommended for a scene, the first one first."""
    if system_of(scene).family == "capsule":
        return IN_PLANE if scene.system in PLANE else ON_LINE
    return SMOOTH


def _shown(
    scene: Scene, method: Method, words: str, step: float, lasting: float | None
) -> ShownRun:
    if method.control == "tolerance":
        step = method.step_sizes[len(method.step_sizes) // 2]
    text = notation.seconds(step) if method.control == "step" else f"rtol {step:g}"
    run = ExtraRun(scene.name, method.name, step, lasting)
    return ShownRun(run, f"{method.name}, {text}", words)
