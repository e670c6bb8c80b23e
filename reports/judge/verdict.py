"""Is a run within its tolerance, and what does a whole convergence study say of its method?

Both questions are answered by rules in order: the first that applies gives the verdict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import (
    Measurement,
    ObservedError,
    floor,
    relative_error,
    unpredicted,
)
from plumbob.models.scene import Observable, Quantity, System
from plumbob.reports.judge.converging import convergence
from plumbob.reports.judge.not_read import not_read
from plumbob.reports.judge.tolerance import Tolerance, exceeded, starts_off, tolerance, too_wide

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
FLAT = 0.7  # three finer steps that leave this much of an error have not helped
LEAVES_OUT = "the run leaves out"
THEORY = "theory of its error"
FLOORS = 100.0  # multiples of the round-off level: an error within them may be resolved no further


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
    claims: str = ""  # what the engine says of its runs that is not so
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
    series: ConvergenceStudy, system: Observed, method: Method, about: Sequence[Quantity] = ()
) -> Judged:
    """The verdict on a method on a scene, from those on its runs; `about` are the scene's
    quantities of interest, or else the leading observable with its largest magnitude as scale."""
    every = [(m, judge(m, system, method, about)) for m in series.measurements]
    listed = [pair for pair in every if pair[0].step not in series.beside] or every
    names = tuple(o.name for o in system.observables)
    beside = [run for m, run in every if m.step in series.beside]
    runs = [run for _, run in listed]
    several = _Runs([m for m, _ in listed], runs, names, method, tuple(about), beside)
    result = next(verdict for rule in _RULES_OF_RUNS if (verdict := rule(several)))
    errors = {step: error for run in runs for step, error in run.errors.items()}
    drawn = None if series.drawn is None else judge(series.drawn, system, method, about)
    result = replace(result, cut=series.cut, unjudged=several.unjudged, errors=errors, drawn=drawn)
    return Judged(result, tuple(run for _, run in every))


def judge(
    measurement: Measurement, system: Observed, method: Method, about: Sequence[Quantity] = ()
) -> Judgement:
    """Compare one run with its tolerances; `pre-asymptotic` where no theory reaches it. `about` are
    the scene's quantities of interest, for the relative error."""
    run = _Run(measurement, system, method)
    verdict = next(verdict for rule in _RULES_OF_A_RUN if (verdict := rule(run)))
    error = relative_error(measurement, about) if about else math.nan
    errors = {measurement.step: error} if math.isfinite(error) else {}
    return replace(verdict, unjudged=run.unjudged, errors=errors)


@dataclass(frozen=True)
class _Run:
    """A run with what its rules ask of it."""

    found: Measurement
    system: Observed
    method: Method

    @property
    def leading(self) -> str:
        """The observable that the verdict leads with."""
        return self.system.observables[0].name

    @cached_property
    def units(self) -> Mapping[str, str]:
        """Unit of each observable."""
        return {o.name: o.unit for o in self.system.observables}

    @cached_property
    def tolerances(self) -> Mapping[str, Tolerance]:
        """Tolerances of the observables that theory says something of."""
        held = {
            name: tolerance(self.found, self.method, name, self.units[name])
            for name in self.found.errors
        }
        return {name: bound for name, bound in held.items() if bound}

    @cached_property
    def unjudged(self) -> Mapping[str, str]:
        """Observables without a tolerance where others have one, each with the reason."""
        if self.found.status != "done" or not self.tolerances:
            return {}
        known = not_read(self.found.scene, self.found.method)
        return {
            name: known[name] if name in known else self._silent(name)
            for name in self.units
            if name not in self.tolerances
        }

    def _silent(self, name: str) -> str:
        if name not in self.found.errors:
            return "the run does not give it"
        reached = self.found.errors[name].predicted or self.found.errors[name].controlled
        return f"the step is too large for the {THEORY}" if reached else f"there is no {THEORY}"


def _not_done(run: _Run) -> Judgement | None:
    """A run that did not reach its end is judged by that alone."""
    status = run.found.status
    return None if status == "done" else Judgement(status, {}, run.found.reason)


