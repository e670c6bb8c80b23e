"""Is a run within its tolerance, and what does a whole convergence study say of its method?

Both questions are answered by rules in order: the first that applies gives the verdict.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import (
    Measurement,
    ObservedError,
    relative_error,
    unpredicted,
)
from plumbob.models.scene import Observable, Quantity, System
from plumbob.reports.judge.converging import convergence
from plumbob.reports.judge.not_read import not_read
from plumbob.reports.judge.tolerance import (
    Tolerance,
    exceeded,
    round_off,
    starts_off,
    tolerance,
    too_wide,
)

Verdict = Literal[
    "predicted",
    "converges",
    "off-prediction",
    "inaccurate",
    "not-converging",
    "diverged",
    "cut-short",
    "pre-asymptotic",
    "unsupported",
    "missing",
]
NO_STEP_FITS = "no step of the scene's step sizes fits"
# Rules of judgement, chosen and not derived:
ELSEWHERE = 0.5  # of the motion itself: a linear bound along the exact motion does not apply
UNBOUNDED = 10.0  # times the motion: a predicted error beyond it is one of an unstable step
FLAT = 0.7  # three finer steps that leave this much of an error have not helped
LEAVES_OUT = "the run leaves out"
THEORY = "theory of its error"
# multiples of the round-off level: an error within them may be resolved no further
FLOORS = 100.0


@dataclass(frozen=True)
class Judgement:
    """A run's verdict, the tolerance of each observable it was compared with, and the reason."""

    verdict: Verdict
    tolerances: Mapping[str, Tolerance]
    reason: str
    cut: bool = False  # finer steps of the convergence study were left out, by the profile
    unjudged: Mapping[str, str] = field(default_factory=dict)
    """Observables that no tolerance is held to though others have one, and why."""
    errors: Mapping[float, float] = field(default_factory=dict)
    """Relative errors of the runs that were made, by step [s], of the quantities of interest."""
    drawn: Judgement | None = None  # of the run at a step that nobody listed
    versions: Mapping[str, str] | None = None
    """Of the packages that it was measured with; None: those that are installed."""


@dataclass(frozen=True)
class Judged:
    """The verdict on a method on a scene, and on each of its runs, coarse to fine."""

    whole: Judgement
    runs: tuple[Judgement, ...]


@dataclass(frozen=True)
class StoredObservables:
    """The observables of a scene as a study keeps them, the leading one first."""

    observables: tuple[Observable, ...]


Observed = System | StoredObservables


def judged(
    series: ConvergenceStudy, system: Observed, method: Method, about: Sequence[Quantity]
) -> Judged:
    """The verdict on a method on a scene, from those on its runs; `about` are the scene's
    quantities of interest."""
    every = [(m, judge(m, system, method, about)) for m in series.measurements]
    listed = [pair for pair in every if pair[0].step not in series.beside] or every
    beside = [run for m, run in every if m.step in series.beside]
    units = {o.name: o.unit for o in system.observables}
    unjudged = _never_judged([run for _, run in listed])
    result = _of_runs(listed, beside, units, method, about, unjudged)
    errors = {step: error for _, run in listed for step, error in run.errors.items()}
    drawn = None if series.drawn is None else judge(series.drawn, system, method, about)
    result = replace(result, cut=series.cut, unjudged=unjudged, errors=errors, drawn=drawn)
    return Judged(result, tuple(run for _, run in every))


def judge(
    measurement: Measurement, system: Observed, method: Method, about: Sequence[Quantity] = ()
) -> Judgement:
    """Compare one run with its tolerances; `pre-asymptotic` where no theory reaches it. `about` are
    the scene's quantities of interest, for the relative error."""
    units = {o.name: o.unit for o in system.observables}
    bounds = {
        name: tolerance(measurement, method, name, units[name]) for name in measurement.errors
    }
    held = {name: bound for name, bound in bounds.items() if bound}
    verdict = _of_a_run(measurement, units, held)
    error = relative_error(measurement, about) if about else math.nan
    errors = {measurement.step: error} if math.isfinite(error) else {}
    return replace(verdict, unjudged=_unjudged(measurement, units, held), errors=errors)


