"""One run held against the exact answer: errors, what theory predicted, invariants, cost."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from plumbob.analytic.answer_cache import Same, as_stepped, exactly, expected
from plumbob.analytic.left_open import (
    by_rounding,
    by_second_run,
    by_series,
    nonlinear_part,
    roundings,
)
from plumbob.analytic.reference import Array, NoAnswer, Reference, Signals, answering
from plumbob.analytic.schemes import ADAPTIVE, Scheme
from plumbob.analytic.theory import SteppedErrors, reaches
from plumbob.engines.abilities import SchemeOfCase, SecondRun
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.sampling import cut_short
from plumbob.engines.trajectory import Trajectory, lost
from plumbob.models.scene import Case, Quantity

REFERENCE_STEP = 1e-3  # [s] that errors of fixed-step methods are shown at
Status = Literal["done", "diverged", "cut-short", "unsupported", "missing"]


@dataclass(frozen=True)
class Prediction:
    """The predicted error of one observable, sum_p C_p step^p, and its reach."""

    largest: float  # largest magnitude over the samples
    end: float  # at the end, with its sign
    terms: Mapping[int, float]  # {p: largest |C_p| step^p over the samples}; empty if no series
    nonlinearity: float  # see `Reference.nonlinearity`
    # largest magnitude over the samples of measured less predicted, signed
    difference: float = 0.0
    open: float = 0.0  # what theory leaves open of that, the largest over the samples
    beyond: float = 0.0  # the most by which a sample differs by more than is open there
    uncertainty: float | None = None
    """Response of the stepped motion to rounding, largest over the samples; None where that of the
    exact answer applies."""
    lasting: float = 0.0
    """Derived size, largest over the samples, of the part of the error that no smaller step
    reduces."""
    beside_lasting: float | None = None
    """Largest excess over the samples of the measured error over that part; None if theory derives
    no such part."""

    @property
    def for_this_step(self) -> bool:
        """Whether it is what the scheme does at this very step, and no series."""
        return not self.terms


@dataclass(frozen=True)
class Controlled:
    """The error that a solver with a tolerance adds to an observable, as another on the same
    equations shows, whose tolerance is much smaller. An error that both have is not in it."""

    largest: float  # bound on the error, over the samples
    beyond: float  # the most by which the error of a sample is larger than its own bound


@dataclass(frozen=True)
class ObservedError:
    """Error of one observable against the exact answer, in its SI unit."""

    largest: float  # largest magnitude over the samples
    end: float  # at the end of the run, with its sign
    uncertainty: (
        float  # what double precision allows the exact answer, largest over the samples
    )
    scale: float  # largest magnitude of the exact observable
    # {reason: bound}, not from the step
    model: Mapping[str, float] = field(default_factory=dict)
    predicted: Prediction | None = None
    controlled: Controlled | None = None
    start: float = 0.0  # magnitude at the first sample; 0 of a force

    @property
    def model_error(self) -> float:
        """Bound on what the model adds to the error, whatever the step."""
        return sum(self.model.values())

    @property
    def falling(self) -> float:
        """The largest magnitude of the part of the error that smaller steps are to reduce: all of
        it but what theory derives as the same at every step."""
        known = self.predicted.beside_lasting if self.predicted else None
        return self.largest if known is None else known

    @property
    def left_open(self) -> float | None:
        """By how much the error may differ from its prediction; None where there is none."""
        return None if self.predicted is None else self.model_error + self.predicted.open


@dataclass(frozen=True)
class Measurement:
    """A measured run of a scene with a method and a step: small, for a worker to return."""

    scene: str
    method: str
    step: float  # [s], or the relative tolerance of an adaptive method
    status: Status
    reason: str = ""
    errors: Mapping[str, ObservedError] = field(default_factory=dict)
    invariants: Mapping[str, float] = field(default_factory=dict)  # largest relative drift
    duration: float = 0.0  # simulated [s]
    steps: int = 0
    seconds: float = 0.0  # of the stepping in this one run, but for waiting: costs are measured
    compile_seconds: float = 0.0
    diverged_at: float | None = None
    warnings: tuple[str, ...] = ()
    note: str = ""  # why there is no prediction, where theory knows nothing of the scheme


def measure(
    case: Case, method: Method, step: float, theory: bool = True
) -> tuple[Measurement, Trajectory | None]:
    """Run once and measure; the trajectory too, for those who plot it. A method that controls its
    local error is held to a second run. Without `theory` its errors alone are measured, without
    bounds on them, which take longer than a run. Raises ParameterError, and NoAnswer where double
    precision does not hold the exact solution."""
    engine = engine_of(method)
    blank = Measurement(case.scene.name, method.name, step, "unsupported")
    if not installed(engine):
        return replace(blank, status="missing", reason=f"{engine.package} is missing"), None
    if not meant(method, case.scene):
        return replace(blank, reason=f"{method.name} is not meant for {case.scene.name}"), None
    try:
        simulation = engine.prepare(case, method, step)
        model = engine.model_error(case, method, step) if theory else {}
    except Unsupported as reason:
        return replace(blank, reason=str(reason)), None
    begin = time.thread_time()
    run = simulation.run()
    # the second is with what reads samples
    seconds = min(run.seconds, time.thread_time() - begin)
    taken = replace(blank, steps=run.steps, seconds=seconds, warnings=run.warnings)
    if why := lost(run):
        return replace(taken, status="diverged", reason=why, diverged_at=run.diverged_at), run
    if short := not_asked_for(case, method, step, run):
        return replace(blank, status="cut-short", reason=f"the run is cut short: {short}"), run
    if theory:
        errors = _errors(case, method, step, run, model)
        drifts = invariant_drifts(case, run)
    else:
        errors = _differences(case, run)
        drifts = {}
    scheme = scheme_of(case, method)
    return replace(
        taken,
        status="done",
        errors=errors,
        invariants=drifts,
        duration=float(run.times[-1]),
        compile_seconds=simulation.compile_seconds,
        note="" if scheme.known else f"no error theory for the scheme '{scheme}'",
    ), run


def not_asked_for(case: Case, method: Method, step: float, run: Trajectory) -> str:
    """Why a run that did not diverge is not the one asked for; empty where it is."""
    fixed = step if method.control == "step" else None
    return cut_short(run, case.scene.duration, fixed)


def complete_run(case: Case, method: Method, step: float) -> Trajectory:
    """A run that reached its end, with numbers alone and the samples that were asked for; raises
    NoAnswer where it did not, and Unsupported."""
    run = engine_of(method).prepare(case, method, step).run()
    if why := lost(run) or not_asked_for(case, method, step, run):
        raise NoAnswer(why)
    return run


def scheme_of(case: Case, method: Method) -> Scheme:
    """The steps that a method takes of this case: its scheme, or another that its engine names."""
    named = engine_of(method).ability(SchemeOfCase)
    return method.scheme if named is None else named.of(case, method)


def _differences(case: Case, run: Trajectory) -> Mapping[str, ObservedError]:
    """The errors of the observables, without bounds on them; raises NoAnswer."""
    with answering():
        exact = case.reference.observe(run.times)
        names = [o.name for o in case.system.observables]
        errors = {n: run.observables[n] - exact[n] for n in names if n in run.observables}
    return {
        name: ObservedError(float(np.abs(error).max()), float(error[-1]), 0.0, 0.0)
        for name, error in errors.items()
    }


def invariant_drifts(case: Case, run: Trajectory) -> Mapping[str, float]:
    """The largest relative drifts of the invariants; none where the run leaves out what they are
    made of."""
    try:
        drifts = case.system.invariants(case.problem, run.observables)
    except KeyError:
        if all(o.name in run.observables for o in case.system.observables):
            raise
        return {}
    return {name: float(np.abs(drift).max()) for name, drift in drifts.items()}


def _errors(
    case: Case,
    method: Method,
    step: float,
    run: Trajectory,
    model: Mapping[str, Mapping[str, float]],
) -> Mapping[str, ObservedError]:
    forces = {o.name for o in case.system.observables if o.force}
    scheme = scheme_of(case, method)
    truth, doubt = exactly(Same(case.reference), run.times.tobytes())
    doubt = {name: scheme.unit * error for name, error in doubt.items()}
    names = [o.name for o in case.system.observables if o.name in run.observables]
    errors = {name: run.observables[name] - truth[name] for name in names}
    predicted = _predictions(case, method, step, run, errors, doubt)
    second = confirming(case, method) if scheme.integrator == ADAPTIVE else None
    controlled = (
        {} if second is None else _controlled(case.reference, run, errors, doubt, second)
    )
    return {
        name: ObservedError(
            largest=float(np.abs(error).max()),
            end=float(error[-1]),
            uncertainty=float(doubt[name].max()),
            scale=float(np.abs(truth[name]).max()),
            model=dict(model.get(name, {})),
            predicted=predicted.get(name),
            controlled=controlled.get(name),
            start=0.0 if name in forces else abs(float(error[0])),
        )
        for name, error in errors.items()
    }


def _predictions(
    case: Case,
    method: Method,
    step: float,
    run: Trajectory,
    errors: Signals,
    doubt: Signals,
) -> Mapping[str, Prediction]:
    """Predictions of the errors at the samples, shape (n,) each, beside those measured: of theory's
    series in the step and, where that does not reach, of what the scheme does at this very step, of
    which rounding alone is left open."""
    scheme = scheme_of(case, method)
    times = run.times.tobytes()
    powers, total, nonlinear = expected(
        Same(case.reference), Same(case.errors), scheme, step, times
    )
    predicted = {}
    for name in errors.keys() & total.keys():
        series = {power: parts[name] for power, parts in sorted(powers.items())}
        terms = {power: float(np.abs(parts).max()) for power, parts in series.items()}
        left = by_series(list(series.values())) + by_rounding(doubt[name], run.steps)
        left += nonlinear_part(terms, nonlinear) * np.maximum.accumulate(np.abs(total[name]))
        predicted[name] = _held(total[name], errors[name], left, terms, nonlinear)
    reaching = (reaches(p.terms, p.largest, p.nonlinearity) for p in predicted.values())
    if method.control == "step" and not (predicted and all(reaching)):
        stepped = as_stepped(Same(case.errors), scheme, step, times)
        predicted |= _at_step(stepped, errors, doubt, scheme.unit, run.steps)
    return predicted


def _at_step(
    stepped: SteppedErrors,
    errors: Signals,
    doubt: Signals,
    unit: float,
    steps: int,
) -> Mapping[str, Prediction]:
    """Predictions for this very step, of which rounding alone is left open: `doubt` is the
    uncertainty of the exact answer, which that of the stepped motion replaces where it is known."""
    own = {name: unit * error for name, error in (stepped.uncertainty or {}).items()}
    predictions = {}
    for name, stepped_error in stepped.errors.items():
        if name not in errors:
            continue
        left_open = by_rounding(own.get(name, doubt[name]), steps)
        predicted = _held(stepped_error, errors[name], left_open, {}, 0.0)
        uncertainty = float(own[name].max()) if name in own else None
        predicted = replace(predicted, uncertainty=uncertainty)
        predictions[name] = _lasting(predicted, errors[name], stepped.lasting.get(name))
    return predictions


def _lasting(predicted: Prediction, error: Array, size: Array | None) -> Prediction:
    """The prediction of an `error`, shape (n,), with the part of the error that has a derived
    `size`, shape (n,), at every step, and the excess over that part. Without such a part the
    prediction stays as it is."""
    if size is None:
        return predicted
    beside = np.maximum(np.abs(error) - np.abs(size), 0.0)
    largest = float(np.abs(size).max())
    return replace(predicted, lasting=largest, beside_lasting=float(beside.max()))


def confirming(case: Case, method: Method) -> Trajectory | None:
    """The run that a method which controls its local error is held to; None where its engine has
    none, or it fails."""
    second = engine_of(method).ability(SecondRun)
    if second is None:
        return None
    other, tolerance = second.of(method)
    key = Same(case.problem), case.scene.duration, other.name, tolerance
    return _confirmed(_Second(key, case, other, tolerance))


@dataclass(frozen=True)
class _Second:
    """A run to hold others to: of a problem the same, whichever method asks for it."""

    key: tuple[Same, float, str, float]
    case: Case = field(compare=False)
    method: Method = field(compare=False)
    tolerance: float = field(compare=False)


@lru_cache(maxsize=4)
def _confirmed(second: _Second) -> Trajectory | None:
    """The trajectory of such a run; None where it fails."""
    with suppress(NoAnswer):
        return complete_run(second.case, second.method, second.tolerance)
    return None


def _controlled(
    exact: Reference,
    run: Trajectory,
    errors: Signals,
    doubt: Signals,
    second: Trajectory,
) -> Mapping[str, Controlled]:
    """The errors of a solver in each observable, as the second run shows."""
    truth = exact.observe(second.times)
    controlled = {}
    for name, error in errors.items():
        theirs = np.interp(run.times, second.times, second.observables[name] - truth[name])
        own = by_second_run(error, theirs)
        beyond = np.abs(error) - own - by_rounding(doubt[name], run.steps)
        controlled[name] = Controlled(float(own.max()), max(float(beyond.max()), 0.0))
    return controlled


def _held(
    predicted: Array, error: Array, left: Array, terms: Mapping[int, float], nonlinear: float
) -> Prediction:
    difference = np.abs(error - predicted)
    return Prediction(
        float(np.abs(predicted).max()),
        float(predicted[-1]),
        terms,
        nonlinear,
        float(difference.max()),
        float(left.max()),
        float(np.maximum(difference - left, 0.0).max()),
    )


def floor(error: ObservedError, steps: int) -> float:
    """The part of an error that no smaller step removes: the model-error bounds, what double
    precision allows the exact answer, and the rounding of every step."""
    return error.model_error + rounding(error, steps)


def rounding(error: ObservedError, steps: int) -> float:
    """Bound on the rounding of the exact answer and of the steps, without the model's error."""
    return error.uncertainty * roundings(steps)


