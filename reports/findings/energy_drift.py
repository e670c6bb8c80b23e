"""Energy of an undamped pendulum over many steps: bounded, or secular at the rate that averaging
predicts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.errors.energy_drift import energy_drift_rate
from plumbob.analytic.errors.schemes import Scheme
from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.registry import method as find_method
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.findings.fresh_runs import run
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Table, row
from plumbob.reports.view.palette import styles
from plumbob.reports.view.traces import curve, figure, linear, logarithmic, positive

LOST = 0.3  # of what is there: more than this is not a drift


@dataclass(frozen=True)
class Drift:
    """The energy error of one run over time, as a line and what is left beside it."""

    run: Trajectory
    errors: tuple[float, ...]  # [J]
    rate: float  # [J/s], of the line
    scatter: float  # [J], largest distance from it
    predicted: float | None  # [J/s]; None where theory has nothing
    round_off: float  # [J/s], one standard deviation of what rounding theta may add
    available: float  # [J] that the motion has above its deepest well

    @property
    def fate(self) -> str:
        """Lost: a good part of it is gone by the end, no longer at any one rate. Secular: the line
        leaves the scatter behind."""
        late = float(np.mean(self.errors[-(len(self.errors) // 10) :]))
        if abs(late) > LOST * self.available:
            return "lost" if late < 0.0 else "gained"
        reach = abs(self.rate) * float(self.run.times[-1])
        return "secular" if reach > 2.0 * self.scatter else "bounded"

    @property
    def secular(self) -> bool:
        """Whether the energy does not stay."""
        return self.fate != "bounded"


def drift(
    name: str, motion: PendulumMotion, method: str, step: float, duration: float
) -> Drift | None:
    """Energy error of one method on a scene whose exact motion is `motion`; None where its engine
    is missing."""
    found = run(name, method, step, duration)
    if found is None:
        return None
    values = energy(motion.potential, motion.inertia, found)
    errors, times = values - values[0], found.times
    rate, start = np.polyfit(times, errors, 1)
    scatter = float(np.abs(errors - (start + rate * times)).max())
    told = predicted(motion, find_method(method).scheme, step)
    noise = _round_off(motion, found, step)
    turn = np.linspace(-np.pi, np.pi, 721)
    available = float(values[0] - np.min(in_double(motion.potential).value(turn)))
    return Drift(found, tuple(errors.tolist()), float(rate), scatter, told, noise, available)


def energy(potential: TrigonometricPotential, inertia: float, run: Trajectory) -> Array:
    """inertia theta_dot^2 / 2 + `potential` [J] along a run, shape (n,)."""
    theta, rate = run.observables["theta"], run.observables["theta_dot"]
    return np.asarray(inertia * rate**2 / 2 + in_double(potential).value(theta))


def in_double(potential: TrigonometricPotential) -> TrigonometricPotential:
    """The potential with coefficients in double precision."""
    return TrigonometricPotential(
        *(float(double(v)) for v in (potential.a, potential.b, potential.c))
    )


def predicted(motion: PendulumMotion, scheme: Scheme, step: float) -> float | None:
    """Mean rate [J/s] at which a scheme changes the energy; None where there is no theory."""
    if not np.isfinite(motion.period):
        return None
    start = (motion.theta, motion.theta_dot)
    terms = energy_drift_rate(motion.rotor, *start, motion.period, scheme)
    return motion.inertia * sum(d * step**p for p, d in terms.items()) if terms else None


def _round_off(motion: PendulumMotion, found: Trajectory, step: float) -> float:
    """Standard deviation of the drift [J/s] that rounding theta once a step makes: each rounding,
    even over a unit in theta's last place, moves the energy by itself times the torque."""
    theta = found.observables["theta"]
    torque = np.asarray(in_double(motion.potential).slope(theta))
    each = float(np.sqrt(np.mean((np.spacing(np.abs(theta)) * torque) ** 2 / 12)))
    return each / math.sqrt(step * float(found.times[-1]))


def measured(
    name: str, motion: PendulumMotion, methods: Sequence[str], step: float, duration: float
) -> tuple[Table, Figure, Mapping[str, Drift]]:
    """Table, figure and numbers of the energy drift on a scene at one step [s] over `duration`
    [s]."""
    tries = {method: drift(name, motion, method, step, duration) for method in methods}
    drifts = {method: found for method, found in tries.items() if found is not None}
    style = styles([find_method(method) for method in methods])
    rows = tuple(
        row(
            Cell(method, "method"),
            d.fate,
            Cell(notation.number(d.scatter), "number"),
            Cell(notation.number(d.rate, 4), "number"),
            Cell("–" if d.predicted is None else notation.number(d.predicted, 4), "number"),
            Cell(notation.number(d.round_off, 2), "number"),
        )
        for method, d in drifts.items()
    )
    heads = ("method", "energy error", "ripple [J]", "fitted drift [J/s]", "predicted drift [J/s]",
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
        "scatter behind. Lost: by the end a third of the energy is gone, and a line says nothing. "
        "Prediction: one step's energy error, averaged along the exact orbit. "
        "Round-off: of θ, once a step, one standard deviation."
    )
    return Table(f"Energy over {count}", heads, rows, note), plot, drifts
