"""Look-ups for findings: a scene's exact answer, and a study's measurements and recordings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from itertools import product

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case

TURN = 2 * np.pi
# number of periods in a run whose period is measured: two whole periods between crossings, and a
# margin
PERIODS = 3.1

LINE = "capsule-line/ca1"  # scene of the source's check manoeuvre


@cache
def case(name: str) -> Case:
    """Returns the problem of a scene and its exact motion; cached for all findings."""
    return case_of(find_scene(name))


def problem(name: str) -> CapsuleProblem:
    """Returns the problem of a capsule's scene."""
    posed = case(name).problem
    assert isinstance(posed, CapsuleProblem)
    return posed


def scheme(method: str) -> Scheme:
    """Returns the scheme of a method, which the theory of errors predicts from."""
    return find_method(method).scheme


def extra_runs(
    scenes: Iterable[str],
    methods: Iterable[str],
    steps: Iterable[float],
    duration: float | None = None,
) -> tuple[ExtraRun, ...]:
    """Returns a run of each scene with each method at each step [s]; `duration` [s] is by default
    the scene's."""
    return tuple(ExtraRun(*parts, duration) for parts in product(scenes, methods, steps))


def plan_of(study: Study) -> StudyPlan:
    """Returns the plan of a study: its profile, scenes and methods."""
    return StudyPlan(study.profile, study.scenes, study.methods)


def convergence_of(study: Study, scene: str, method: str) -> ConvergenceStudy | None:
    """Returns the convergence study of a scene with a method; None if there is none."""
    for series in study.convergence:
        if (series.scene, series.method) == (scene, method):
            return series
    return None


def find_measurement(study: Study, scene: str, method: str, step: float) -> Measurement | None:
    """Returns the measurement of a scene with a method at a step [s]; None if that run did not
    reach its end."""
    series = convergence_of(study, scene, method)
    for run in series.measurements if series else ():
        if run.status == "done" and np.isclose(run.step, step, rtol=1e-9):
            return run
    return None


def recordings(study: Study, requests: Iterable[ExtraRun]) -> Mapping[ExtraRun, Trajectory]:
    """Returns the recordings of the requested runs, by request; a run that was not made is left
    out."""
    answers = {request: study.answer(request) for request in requests}
    return {request: run for request, run in answers.items() if run}


def end_error(scene: str, run: Trajectory) -> float:
    """Returns the relative error of the final displacement in a recording of a scene."""
    reached = float(run.observables["displacement"][-1])
    return reached / float(problem(scene).motion.displacement) - 1.0


def displacement_error(study: Study, scene: str, method: str, step: float) -> float | None:
    """Returns the relative error of the final displacement of a recorded run; None if the study
    does not hold the run."""
    run = study.answer(ExtraRun(scene, method, step))
    return None if run is None else end_error(scene, run)


def measured_error(study: Study, scene: str, method: str, step: float) -> float | None:
    """Returns the relative error of the final displacement of a measured run; None if the study
    does not hold the run."""
    run = find_measurement(study, scene, method, step)
    exact = float(problem(scene).motion.displacement)
    return None if run is None else run.errors["displacement"].end / exact


def method_names(
    study: Study, engines: Iterable[str] = ("mujoco", "pymunk")
) -> tuple[str, ...]:
    """Returns the names of a study's methods that run in one of `engines`."""
    return tuple(method.name for method in study.methods if method.engine in engines)


def covers(plan: Study | StudyPlan, *scenes: str) -> bool:
    """Returns whether a study, or a plan, has all of these scenes."""
    return set(scenes) <= {scene.name for scene in plan.scenes}


def energy(potential: TrigonometricPotential, inertia: float, run: Trajectory) -> Array:
    """Returns the energy inertia theta_dot^2 / 2 + `potential` [J] along a run, shape (n,)."""
    theta = run.observables["theta"]
    rate = run.observables["theta_dot"]
    return np.asarray(inertia * rate**2 / 2 + in_double(potential).value(theta))


def in_double(potential: TrigonometricPotential) -> TrigonometricPotential:
    """Returns the potential with coefficients in double precision."""
    coefficients = (potential.a, potential.b, potential.c)
    return TrigonometricPotential(*(float(double(value)) for value in coefficients))


def period(run: Trajectory | None, centre: float) -> float | None:
    """Returns the mean period [s] of a pendulum's run; None if the run holds no whole period.

    If the pendulum rotates, the period is the mean over the whole turns. Otherwise, it is the mean
    time between upward passages of the angle `centre` [rad]. Between the samples, the angle is the
    cubic through the angles and rates at the samples."""
    if run is None:
        return None
    from scipy.interpolate import CubicHermiteSpline

    theta = run.observables["theta"]
    angle_at = CubicHermiteSpline(run.times, theta, run.observables["theta_dot"])
    rotated = float(theta[-1] - theta[0])
    turns = int(abs(rotated) // TURN)
    if turns:
        end_angle = float(theta[0]) + np.copysign(turns * TURN, rotated)
        ends = angle_at.solve(end_angle, extrapolate=False)
        return float(ends[0] - run.times[0]) / turns if len(ends) else None
    # Rounding may put a start at the centre just outside the first interval, so that the passage is
    # found twice or not at all.
    passages = angle_at.solve(centre, extrapolate=False)
    upward = [t for t in passages if np.isfinite(t) and angle_at(t, 1) > 0.0]
    distinct = [t for i, t in enumerate(upward) if i == 0 or t - upward[i - 1] > 1e-9]
    count = len(distinct) - 1
    return float((distinct[-1] - distinct[0]) / count) if count > 0 else None
