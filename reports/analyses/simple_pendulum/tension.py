"""The force in the rod as the engines report it, and its error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.systems.pendulums.rod_tension import tension
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import Curve, case, recordings, runs
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE

SCENES = (f"{SIMPLE}free-large", f"{SIMPLE}rotating-fast", f"{SIMPLE}forced-large")
METHODS = ("mujoco/euler", "mujoco/rk4", "pymunk/tight", "pymunk/default")
STEPS, DURATION = (2e-3, 1e-3), 3.0  # [s]
DRAWN, DRAWN_STEP = ("mujoco/rk4", "pymunk/tight"), 1e-2


@dataclass(frozen=True)
class TensionErrors:
    """Largest errors [N] of the tension that a method reports of a scene."""

    scene: str
    method: str
    errors: tuple[float, ...]  # at STEPS
    beside: float  # from T of the engine's own state, at the last of them
    left: float  # of that, what is not the delay of an impulse

    @property
    def has_sensor(self) -> bool:
        """Whether a sensor reports it, and not the impulse of a joint."""
        return self.method.startswith("mujoco")


@dataclass(frozen=True)
class RodTension:
    """The tension by MuJoCo's sensor and pymunk's impulse, against T of the exact motion and T of
    the engine's own state."""

    runs: tuple[TensionErrors, ...]
    exact: Curve  # the tension [N] over time in the first scene
    drawn: Mapping[str, Curve]  # the same by method
    steps: tuple[float, ...] = STEPS
    drawn_step: float = DRAWN_STEP
    duration: float = DURATION

    @property
    def sensor(self) -> float:
        """The sensor's largest difference from T of its own state."""
        return max((run.beside for run in self.runs if run.has_sensor), default=0.0)

    @property
    def impulse(self) -> float:
        """The same of the joint's impulse."""
        return max((run.beside for run in self.runs if not run.has_sensor), default=0.0)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each scene with each method at two steps, and the runs drawn."""
    return (*runs(SCENES, METHODS, STEPS, DURATION), *_drawn())


def _drawn() -> Sequence[ExtraRun]:
    return runs(SCENES[:1], DRAWN, (DRAWN_STEP,), DURATION)


def numbers(study: Study) -> RodTension:
    """The errors of the tension by scene and method, and its course in the first scene."""
    pairs = [(scene, method) for scene in SCENES for method in METHODS]
    every = [_errors(study, scene, method) for scene, method in pairs]
    times = np.linspace(0.0, DURATION, 240)
    return RodTension(
        tuple(filter(None, every)),
        (times, case(SCENES[0]).reference.observe(times)["tension"]),
        {
            request.method: (run.times[1::6], run.observables["tension"][1::6])
            for request, run in recordings(study, _drawn()).items()
        },
    )


def claims(tensions: RodTension) -> Claims:
    """The impulse is much further from the state's tension than the sensor."""
    if not any(run.has_sensor for run in tensions.runs) or not tensions.impulse > 0.0:
        return ()
    what = "distances of pymunk's impulse and of MuJoCo's sensor from the state's tension"
    return (clear(what, tensions.impulse, tensions.sensor, "N"),)


def _errors(study: Study, scene: str, method: str) -> TensionErrors | None:
    """The errors of a method's runs of a scene; None where one is missing."""
    recorded = recordings(study, runs((scene,), (method,), STEPS, DURATION))
    sizes = [_sizes(scene, run) for run in recorded.values()]
    if len(sizes) < len(STEPS):
        return None
    errors, beside, left = zip(*sizes, strict=True)
    return TensionErrors(scene, method, errors, beside[-1], left[-1])


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
