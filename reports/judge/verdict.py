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
    round_off,
    start_mismatch,
    tolerance,
    tolerance_excess,
    wide_model_bound,
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
LINEAR_RANGE = 0.5
# Predicted error relative to the motion, from which a step counts as unstable.
UNSTABLE_RATIO = 10.0
PLATEAU_RATIO = 0.7  # ratio of the error at the smallest of four steps to that at the largest
LEAVES_OUT = "the run leaves out"
ERROR_THEORY = "theory of its error"
# Error relative to the round-off level, below which smaller steps need not reduce the error.
PLATEAU_ROUND_OFFS = 100.0


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
class JudgedMethod:
    """The verdict on a method on a scene, and on each of its runs, coarse to fine."""

    whole: Judgement
    runs: tuple[Judgement, ...]


@dataclass(frozen=True)
class StoredObservables:
    """The observables of a scene as a stored study names them, the leading one first."""

    observables: tuple[Observable, ...]


ObservedSystem = System | StoredObservables


def judge_method(
    study: ConvergenceStudy,
    system: ObservedSystem,
    method: Method,
    quantities: Sequence[Quantity],
) -> JudgedMethod:
    """Returns the verdict on a method on a scene, with the verdicts on its runs. `quantities` are
    the scene's quantities of interest."""
    judged_runs = [(run, judge(run, system, method, quantities)) for run in study.measurements]
    # Runs beside the listed step sizes show no order and no plateau.
    listed = [pair for pair in judged_runs if pair[0].step not in study.beside] or judged_runs
    beside = [judgement for run, judgement in judged_runs if run.step in study.beside]
    units = {o.name: o.unit for o in system.observables}
    unjudged = _never_judged([judgement for _, judgement in listed])
    verdict = _method_verdict(listed, beside, units, method, quantities, unjudged)
    errors: dict[float, float] = {}
    for _, judgement in listed:
        errors.update(judgement.errors)
    drawn = None
    if study.drawn is not None:
        drawn = judge(study.drawn, system, method, quantities)
    whole = replace(verdict, cut=study.cut, unjudged=unjudged, errors=errors, drawn=drawn)
    return JudgedMethod(whole, tuple(judgement for _, judgement in judged_runs))


def judge(
    run: Measurement,
    system: ObservedSystem,
    method: Method,
    quantities: Sequence[Quantity] = (),
) -> Judgement:
    """Returns the verdict on one run: its errors compared with their tolerances. If no theory
    reaches the run's step, the verdict is `pre-asymptotic`. `quantities` are the scene's quantities
    of interest: the relative error refers to them."""
    units = {o.name: o.unit for o in system.observables}
    tolerances: dict[str, Tolerance] = {}
    for name in run.errors:
        bound = tolerance(run, method, name, units[name])
        if bound is not None:
            tolerances[name] = bound
    verdict = _run_verdict(run, units, tolerances)
    error = relative_error(run, quantities) if quantities else math.nan
    errors = {run.step: error} if math.isfinite(error) else {}
    unjudged = _unjudged_observables(run, units, tolerances)
    return replace(verdict, unjudged=unjudged, errors=errors)


def _run_verdict(
    run: Measurement, units: Mapping[str, str], tolerances: Mapping[str, Tolerance]
) -> Judgement:
    """Returns the verdict on a run. `tolerances` has the observables that theory covers; `units`
    has the units of all observables, the leading observable first."""
    if run.status != "done":
        return Judgement(run.status, {}, run.reason)
    failure = _content_failure(run, tuple(units))
    if failure:
        return replace(failure, tolerances=tolerances)
    leading = next(iter(units))
    verdict = (
        _beyond_linear_range(run, leading)
        or _tolerance_failure(run, units, tolerances)
        or _loose_tolerance(run, leading, units[leading], tolerances)
    )
    if verdict:
        return verdict
    if tolerances:
        return Judgement("predicted", tolerances, "")
    return Judgement("pre-asymptotic", {}, run.note or _beyond_theory(run.errors.values()))


