"""Energy of an undamped pendulum over many steps: bounded, or secular at the rate that averaging
predicts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.errors.smooth_motion.energy_drift import energy_drift_rate
from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.claims import as_predicted
from plumbob.reports.analyses.measurements import runs, scheme
from plumbob.reports.view import notation
from plumbob.reports.view.content import Claim, Figure, Table, method_cell, row, value
from plumbob.reports.view.palette import styles
from plumbob.reports.view.traces import curve, logarithmic, over_time, positive

LOST = 0.3  # of the available energy: more than this is not a drift


@dataclass(frozen=True)
class EnergyDrift:
    """The energy error of a run over time, as a straight line and the deviation from it."""

    times: Array  # [s]
    errors: Array  # [J], at them
    rate: float  # [J/s], of the line
    scatter: float  # [J], largest deviation from it
    predicted: float | None  # [J/s]; None where there is no theory
    round_off: float  # [J/s], one standard deviation of the drift from rounding theta
    fate: str  # lost, gained, secular or bounded

    @property
    def secular(self) -> bool:
        """Whether the energy error grows."""
        return self.fate != "bounded"


@dataclass(frozen=True)
class EnergyDrifts:
    """Energy errors of a scene's runs at one step [s], by method, without those whose engine is
    missing: symplectic methods beside one that is not."""

    step: float
    steps: float
    symplectic: tuple[str, ...]
    other: str
    by_method: Mapping[str, EnergyDrift]

    @property
    def bounded(self) -> tuple[str, ...]:
        """Methods whose energy error does not grow."""
        return tuple(name for name, drift in self.by_method.items() if not drift.secular)

    @property
    def overtaken(self) -> Mapping[str, float]:
        """When [s] the drift of the other method exceeds the oscillation of a symplectic one."""
        other = self.by_method.get(self.other)
        rate = abs(other.rate) if other is not None and other.secular else 0.0
        kept = [name for name in self.symplectic if name in self.bounded]
        return {name: self.by_method[name].scatter / rate for name in kept if rate}


@dataclass(frozen=True)
class EnergyRuns:
    """Runs of a scene with some methods at one step [s] over a duration [s]."""

    scene: str
    methods: tuple[str, ...]
    step: float
    duration: float

    @property
    def requests(self) -> tuple[ExtraRun, ...]:
        """The runs as a study is asked for them, in the order of the methods."""
        return runs((self.scene,), self.methods, (self.step,), self.duration)

    @property
    def steps(self) -> float:
        """Steps of a run."""
        return self.duration / self.step


@dataclass(frozen=True)
class Drift:
    """The energy error of one run over time, as a straight line and the deviation from it."""

    run: Trajectory
    errors: tuple[float, ...]  # [J]
    rate: float  # [J/s], of the line
    scatter: float  # [J], largest deviation from it
    predicted: float | None  # [J/s]; None where there is no theory
    round_off: float  # [J/s], one standard deviation of the drift from rounding theta
    available: float  # [J], of the motion above its deepest well

    @property
    def fate(self) -> str:
        """Lost or gained: a good part of it, by the end, at no constant rate. Secular: the line
        rises above the scatter."""
        late = float(np.mean(self.errors[-(len(self.errors) // 10) :]))
        if abs(late) > LOST * self.available:
            return "lost" if late < 0.0 else "gained"
        reach = abs(self.rate) * float(self.run.times[-1])
        return "secular" if reach > 2.0 * self.scatter else "bounded"

    @property
    def secular(self) -> bool:
        """Whether the energy error grows."""
        return self.fate != "bounded"


def drift(motion: PendulumMotion, method: str, step: float, run: Trajectory) -> Drift:
    """Energy error of a run with one method at a step [s], of a scene whose exact motion is
    `motion`."""
    values = energy(motion.potential, motion.inertia, run)
    errors, times = values - values[0], run.times
    rate, start = np.polyfit(times, errors, 1)
    scatter = float(np.abs(errors - (start + rate * times)).max())
    theory = predicted(motion, method, step)
    noise = _round_off(motion, run, step)
    turn = np.linspace(-np.pi, np.pi, 721)
    available = float(values[0] - np.min(in_double(motion.potential).value(turn)))
    return Drift(run, tuple(errors.tolist()), float(rate), scatter, theory, noise, available)


def drift_claims(
    drifts: Mapping[str, Drift], symplectic: Sequence[str], secular: str
) -> tuple[Claim, ...]:
    """That symplectic methods keep the energy, and another lets it drift at the predicted rate."""
    kept = [
        Claim(f"the energy error of {name} is {drifts[name].fate}", not drifts[name].secular)
        for name in symplectic
        if name in drifts
    ]
    if secular not in drifts or drifts[secular].predicted is None:
        return tuple(kept)
    secular_drift, rate = drifts[secular], float(drifts[secular].predicted or 0.0)
    return (*kept, as_predicted(f"the drift of {secular}", secular_drift.rate, rate, "J/s"))


def overtaken(drifts: Mapping[str, Drift], symplectic: Sequence[str], secular: str) -> str:
    """When a steady drift exceeds the oscillations that symplectic methods leave, in a sentence;
    empty where there is none to compare."""
    rate = abs(drifts[secular].rate) if secular in drifts and drifts[secular].secular else 0.0
    swings = {
        name: drifts[name].scatter
        for name in symplectic
        if name in drifts and not drifts[name].secular
    }
    if not rate or not swings:
        return ""
    late = {name: notation.short(float(f"{swing / rate:.2g}")) for name, swing in swings.items()}
    each = " and that ".join(
        f"of {name} ({notation.number(swing, 2)} J) after {late[name]} s"
        for name, swing in swings.items()
    )
    return (
        f"At this step the drift of {secular} exceeds the oscillation {each}; in a shorter run its "
        "energy error is the smaller one. "
    )


def energy(potential: TrigonometricPotential, inertia: float, run: Trajectory) -> Array:
    """inertia theta_dot^2 / 2 + `potential` [J] along a run, shape (n,)."""
    theta, rate = run.observables["theta"], run.observables["theta_dot"]
    return np.asarray(inertia * rate**2 / 2 + in_double(potential).value(theta))


def in_double(potential: TrigonometricPotential) -> TrigonometricPotential:
    """The potential with coefficients in double precision."""
    return TrigonometricPotential(
        *(float(double(v)) for v in (potential.a, potential.b, potential.c))
    )


def predicted(motion: PendulumMotion, method: str, step: float) -> float | None:
    """Mean rate [J/s] at which a method changes the energy; None where there is no theory."""
    if not np.isfinite(motion.period):
        return None
    start = (motion.theta, motion.theta_dot)
    terms = energy_drift_rate(motion.rotor, *start, motion.period, scheme(method))
    return motion.inertia * sum(d * step**p for p, d in terms.items()) if terms else None


def _round_off(motion: PendulumMotion, run: Trajectory, step: float) -> float:
    """Standard deviation of the drift [J/s] from rounding theta once a step: each rounding, uniform
    over a unit in theta's last place, changes the energy by its size times the torque."""
    theta = run.observables["theta"]
    torque = np.asarray(in_double(motion.potential).slope(theta))
    each = float(np.sqrt(np.mean((np.spacing(np.abs(theta)) * torque) ** 2 / 12)))
    return each / math.sqrt(step * float(run.times[-1]))


