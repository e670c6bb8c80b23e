"""Verdicts on single runs and on convergence studies.

Each verdict is decided by rules in order: the first rule that applies gives the verdict.
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
# The next four rules are chosen, not derived.
# Largest predicted error relative to the motion: above it a bound that is linearised along the
# exact motion does not apply.
ELSEWHERE = 0.5
UNBOUNDED = 10.0  # predicted error relative to the motion, from which a step counts as unstable
FLAT = 0.7  # ratio of errors, three steps apart, from which smaller steps do not help
LEAVES_OUT = "the run leaves out"
THEORY = "theory of its error"
# Error relative to the round-off level, below which smaller steps need not reduce the error.
FLOORS = 100.0


@dataclass(frozen=True)
class Judgement:
    """The verdict on one run or on one convergence study, with the tolerances and the reason."""

    verdict: Verdict
    tolerances: Mapping[str, Tolerance]
    reason: str
    cut: bool = False  # whether the profile left out finer steps of the convergence study
    unjudged: Mapping[str, str] = field(default_factory=dict)
    """{observable without a tolerance: reason}; empty if no observable has a tolerance."""
    errors: Mapping[float, float] = field(default_factory=dict)
    """{step [s] or tolerance: relative error of the quantities of interest} of the runs."""
    drawn: Judgement | None = None  # the verdict on the run at a randomly drawn step
    versions: Mapping[str, str] | None = None
    """{package: version} at the time of measurement; None: the installed versions."""


@dataclass(frozen=True)
class Judged:
    """The verdict on a method on a scene, and on each of its runs, coarse to fine."""

    whole: Judgement
    runs: tuple[Judgement, ...]


@dataclass(frozen=True)
class StoredObservables:
    """The observables of a scene as a stored study names them, the leading one first."""

    observables: tuple[Observable, ...]


Observed = System | StoredObservables


def judged(
    series: ConvergenceStudy, system: Observed, method: Method, about: Sequence[Quantity]
) -> Judged:
    """Returns the verdict on a method on a scene, with the verdicts on its runs. `about` are the
    scene's quantities of interest."""
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
    """Returns the verdict on one run: its errors compared with their tolerances. If no theory
    reaches the run's step, the verdict is `pre-asymptotic`. `about` are the scene's quantities of
    interest: the relative error refers to them."""
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
    """Returns the verdict on a run. `held` are the tolerances of the observables that theory
    covers; `units` are the units of all observables, the leading observable first."""
    if run.status != "done":
        return Judgement(run.status, {}, run.reason)
    if dropped := _dropped(run, tuple(units)):
        return replace(dropped, tolerances=held)
    leading = next(iter(units))
    error = run.errors.get(leading)
    predicted = error.predicted if error else None
    exactly = predicted is not None and predicted.for_this_step
    # A prediction with an uncertainty steps the motion itself, and needs no linearised bound.
    stepped = predicted is not None and predicted.uncertainty is not None
    bounded = predicted if exactly and not stepped else None
    if error and bounded and bounded.largest > ELSEWHERE * error.scale > 0.0:
        # The bounds of the model error are linearised along the exact motion.
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
    # A tolerance as large as the motion itself tests nothing.
    if error and leading in held:
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
    """Whether the prediction grows far beyond the motion and the error stays below the prediction.
    At an unstable step this happens if an engine limits rates that the equations do not limit."""
    predicted = error.predicted.largest if error.predicted else 0.0
    return max(error.largest, UNBOUNDED * error.scale) < predicted


def _dropped(run: Measurement, observables: Sequence[str]) -> Judgement | None:
    """Returns `off-prediction` if a run lacks an observable that is not declared as missing, or if
    the run does not start where the scene starts; otherwise None."""
    declared = not_read(run.scene, run.method)
    names = [name for name in observables if name not in run.errors and name not in declared]
    if run.status != "done":
        return None
    why = f"{LEAVES_OUT} {', '.join(names)}" if names else starts_off(run)
    return Judgement("off-prediction", {}, why) if why else None


def _unjudged(
    run: Measurement, names: Iterable[str], held: Mapping[str, Tolerance]
) -> Mapping[str, str]:
    """Observables without a tolerance, each with the reason; empty if no observable has a
    tolerance."""
    if run.status != "done" or not held:
        return {}
    known = not_read(run.scene, run.method)
    return {name: known.get(name) or _silent(run, name) for name in names if name not in held}


def _silent(run: Measurement, name: str) -> str:
    """The reason why an observable has no tolerance in a run."""
    if name not in run.errors:
        return "the run does not give it"
    reached = run.errors[name].predicted or run.errors[name].controlled
    return f"the step is too large for the {THEORY}" if reached else f"there is no {THEORY}"


def _never_judged(runs: Sequence[Judgement]) -> Mapping[str, str]:
    """Observables that have a tolerance in no run, each with the reason in the finest run. Runs
    without any tolerance do not count."""
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
    """Returns the verdict on a method from its runs on a scene, coarse to fine. The runs `beside`
    the listed step sizes are judged one by one, and show no order and no plateau. `units` are the
    units of the observables, the leading observable first."""
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
    # A known limit does not excuse a missing observable: this rule stands before them.
    if dropped := next(filter(None, (_dropped(m, names) for m in found)), None):
        return dropped
    # Without theory, the envelope of the errors alone is judged.
    if unpredicted(found, method):
        result = convergence(found, about)
        diverged = first("diverged") if result.verdict is None else None
        return diverged or Judgement(result.verdict or "pre-asymptotic", {}, result.reason)
    failed = first("off-prediction")
    flat = _flat(found, units, names[0])
    # If only steps that are too large for theory pass, they show nothing about finer steps.
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
    """Returns the finest run's verdict `predicted`, which stands for the method; None if no run is
    `predicted`. If the method leaves an observable unjudged, or its model-error bound is too wide,
    the verdict is `off-prediction` instead."""
    for finest, run in reversed(listed):
        if run.verdict == "predicted":
            too_much = _claims_too_much([m for m, _ in listed], names, unjudged)
            why = too_much or too_wide(finest, quantities)
            return Judgement("off-prediction", run.tolerances, why) if why else run
    return None


def _flat(found: Sequence[Measurement], units: Mapping[str, str], name: str) -> str:
    """Message if the error of an observable stays far above round-off over the four finest runs;
    empty if smaller steps still reduce the error. The part of the error that theory derives as the
    same at every step does not count."""
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
    """Returns the verdict if every run is as predicted and yet an error stays that theory does not
    derive; None if there is no such error. The exact motion is part of the measured error and of a
    prediction that steps the model. If the exact motion is wrong, only an error that does not fall
    with the step shows it. An error as large as the motion does not show it."""
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
    """Message if a method that passes leaves an observable unjudged in every run, or is judged by
    an observable that its engine is declared not to give; otherwise empty."""
    given = [name for name in names if any(name in m.errors for m in found)]
    if silent := [name for name in given if name in unjudged]:
        return f"{', '.join(silent)}: not judged, {unjudged[silent[0]]}"
    declared = not_read(found[0].scene, found[0].method)
    if judged := [name for name in declared if name not in unjudged]:
        return f"{', '.join(judged)}: judged, and declared to be not"
    return ""