def _beyond_linear_range(run: Measurement, leading: str) -> Judgement | None:
    """Returns `pre-asymptotic` if the predicted error of the leading observable is too large for
    the bound of the model error: the bound is linearised along the exact motion. Otherwise returns
    None."""
    error = run.errors.get(leading)
    if error is None or error.predicted is None:
        return None
    predicted = error.predicted
    # A prediction with an uncertainty steps the motion itself, and needs no linearised bound.
    if not predicted.for_this_step or predicted.uncertainty is not None:
        return None
    if not predicted.largest > LINEAR_RANGE * error.scale > 0.0:
        return None
    reason = (
        f"the predicted error of {leading} at this step exceeds half the motion: the bound of "
        "the model error is not known there"
    )
    return Judgement("pre-asymptotic", {}, reason)


def _tolerance_failure(
    run: Measurement, units: Mapping[str, str], tolerances: Mapping[str, Tolerance]
) -> Judgement | None:
    """Returns `off-prediction` if an error exceeds its tolerance; None if no error does. If the
    prediction of every such error grows far beyond the motion, returns `pre-asymptotic`."""
    excesses: dict[str, str] = {}
    for name, bound in tolerances.items():
        excess = tolerance_excess(run, name, bound, units)
        if excess:
            excesses[name] = excess
    for name, excess in excesses.items():
        if not _prediction_unbounded(run.errors[name]):
            reason = f"the error of {name} is {excess}"
            return Judgement("off-prediction", tolerances, reason)
    if not excesses:
        return None
    reason = (
        f"the predicted error of {', '.join(excesses)} grows without bound at this step, and "
        "the measured one does not: the engine may limit rates that the equations do not limit"
    )
    return Judgement("pre-asymptotic", {}, reason)


def _loose_tolerance(
    run: Measurement, leading: str, unit: str, tolerances: Mapping[str, Tolerance]
) -> Judgement | None:
    """Returns `pre-asymptotic` if the tolerance of the leading observable is as large as its
    motion: such a tolerance tests nothing. Otherwise None."""
    error = run.errors.get(leading)
    if error is None or leading not in tolerances:
        return None
    predicted = error.predicted
    if predicted is not None and predicted.uncertainty is not None:
        allowed = tolerances[leading].bound - predicted.largest
    elif predicted is not None and predicted.for_this_step:
        allowed = error.model_error
    else:
        allowed = tolerances[leading].bound
    if not 0.0 < error.scale <= allowed:
        return None
    reason = (
        f"the tolerance of {leading}, {allowed:.3g} {unit}, is as large as its motion, "
        f"{error.scale:.3g} {unit}"
    )
    return Judgement("pre-asymptotic", tolerances, reason)


def _prediction_unbounded(error: ObservedError) -> bool:
    """Whether the prediction grows far beyond the motion and the error stays below the prediction.
    At an unstable step this happens if an engine limits rates that the equations do not limit."""
    predicted = error.predicted.largest if error.predicted else 0.0
    return max(error.largest, UNSTABLE_RATIO * error.scale) < predicted


def _content_failure(run: Measurement, observables: Sequence[str]) -> Judgement | None:
    """Returns `off-prediction` if a run lacks an observable that is not declared as missing, or if
    the run does not start where the scene starts; otherwise None."""
    if run.status != "done":
        return None
    declared = not_read(run.scene, run.method)
    expected_names = [name for name in observables if name not in declared]
    missing = [name for name in expected_names if name not in run.errors]
    reason = f"{LEAVES_OUT} {', '.join(missing)}" if missing else start_mismatch(run)
    return Judgement("off-prediction", {}, reason) if reason else None


def _unjudged_observables(
    run: Measurement, names: Iterable[str], tolerances: Mapping[str, Tolerance]
) -> Mapping[str, str]:
    """Observables without a tolerance, each with the reason; empty if no observable has a
    tolerance."""
    if run.status != "done" or not tolerances:
        return {}
    declared = not_read(run.scene, run.method)
    unjudged = [name for name in names if name not in tolerances]
    return {name: declared.get(name) or _unjudged_reason(run, name) for name in unjudged}


