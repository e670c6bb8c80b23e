"""Energy of the large swing over many steps: bounded, secular as predicted, or lost by a joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.jointed_euler import JointedSeries
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.study import Study
from plumbob.reports.findings.energy_drift import Drift, energy, measured
from plumbob.reports.findings.fresh_runs import run
from plumbob.reports.findings.simple_pendulum.problems import SIMPLE, case, number
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row

SCENE = f"{SIMPLE}free-large"
MILLION = f"{SIMPLE}million-steps"
METHODS = ("mujoco/euler", "ode/leapfrog", "ode/rk4", "pymunk/default", "pymunk/tight")
STEP = 5e-3  # [s]: at a tenth of it RK4's drift, a 10^5th, would be below round-off
STEPS = MappingProxyType({"quick": 10_000, "full": 1_000_000})
LOSS_STEPS, ITERATIONS = (4e-3, 2e-3, 1e-3), (1, 10, 50)
LOSS_SPAN = 8.5  # [s]: three periods and a little


def finding(study: Study) -> Finding:
    """Which methods keep the energy of case 2, at which rate RK4 loses it, and what joints take."""
    table, plot, drifts = compared(study.profile)
    rk4 = drifts["ode/rk4"]
    share = "" if rk4.predicted is None else (
        f", where averaging predicts {notation.number(rk4.predicted, 5)}"
    )  # fmt: skip
    bounded = [m for m, d in drifts.items() if not d.secular]
    return Finding(
        "pendulum-energy",
        "Energy: symplectic steps keep it, RK4 loses it at a predicted rate, pymunk's joint fast",
        "confirmed",
        f"Over {STEPS[study.profile]} steps of {notation.short(STEP)} s the energy error of "
        f"{' and '.join(bounded)} stays bounded; ode/rk4 drifts by "
        f"{notation.number(rk4.rate, 5)} J/s{share}.",
        (
            "Prediction is the energy that one step of RK4 gains or loses, averaged along the exact "
            "orbit. Its h⁴ part averages to nothing by time symmetry; h⁵ is left.",
            "A pymunk joint as it comes (pymunk/default) costs energy at first order: the loss "
            "goes as the step, and predicted is the first coefficient of the jointed step's error. "
            "Iterations change no digit of it. With error_bias 0 (pymunk/tight) the loss goes as "
            "the cube of the step and shows only after many steps; no theory of it stands here.",
        ),
        (table, _losses()),
        (plot,),
        (
            f"plumbob validate --profile full --scenes {MILLION} --methods {','.join(METHODS)}",
            f"plumbob run {SCENE} pymunk/default --step 1e-3",
        ),
    )


@cache
def compared(profile: str) -> tuple[Table, Figure, Mapping[str, Drift]]:
    """Table, figure and numbers of the energy drift, over as many steps as a profile allows."""
    return measured(SCENE, _motion(), METHODS, STEP, STEP * STEPS[profile])


def _motion() -> PendulumMotion:
    motion = case(SCENE).problem.elliptic
    assert motion is not None  # nothing damps or forces it
    return motion


def loss(method: str, step: float, iterations: int = 10) -> float | None:
    """Mean rate [J/s] at which a joint loses energy over LOSS_SPAN; None without pymunk."""
    how = find_method(method)
    how = replace(how, settings={**how.settings, "iterations": iterations})
    found = run(SCENE, how, step, LOSS_SPAN)
    if found is None:
        return None
    motion = _motion()
    values, whole = energy(motion.potential, motion.inertia, found), motion.period
    ends = [float(np.interp(t, found.times, values)) for t in (whole, 3 * whole)]
    return (ends[1] - ends[0]) / (2 * whole)


def predicted_loss(step: float) -> float:
    """The same by the first coefficient of the jointed step's error: of energy, over two periods
    after the first, when the joint's opening has settled."""
    motion = _motion()
    times = motion.period * np.array([1.0, 3.0])
    series = JointedSeries(motion.rotor, motion.theta, motion.theta_dot)
    closing_rate = find_method("pymunk/default").scheme.joint_closing_rate
    assert closing_rate is not None
    first = series.at(closing_rate, times)[1]
    theta, rate = motion.state(times)
    torque = np.asarray(motion.rotor.acceleration(times, theta, rate))
    gained = motion.inertia * (rate * first["theta_dot"] - torque * first["theta"])
    return step * float(gained[1] - gained[0]) / (2 * motion.period)


def _losses() -> Table:
    rows = []
    for method in ("pymunk/default", "pymunk/tight"):
        for step in LOSS_STEPS:
            told = predicted_loss(step) if method == "pymunk/default" else None
            values = [loss(method, step, n) for n in ITERATIONS]
            rows.append(row(Cell(method, "method"), Cell(f"{notation.short(step)} s", "number"),
                            *(number(v, 4) for v in values), number(told, 4)))  # fmt: skip
    return Table(
        "What pymunk's joint loses of the energy [J/s], by step and by iterations of its solver",
        ("method", "step", *(notation.plural(n, "iteration") for n in ITERATIONS),
         "predicted at first order"),
        tuple(rows),
        "Mean over the second and third period. It takes 19.6 J to lift the bob from hanging to "
        "the top.",
    )  # fmt: skip


def hard(study: Study) -> tuple[Figure | Table, ...]:
    """The energy over as many steps as the profile allows."""
    table, plot, _ = compared(study.profile)
    return plot, table
