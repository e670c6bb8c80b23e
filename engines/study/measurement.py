"""Measures one run against the exact answer: errors, their predictions, invariants, cost."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from plumbob.analytic.answer_cache import Same, as_stepped, exactly, expected_series
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

REFERENCE_STEP = 1e-3  # [s] step at which errors of fixed-step methods are compared
Status = Literal["done", "diverged", "cut-short", "unsupported", "missing"]


@dataclass(frozen=True)
class Prediction:
    """The predicted error of one observable: a series sum_p C_p step^p, or the error of the scheme
    stepped in plain numbers. "Largest" means over the samples of the run."""

    largest: float  # largest magnitude
    end: float  # value at the end, with its sign
    terms: Mapping[int, float]  # {p: largest |C_p| step^p}; empty if it is no series
    nonlinearity: float  # see `Reference.nonlinearity`
    difference: float = 0.0  # largest magnitude of the measured less the predicted error
    open: float = 0.0  # largest bound on that difference that theory leaves open
    beyond: float = 0.0  # largest amount by which that difference exceeds its bound
    uncertainty: float | None = None
    """Largest response of the stepped motion to rounding; None if the response of the exact motion
    applies."""
    lasting: float = 0.0
    """Largest derived size of the part of the error that no smaller step reduces."""
    beside_lasting: float | None = None
    """Largest excess of the measured error over that part; None if theory derives no such part."""

    @property
    def for_this_step(self) -> bool:
        """Whether it is the error of the scheme stepped at this very step, and no series."""
        return not self.terms


@dataclass(frozen=True)
class Controlled:
    """The error that a solver with a tolerance makes in an observable, as a second solver of the
    same equations shows, whose tolerance is much smaller. Errors that both solvers have are not in
    it."""

    largest: float  # largest bound on the error over the samples
    beyond: float  # largest amount by which the error of a sample exceeds its bound


@dataclass(frozen=True)
class ObservedError:
    """The error of one observable against the exact answer, in the observable's SI unit."""

    largest: float  # largest magnitude over the samples
    end: float  # value at the end of the run, with its sign
    uncertainty: float  # largest uncertainty of the exact answer in double precision
    scale: float  # largest magnitude of the exact observable
    model: Mapping[str, float] = field(default_factory=dict)
    """{reason: bound} of the errors of the engine's model, which do not come from the step."""
    predicted: Prediction | None = None
    controlled: Controlled | None = None
    start: float = 0.0  # magnitude at the first sample; 0 for a force

    @property
    def model_error(self) -> float:
        """The bound on the error of the engine's model, whatever the step."""
        return sum(self.model.values())

    @property
    def falling(self) -> float:
        """The largest magnitude of the part of the error that smaller steps must reduce: all of the
        error except the part that theory derives as the same at every step."""
        known = self.predicted.beside_lasting if self.predicted else None
        return self.largest if known is None else known

    @property
    def left_open(self) -> float | None:
        """The amount by which the error may differ from its prediction; None without a
        prediction."""
        return None if self.predicted is None else self.model_error + self.predicted.open


@dataclass(frozen=True)
class Measurement:
    """A measured run of a scene with a method and a step. It is small: workers return it."""

    scene: str
    method: str
    step: float  # [s], or the relative tolerance of an adaptive method
    status: Status
    reason: str = ""
    errors: Mapping[str, ObservedError] = field(default_factory=dict)
    invariants: Mapping[str, float] = field(default_factory=dict)  # largest relative drifts
    duration: float = 0.0  # simulated time [s]
    steps: int = 0
    seconds: float = 0.0  # processor time of this run's steps [s]; costs are measured apart
    compile_seconds: float = 0.0
    diverged_at: float | None = None  # [s]
    warnings: tuple[str, ...] = ()
    note: str = ""  # why there is no prediction, if theory does not know the scheme


def measure(
    case: Case, method: Method, step: float, theory: bool = True
) -> tuple[Measurement, Trajectory | None]:
    """Runs a case once and measures the run; returns the trajectory too, if there is one. A method
    that controls its local error is compared with a second run. Without `theory` only errors are
    measured, without their bounds, which take longer than the run. Raises ParameterError, and
    NoAnswer if double precision does not determine the exact solution."""
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
    # The run's own time is wall time; the time of this thread also counts reading samples.
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
    """Returns why a run that did not diverge is not the run that was requested; empty if it is."""
    fixed = step if method.control == "step" else None
    return cut_short(run, case.scene.duration, fixed)


def complete_run(case: Case, method: Method, step: float) -> Trajectory:
    """Returns a run that reached its end, with finite numbers and the samples that were asked for.
    Raises NoAnswer if the run is lost or incomplete, and Unsupported."""
    run = engine_of(method).prepare(case, method, step).run()
    if why := lost(run) or not_asked_for(case, method, step, run):
        raise NoAnswer(why)
    return run


def scheme_of(case: Case, method: Method) -> Scheme:
    """The scheme of a method on this case: the method's own, unless the engine names another."""
    named = engine_of(method).ability(SchemeOfCase)
    return method.scheme if named is None else named.of(case, method)


