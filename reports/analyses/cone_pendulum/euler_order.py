"""Semi-implicit Euler's order on both bases: of second order where the motion starts unforced."""

from __future__ import annotations

import numpy as np

from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.measurements import case, convergence_of, scheme

METHOD = "mujoco/euler"
DURATION = 0.5  # [s], where a study lacks the scene
DIGITS = 9  # decimal places of a coefficient


def numbers(study: Study) -> Record:
    """The leading coefficients on both bases, and the orders that the study has."""
    resting, turning = _leading(study, RESTING), _leading(study, ROTATING)
    # the first-order term is zero on the platform at rest
    vanishes = resting.first < 1e-9 * turning.first
    return Record(resting=resting, turning=turning, method=METHOD, vanishes=vanishes)


def _leading(study: Study, scene: str) -> Record:
    """The error's leading coefficients on a scene, and the order that was observed."""
    problem = forms(scene).problem
    start = problem.motion.rotor.acceleration(0.0, problem.theta, problem.theta_dot)
    duration = next((s.duration for s in study.scenes if s.name == scene), DURATION)
    terms = case(scene).errors.series(scheme(METHOD), np.linspace(0.0, duration, 200))
    # digits beyond these differ from process to process
    first, second = (round(float(np.abs(terms[p]["theta"]).max()), DIGITS) for p in (1, 2))
    series = convergence_of(study, scene, METHOD)
    return Record(
        scene=scene,
        acceleration=start,  # [rad/s^2], at the start
        first=first,  # largest |C₁| [rad/s]
        second=second,  # largest |C₂| [rad/s^2]
        order=series.order if series else None,
    )


EULER_ORDER = Analysis("cone_pendulum/euler_order", numbers)
