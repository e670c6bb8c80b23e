"""Energy of the large swing over many steps: bounded, drifting as predicted, or lost by a joint."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.smooth_motion.jointed_euler import JointedSeries
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims
from plumbob.reports.analyses.energy_drift import (
    EnergyRuns,
    energy,
    energy_claims,
    energy_drifts,
)
from plumbob.reports.analyses.measurements import case, scheme
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE

SCENE = f"{SIMPLE}free-large"
MILLION = f"{SIMPLE}million-steps"
JOINTED = ("pymunk/default", "pymunk/tight")
SYMPLECTIC, RK4 = ("mujoco/euler", "ode/leapfrog"), "ode/rk4"
METHODS = (*SYMPLECTIC, RK4, *JOINTED)
STEP = 5e-3  # [s]: at a tenth of it RK4's drift, a 10^5th, would be below round-off
STEPS = MappingProxyType({"quick": 10_000, "full": 1_000_000})
LOSS_STEPS, ITERATIONS = (4e-3, 2e-3, 1e-3), (1, 10, 50)
LOSS_SPAN = 8.5  # [s]: three periods and a little


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs over many steps, and short ones with as many iterations of the joint's solver."""
    losses = [_loss_run(m, h, n) for m in JOINTED for h in LOSS_STEPS for n in ITERATIONS]
    return (*_energy_runs(plan.profile).requests, *losses)


def _energy_runs(profile: str) -> EnergyRuns:
    return EnergyRuns(SCENE, METHODS, STEP, STEP * STEPS[profile])


def _loss_run(method: str, step: float, iterations: int) -> ExtraRun:
    return ExtraRun(SCENE, method, step, LOSS_SPAN, settings=(("iterations", iterations),))


def numbers(study: Study) -> Record:
    """The drifts over many steps, and what joints lose over a few periods."""
    losses = [
        Record(
            method=method,
            step=step,  # [s]
            # by ITERATIONS; None without pymunk
            rates=[loss(study, method, step, iterations) for iterations in ITERATIONS],
            # at first order; None without theory
            predicted=predicted_loss(step) if method == "pymunk/default" else None,
        )
        for method in JOINTED
        for step in LOSS_STEPS
    ]
    return Record(drifts=compared(study), losses=losses, methods=METHODS, iterations=ITERATIONS)


def compared(study: Study) -> Record:
    """The energy drifts over as many steps as a profile allows."""
    return energy_drifts(study, _energy_runs(study.profile), _motion(), SYMPLECTIC, RK4)


def million_numbers(study: Study, scene: Scene) -> Record | None:
    """The same on the page of the scene of a million steps."""
    return compared(study) if scene.name == MILLION else None


def claims(energies: Record) -> Claims:
    """Symplectic methods keep the energy, and RK4 lets it drift at the predicted rate."""
    return energy_claims(energies.drifts)


def _motion() -> PendulumMotion:
    motion = case(SCENE).problem.elliptic
    assert isinstance(motion, PendulumMotion)  # no damping and no force
    return motion


def loss(study: Study, method: str, step: float, iterations: int = 10) -> float | None:
    """Mean rate [J/s] at which a joint loses energy over LOSS_SPAN; None without pymunk."""
    run = study.answer(_loss_run(method, step, iterations))
    return None if run is None else loss_rate(run)


def loss_rate(run: Trajectory) -> float:
    """Mean rate [J/s] of the energy over the second and third period of a run."""
    motion = _motion()
    values, period = energy(motion.potential, motion.inertia, run), motion.period
    ends = [float(np.interp(t, run.times, values)) for t in (period, 3 * period)]
    return (ends[1] - ends[0]) / (2 * period)


def predicted_loss(step: float) -> float:
    """The same from the first coefficient of the jointed step's error, over two periods after the
    first, when the opening of the joint has settled."""
    motion = _motion()
    times = motion.period * np.array([1.0, 3.0])
    closing_rate = scheme("pymunk/default").joint_closing_rate
    assert closing_rate
    series = JointedSeries(motion.rotor, motion.theta, motion.theta_dot)
    first = series.at(closing_rate, times)[1]
    theta, rate = motion.state(times)
    torque = np.asarray(motion.rotor.acceleration(times, theta, rate))
    gained = motion.inertia * (rate * first["theta_dot"] - torque * first["theta"])
    return step * float(gained[1] - gained[0]) / (2 * motion.period)


ENERGY = Analysis("simple_pendulum/pendulum_energy", numbers, requests, claims)
MILLION_STEPS = Analysis("simple_pendulum/million_steps", million_numbers, requests)
