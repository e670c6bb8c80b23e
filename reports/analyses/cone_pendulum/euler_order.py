"""Semi-implicit Euler's order on both bases: of second order where the motion starts unforced."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.engines.study.order import Order
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.measurements import case, convergence_of, scheme

METHOD = "mujoco/euler"
DURATION = 0.5  # [s], where a study lacks the scene
DIGITS = 9  # decimal places of a coefficient


@dataclass(frozen=True)
class Leading:
    """The error's leading coefficients on a scene, and the order that was observed."""

    scene: str
    acceleration: float  # [rad/s^2], at the start
    first: float  # largest |C₁| [rad/s]
    second: float  # largest |C₂| [rad/s^2]
    order: Order | None


@dataclass(frozen=True)
class EulerOrder:
    """Both bases: the first-order term vanishes on one of them."""

    resting: Leading
    turning: Leading
    method: str = METHOD

    @property
    def vanishes(self) -> bool:
        """Whether the first-order term is zero on the platform at rest."""
        return self.resting.first < 1e-9 * self.turning.first


def numbers(study: Study) -> EulerOrder:
    """The leading coefficients on both bases, and the orders that the study has."""
    return EulerOrder(_leading(study, RESTING), _leading(study, ROTATING))


def _leading(study: Study, scene: str) -> Leading:
    problem = forms(scene).problem
    start = problem.motion.rotor.acceleration(0.0, problem.theta, problem.theta_dot)
    duration = next((s.duration for s in study.scenes if s.name == scene), DURATION)
    terms = case(scene).errors.series(scheme(METHOD), np.linspace(0.0, duration, 200))
    # digits beyond these differ from process to process
    first, second = (round(float(np.abs(terms[p]["theta"]).max()), DIGITS) for p in (1, 2))
    series = convergence_of(study, scene, METHOD)
    return Leading(scene, float(start), first, second, series.order if series else None)


EULER_ORDER = Analysis("cone_pendulum/euler_order", numbers)
