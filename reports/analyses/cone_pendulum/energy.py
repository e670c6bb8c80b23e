"""Energy over many steps of the source's Fig. 3; the hard cases: a million steps, and saddles."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING, forms
from plumbob.reports.analyses.energy_drift import (
    EnergyRuns,
    drift_claims,
    drift_table,
    overtaken,
)
from plumbob.reports.analyses.measurements import case
from plumbob.reports.analyses.saddle_growth import Saddle, saddle_growth
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Finding, Table

METHODS = ("mujoco/euler", "ode/leapfrog", "mujoco/rk4")
RUNS = EnergyRuns(ROTATING, METHODS, 1e-3, 10.0)  # 10^4 steps, 62 turns
MILLION = "cone-pendulum/million-steps"


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs over many steps, over a million where the study has that scene."""
    return (*RUNS.requests, *(_million().requests if plan.has(MILLION) else ()))


def finding(study: Study) -> Finding:
    """Which methods keep the energy, over ten thousand steps of the source's Fig. 3."""
    table, plot, drifts = drift_table(study, RUNS, forms(ROTATING).correct)
    bounded = [m for m, d in drifts.items() if not d.secular]
    drifting = "; ".join(
        f"with {m} it drifts by {notation.number(d.rate)} J/s"
        + (f", and averaging predicts {notation.number(d.predicted)}" if d.predicted else "")
        for m, d in drifts.items()
        if d.secular
    )
    return Finding(
        "energy",
        "Symplectic methods keep the energy within bounds; RK4 lets it drift at a predicted rate",
        "confirmed",
        f"{overtaken(drifts, METHODS[:2], METHODS[2])}For longer runs take a symplectic "
        "method, or allow for RK4's energy drift, whose rate is predicted. "
        f"Over {RUNS.steps:.0f} steps the energy error of {' and '.join(bounded)} stays "
        f"bounded{'; ' * bool(drifting)}{drifting}.",
        (
            "RK4 is so accurate here that its drift is far below the oscillation of the "
            "symplectic methods; but the drift grows with every turn, and the oscillation does "
            "not.",
        ),
        (table,),
        (plot,),
        (f"plumbob validate --profile full --scenes {MILLION} --methods {','.join(METHODS)}",),
        claims=(*drift_claims(drifts, METHODS[:2], METHODS[2]),),
    )


def hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    """Growth of the errors next to a separatrix; energy over a million steps."""
    if scene.name == MILLION:
        table, plot, _ = drift_table(study, _million(), forms(MILLION).correct)
        return plot, table
    problem = case(scene.name).problem
    saddles = [e for e in problem.equilibria if e.kind == "saddle"]
    if not saddles:
        return ()
    highest = max(saddles, key=lambda e: e.potential)
    return saddle_growth(study, scene, problem.motion, Saddle(highest.theta, highest.rate))


def _million() -> EnergyRuns:
    """The scene that is there for it, at its finest step."""
    scene = case(MILLION).scene
    return EnergyRuns(MILLION, METHODS, scene.steps[-1], scene.duration)
