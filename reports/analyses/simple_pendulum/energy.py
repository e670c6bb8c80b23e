"""Energy of the large swing over many steps: bounded, drifting as predicted, or lost by a joint."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.smooth_motion.energy_drift import energy_drift_rate
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, as_predicted
from plumbob.reports.analyses.measurements import case, energy, recordings, runs, scheme
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE
from plumbob.reports.view.content import Claim

SCENE = f"{SIMPLE}free-large"
JOINTED = ("pymunk/default", "pymunk/tight")
SYMPLECTIC, RK4 = ("mujoco/euler", "ode/leapfrog"), "ode/rk4"
METHODS = (*SYMPLECTIC, RK4, *JOINTED)
STEP = 5e-3  # [s]: at a tenth of it RK4's drift, a 10^5th, would be below round-off
STEPS = MappingProxyType({"quick": 10_000, "full": 1_000_000})
LOSS_STEPS = (4e-3, 2e-3, 1e-3)
LOSS_SPAN = 8.5  # [s]: three periods and a little


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs over many steps, and short ones of joints."""
    return (*_long_runs(plan.profile), *_short_runs())


def _long_runs(profile: str) -> Sequence[ExtraRun]:
    return runs((SCENE,), METHODS, (STEP,), STEP * STEPS[profile])


def _short_runs() -> Sequence[ExtraRun]:
    return runs((SCENE,), JOINTED, LOSS_STEPS, LOSS_SPAN)


def numbers(study: Study) -> Record:
    """The drifts over many steps, and what joints lose over a few periods."""
    recorded = recordings(study, _long_runs(study.profile))
    drifts = {request.method: drift(request.method, run) for request, run in recorded.items()}
    return Record(
        step=STEP,  # [s]
        steps=STEPS[study.profile],
        other=RK4,
        drifts=drifts,
        bounded=[name for name, of in drifts.items() if of.fate == "bounded"],
        losses=[
            Record(
                method=request.method,
                step=request.step,  # [s]
                rate=loss_rate(run),
                predicted=predicted_loss(request.method, request.step),
            )
            for request, run in recordings(study, _short_runs()).items()
        ],
        methods=METHODS,
    )


def claims(energies: Record) -> Claims:
    """Symplectic methods keep the energy, and RK4 lets it drift at the predicted rate."""
    drifts = energies.drifts
    kept = [
        Claim(f"the energy error of {name} is {drifts[name].fate}", name in energies.bounded)
        for name in SYMPLECTIC
        if name in drifts
    ]
    other = [drifts[RK4]] if RK4 in drifts else []
    text = f"the drift of {RK4}"
    return (*kept, *(as_predicted(text, of.rate, of.predicted, "J/s") for of in other))


def drift(method: str, run: Trajectory) -> Record:
    """The energy error of a run with a method, and a line through it: `secular` where that rises
    higher than twice the scatter about it."""
    motion, times = _motion(), run.times
    energies = energy(motion.potential, motion.inertia, run)
    errors = energies - energies[0]
    rate, start = np.polyfit(times, errors, 1)
    scatter = float(np.abs(errors - (start + rate * times)).max())
    terms = energy_drift_rate(
        motion.rotor, motion.theta, motion.theta_dot, motion.period, scheme(method)
    )
    return Record(
        times=times,  # [s]
        errors=errors,  # [J], at them
        rate=rate,  # [J/s], of the line
        scatter=scatter,  # [J], largest deviation from it
        # mean rate [J/s] by averaging; None where there is no theory
        predicted=motion.inertia * sum(d * STEP**p for p, d in terms.items()) if terms else None,
        fate="secular" if abs(rate) * times[-1] > 2.0 * scatter else "bounded",
    )


def _motion() -> PendulumMotion:
    motion = case(SCENE).problem.elliptic
    assert isinstance(motion, PendulumMotion)  # no damping and no force
    return motion


def loss_rate(run: Trajectory) -> float:
    """Mean rate [J/s] of the energy over the second and third period of a run."""
    motion = _motion()
    values, period = energy(motion.potential, motion.inertia, run), motion.period
    first, last = np.interp([period, 3 * period], run.times, values)
    return float(last - first) / (2 * period)


def predicted_loss(method: str, step: float) -> float:
    """The same of the steps of a bob with a joint, in plain numbers."""
    times = step * np.arange(round(LOSS_SPAN / step) + 1.0)
    errors = case(SCENE).errors.at_step(scheme(method), step, times).errors
    exact = _motion().observe(times)
    return loss_rate(Trajectory(times, {name: exact[name] + errors[name] for name in exact}))


ENERGY = Analysis("simple_pendulum/pendulum_energy", numbers, requests, claims)
