"""Is a run within its tolerance, and what does a whole convergence study say of its method?

Both questions are answered by rules in order: the first that applies gives the verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Protocol

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, ObservedError, floor
from plumbob.engines.study.results import Study
from plumbob.models.scene import Observable
from plumbob.reports.judge.tolerance import Tolerance, missed, tolerance

Verdict = Literal[
    "pass", "fail", "not-converging", "diverged", "unsupported", "missing", "pre-asymptotic"
]
NO_STEP_FITS = "no step of the scene's step sizes fits"
# Rules of judgement, chosen and not derived:
ELSEWHERE = 0.5  # of the motion itself: a linear bound along the exact motion does not apply
FLAT = 0.7  # three finer steps that leave this much of an error have not helped
FLOORS = 100.0  # multiples of the round-off level: an error within them may be resolved no further


@dataclass(frozen=True)
class Judgement:
    """A run's verdict, the tolerance of each observable it was compared with, and the reason."""

    verdict: Verdict
    tolerances: Mapping[str, Tolerance]
    reason: str
    cut: bool = False  # finer steps of the convergence study were left out, by the profile


@dataclass(frozen=True)
class Judged:
    """The verdict on a method on a scene, and on each of its runs, coarse to fine."""

    whole: Judgement
    runs: tuple[Judgement, ...]


class Observed(Protocol):
    """What has observables, the leading one first: a system, or what a study keeps of it."""

    @property
    def observables(self) -> tuple[Observable, ...]:
        """Names and units."""
        ...


@dataclass(frozen=True)
class StoredObservables:
    """The observables of a scene as a study keeps them."""

    observables: tuple[Observable, ...]


Judgements = Mapping[tuple[str, str], Judged]  # by scene and method


def judge_study(study: Study) -> Judgements:
    """The verdicts on everything that a study measured; each run is judged once."""
    methods = {m.name: m for m in study.methods}
    observed = {s.name: StoredObservables(study.observables(s.name)) for s in study.scenes}
    return {
        (c.scene, c.method): judged(c, observed[c.scene], methods[c.method])
        for c in study.convergence
    }


def judged(found: ConvergenceStudy, system: Observed, method: Method) -> Judged:
    """The verdict on a method on a scene, from those on its runs."""
    runs = tuple(judge(m, system, method) for m in found.measurements)
    several = _Runs(found.measurements, runs, system.observables[0].name)
    whole = next(verdict for rule in _RULES_OF_RUNS if (verdict := rule(several)) is not None)
    return Judged(replace(whole, cut=found.cut), runs)


def judge_convergence(found: ConvergenceStudy, system: Observed, method: Method) -> Judgement:
    """The verdict on a method on a scene: the worst of its runs, but for steps too large for the
    theory, if a finer one is within tolerance."""
    return judged(found, system, method).whole


def judge(found: Measurement, system: Observed, method: Method) -> Judgement:
    """Compare one run with its tolerances; `pre-asymptotic` where no theory reaches it."""
    run = _Run(found, system, method)
    return next(verdict for rule in _RULES_OF_A_RUN if (verdict := rule(run)) is not None)


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
        return {name: bound for name, bound in held.items() if bound is not None}


def _not_done(run: _Run) -> Judgement | None:
    """What did not run to its end is judged by that alone."""
    status = run.found.status
    return None if status == "done" else Judgement(status, {}, run.found.reason)


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
        error = run.found.errors[name]
        if not error.largest <= bound.bound:
            reason = f"the error of {name} is {error.largest:.3g} {bound.unit}, allowed "
            return Judgement("fail", run.tolerances, f"{reason}{bound.bound:.3g}")
        if (why := missed(error)) is not None:
            return Judgement("fail", run.tolerances, f"the error of {name} is {why} {bound.unit}")
    return None


def _says_nothing(run: _Run) -> Judgement | None:
    """A tolerance as large as the motion itself tests nothing."""
    name = run.leading
    if name not in run.tolerances:
        return None
    seen = run.found.errors[name]
    predicted = seen.predicted
    exactly = predicted is not None and predicted.for_this_step
    allowed = sum(seen.model.values()) if exactly else run.tolerances[name].bound
    if predicted is not None and predicted.uncertainty is not None:
        allowed = run.tolerances[name].bound - predicted.largest
    if not 0.0 < seen.scale <= allowed:
        return None
    why = f"{name} may be {allowed:.3g} {run.units[name]} beside what is predicted of it"
    return Judgement("pre-asymptotic", run.tolerances, f"{why}, and is {seen.scale:.3g} in all")


def _no_theory(run: _Run) -> Judgement | None:
    """Without any tolerance nothing is claimed."""
    if run.tolerances:
        return None
    theory = any(e.predicted or e.controlled for e in run.found.errors.values())
    why = "the step is too large for the" if theory else "there is no"
    return Judgement("pre-asymptotic", {}, run.found.note or f"{why} theory of its error")


def _within(run: _Run) -> Judgement:
    return Judgement("pass", run.tolerances, "")


_RULES_OF_A_RUN: tuple[Callable[[_Run], Judgement | None], ...] = (
    _not_done, _leads_elsewhere, _beyond_tolerance, _says_nothing, _no_theory, _within,
)  # fmt: skip


@dataclass(frozen=True)
class _Runs:
    """The runs of one method on one scene, coarse to fine, with their verdicts."""

    found: Sequence[Measurement]
    runs: Sequence[Judgement]
    leading: str

    @cached_property
    def flat(self) -> str | None:
        """Why the error has stopped far above round-off; None while smaller steps still help, and
        where it is that of the scheme stepped on the same equation, which does converge."""
        done = [m for m in self.found if m.status == "done"]
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
        """The coarsest run with this verdict."""
        return next((run for run in self.runs if run.verdict == verdict), None)


def _does_not_run(several: _Runs) -> Judgement | None:
    return several.first("unsupported") or several.first("missing")


def _fails(several: _Runs) -> Judgement | None:
    """A failed run fails the method; where no step helps, it does not converge."""
    failed = several.first("fail")
    if failed is None or several.flat is None:
        return failed
    return Judgement("not-converging", failed.tolerances, several.flat)


def _stays(several: _Runs) -> Judgement | None:
    """An error that stays is a finding, unless the theory there is does not reach the finest step:
    steps too large for it show nothing about finer ones."""
    if several.flat is None or several.runs[-1].verdict == "pre-asymptotic":
        return None
    return Judgement("not-converging", {}, several.flat)


def _passes(several: _Runs) -> Judgement | None:
    passed = [run for run in several.runs if run.verdict == "pass"]
    return passed[-1] if passed else None


def _no_step_fits(several: _Runs) -> Judgement | None:
    if several.runs:
        return None
    return Judgement("unsupported", {}, NO_STEP_FITS)


def _as_the_finest(several: _Runs) -> Judgement:
    return several.runs[-1]


_RULES_OF_RUNS: tuple[Callable[[_Runs], Judgement | None], ...] = (
    _does_not_run, _fails, _stays, _passes, _no_step_fits, _as_the_finest,
)  # fmt: skip
