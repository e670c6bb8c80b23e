"""Which runs a scene's replay shows beside the exact answer: default and recommended settings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from plumbob.engines.method import USER_METHOD, Method, meant
from plumbob.engines.study.convergence import DEFAULT
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import ON_PLANE, Scene

Role = Literal["default", "user", "recommended", "other"]
DEFAULT_METHOD, DEFAULT_STEP = DEFAULT  # its step [s]
SMOOTH = ("mujoco/rk4+midpoint", "mujoco/rk4")  # a control read at mid-step, where there is one
ON_LINE = ("mujoco/euler+coulomb", "mujoco/euler+stiff")  # contacts that converge
IN_PLANE = ("mujoco/rk4+coulomb", *ON_LINE)  # turning: RK4 is up to 100 times as accurate
PLANE = ("capsule-coast", "capsule-plan", "capsule-turn")
LEAST_STEPS = 100  # of a run that a replay shows
MOST_SECONDS = 100.0  # [s] of a system without a picture of its own
MOST_SWINGS = 40  # of a pendulum or cone, and at most ten repeated manoeuvres
MOST_MANOEUVRES = 10
EXACT = "exact"  # the engine of closed forms, which are the exact answer


@dataclass(frozen=True)
class ShownRun:
    """A run that a replay shows, and why that one."""

    role: Role
    run: ExtraRun
    control: Literal["step", "tolerance"]  # what its step means


def shown_seconds(scene: Scene) -> float:
    """How much of a scene's motion is replayed [s]: all, but of thousands of swings the first
    forty, of a thousand manoeuvres the first ten, and of other systems a hundred seconds. Works out
    no motion in the plane but one that is repeated: a plan of it takes seconds."""
    duration, family = scene.duration, system_of(scene).family
    if family == "capsule":
        if scene.parameters.get("count", 1) <= MOST_MANOEUVRES:
            return duration
        return float(min(duration, MOST_MANOEUVRES * case_of(scene).problem.motion.period))
    if family not in ("cone_pendulum", "simple_pendulum"):
        return min(duration, MOST_SECONDS)
    problem = case_of(scene).problem
    if family == "cone_pendulum":
        if problem.motion.regime not in ("libration", "rotation"):
            return duration
        return float(min(duration, MOST_SWINGS * problem.motion.period))
    if problem.gravity == 0.0:
        return duration
    swing = 2.0 * math.pi * math.sqrt(problem.length / problem.gravity)
    return float(min(duration, MOST_SWINGS * swing))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The runs that the replays of a plan's scenes show."""
    return [shown.run for scene in plan.scenes for shown in shown_runs(plan, scene)]


def shown_runs(plan: StudyPlan, scene: Scene) -> Sequence[ShownRun]:
    """The two runs that a scene's replay shows, at one step: default settings, or the user's own,
    and the recommended ones; of a plan without these its first methods. None where the scene is not
    the registered one of that name, which a request names."""
    usual = find_scene(scene.name)
    if (usual.parameters, usual.duration) != (scene.parameters, scene.duration):
        return ()
    known = {m.name: m for m in plan.methods if meant(m, scene)}
    chosen: dict[str, Role] = {}
    if USER_METHOD in known:
        chosen[USER_METHOD] = "user"
    elif DEFAULT_METHOD in known:
        chosen[DEFAULT_METHOD] = "default"
    best = next((name for name in _recommended(scene) if name in known), None)
    if best:
        chosen[best] = "recommended"
    for name, method in known.items():
        if len(chosen) < 2 and method.engine != EXACT:
            chosen.setdefault(name, "other")
    step = known[USER_METHOD].step_sizes[0] if USER_METHOD in known else _step(scene)
    return [_shown(scene, known[name], role, step) for name, role in chosen.items()]


def _recommended(scene: Scene) -> tuple[str, ...]:
    """The methods that are recommended for a scene, the first one first."""
    if system_of(scene).family != "capsule":
        return (*ON_LINE, *SMOOTH) if system_of(scene).kind == ON_PLANE else SMOOTH
    return IN_PLANE if scene.system in PLANE else ON_LINE


def _shown(scene: Scene, method: Method, role: Role, step: float) -> ShownRun:
    seconds = shown_seconds(scene)
    lasting = None if seconds == scene.duration else seconds
    if method.control == "tolerance":
        step = method.step_sizes[len(method.step_sizes) // 2]
    return ShownRun(role, ExtraRun(scene.name, method.name, step, lasting), method.control)


def _step(scene: Scene) -> float:
    """The step [s] of all runs: the one at which methods are compared where that suits the scene,
    or the scene's largest that does."""
    most = shown_seconds(scene) / LEAST_STEPS
    if most >= REFERENCE_STEP:
        return REFERENCE_STEP
    return max((h for h in scene.steps if h <= most), default=min(scene.steps))