def _of_a_run(
    run: Measurement, units: Mapping[str, str], held: Mapping[str, Tolerance]
) -> Judgement:
    """The verdict on a run by the tolerances of observables that theory says something of."""
    if run.status != "done":
        return Judgement(run.status, {}, run.reason)
    if dropped := _dropped(run, tuple(units)):
        return replace(dropped, tolerances=held)
    leading = next(iter(units))
    error = run.errors.get(leading)
    predicted = error.predicted if error else None
    exactly = predicted is not None and predicted.for_this_step
    stepped = predicted is not None and predicted.uncertainty is not None  # the motion itself
    bounded = predicted if exactly and not stepped else None
    if error and bounded and bounded.largest > ELSEWHERE * error.scale > 0.0:
        # Bounds of the model's error are linearised along the exact motion.
        far = (
            f"the predicted error of {leading} at this step exceeds half the motion, where the "
        )
        return Judgement("pre-asymptotic", {}, f"{far}bound of the model's error is not known")
    off = {
        name: why for name, bound in held.items() if (why := exceeded(run, name, bound, units))
    }
    for name, why in off.items():
        if not _unbounded(run.errors[name]):
            return Judgement("off-prediction", held, f"the error of {name} is {why}")
    if off:
        why = (
            f"the predicted error of {', '.join(off)} at this step has no bounds, as an engine"
        )
        return Judgement(
            "pre-asymptotic", {}, f"{why} may have that holds rates below some limit"
        )
    if error and leading in held:  # a tolerance as large as the motion itself tests nothing
        allowed = error.model_error if exactly else held[leading].bound
        if predicted and stepped:
            allowed = held[leading].bound - predicted.largest
        if 0.0 < error.scale <= allowed:
            why = f"{leading} may be {allowed:.3g} {units[leading]} beside what is predicted of it"
            return Judgement("pre-asymptotic", held, f"{why}, and is {error.scale:.3g} in all")
    if not held:
        theory = any(e.predicted or e.controlled for e in run.errors.values())
        why = f"{'the step is too large for the' if theory else 'there is no'} {THEORY}"
        return Judgement("pre-asymptotic", {}, run.note or why)
    return Judgement("predicted", held, "")


def _unbounded(error: ObservedError) -> bool:
    """Whether an error stays below one that is predicted to grow far beyond the motion: where a
    step is unstable, an engine may limit what the equations do not."""
    predicted = error.predicted.largest if error.predicted else 0.0
    return max(error.largest, UNBOUNDED * error.scale) < predicted


def _dropped(run: Measurement, observables: Sequence[str]) -> Judgement | None:
    """An observable that the run does not give, and that is not declared so, fails; and one that
    does not begin as in the scene."""
    declared = not_read(run.scene, run.method)
    names = [name for name in observables if name not in run.errors and name not in declared]
    if run.status != "done":
        return None
    why = f"{LEAVES_OUT} {', '.join(names)}" if names else starts_off(run)
    return Judgement("off-prediction", {}, why) if why else None


def _unjudged(
    run: Measurement, names: Iterable[str], held: Mapping[str, Tolerance]
) -> Mapping[str, str]:
    """Observables without a tolerance where others have one, each with the reason."""
    if run.status != "done" or not held:
        return {}
    known = not_read(run.scene, run.method)
    return {name: known.get(name) or _silent(run, name) for name in names if name not in held}


def _silent(run: Measurement, name: str) -> str:
    if name not in run.errors:
        return "the run does not give it"
    reached = run.errors[name].predicted or run.errors[name].controlled
    return f"the step is too large for the {THEORY}" if reached else f"there is no {THEORY}"


def _never_judged(runs: Sequence[Judgement]) -> Mapping[str, str]:
    """Observables that no run has a tolerance for, though runs have one for others; the reason is
    that of the finest of them."""
    held = [run.unjudged for run in runs if run.tolerances]
    finest = held[-1] if held else {}
    return {name: why for name, why in finest.items() if all(name in of for of in held)}