def unpredicted(found: Sequence[Measurement], method: Method) -> bool:
    """Whether no theory says anything of the errors of fixed-step runs."""
    errors = [e for m in found for e in m.errors.values()]
    return method.control == "step" and bool(errors) and not any(e.predicted for e in errors)


def reference_run(found: Sequence[Measurement], method: Method) -> Measurement | None:
    """The run that stands for a method: the one whose step is nearest to a millisecond, or has the
    tightest tolerance, of those that reached their end; None where none did."""
    done = [m for m in found if m.status == "done"]
    if method.control == "tolerance":
        return min(done, key=lambda m: m.step, default=None)
    return min(done, key=lambda m: abs(math.log(m.step / REFERENCE_STEP)), default=None)


def relative_error(found: Measurement, quantities: Sequence[Quantity]) -> float:
    """The error of a run: the worst of its quantities of interest, relative to their scales;
    infinite for a run that diverged, not a number for one that was not made or leaves one out."""
    if found.status != "done":
        return math.inf if found.status == "diverged" else math.nan
    return worst(found, quantities)[1]


def worst(found: Measurement, quantities: Sequence[Quantity]) -> tuple[Quantity, float]:
    """The quantity of interest whose error is the largest, relative to its scale, and that error,
    not a number where the run leaves the quantity out."""
    errors = [(q, _of_interest(found.errors.get(q.observable), q)) for q in quantities]
    return max(errors, key=lambda pair: math.inf if math.isnan(pair[1]) else pair[1])


def _of_interest(error: ObservedError | None, quantity: Quantity) -> float:
    if error is None:
        return math.nan
    size = abs(error.end) if quantity.when == "end" else error.largest
    return size / quantity.scale