def _differences(case: Case, run: Trajectory) -> Mapping[str, ObservedError]:
    """The errors of the observables, without bounds; raises NoAnswer."""
    with answering():
        exact = case.reference.observe(run.times)
        names = [o.name for o in case.system.observables]
        errors = {n: run.observables[n] - exact[n] for n in names if n in run.observables}
    return {
        name: ObservedError(float(np.abs(error).max()), float(error[-1]), 0.0, 0.0)
        for name, error in errors.items()
    }


def invariant_drifts(case: Case, run: Trajectory) -> Mapping[str, float]:
    """The largest relative drift of each invariant; empty if the run lacks observables that the
    invariants need."""
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
    """The errors of the observables of a run, with their predictions and bounds."""
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
    """Predictions of the measured `errors`, shape (n,) each, by observable. They are theory's
    series in the step; if the series does not reach this step, they are the errors of the scheme
    stepped in plain numbers, of which only rounding is left open. `doubt` is the uncertainty of the
    exact answer, shape (n,) by observable."""
    scheme = scheme_of(case, method)
    times = run.times.tobytes()
    powers, total, nonlinear = expected_series(
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
    """Predictions by the scheme stepped in plain numbers, of which only rounding is left open: the
    uncertainty of the stepped motion if it is known, else `doubt`, the uncertainty of the exact
    answer."""
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
    """Adds to the prediction of an `error`, shape (n,), the part that is the same at every step,
    with the derived `size`, shape (n,), and the excess of the error over that part. If there is no
    such part, the prediction stays as it is."""
    if size is None:
        return predicted
    beside = np.maximum(np.abs(error) - np.abs(size), 0.0)
    largest = float(np.abs(size).max())
    return replace(predicted, lasting=largest, beside_lasting=float(beside.max()))


def confirming(case: Case, method: Method) -> Trajectory | None:
    """The second run with which a method that controls its local error is compared; None if the
    engine has no such run, or the run fails."""
    second = engine_of(method).ability(SecondRun)
    if second is None:
        return None
    other, tolerance = second.of(method)
    key = Same(case.problem), case.scene.duration, other.name, tolerance
    return _confirmed(_Second(key, case, other, tolerance))


@dataclass(frozen=True)
class _Second:
    """A second run, which all methods on the same problem share: two are equal if their keys
    are."""

    key: tuple[Same, float, str, float]  # problem, duration [s], method, tolerance
    case: Case = field(compare=False)
    method: Method = field(compare=False)
    tolerance: float = field(compare=False)


@lru_cache(maxsize=4)
def _confirmed(second: _Second) -> Trajectory | None:
    """The trajectory of a second run; None if it fails."""
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
    """The error of a solver in each observable, as the `second` run shows it."""
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
    """The prediction of a measured error that may differ by `left`, shape (n,) each."""
    difference = np.abs(error - predicted)
    return Prediction(
        largest=float(np.abs(predicted).max()),
        end=float(predicted[-1]),
        terms=terms,
        nonlinearity=nonlinear,
        difference=float(difference.max()),
        open=float(left.max()),
        beyond=float(np.maximum(difference - left, 0.0).max()),
    )


def floor(error: ObservedError, steps: int) -> float:
    """The floor of an error, which no smaller step removes: the bounds on the model's error, the
    uncertainty of the exact answer, and the rounding of `steps` steps."""
    return error.model_error + rounding_bound(error, steps)


def rounding_bound(error: ObservedError, steps: int) -> float:
    """The bound on the rounding of the exact answer and of `steps` steps, without the model's
    error."""
    return error.uncertainty * roundings(steps)


def unpredicted(found: Sequence[Measurement], method: Method) -> bool:
    """Whether the runs are of a fixed-step method, and no error of theirs is predicted."""
    errors = [error for run in found for error in run.errors.values()]
    predicted = any(error.predicted for error in errors)
    return method.control == "step" and bool(errors) and not predicted


def reference_run(found: Sequence[Measurement], method: Method) -> Measurement | None:
    """The run that represents a method, of the runs that reached their end: the run at the step
    nearest to REFERENCE_STEP, or with the tightest tolerance. None if no run reached its end."""
    done = [m for m in found if m.status == "done"]
    if method.control == "tolerance":
        return min(done, key=lambda m: m.step, default=None)
    return min(done, key=lambda m: abs(math.log(m.step / REFERENCE_STEP)), default=None)


def relative_error(found: Measurement, quantities: Sequence[Quantity]) -> float:
    """The relative error of a run: the largest over the quantities of interest, relative to their
    scales. It is infinite for a run that diverged, and nan if the run was not made or lacks a
    quantity."""
    if found.status != "done":
        return math.inf if found.status == "diverged" else math.nan
    return worst(found, quantities)[1]


def worst(found: Measurement, quantities: Sequence[Quantity]) -> tuple[Quantity, float]:
    """The quantity of interest with the largest error, relative to its scale, and that error, which
    is nan if the run lacks the quantity."""
    errors = [(q, _of_interest(found.errors.get(q.observable), q)) for q in quantities]
    return max(errors, key=lambda pair: math.inf if math.isnan(pair[1]) else pair[1])


def _of_interest(error: ObservedError | None, quantity: Quantity) -> float:
    """The error of a quantity of interest relative to its scale; nan without an error."""
    if error is None:
        return math.nan
    size = abs(error.end) if quantity.when == "end" else error.largest
    return size / quantity.scale
