"""Energy over many steps: bounded, or secular at the rate that averaging foretells."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analytic.cone_pendulum import ConePendulum
from analytic.stepping.energy_drift import energy_drift_rate
from engines.registry import method as find_method
from engines.trajectory import Trajectory
from models.registry import scene as find_scene
from reports import notation
from reports.content import Cell, Figure, Finding, Table, row
from reports.palette import styles
from reports.sections.cone_pendulum.problems import ROTATING, case, energy, in_double, run
from reports.traces import curve, figure, linear, logarithmic, positive

METHODS = ("mujoco/euler", "ode/leapfrog", "mujoco/rk4")
STEP, DURATION = 1e-3, 10.0  # [s]: 10^4 steps, 62 turns


@dataclass(frozen=True)
class Drift:
    """The energy error of one run over time, as a line and what is left beside it."""

    run: Trajectory
    errors: tuple[float, ...]  # [J]
    rate: float  # [J/s], of the line
    scatter: float  # [J], largest distance from it
    foretold: float | None  # [J/s]; None where theory has nothing
    round_off: float  # [J/s], one standard deviation of what rounding theta may add

    @property
    def secular(self) -> bool:
        """Whether the line leaves the scatter behind."""
        return abs(self.rate) * float(self.run.times[-1]) > 2.0 * self.scatter


def drift(name: str, method: str, step: float, duration: float) -> Drift | None:
    """Energy error of one method on a scene; None where its engine is missing."""
    problem = case(name).problem
    found = run(name, method, step, duration)
    if found is None:
        return None
    values = energy(problem, problem.potential, found)
    errors, times = values - values[0], found.times
    rate, start = np.polyfit(times, errors, 1)
    scatter = float(np.abs(errors - (start + rate * times)).max())
    told = _foretold(problem, find_method(method).scheme, step)
    noise = _round_off(problem, found, step)
    return Drift(found, tuple(errors.tolist()), float(rate), scatter, told, noise)


def _foretold(problem: ConePendulum, scheme: str, step: float) -> float | None:
    period = problem.motion.period
    if not np.isfinite(period):
        return None
    terms = energy_drift_rate(
        problem.motion.rotor, problem.theta, problem.theta_dot, period, scheme
    )
    if not terms:
        return None
    return problem.body.inertia_x * sum(d * step**p for p, d in terms.items())


def _round_off(problem: ConePendulum, found: Trajectory, step: float) -> float:
    """Standard deviation of the drift [J/s] that rounding theta once a step makes: each rounding,
    even over a unit in theta's last place, moves the energy by itself times the torque."""
    theta = found.observables["theta"]
    torque = np.asarray(in_double(problem.potential).slope(theta))
    each = float(np.sqrt(np.mean((np.spacing(np.abs(theta)) * torque) ** 2 / 12)))
    return each / math.sqrt(step * float(found.times[-1]))


def finding() -> Finding:
    """Which methods keep the energy, over ten thousand steps of the source's Fig. 3."""
    table, plot, drifts = measured(ROTATING, STEP, DURATION)
    bounded = [m for m, d in drifts.items() if not d.secular]
    loose = {m: d for m, d in drifts.items() if d.secular}
    told = "; ".join(
        f"{m} drifts by {notation.number(d.rate)} J/s"
        + (f" where averaging foretells {notation.number(d.foretold)}" if d.foretold else "")
        for m, d in loose.items()
    )
    return Finding(
        "energy",
        "Symplectic methods keep the energy within bounds; RK4 lets it drift at a foretold rate",
        "confirmed",
        f"Over {DURATION / STEP:.0f} steps the energy error of {' and '.join(bounded)} stays "
        f"bounded; {told}.",
        (
            "RK4 is so exact here that its drift is far below the symplectic methods' ripple; but "
            "it grows with every turn, and the ripple does not.",
        ),
        (table,),
        (plot,),
        (
            "plumbob validate --profile full --scenes cone-pendulum/million-steps "
            f"--methods {','.join(METHODS)}",
        ),
    )


def measured(name: str, step: float, duration: float) -> tuple[Table, Figure, dict[str, Drift]]:
    """Table, figure and numbers of the energy drift on a scene at one step."""
    tries = {method: drift(name, method, step, duration) for method in METHODS}
    drifts = {method: found for method, found in tries.items() if found is not None}
    style = styles([find_method(method) for method in METHODS])
    rows = tuple(
        row(
            Cell(method, "method"),
            "secular" if d.secular else "bounded",
            Cell(notation.number(d.scatter), "number"),
            Cell(notation.number(d.rate, 4), "number"),
            Cell("–" if d.foretold is None else notation.number(d.foretold, 4), "number"),
            Cell(notation.number(d.round_off, 2), "number"),
        )
        for method, d in drifts.items()
    )
    heads = ("method", "energy error", "ripple [J]", "fitted drift [J/s]", "foretold drift [J/s]",
             "round-off may add [J/s]")  # fmt: skip
    count = f"{duration / step:.0f} steps of {notation.short(step)} s"
    traces = [
        curve(d.run.times[1:], positive(d.errors[1:]), style[method], method=method)
        for method, d in drifts.items()
    ]
    plot = figure(
        f"Energy error over {count}",
        "A straight band is bounded; a rising line is lost for good.",
        traces,
        linear("time [s]"),
        logarithmic("|energy error| [J]"),
        legend=True,
        wide=True,
        height=300,
    )
    note = (
        "Fitted: a straight line through the energy error. Secular: the line leaves twice its "
        "scatter behind. Foretold: one step's energy error, averaged along the exact orbit. "
        "Round-off: of θ, once a step, one standard deviation."
    )
    return Table(f"Energy over {count}", heads, rows, note), plot, drifts


def hard(name: str) -> tuple[Figure | Table, ...]:
    """The same on the scene that is there for it, at its finest step."""
    scene = find_scene(name)
    table, plot, _ = measured(name, scene.steps[-1], scene.duration)
    return plot, table
