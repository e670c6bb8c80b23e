"""One run held against the exact answer: errors, what theory predicted, invariants, cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from plumbob.analytic.errors.schemes import ADAPTIVE
from plumbob.analytic.errors.theory import SteppedErrors, reaches
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array, Reference
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case

Status = Literal["done", "diverged", "unsupported", "missing"]


@dataclass(frozen=True)
class Prediction:
    """What theory says the error of one observable is, sum_p C_p step^p, and its reach."""

    largest: float  # largest magnitude over the samples
    end: float  # at the end, with its sign
    terms: Mapping[int, float]  # {p: largest |C_p| step^p over the samples}; empty if no series
    nonlinearity: float  # see `Reference.nonlinearity`
    missed: float | None = None
    """Where it is exact: the largest error beside it that rounding does not explain."""
    uncertainty: float | None = None
    """What double precision allows the stepped motion, largest over the samples; None where what it
    allows the exact answer applies."""


@dataclass(frozen=True)
class Controlled:
    """What a solver that controls its local error to a relative tolerance may do to an observable:
    every step has an error of the tolerance, and the motion carries that to the end."""

    largest: float
    nonlinearity: float  # see `Reference.nonlinearity`


@dataclass(frozen=True)
class ObservedError:
    """Error of one observable against the exact answer, in its SI unit."""

    largest: float  # largest magnitude over the samples
    end: float  # at the end of the run, with its sign
    uncertainty: float  # what double precision allows the exact answer, largest over the samples
    scale: float  # largest magnitude of the exact observable
    model: Mapping[str, float] = field(default_factory=dict)  # {reason: bound}, not from the step
    predicted: Prediction | None = None
    controlled: Controlled | None = None


@dataclass(frozen=True)
class Measurement:
    """What a run of a scene with a method and a step gave: small, for a worker to return."""

    scene: str
    method: str
    step: float  # [s], or the relative tolerance of an adaptive method
    status: Status
    reason: str = ""
    errors: Mapping[str, ObservedError] = field(default_factory=dict)
    invariants: Mapping[str, float] = field(default_factory=dict)  # largest relative drift
    channels: Mapping[str, float] = field(default_factory=dict)  # {engine's extra: spread}
    duration: float = 0.0  # simulated [s]
    steps: int = 0
    seconds: float = 0.0  # wall time of the stepping in this one run: see cost for a measured one
    compile_seconds: float = 0.0
    diverged_at: float | None = None
    warnings: tuple[str, ...] = ()
    note: str = ""  # why there is no prediction, where theory knows nothing of the scheme


def measure(case: Case, method: Method, step: float) -> tuple[Measurement, Trajectory | None]:
    """Run once and measure; the trajectory too, for those who plot it. Raises ParameterError."""
    scene = case.scene
    blank = Measurement(scene.name, method.name, step, "unsupported")
    if not installed(engine_of(method)):
        return _with(
            blank, status="missing", reason=f"{engine_of(method).package} is missing"
        ), None
    engine = engine_of(method)
    if not meant(method, scene):
        return _with(blank, reason=f"{method.name} is not meant for {scene.name}"), None
    try:
        simulation = engine.prepare(case, method, step)
        model = engine.model_error(case, method, step)
    except Unsupported as why:
        return _with(blank, reason=str(why)), None
    run = simulation.run()
    if run.diverged_at is not None or len(run.times) < 2:
        return _with(
            blank,
            status="diverged",
            reason="; ".join(run.warnings) or "beyond every reach of the motion",
            diverged_at=run.diverged_at,
            steps=run.steps,
            seconds=run.seconds,
            warnings=run.warnings,
        ), run
    drifts = case.system.invariants(case.problem, run.observables)
    return _with(
        blank,
        status="done",
        errors=_errors(case, method, step, run, model),
        invariants={name: float(np.abs(drift).max()) for name, drift in drifts.items()},
        channels={name: float(np.ptp(values)) for name, values in run.channels.items()},
        duration=float(run.times[-1]),
        steps=run.steps,
        seconds=run.seconds,
        compile_seconds=simulation.compile_seconds,
        warnings=run.warnings,
        note="" if method.scheme.known else f"no error theory for the scheme '{method.scheme}'",
    ), run


def _errors(
    case: Case,
    method: Method,
    step: float,
    run: Trajectory,
    model: Mapping[str, Mapping[str, float]],
) -> Mapping[str, ObservedError]:
    exact, theory, names = case.reference, case.errors, [o.name for o in case.system.observables]
    truth, doubt = exact.observe(run.times), exact.uncertainty(run.times)
    series = theory.series(method.scheme, run.times)
    powers = {p: {n: c * step**p for n, c in terms.items()} for p, terms in series.items()}
    total = {
        name: sum((terms[name] for terms in powers.values()), np.zeros(len(run.times)))
        for name in names
        if powers and all(name in terms for terms in powers.values())
    }
    nonlinear = exact.nonlinearity(run.times, total) if total else 0.0
    predicted = {name: _predicted(name, total, powers, nonlinear) for name in total}
    stepped = SteppedErrors({})
    if method.control == "step" and not (
        predicted and all(reaches(p.terms, p.largest, p.nonlinearity) for p in predicted.values())
    ):
        stepped = theory.at_step(method.scheme, step, run.times)
    own = stepped.uncertainty or {}
    carried = _carried(exact, method, step, run, doubt)
    errors = {}
    for name in (name for name in names if name in run.observables):
        error = run.observables[name] - truth[name]
        errors[name] = ObservedError(
            largest=float(np.abs(error).max()),
            end=float(error[-1]),
            uncertainty=float(doubt[name].max()),
            scale=float(np.abs(truth[name]).max()),
            model=dict(model.get(name, {})),
            predicted=_at_step(stepped.errors[name], error, doubt[name], own.get(name), run.steps)
            if name in stepped.errors
            else predicted.get(name),
            controlled=carried.get(name),
        )
    return errors


def _carried(
    exact: Reference, method: Method, step: float, run: Trajectory, doubt: Mapping[str, Array]
) -> Mapping[str, Controlled]:
    if method.scheme.integrator != ADAPTIVE:
        return {}
    may = {name: step * run.steps * value / ULP for name, value in doubt.items()}
    nonlinear = exact.nonlinearity(run.times, may)
    return {name: Controlled(float(value.max()), nonlinear) for name, value in may.items()}


def _predicted(
    name: str,
    total: Mapping[str, Array],
    powers: Mapping[int, Mapping[str, Array]],
    nonlinear: float,
) -> Prediction:
    return Prediction(
        largest=float(np.abs(total[name]).max()),
        end=float(total[name][-1]),
        terms={p: float(np.abs(terms[name]).max()) for p, terms in powers.items()},
        nonlinearity=nonlinear,
    )


def _at_step(
    predicted: Array, error: Array, doubt: Array, own: Array | None, steps: int
) -> Prediction:
    """What is predicted of an error at the samples, shape (n,), for this very step: `doubt` is the
    uncertainty of the exact answer, `own` that of the stepped motion, where it has one."""
    rounded = (doubt if own is None else own) * (1.0 + 2.0 * float(np.sqrt(steps)))  # as in `floor`
    return Prediction(
        largest=float(np.abs(predicted).max()),
        end=float(predicted[-1]),
        terms={},
        nonlinearity=0.0,
        missed=float(np.maximum(np.abs(error - predicted) - rounded, 0.0).max()),
        uncertainty=None if own is None else float(own.max()),
    )


def _with(blank: Measurement, **values: Any) -> Measurement:
    return replace(blank, **values)


def floor(error: ObservedError, steps: int) -> float:
    """What no smaller step can take from an error: the model-error bounds, what double precision
    allows the exact answer, and the rounding of every step, which adds up as a random walk: four
    standard deviations of half a unit in the last place, whose effect is that of an input's."""
    return sum(error.model.values()) + error.uncertainty * (1.0 + 2.0 * float(np.sqrt(steps)))
