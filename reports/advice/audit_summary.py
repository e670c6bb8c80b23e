"""The summary of a motion audit: a grade for each of four questions, and the fixes, best first."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from plumbob.engines.audit.audit import Audit
from plumbob.reports.advice.audit_advice import AuditAdvice, Halving, StepChoice

# "good" needs nothing, "fair" should be looked at, "bad" should be changed.
Grade = Literal["good", "fair", "bad", "unknown"]
AuditQuestion = Literal["accuracy", "smaller step", "stability", "model"]
# [m] Largest errors of the grades "good" and "fair": about a tenth of what a gripper or a foot is
# placed with, and what is placed with.
GOOD_ERROR, FAIR_ERROR = 1e-3, 1e-2


@dataclass(frozen=True)
class Fix:
    """A change of integrator and step, and the number by which it divides the error."""

    choice: StepChoice
    # Infinite if the model's own run diverges; below 1 if the change only saves time
    gain: float


@dataclass(frozen=True)
class AuditSummary:
    """Grades of an audit by question, and its fixes, the largest gain first."""

    grades: tuple[tuple[AuditQuestion, Grade], ...]
    fixes: tuple[Fix, ...]


def audit_summary(audit: Audit, advice: AuditAdvice, halved: Halving | None) -> AuditSummary:
    """Returns the summary of an audit; `halved` is the effect of halving its step, None if no
    motion is certified."""
    grades: tuple[tuple[AuditQuestion, Grade], ...] = (
        ("accuracy", _accuracy(audit)),
        ("smaller step", _smaller_step(audit, halved)),
        ("stability", _stability(audit, advice)),
        ("model", _model(audit, advice)),
    )
    return AuditSummary(grades, _fixes(audit, advice))


def _accuracy(audit: Audit) -> Grade:
    """Returns the grade of the error at the model's own step."""
    if audit.found is None or audit.still:
        return "unknown"
    largest = audit.error + audit.uncertainty
    if not largest <= FAIR_ERROR:  # also if the run diverges
        return "bad"
    return "good" if largest <= GOOD_ERROR else "fair"


def _smaller_step(audit: Audit, halved: Halving | None) -> Grade:
    """Returns the grade of what a smaller step does: "good" if the error falls with the step or is
    too small to see it fall."""
    if halved is None or audit.still:
        return "unknown"
    if halved.outcome in ("diverges", "needed", "does not help"):
        return "bad"
    return "fair" if halved.outcome == "hardly helps" else "good"


def _stability(audit: Audit, advice: AuditAdvice) -> Grade:
    """Returns the grade of the distance of the model's own step from the largest that holds."""
    stability = audit.stability
    if stability is None:
        return "unknown"
    if stability.unstable:
        return "bad"
    if advice.near_limit is not None:
        return "fair"
    return "good" if stability.own.confirmed or stability.own.holds_to else "unknown"


def _model(audit: Audit, advice: AuditAdvice) -> Grade:
    """Returns the grade of the model itself: "bad" if MuJoCo changes the model to keep it stable,
    "fair" if contacts drift or are deep at any step, or the solver does not converge."""
    if advice.situation == "uncertified":
        return "unknown"
    if advice.raised:
        return "bad"
    return "fair" if advice.model_effects or advice.more_iterations else "good"


def _fixes(audit: Audit, advice: AuditAdvice) -> tuple[Fix, ...]:
    """Returns the advised choices that change the file, each once, the largest gain first. The
    choice that only saves computing time comes last."""
    choices = [choice for _, choice in advice.cheapest if choice is not None]
    if advice.enough is not None:
        choices.append(advice.enough)
    by_change = {
        (choice.integrator, choice.step): choice for choice in choices if choice.options
    }
    fixes = [Fix(choice, _gain(audit, choice)) for choice in by_change.values()]
    useful = [fix for fix in fixes if fix.gain > 1.0 or fix.choice == advice.enough]
    return tuple(sorted(useful, key=lambda fix: -fix.gain))


def _gain(audit: Audit, choice: StepChoice) -> float:
    """Returns the number by which a choice divides the error."""
    if not math.isfinite(audit.error):
        return math.inf
    return audit.error / choice.error if choice.error else math.inf
