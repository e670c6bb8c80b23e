"""The force in the rod as the engines report it, and its error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.systems.pendulums.rod_tension import tension
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import case, recordings, runs
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE

SCENES = (f"{SIMPLE}free-large", f"{SIMPLE}rotating-fast", f"{SIMPLE}forced-large")
METHODS = ("mujoco/euler", "mujoco/rk4", "pymunk/tight", "pymunk/default")
STEPS, DURATION = (2e-3, 1e-3), 3.0  # [s]


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each scene with each method at two steps."""
    return runs(SCENES, METHODS, STEPS, DURATION)


def numbers(study: Study) -> Record:
    """The errors of the tension by scene and method."""
    pairs = [(scene, method) for scene in SCENES for method in METHODS]
    every = [_errors(study, scene, method) for scene, method in pairs]
    errors = tuple(filter(None, every))
    sensor, impulse = (
        max((run.beside for run in errors if run.has_sensor == sensed), default=0.0)
        for sensed in (True, False)
    )
    return Record(
        runs=errors,
        steps=STEPS,
        duration=DURATION,
        sensor=sensor,  # its largest difference from T of its own state
        impulse=impulse,  # the same of the joint's
    )


def claims(tensions: Record) -> Claims:
    """The impulse is much further from the state's tension than the sensor."""
    if not any(run.has_sensor for run in tensions.runs) or not tensions.impulse > 0.0:
        return ()
    what = "distances of pymunk's impulse and of MuJoCo's sensor from the state's tension"
    return (clear(what, tensions.impulse, tensions.sensor, "N"),)


def _errors(study: Study, scene: str, method: str) -> Record | None:
    """The errors of a method's runs of a scene; None where one is missing."""
    recorded = recordings(study, runs((scene,), (method,), STEPS, DURATION))
    sizes = [_sizes(scene, run) for run in recorded.values()]
    if len(sizes) < len(STEPS):
        return None
    errors, beside, left = zip(*sizes, strict=True)
    return Record(
        scene=scene,
        method=method,
        errors=errors,  # largest [N], at STEPS
        beside=beside[-1],  # from T of the engine's own state, at the last of them
        left=left[-1],  # of that, what is not the delay of an impulse
        has_sensor=method.startswith("mujoco"),  # and not the impulse of a joint
    )


def _sizes(scene: str, run: Trajectory) -> tuple[float, ...]:
    """Largest error of the tension [N], its distance from T of the engine's own state, and what of
    that is not the delay of an impulse; the first sample, before any step, left out."""
    problem, exact = case(scene).problem, case(scene).reference
    observed = {name: samples[1:] for name, samples in run.observables.items()}
    truth = exact.observe(run.times[1:])["tension"]
    theta, rate = observed["theta"], observed["theta_dot"]
    beside = observed["tension"] - tension(problem.length, problem.gravity, theta, rate)
    step = float(run.times[-1]) / run.steps
    delay = problem.gravity * step * rate * np.sin(theta)
    errors = (observed["tension"] - truth, beside, beside - delay)
    return tuple(float(np.abs(error).max()) for error in errors)


TENSION = Analysis("simple_pendulum/rod_tension", numbers, requests, claims)
