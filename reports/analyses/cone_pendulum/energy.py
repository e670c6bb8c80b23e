"""Energy over many steps of the source's Fig. 3; the hard cases: a million steps, and saddles."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING, forms
from plumbob.reports.analyses.energy_drift import (
    EnergyRuns,
    energy_claims,
    energy_drifts,
)
from plumbob.reports.analyses.measurements import case
from plumbob.reports.analyses.saddle_growth import growth_at_saddle

SYMPLECTIC, OTHER = ("mujoco/euler", "ode/leapfrog"), "mujoco/rk4"
METHODS = (*SYMPLECTIC, OTHER)
RUNS = EnergyRuns(ROTATING, METHODS, 1e-3, 10.0)  # 10^4 steps, 62 turns
MILLION = "cone-pendulum/million-steps"


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs over many steps."""
    return RUNS.requests


def numbers(study: Study) -> Record:
    """Energy errors over ten thousand steps of the source's Fig. 3."""
    return energy_drifts(study, RUNS, forms(ROTATING).correct, SYMPLECTIC, OTHER)


def million_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs over a million steps where the study has that scene."""
    return _million().requests if plan.has(MILLION) else ()


def million_numbers(study: Study, scene: Scene) -> Record | None:
    """Energy errors over a million steps."""
    if scene.name != MILLION:
        return None
    return energy_drifts(study, _million(), forms(MILLION).correct, SYMPLECTIC, OTHER)


def saddle_numbers(study: Study, scene: Scene) -> Record | None:
    """Growth of the errors next to the highest saddle."""
    problem = case(scene.name).problem
    saddles = [e for e in problem.equilibria if e.kind == "saddle"]
    if scene.name == MILLION or not saddles:
        return None
    highest = max(saddles, key=lambda e: e.potential)
    return growth_at_saddle(
        study, scene, problem.motion, Record(theta=highest.theta, rate=highest.rate)
    )


def _million() -> EnergyRuns:
    """The scene that is there for it, at its finest step."""
    scene = case(MILLION).scene
    return EnergyRuns(MILLION, METHODS, scene.steps[-1], scene.duration)


ENERGY = Analysis("cone_pendulum/energy", numbers, requests, energy_claims)
MILLION_STEPS = Analysis("cone_pendulum/million_steps", million_numbers, million_requests)
SADDLE = Analysis("cone_pendulum/saddle", saddle_numbers)
