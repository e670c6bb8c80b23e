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
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Record
from plumbob.reports.analyses.claims import Claims, as_predicted
from plumbob.reports.analyses.measurements import recordings, runs, scheme
from plumbob.reports.view.content import Claim

LOST = 0.3  # of the available energy: more than this is not a drift


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


def energy_drifts(
    study: Study, asked: EnergyRuns, motion: PendulumMotion, symplectic: Sequence[str], other: str
) -> Record:
    """Energy errors of recorded runs of a scene whose exact motion is `motion`."""
    by_method = {
        request.method: energy_drift(motion, request.method, asked.step, run)
        for request, run in recordings(study, asked.requests).items()
    }
    bounded = tuple(name for name, drift in by_method.items() if drift.fate == "bounded")
    return Record(
        step=asked.step,  # [s]
        steps=asked.duration / asked.step,
        symplectic=symplectic,
        other=other,
        by_method=by_method,
        bounded=bounded,  # methods whose energy error does not grow
        overtaken=overtaken(by_method, [name for name in symplectic if name in bounded], other),
    )


def overtaken(
    by_method: Mapping[str, Record], bounded: Sequence[str], other: str
) -> Mapping[str, float]:
    """When [s] the drift of the other method exceeds the oscillation of each of those bounded;
    empty where it was not run, or has no drift."""
    if other not in by_method or by_method[other].fate == "bounded":
        return {}
    rate = abs(by_method[other].rate)
    return {name: by_method[name].scatter / rate for name in bounded}


def energy_claims(drifts: Record) -> Claims:
    """That symplectic methods keep the energy, and the other lets it drift at the predicted
    rate."""
    kept = [
        Claim(f"the energy error of {name} is {drift.fate}", name in drifts.bounded)
        for name, drift in drifts.by_method.items()
        if name in drifts.symplectic
    ]
    other = drifts.by_method.get(drifts.other)
    if other is None or other.predicted is None:
        return tuple(kept)
    return (*kept, as_predicted(f"the drift of {drifts.other}", other.rate, other.predicted, "J/s"))


def energy_drift(motion: PendulumMotion, method: str, step: float, run: Trajectory) -> Record:
    """Energy error of a run with one method at a step [s], of a scene whose exact motion is
    `motion`."""
    energies, times = energy(motion.potential, motion.inertia, run), run.times
    errors = energies - energies[0]
    rate, start = np.polyfit(times, errors, 1)
    scatter = float(np.abs(errors - (start + rate * times)).max())
    turn = np.linspace(-np.pi, np.pi, 721)
    available = float(energies[0] - np.min(in_double(motion.potential).value(turn)))
    return Record(
        times=times,  # [s]
        errors=errors,  # [J], at them
        rate=rate,  # [J/s], of the line
        scatter=scatter,  # [J], largest deviation from it
        predicted=predicted(motion, method, step),  # [J/s]; None where there is no theory
        # [J/s], one standard deviation of the drift from rounding theta
        round_off=_round_off(motion, run, step),
        # lost, gained, secular or bounded
        fate=fate(errors, abs(float(rate)) * float(times[-1]), scatter, available),
    )


def fate(errors: Array, reach: float, scatter: float, available: float) -> str:
    """Lost or gained: a good part of the `available` energy [J], by the end, at no constant rate.
    Secular: the line reaches higher than the scatter about it."""
    late = float(np.mean(errors[-(len(errors) // 10) :]))
    if abs(late) > LOST * available:
        return "lost" if late < 0.0 else "gained"
    return "secular" if reach > 2.0 * scatter else "bounded"


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