def fate(errors: Array, reach: float, scatter: float, available: float) -> str:
    """Lost or gained: a good part of the `available` energy [J], by the end, at no constant rate.
    Secular: the line reaches higher than the scatter about it."""
    late = float(np.mean(errors[-(len(errors) // 10) :]))
    if abs(late) > LOST * available:
        return "lost" if late < 0.0 else "gained"
    return "secular" if reach > 2.0 * scatter else "bounded"


def energy_drift(motion: PendulumMotion, method: str, step: float, run: Trajectory) -> EnergyDrift:
    """Energy error of a run with one method at a step [s], of a scene whose exact motion is
    `motion`."""
    energies, times = energy(motion.potential, motion.inertia, run), run.times
    errors = energies - energies[0]
    rate, start = np.polyfit(times, errors, 1)
    scatter = float(np.abs(errors - (start + rate * times)).max())
    turn = np.linspace(-np.pi, np.pi, 721)
    available = float(energies[0] - np.min(in_double(motion.potential).value(turn)))
    return EnergyDrift(
        times,
        errors,
        float(rate),
        scatter,
        predicted(motion, method, step),
        _round_off(motion, run, step),
        fate(errors, abs(float(rate)) * float(times[-1]), scatter, available),
    )


def energy_drifts(
    study: Study, asked: EnergyRuns, motion: PendulumMotion, symplectic: Sequence[str], other: str
) -> EnergyDrifts:
    """Energy errors of recorded runs of a scene whose exact motion is `motion`."""
    recorded = {request.method: study.recording(request) for request in asked.requests}
    by_method = {
        method: energy_drift(motion, method, asked.step, run)
        for method, run in recorded.items()
        if run is not None
    }
    return EnergyDrifts(asked.step, asked.steps, tuple(symplectic), other, by_method)


def energy_claims(drifts: EnergyDrifts) -> Sequence[Claim]:
    """That symplectic methods keep the energy, and the other lets it drift at the predicted
    rate."""
    kept = [
        Claim(f"the energy error of {name} is {drift.fate}", not drift.secular)
        for name, drift in drifts.by_method.items()
        if name in drifts.symplectic
    ]
    other = drifts.by_method.get(drifts.other)
    if other is None or other.predicted is None:
        return tuple(kept)
    return (*kept, as_predicted(f"the drift of {drifts.other}", other.rate, other.predicted, "J/s"))


def drift_table(
    study: Study, asked: EnergyRuns, motion: PendulumMotion
) -> tuple[Table, Figure, Mapping[str, Drift]]:
    """Table, figure and numbers of the energy drift in recorded runs of a scene whose exact motion
    is `motion`; a method whose engine is missing is left out."""
    recorded = {request.method: study.recording(request) for request in asked.requests}
    drifts = {
        method: drift(motion, method, asked.step, run)
        for method, run in recorded.items()
        if run is not None
    }
    style = styles([find_method(method) for method in asked.methods])
    rows = tuple(
        row(
            method_cell(method),
            d.fate,
            value(d.scatter),
            value(d.rate, 4),
            value(d.predicted, 4),
            value(d.round_off, 2),
        )
        for method, d in drifts.items()
    )
    heads = ("method", "energy error", "oscillation [J]", "fitted drift [J/s]",
             "predicted drift [J/s]", "drift from round-off [J/s]")  # fmt: skip
    count = f"{asked.steps:.0f} steps of {notation.short(asked.step)} s"
    plot = over_time(
        f"Energy error over {count}",
        "A horizontal band is bounded; a rising line is a drift.",
        [
            curve(d.run.times[1:], positive(d.errors[1:]), style[method], method=method)
            for method, d in drifts.items()
        ],
        logarithmic("|energy error| [J]"),
        wide=True,
        height=300,
    )
    note = (
        "Fitted: a straight line through the energy error. Secular: the line rises above twice its "
        "scatter. Lost: by the end a third of the energy is gone, and a line means nothing. "
        "Predicted: one step's energy error, averaged along the exact orbit. Round-off: of θ, once "
        "a step, one standard deviation."
    )
    return Table(f"Energy over {count}", heads, rows, note), plot, drifts