def _leaves_out(run: _Run) -> Judgement | None:
    """An observable that the run does not give, and that is not declared so, fails; and one that
    does not begin as in the scene."""
    dropped = _dropped(run.found, tuple(run.units))
    return dropped and replace(dropped, tolerances=run.tolerances)


def _dropped(run: Measurement, observables: Sequence[str]) -> Judgement | None:
    declared = not_read(run.scene, run.method)
    names = [name for name in observables if name not in run.errors and name not in declared]
    if run.status != "done":
        return None
    why = f"{LEAVES_OUT} {', '.join(names)}" if names else starts_off(run)
    return Judgement("off-prediction", {}, why) if why else None


def _leads_elsewhere(run: _Run) -> Judgement | None:
    """By theory the step takes the leading observable so far from the exact motion that bounds of
    the model's error, which are linearised along that motion, do not apply."""
    error = run.found.errors.get(run.leading)
    predicted = error and error.predicted
    if not error or not predicted or not predicted.for_this_step:
        return None
    if predicted.uncertainty is not None:  # the motion itself was stepped
        return None
    if not predicted.largest > ELSEWHERE * error.scale > 0.0:
        return None
    far = f"the predicted error of {run.leading} at this step exceeds half the motion, where the "
    return Judgement("pre-asymptotic", {}, f"{far}bound of the model's error is not known")


def _beyond_tolerance(run: _Run) -> Judgement | None:
    """An error above its bound, or off a prediction to the last digit, fails."""
    for name, bound in run.tolerances.items():
        if (why := exceeded(run.found, name, bound, run.units)) is not None:
            return Judgement("off-prediction", run.tolerances, f"the error of {name} is {why}")
    return None


def _says_nothing(run: _Run) -> Judgement | None:
    """A tolerance as large as the motion itself tests nothing."""
    name = run.leading
    if name not in run.tolerances:
        return None
    error = run.found.errors[name]
    predicted = error.predicted
    exactly = predicted is not None and predicted.for_this_step
    allowed = error.model_error if exactly else run.tolerances[name].bound
    if predicted and predicted.uncertainty is not None:
        allowed = run.tolerances[name].bound - predicted.largest
    if not 0.0 < error.scale <= allowed:
        return None
    why = f"{name} may be {allowed:.3g} {run.units[name]} beside what is predicted of it"
    return Judgement("pre-asymptotic", run.tolerances, f"{why}, and is {error.scale:.3g} in all")


def _no_theory(run: _Run) -> Judgement | None:
    """Without any tolerance nothing is claimed."""
    if run.tolerances:
        return None
    theory = any(e.predicted or e.controlled for e in run.found.errors.values())
    why = "the step is too large for the" if theory else "there is no"
    return Judgement("pre-asymptotic", {}, run.found.note or f"{why} {THEORY}")


_RULES_OF_A_RUN: tuple[Callable[[_Run], Judgement | None], ...] = (
    _not_done,
    _leaves_out,
    _leads_elsewhere,
    _beyond_tolerance,
    _says_nothing,
    _no_theory,
    lambda run: Judgement("predicted", run.tolerances, ""),
)


