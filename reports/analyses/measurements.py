"""Look-ups of findings: a scene's exact answer, and a study's measurements and recordings of it."""

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
# of a run whose period is measured: two whole ones between crossings, and some more
PERIODS = 3.1

LINE = "capsule-line/ca1"  # the check manoeuvre of the source


@cache
def case(name: str) -> Case:
    """The problem of a scene and its exact motion, worked out once for all findings."""
    return case_of(find_scene(name))


def problem(name: str) -> CapsuleProblem:
    """The problem of a capsule's scene."""
    posed = case(name).problem
    assert isinstance(posed, CapsuleProblem)
    return posed


def scheme(method: str) -> Scheme:
    """The scheme of a method, as the theory of errors knows it."""
    return find_method(method).scheme


def runs(
    scenes: Iterable[str],
    methods: Iterable[str],
    steps: Iterable[float],
    duration: float | None = None,
) -> tuple[ExtraRun, ...]:
    """Each scene with each method at each step [s], for `duration` [s] where that is given."""
    return tuple(ExtraRun(*parts, duration) for parts in product(scenes, methods, steps))


def plan_of(study: Study) -> StudyPlan:
    """The plan of a study."""
    return StudyPlan(study.profile, study.scenes, study.methods)


def convergence_of(study: Study, scene: str, method: str) -> ConvergenceStudy | None:
    """The convergence study of a scene with a method, or None."""
    return next((c for c in study.convergence if (c.scene, c.method) == (scene, method)), None)


def measured(study: Study, scene: str, method: str, step: float) -> Measurement | None:
    """The measurement of a scene with a method at a step [s], or None."""
    series = convergence_of(study, scene, method)
    for run in series.measurements if series else ():
        if run.status == "done" and np.isclose(run.step, step, rtol=1e-9):
            return run
    return None


def recordings(study: Study, requests: Iterable[ExtraRun]) -> Mapping[ExtraRun, Trajectory]:
    """The recordings of those requested runs that were made."""
    every = {request: study.answer(request) for request in requests}
    return {request: run for request, run in every.items() if run}


def end_error(scene: str, run: Trajectory) -> float:
    """Relative error of the displacement at the end of a recording of a scene."""
    reached = float(run.observables["displacement"][-1])
    return reached / float(problem(scene).motion.displacement) - 1.0


def displacement_error(study: Study, scene: str, method: str, step: float) -> float | None:
    """The same of a recorded run, or None where there is no such run."""
    run = study.answer(ExtraRun(scene, method, step))
    return None if run is None else end_error(scene, run)


def measured_error(study: Study, scene: str, method: str, step: float) -> float | None:
    """Relative error of the displacement at the end of a measured run, or None."""
    run = measured(study, scene, method, step)
    exact = float(problem(scene).motion.displacement)
    return None if run is None else run.errors["displacement"].end / exact


def names(study: Study, engines: Iterable[str] = ("mujoco", "pymunk")) -> tuple[str, ...]:
    """Methods of a study by name, of these engines."""
    return tuple(method.name for method in study.methods if method.engine in engines)


def covers(plan: Study | StudyPlan, *scenes: str) -> bool:
    """Whether a study, or its plan, has all of these scenes."""
    return set(scenes) <= {scene.name for scene in plan.scenes}


def energy(potential: TrigonometricPotential, inertia: float, run: Trajectory) -> Array:
    """inertia theta_dot^2 / 2 + `potential` [J] along a run, shape (n,)."""
    theta = run.observables["theta"]
    rate = run.observables["theta_dot"]
    return np.asarray(inertia * rate**2 / 2 + in_double(potential).value(theta))


def in_double(potential: TrigonometricPotential) -> TrigonometricPotential:
    """The potential with coefficients in double precision."""
    return TrigonometricPotential(
        *(float(double(v)) for v in (potential.a, potential.b, potential.c))
    )


def period(run: Trajectory | None, centre: float) -> float | None:
    """Mean period [s] of a run: of whole turns, or else of swings about an angle `centre` [rad],
    between the first and the last time that it goes up through it, by the cubic through angles and
    rates at the samples. None where there is none."""
    if run is None:
        return None
    from scipy.interpolate import CubicHermiteSpline

    theta = run.observables["theta"]
    course = CubicHermiteSpline(run.times, theta, run.observables["theta_dot"])
    gone = float(theta[-1] - theta[0])
    if turns := int(abs(gone) // TURN):
        ends = course.solve(
            float(theta[0]) + np.copysign(turns * TURN, gone), extrapolate=False
        )
        return float(ends[0] - run.times[0]) / turns if len(ends) else None
    # a start exactly at the centre may be found just outside the first interval, or not at all
    places = course.solve(centre, extrapolate=False)
    upward = [t for t in places if np.isfinite(t) and course(t, 1) > 0.0]
    distinct = [t for i, t in enumerate(upward) if i == 0 or t - upward[i - 1] > 1e-9]
    count = len(distinct) - 1
    return float((distinct[-1] - distinct[0]) / count) if count > 0 else None