def _unjudged_reason(run: Measurement, name: str) -> str:
    """The reason why an observable has no tolerance in a run."""
    if name not in run.errors:
        return "the run does not give it"
    return _beyond_theory([run.errors[name]])


def _beyond_theory(errors: Iterable[ObservedError]) -> str:
    """The reason why none of these errors has a tolerance: theory does not reach the step, or there
    is no theory of any of them."""
    if any(error.predicted or error.controlled for error in errors):
        return f"the step is too large for the {ERROR_THEORY}"
    return f"there is no {ERROR_THEORY}"


def _never_judged(judgements: Sequence[Judgement]) -> Mapping[str, str]:
    """Observables that have a tolerance in no run, each with the reason in the finest run. Runs
    without any tolerance do not count."""
    unjudged = [judgement.unjudged for judgement in judgements if judgement.tolerances]
    if not unjudged:
        return {}
    finest = unjudged[-1]
    in_every_run = set.intersection(*(set(names) for names in unjudged))
    return {name: reason for name, reason in finest.items() if name in in_every_run}


def _method_verdict(
    listed: Sequence[tuple[Measurement, Judgement]],
    beside: Sequence[Judgement],
    units: Mapping[str, str],
    method: Method,
    quantities: Sequence[Quantity],
    unjudged: Mapping[str, str],
) -> Judgement:
    """Returns the verdict on a method from its runs on a scene, coarse to fine. The runs `beside`
    the listed step sizes are judged one by one, and show no order and no plateau. `units` are the
    units of the observables, the leading observable first."""
    runs = [run for run, _ in listed]
    judgements = [judgement for _, judgement in listed]
    every = (*judgements, *beside)
    not_run = _first_with(every, "unsupported", "missing", "cut-short")
    if not_run:
        return not_run
    # A known limit does not excuse a missing observable: this rule stands before them.
    for run in runs:
        failure = _content_failure(run, tuple(units))
        if failure:
            return failure
    # Without theory, the envelope of the errors alone is judged.
    if unpredicted(runs, method):
        return _envelope_verdict(runs, quantities, every)
    failed = _first_with(every, "off-prediction")
    plateau = _leading_plateau(runs, units)
    # If only steps that are too large for theory pass, they show nothing about finer steps.
    if plateau and (failed or judgements[-1].verdict not in ("predicted", "pre-asymptotic")):
        return Judgement("not-converging", failed.tolerances if failed else {}, plateau)
    if failed:
        return failed
    if not judgements:
        return Judgement("unsupported", {}, NO_STEP_FITS)
    finest = _finest_verdict(listed, tuple(units), quantities, unjudged) or judgements[-1]
    if finest.verdict != "predicted":
        return finest
    return _unexplained_plateau(runs, units) or finest


def _first_with(judgements: Sequence[Judgement], *verdicts: Verdict) -> Judgement | None:
    """Returns a judgement that has one of these verdicts; an earlier verdict goes before a later
    one. None if no judgement has one."""
    for verdict in verdicts:
        for judgement in judgements:
            if judgement.verdict == verdict:
                return judgement
    return None


def _envelope_verdict(
    runs: Sequence[Measurement], quantities: Sequence[Quantity], judgements: Sequence[Judgement]
) -> Judgement:
    """Returns the verdict on a method without theory. If the envelope of the errors decides
    nothing, a run that diverged does; `judgements` are the verdicts on the runs."""
    result = convergence(runs, quantities)
    if result.verdict is not None:
        return Judgement(result.verdict, {}, result.reason)
    diverged = _first_with(judgements, "diverged")
    return diverged or Judgement("pre-asymptotic", {}, result.reason)


def _finest_verdict(
    listed: Sequence[tuple[Measurement, Judgement]],
    names: Sequence[str],
    quantities: Sequence[Quantity],
    unjudged: Mapping[str, str],
) -> Judgement | None:
    """Returns the finest run's verdict `predicted`, which stands for the method; None if no run is
    `predicted`. If the method leaves an observable unjudged, or its model-error bound is too wide,
    the verdict is `off-prediction` instead."""
    for run, judgement in reversed(listed):
        if judgement.verdict == "predicted":
            runs = [measurement for measurement, _ in listed]
            mismatch = _observables_mismatch(runs, names, unjudged)
            reason = mismatch or wide_model_bound(run, quantities)
            if reason:
                return Judgement("off-prediction", judgement.tolerances, reason)
            return judgement
    return None