@dataclass(frozen=True)
class _Runs:
    """The runs of one method on one scene, coarse to fine, with their verdicts; those `beside` its
    step sizes tell of no order and no plateau, and are judged each by itself."""

    found: Sequence[Measurement]
    runs: Sequence[Judgement]
    observables: tuple[str, ...]  # the leading one first
    method: Method
    about: tuple[Quantity, ...]
    beside: Sequence[Judgement] = ()

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities of interest."""
        leading = [m.errors[self.leading].scale for m in self.found if self.leading in m.errors]
        return self.about or (Quantity(self.leading, max(leading, default=1.0) or 1.0),)

    @property
    def leading(self) -> str:
        """The observable that the verdict leads with."""
        return self.observables[0]

    @cached_property
    def unjudged(self) -> Mapping[str, str]:
        """Observables that no run has a tolerance for, though runs have one for others; the reason
        is that of the finest of them."""
        held = [run for run in self.runs if run.tolerances]
        judged = {name for run in held for name in run.tolerances}
        return {
            name: why
            for run in held[-1:]
            for name, why in run.unjudged.items()
            if name not in judged
        }

    @cached_property
    def flat(self) -> str | None:
        """Why the error has stopped far above round-off; None while smaller steps still help, and
        where it is that of the scheme stepped on the engine's own equations, which does converge to
        their motion."""
        done = [m for m in self.found if m.status == "done" and self.leading in m.errors]
        if len(done) < 4:
            return None
        last: list[ObservedError] = [m.errors[self.leading] for m in done[-4:]]
        if last[-1].largest < FLAT * last[0].largest:
            return None
        if (predicted := last[-1].predicted) and predicted.uncertainty is not None:
            return None
        least = floor(last[-1], done[-1].steps)
        if last[-1].largest <= FLOORS * least:
            return None
        times = f", {last[-1].largest / least:.2g} times the round-off level" if least else ""
        return f"the error of {self.leading} stays at {last[-1].largest:.3g}{times}"

    def first(self, verdict: Verdict) -> Judgement | None:
        """The coarsest run with this verdict, or one beside them."""
        return next((run for run in (*self.runs, *self.beside) if run.verdict == verdict), None)


def _does_not_run(several: _Runs) -> Judgement | None:
    return several.first("unsupported") or several.first("missing") or several.first("cut-short")


def _drops(several: _Runs) -> Judgement | None:
    """An observable that an engine leaves out is no known limit."""
    dropped = (_dropped(m, several.observables) for m in several.found)
    return next(filter(None, dropped), None)


def _without_theory(several: _Runs) -> Judgement | None:
    """Of a method that no theory covers only the envelope of its errors is judged."""
    if not unpredicted(several.found, several.method):
        return None
    result = convergence(several.found, several.quantities)
    if result.verdict is None and (diverged := several.first("diverged")):
        return diverged
    return Judgement(result.verdict or "pre-asymptotic", {}, result.reason)


def _fails(several: _Runs) -> Judgement | None:
    """A failed run fails the method; where no step helps, it does not converge."""
    failed = several.first("off-prediction")
    if failed is None or several.flat is None:
        return failed
    return Judgement("not-converging", failed.tolerances, several.flat)


def _stays(several: _Runs) -> Judgement | None:
    """An error that does not fall is `not-converging`, unless no theory reaches the finest step:
    steps too large for it show nothing about finer ones."""
    if several.flat is None or several.runs[-1].verdict == "pre-asymptotic":
        return None
    return Judgement("not-converging", {}, several.flat)


def _claims_too_much(several: _Runs) -> Judgement | None:
    """To pass, every observable that the engine gives is judged in some run; and none is that it
    is declared not to give."""
    passed = next((run for run in reversed(several.runs) if run.verdict == "predicted"), None)
    if passed is None:
        return None
    names = [n for n in several.observables if any(n in m.errors for m in several.found)]
    silent = [name for name in names if name in several.unjudged]
    if silent:
        why = several.unjudged[silent[0]]
        return Judgement(
            "off-prediction", passed.tolerances, f"{', '.join(silent)}: not judged, {why}"
        )
    declared = not_read(several.found[0].scene, several.found[0].method)
    judged = [name for name in declared if name not in several.unjudged]
    if judged:
        why = f"{', '.join(judged)}: judged, and declared to be not"
        return Judgement("off-prediction", passed.tolerances, why)
    return None


def _passes(several: _Runs) -> Judgement | None:
    """The finest run that passes stands for all, unless its model-error bound is too wide."""
    pairs = zip(several.found, several.runs, strict=True)
    passed = [(m, run) for m, run in pairs if run.verdict == "predicted"]
    if not passed:
        return None
    why = too_wide(passed[-1][0], several.quantities)
    return Judgement("off-prediction", passed[-1][1].tolerances, why) if why else passed[-1][1]


def _no_step_fits(several: _Runs) -> Judgement | None:
    if several.runs:
        return None
    return Judgement("unsupported", {}, NO_STEP_FITS)


_RULES_OF_RUNS: tuple[Callable[[_Runs], Judgement | None], ...] = (
    _does_not_run,
    _drops,
    _without_theory,
    _fails,
    _stays,
    _claims_too_much,
    _passes,
    _no_step_fits,
    lambda several: several.runs[-1],
)