def _of_runs(
    listed: Sequence[tuple[Measurement, Judgement]],
    beside: Sequence[Judgement],
    units: Mapping[str, str],
    method: Method,
    about: Sequence[Quantity],
    unjudged: Mapping[str, str],
) -> Judgement:
    """The verdict on a method from its runs on a scene, coarse to fine; those `beside` its step
    sizes tell of no order and no plateau, and are judged each by itself. `units` are those of the
    observables, the leading one first."""
    found = [m for m, _ in listed]
    names = tuple(units)
    runs = [run for _, run in listed]

    def first(*verdicts: Verdict) -> Judgement | None:
        every = (
            run for verdict in verdicts for run in (*runs, *beside) if run.verdict == verdict
        )
        return next(every, None)

    if not_run := first("unsupported", "missing", "cut-short"):
        return not_run
    # An observable that an engine leaves out is no known limit.
    if dropped := next(filter(None, (_dropped(m, names) for m in found)), None):
        return dropped
    if unpredicted(found, method):  # only the envelope of its errors is judged
        result = convergence(found, about)
        diverged = first("diverged") if result.verdict is None else None
        return diverged or Judgement(result.verdict or "pre-asymptotic", {}, result.reason)
    failed = first("off-prediction")
    flat = _flat(found, units, names[0])
    # Steps too large for theory show nothing about finer ones.
    if flat and (failed or runs[-1].verdict not in ("predicted", "pre-asymptotic")):
        return Judgement("not-converging", failed.tolerances if failed else {}, flat)
    if failed:
        return failed
    if not runs:
        return Judgement("unsupported", {}, NO_STEP_FITS)
    passed = _finest(listed, names, about, unjudged) or runs[-1]
    return (_unexplained(found, units) if passed.verdict == "predicted" else None) or passed


def _finest(
    listed: Sequence[tuple[Measurement, Judgement]],
    names: Sequence[str],
    quantities: Sequence[Quantity],
    unjudged: Mapping[str, str],
) -> Judgement | None:
    """The finest run that passes, which stands for all, or why it may not; None where none does."""
    for finest, run in reversed(listed):
        if run.verdict == "predicted":
            too_much = _claims_too_much([m for m, _ in listed], names, unjudged)
            why = too_much or too_wide(finest, quantities)
            return Judgement("off-prediction", run.tolerances, why) if why else run
    return None


def _flat(found: Sequence[Measurement], units: Mapping[str, str], name: str) -> str:
    """Why the error of an observable stays far above round-off; empty while smaller steps still
    help, and if theory derives that what is left is the same at every step."""
    done = [m for m in found if m.status == "done" and name in m.errors][-4:]
    if len(done) < 4:
        return ""
    last = done[-1].errors[name]
    least = round_off(done[-1], name, units)
    helped = last.falling < FLAT * done[0].errors[name].falling
    if helped or last.falling <= last.model_error + FLOORS * least:
        return ""
    times = f", {last.largest / least:.2g} times the round-off level" if least else ""
    return f"the error of {name} stays at {last.largest:.3g}{times}"


def _unexplained(found: Sequence[Measurement], units: Mapping[str, str]) -> Judgement | None:
    """The verdict on runs that are as predicted, but whose error stays although theory does not
    derive that; None if there is no such error. The measured error and a prediction that steps the
    model are both differences from the same exact motion: if that is wrong, only an error that does
    not fall with the step shows it. An error as large as the motion shows nothing yet."""
    flat = {name: why for name in units if (why := _flat(found, units, name))}
    if not flat:
        return None
    last = [m for m in found if m.status == "done"][-1].errors
    lost = all(last[name].largest > ELSEWHERE * last[name].scale > 0.0 for name in flat)
    because = (
        "as large as the motion: no step that was run shows whether it falls"
        if lost
        else "and theory derives no error that is the same at every step"
    )
    why = f"{next(iter(flat.values()))}, {because}"
    return Judgement("pre-asymptotic" if lost else "not-converging", {}, why)


def _claims_too_much(
    found: Sequence[Measurement], names: Sequence[str], unjudged: Mapping[str, str]
) -> str:
    """Why a method that passes does not: every observable that the engine gives is to be judged in
    some run, and none that it is declared not to give."""
    given = [name for name in names if any(name in m.errors for m in found)]
    if silent := [name for name in given if name in unjudged]:
        return f"{', '.join(silent)}: not judged, {unjudged[silent[0]]}"
    declared = not_read(found[0].scene, found[0].method)
    if judged := [name for name in declared if name not in unjudged]:
        return f"{', '.join(judged)}: judged, and declared to be not"
    return ""