def _plateau(runs: Sequence[Measurement], units: Mapping[str, str], name: str) -> str:
    """Message if the error of an observable stays far above round-off over the four finest runs;
    empty if smaller steps still reduce the error. The part of the error that theory derives as the
    same at every step does not count."""
    finest_four = [run for run in runs if run.status == "done" and name in run.errors][-4:]
    if len(finest_four) < 4:
        return ""
    coarse_error = finest_four[0].errors[name]
    fine_error = finest_four[-1].errors[name]
    level = round_off(finest_four[-1], name, units)
    falls = fine_error.falling < PLATEAU_RATIO * coarse_error.falling
    at_round_off = fine_error.falling <= fine_error.model_error + PLATEAU_ROUND_OFFS * level
    if falls or at_round_off:
        return ""
    times = f", {fine_error.largest / level:.2g} times the round-off level" if level else ""
    return f"the error of {name} stays at {fine_error.largest:.3g}{times}"


def _half_of_motion(error: ObservedError, unit: str) -> float:
    """Returns the error from which an error counts as large as the motion, in the observable's
    `unit`: LINEAR_RANGE of the motion. A turn brings an angle back, so that an angle's motion
    counts as one turn at most."""
    size = min(error.scale, math.tau) if unit == "rad" else error.scale
    return LINEAR_RANGE * size


def _leading_plateau(runs: Sequence[Measurement], units: Mapping[str, str]) -> str:
    """Message of `_plateau` for the leading observable; empty if theory predicts an error as large
    as the motion at the finest step. So large an error need not fall from step to step: only the
    difference from the prediction shows a defect."""
    leading = next(iter(units))
    plateau = _plateau(runs, units, leading)
    if not plateau:
        return ""
    finest = [run for run in runs if run.status == "done" and leading in run.errors][-1]
    error = finest.errors[leading]
    predicted = error.predicted.largest if error.predicted else 0.0
    return "" if predicted > _half_of_motion(error, units[leading]) > 0.0 else plateau


def _unexplained_plateau(
    runs: Sequence[Measurement], units: Mapping[str, str]
) -> Judgement | None:
    """Returns the verdict if every run is as predicted and yet an error stays that theory does not
    derive; None if there is no such error. The exact motion is part of the measured error and of a
    prediction that steps the model. If the exact motion is wrong, only an error that does not fall
    with the step shows it. An error as large as the motion does not show it."""
    plateaus: dict[str, str] = {}
    for name in units:
        plateau = _plateau(runs, units, name)
        if plateau:
            plateaus[name] = plateau
    if not plateaus:
        return None
    finest = [run for run in runs if run.status == "done"][-1]
    halves = {name: _half_of_motion(finest.errors[name], units[name]) for name in plateaus}
    plateau = next(iter(plateaus.values()))
    if all(finest.errors[name].largest > half > 0.0 for name, half in halves.items()):
        reason = "as large as the motion: no step that was run shows whether it falls"
        return Judgement("pre-asymptotic", {}, f"{plateau}, {reason}")
    reason = "and theory derives no error that is the same at every step"
    return Judgement("not-converging", {}, f"{plateau}, {reason}")


def _observables_mismatch(
    runs: Sequence[Measurement], names: Sequence[str], unjudged: Mapping[str, str]
) -> str:
    """Message if a method that passes leaves an observable unjudged in every run, or is judged by
    an observable that its engine is declared not to give; otherwise empty."""
    given: set[str] = set()
    for run in runs:
        given.update(run.errors)
    silent = [name for name in names if name in given and name in unjudged]
    if silent:
        return f"{', '.join(silent)}: not judged, {unjudged[silent[0]]}"
    declared = not_read(runs[0].scene, runs[0].method)
    judged = [name for name in declared if name not in unjudged]
    if judged:
        return f"{', '.join(judged)}: judged, although the engine is declared not to give it"
    return ""
