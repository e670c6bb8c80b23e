"""Is a run within its tolerance, and what does a whole convergence_study of steps say of its method?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, ObservedError, floor
from plumbob.models.scene import System
from plumbob.reports.judge.tolerance import Tolerance, missed, tolerance

Verdict = Literal["pass", "fail", "not-converging", "diverged", "unsupported", "missing", "coarse"]
ELSEWHERE = 0.5  # of the motion itself
FLAT = 0.7  # three finer steps that leave this much of an error have not helped


@dataclass(frozen=True)
class Judgement:
    """A run's verdict, the tolerance of each observable it was held to, and the reason."""

    verdict: Verdict
    tolerances: Mapping[str, Tolerance]
    reason: str
    cut: bool = False  # finer steps of the step_sizes were left out, by the profile


def judge(found: Measurement, system: System, method: Method) -> Judgement:
    """Hold one run to its tolerances; `coarse` where theory does not reach its step."""
    if found.status != "done":
        return Judgement(found.status, {}, found.reason)
    units = {o.name: o.unit for o in system.observables}
    leading = system.observables[0].name
    if leading in found.errors and _elsewhere(found.errors[leading]):
        far = f"{leading} is to go elsewhere at this step, where the model's share is not known"
        return Judgement("coarse", {}, far)
    held = {name: tolerance(found, method, name, units[name]) for name in found.errors}
    known = {name: bound for name, bound in held.items() if bound is not None}
    for name, bound in known.items():
        error = found.errors[name].largest
        if not error <= bound.bound:
            reason = f"{name} is off by {error:.3g} {bound.unit}, allowed {bound.bound:.3g}"
            return Judgement("fail", known, reason)
        if (why := missed(found.errors[name])) is not None:
            return Judgement("fail", known, f"{name} is {why} {bound.unit}")
    if leading in known:
        seen = found.errors[leading]
        if 0.0 < seen.scale <= (allowed := _unexplained(seen, known[leading])):
            why = f"{leading} may be {allowed:.3g} {units[leading]} beside what is predicted of it"
            return Judgement("coarse", known, f"{why}, and is {seen.scale:.3g} in all")
    if not known:
        told = any(e.predicted or e.controlled for e in found.errors.values())
        why = "the step is too coarse for" if told else "there is no"
        return Judgement("coarse", {}, found.note or f"{why} theory of its error")
    return Judgement("pass", known, "")


def _elsewhere(error: ObservedError) -> bool:
    """Whether a step goes by theory so far from the exact motion that what the model adds, which is
    reckoned along that, says nothing."""
    told = error.predicted
    return bool(told and told.missed is not None and told.largest > ELSEWHERE * error.scale > 0.0)


def _unexplained(error: ObservedError, held: Tolerance) -> float:
    """How far an error may be from what theory says of it: the model's share where that is said to
    the last digit, else all of its tolerance."""
    told = error.predicted
    return sum(error.model.values()) if told and told.missed is not None else held.bound


def judge_convergence(found: ConvergenceStudy, system: System, method: Method) -> Judgement:
    """The verdict on a method on a scene: the worst of its runs, but for steps too coarse for it,
    if a finer one is within tolerance."""
    return replace(_judge_convergence(found, system, method), cut=found.cut)


def _judge_convergence(found: ConvergenceStudy, system: System, method: Method) -> Judgement:
    runs = [judge(m, system, method) for m in found.measurements]
    for verdict in ("unsupported", "missing"):
        for run in runs:
            if run.verdict == verdict:
                return run
    failed = [run for run in runs if run.verdict == "fail"]
    if failed:
        flat = _flat(found.measurements, system.observables[0].name)
        return (
            failed[0] if flat is None else Judgement("not-converging", failed[0].tolerances, flat)
        )
    # Steps too coarse for a theory that there is show nothing about finer ones.
    flat = _flat(found.measurements, system.observables[0].name)
    if flat is not None and runs[-1].verdict != "coarse":
        return Judgement("not-converging", {}, flat)
    passed = [run for run in runs if run.verdict == "pass"]
    if passed:
        return passed[-1]
    if not runs:
        return Judgement("unsupported", {}, "no step of the step_sizes fits")
    return runs[-1]


def _flat(found: Sequence[Measurement], leading: str) -> str | None:
    """Why the error has stopped far above round-off, or None while smaller steps still help."""
    done = [m for m in found if m.status == "done"]
    if len(done) < 4:
        return None
    last = [m.errors[leading] for m in done[-4:]]
    if last[-1].largest < FLAT * last[0].largest:
        return None
    least = floor(last[-1], done[-1].steps)
    if last[-1].largest <= 100.0 * least:
        return None
    times = f", {last[-1].largest / least:.0f} floors" if least else ""
    return f"{leading} stays off by {last[-1].largest:.3g}{times}"
