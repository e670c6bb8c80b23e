"""Energy of the large swing over many steps: bounded, drifting as predicted, or lost by a joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.smooth_motion.jointed_euler import JointedSeries
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.energy_drift import (
    Drift,
    EnergyRuns,
    drift_claims,
    drift_table,
    energy,
    overtaken,
)
from plumbob.reports.analyses.measurements import case, scheme
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, method_cell, row, value

SCENE = f"{SIMPLE}free-large"
MILLION = f"{SIMPLE}million-steps"
METHODS = ("mujoco/euler", "ode/leapfrog", "ode/rk4", "pymunk/default", "pymunk/tight")
STEP = 5e-3  # [s]: at a tenth of it RK4's drift, a 10^5th, would be below round-off
STEPS = MappingProxyType({"quick": 10_000, "full": 1_000_000})
JOINTED = ("pymunk/default", "pymunk/tight")
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


def finding(study: Study) -> Finding:
    """Which methods keep the energy of case 2, at which rate RK4 loses it, and what joints take."""
    table, plot, drifts = compared(study)
    rk4 = drifts["ode/rk4"]
    theory = "" if rk4.predicted is None else (
        f", and averaging predicts {notation.number(rk4.predicted, 5)} J/s"
    )  # fmt: skip
    bounded = [m for m, d in drifts.items() if not d.secular]
    return Finding(
        "pendulum-energy",
        "Energy: symplectic steps keep it, RK4 loses it at a predicted rate, pymunk's joint fast",
        "confirmed",
        f"{overtaken(drifts, METHODS[:2], METHODS[2])}For longer runs take symplectic steps: "
        "RK4 loses energy slowly, pymunk's default joint fast. "
        f"Over {STEPS[study.profile]} steps of {notation.short(STEP)} s the energy error of "
        f"{' and '.join(bounded)} stays bounded; ode/rk4 drifts by "
        f"{notation.number(rk4.rate, 5)} J/s{theory}.",
        (
            "The prediction is the energy that one step of RK4 gains or loses, averaged along the "
            "exact orbit. Its h⁴ term averages to zero by time symmetry; the h⁵ term is left.",
            "A pymunk joint with default settings (pymunk/default) loses energy at first order: "
            "the loss is proportional to the step, and the prediction is the first coefficient of "
            "the error of a step with a joint that closes slowly. Iterations change no digit of "
            "it. With error_bias 0 (pymunk/tight) the loss goes with the cube of the step and "
            "shows only after many steps; there is no theory of it here.",
        ),
        (table, _losses(study)),
        (plot,),
        (
            f"plumbob validate --profile full --scenes {MILLION} --methods {','.join(METHODS)}",
            f"plumbob run {SCENE} pymunk/default --step 1e-3",
        ),
        claims=(*drift_claims(drifts, METHODS[:2], METHODS[2]),),
    )


def compared(study: Study) -> tuple[Table, Figure, Mapping[str, Drift]]:
    """Table, figure and numbers of the energy drift, over as many steps as a profile allows."""
    return drift_table(study, _energy_runs(study.profile), _motion())


def _motion() -> PendulumMotion:
    motion = case(SCENE).problem.elliptic
    assert isinstance(motion, PendulumMotion)  # no damping and no force
    return motion


def loss(study: Study, method: str, step: float, iterations: int = 10) -> float | None:
    """Mean rate [J/s] at which a joint loses energy over LOSS_SPAN; None without pymunk."""
    run = study.recording(_loss_run(method, step, iterations))
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
    assert closing_rate is not None
    series = JointedSeries(motion.rotor, motion.theta, motion.theta_dot)
    first = series.at(closing_rate, times)[1]
    theta, rate = motion.state(times)
    torque = np.asarray(motion.rotor.acceleration(times, theta, rate))
    gained = motion.inertia * (rate * first["theta_dot"] - torque * first["theta"])
    return step * float(gained[1] - gained[0]) / (2 * motion.period)


def _losses(study: Study) -> Table:
    rows = []
    for method in JOINTED:
        for step in LOSS_STEPS:
            predicted = predicted_loss(step) if method == "pymunk/default" else None
            rates = [loss(study, method, step, n) for n in ITERATIONS]
            rows.append(row(method_cell(method), Cell(f"{notation.short(step)} s", "number"),
                            *(value(v, 4) for v in rates), value(predicted, 4)))  # fmt: skip
    return Table(
        "Energy lost by pymunk's joint [J/s], by step and by iterations of its solver",
        ("method", "step", *(notation.plural(n, "iteration") for n in ITERATIONS),
         "predicted at first order"),
        tuple(rows),
        "Mean over the second and third period. It takes 19.6 J to lift the bob from hanging to "
        "the top.",
    )  # fmt: skip


def hard(study: Study) -> tuple[Figure | Table, ...]:
    """The energy over as many steps as the profile allows."""
    table, plot, _ = compared(study)
    return plot, table
