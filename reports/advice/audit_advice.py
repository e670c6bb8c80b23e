"""The advice of an audit: which integrator and step a user's model file should have.

A step is advised only if the run at that step, and the run at every smaller step of the same
integrator, reaches the wanted error. No step is advised within 20 % of the largest step that holds.
No run is advised if another run that may be advised is both cheaper and more accurate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.costs import ALIKE, Ratio, ratio
from plumbob.engines.audit.reference import RESOLVED, Certificate
from plumbob.engines.audit.stability import LargestSteps
from plumbob.engines.audit.step_errors import TARGETS, TRUSTED, StepComparison, StepError
from plumbob.engines.own_motion import OUT_OF_TIME, OwnModel
from plumbob.reports.advice.step_search import LIMIT_FRACTION

# Ratio of errors: among runs of about the same cost, a change of the integrator has to gain more.
CLEARLY_BETTER = 2.0
# Ratio of errors that count as equal: two digits of both agree. Errors of Euler and implicitfast
# steps of a model without gyroscopic forces differ by less, and their costs by scatter alone.
EQUAL_ERRORS = 0.95
RAISED = 2.0  # in steps, the time constant to which refsafe raises a shorter one
# Effects of the model that a user may take for an error of the step.
VISIBLE_DEPTH = 1e-4  # [m] of a contact at the end of the motion
VISIBLE_DRIFT = 1e-4  # [m/s] of a contact at the end of the motion that friction should hold
# [m/s or rad/s] Largest velocity of a motion that has come to rest, but for drift.
AT_REST = 0.02
HELPS, HARDLY_HELPS = 0.71, 0.95  # ratios of the errors at half a step to those at the step
LISTED_ERRORS = 5  # largest number of errors listed as the step is halved


@dataclass(frozen=True)
class PassedOver:
    """A run that is cheaper than the advised run and whose own error is small enough, and the
    reason why it is not advised."""

    integrator: str
    step: float  # [s]
    cost: Ratio | None  # in multiples of the cost of the model's own step
    limit: float | None  # [s] the largest step that holds, if the run's step is too near it
    # The smaller step [s] whose error is too large, and that error [m]; None if there is none.
    worse: tuple[float, float] | None


@dataclass(frozen=True)
class StepChoice:
    """The integrator and step that are advised for a wanted error."""

    target: float  # [m] wanted error
    integrator: str
    step: float  # [s]
    # [m] the largest error at this step and at all smaller steps of the integrator that were run
    error: float
    # in multiples of the cost of the model's own step; None if that diverges
    cost: Ratio | None
    # {attribute of the file's options: (its value, the value to put in its place)}
    options: Mapping[str, tuple[str, str]]
    # Whether the engine would soften contacts that act at this step, unless refsafe is disabled.
    unguarded: bool
    limit: float | None  # [s] the largest step of the integrator that holds; None if not known
    passed_over: PassedOver | None  # the cheapest run that seems as good

    @property
    def new_options(self) -> dict[str, str]:
        """The values to put into the file, by the names of its options."""
        return {name: value for name, (_, value) in self.options.items()}


@dataclass(frozen=True)
class StepEvidence:
    """The runs of a user's model, and what is known of their errors and limits."""

    model: OwnModel
    reference: Certificate
    compared: StepComparison
    stability: LargestSteps | None

    @property
    def uncertainty(self) -> float:
        """The uncertainty [m] of the certified motion where the errors are taken."""
        return float(self.reference.uncertainty[self.compared.index])

    def error(self, run: StepError) -> float:
        """Returns the error [m] of a run."""
        return run.at(self.compared.index)

    def cost(self, run: StepError) -> Ratio | None:
        """Returns the cost of a run in multiples of the cost of the model's own step; None if one
        of both was not timed."""
        own = self.compared.own
        if run is own and run.cost:
            return Ratio(1.0, 1.0, 1.0)
        if run.cost is None or own.cost is None:
            return None
        return ratio(run.cost, own.cost, own.step / run.step)

    def limit(self, integrator: str) -> float | None:
        """Returns the largest step [s] of an integrator that holds along the motion, and at which
        no contact chatters; None if no such limit is known."""
        for limit in self.stability.limits if self.stability else ():
            known = limit.confirmed or limit.holds_to is not None
            if limit.integrator == integrator and known and limit.largest_step is not None:
                return min(limit.largest_step, limit.chatters or math.inf)
        return None

    def near_limit(self, integrator: str, step: float) -> bool:
        """Returns whether a step [s] is too near the limit of an integrator to be advised."""
        limit = self.limit(integrator)
        return limit is not None and step > LIMIT_FRACTION * limit

    def smaller_runs(self, run: StepError) -> list[StepError]:
        """Returns the runs of the integrator of `run` at its step and below, the smallest step
        first."""
        same = [r for r in self.compared.steps if r.integrator == run.integrator]
        return sorted((r for r in same if r.step <= run.step), key=lambda r: r.step)

    def misses(self, run: StepError, target: float) -> bool:
        """Returns whether a run ended early, or its error may exceed `target` [m]."""
        return run.cost is None or not self.error(run) + self.uncertainty <= target


def step_choice(evidence: StepEvidence, target: float) -> StepChoice | None:
    """Returns the integrator and step to advise for an error of at most `target` [m]. Returns None
    if no run reaches the error, or if the certified motion is not known to TRUSTED of it."""
    if evidence.uncertainty > TRUSTED * target:
        return None
    reaching = [
        run
        for run in evidence.compared.steps
        if not evidence.near_limit(run.integrator, run.step)
        and not any(evidence.misses(smaller, target) for smaller in evidence.smaller_runs(run))
    ]
    if not reaching:
        return None
    run = _chosen_run(evidence, reaching)
    return StepChoice(
        target=target,
        integrator=run.integrator,
        step=run.step,
        error=max(evidence.error(smaller) for smaller in evidence.smaller_runs(run)),
        cost=evidence.cost(run),
        options=evidence.model.option(run.integrator, run.step),
        unguarded=run.softened,
        limit=evidence.limit(run.integrator),
        passed_over=_passed_over(evidence, run, target),
    )


def _chosen_run(evidence: StepEvidence, reaching: Sequence[StepError]) -> StepError:
    """Returns one of the cheapest of the runs that reach an error. Of the runs that cost about the
    same, none that is returned is both more expensive and less accurate than another. The model's
    own step comes first, then its own integrator, then the larger step. Another integrator comes
    first if its error is clearly smaller."""
    own = evidence.compared.own
    most = ALIKE * min(_ns_per_second(run) for run in reaching)
    alike = [run for run in reaching if _ns_per_second(run) <= most]
    undominated = [run for run in alike if not any(_dominates(evidence, o, run) for o in alike)]
    if own in undominated:
        return own
    smallest = min(evidence.error(run) for run in undominated)
    accurate = [r for r in undominated if evidence.error(r) <= CLEARLY_BETTER * smallest]
    return min(
        accurate, key=lambda run: (run.integrator != own.integrator, run.integrator, -run.step)
    )


def _dominates(evidence: StepEvidence, run: StepError, other: StepError) -> bool:
    """Returns whether a run is both cheaper and noticeably more accurate than another run."""
    cheaper = _ns_per_second(run) < _ns_per_second(other)
    return cheaper and evidence.error(run) < EQUAL_ERRORS * evidence.error(other)


def _ns_per_second(run: StepError) -> float:
    """Returns the processor time [ns] per simulated second; infinite if it is not known."""
    return math.inf if run.ns_per_second is None else run.ns_per_second


def _passed_over(evidence: StepEvidence, chosen: StepError, target: float) -> PassedOver | None:
    """Returns the cheapest run that costs clearly less than the chosen run and whose own error is
    at most `target` [m]; None if there is none."""
    most = _ns_per_second(chosen) / ALIKE
    cheaper = [
        run
        for run in evidence.compared.steps
        if _ns_per_second(run) < most and evidence.error(run) <= target
    ]
    if not cheaper:
        return None
    run = min(cheaper, key=_ns_per_second)
    near = evidence.near_limit(run.integrator, run.step)
    smaller = evidence.smaller_runs(run)
    missing = [r for r in smaller if evidence.misses(r, target)]
    worst = max(missing, key=evidence.error, default=None)
    return PassedOver(
        integrator=run.integrator,
        step=run.step,
        cost=evidence.cost(run),
        limit=evidence.limit(run.integrator) if near else None,
        worse=None if worst is None or worst is run else (worst.step, evidence.error(worst)),
    )


@dataclass(frozen=True)
class ModelEffect:
    """An effect that the model's continuous motion has too, so that no smaller step reduces it."""

    name: Literal["depth", "drift"]
    size: float  # [m] depth of a contact, or [m/s] slip of a contact that friction should hold
    geoms: str  # the two geoms of the contact
    settings: Mapping[str, str]  # {the setting of the model that causes the effect: its value}


@dataclass(frozen=True)
class AuditAdvice:
    """The actions that an audit advises."""

    # "uncertified": no motion is certified; "still": nothing moves; "steps": steps were compared.
    situation: Literal["uncertified", "still", "steps"]
    cheapest: tuple[tuple[float, StepChoice | None], ...] = ()  # a choice for each target [m]
    # The choice for the largest target below the error at the model's own step
    better: StepChoice | None = None
    # The choice for the smallest target that the model's own step reaches, if the choice saves
    # computing time
    enough: StepChoice | None = None
    accurate: bool = False  # whether the error at the model's own step is below every target
    model_effects: tuple[ModelEffect, ...] = ()  # errors that no step reduces
    # [s] the largest step that holds, if the model's own step is too near it
    near_limit: float | None = None
    known_until: float | None = None  # [s] end of the certified motion, if that is short
    larger_budget: bool = False  # whether more computing time certifies more
    more_iterations: bool = False  # whether the constraint solver stops at its cap
    raised: tuple[str, ...] = ()  # time constants to raise in the file before another step
    raised_to: float = 0.0  # [s] the value to which they are to be raised


def audit_advice(audit: Audit) -> AuditAdvice:
    """Returns the advice that follows from an audit."""
    compared = audit.found
    if compared is None:
        return AuditAdvice("uncertified")
    if audit.still:
        return AuditAdvice("still")
    evidence = StepEvidence(audit.model, audit.reference, compared, audit.stability)
    cheapest = tuple((target, step_choice(evidence, target)) for target in TARGETS)
    choices = [choice for _, choice in cheapest if choice is not None]
    better = [choice for choice in choices if choice.target < audit.error]
    near = evidence.near_limit(audit.integrator, audit.step)
    return AuditAdvice(
        situation="steps",
        cheapest=cheapest,
        better=better[0] if better else None,
        enough=_cheaper_choice(audit, choices),
        accurate=audit.error <= min(TARGETS),
        model_effects=_model_effects(audit, compared.index),
        near_limit=evidence.limit(audit.integrator) if near else None,
        known_until=None if audit.complete else audit.until,
        larger_budget=OUT_OF_TIME in audit.reference.why,
        more_iterations=bool(compared.own.remarks),
        raised=tuple(audit.clamped) if compared.clamping_acts else (),
        raised_to=RAISED * audit.step,
    )


def _cheaper_choice(audit: Audit, choices: Sequence[StepChoice]) -> StepChoice | None:
    """Returns the choice for the smallest target that the model's own step reaches, if the choice
    saves computing time; None if it saves none, or if the motion is not certified to its end."""
    upper_error = audit.error + audit.uncertainty
    as_accurate = [choice for choice in choices if choice.target >= upper_error]
    if not as_accurate or not audit.complete:
        return None
    choice = as_accurate[-1]
    return choice if choice.cost and choice.cost.saves else None


def _model_effects(audit: Audit, index: int) -> tuple[ModelEffect, ...]:
    """Returns the depth and the drift of contacts at the end of the certified motion, the end of
    the control period `index`, if the motion has come to rest there. A depth that is smaller than
    the error of the step is left out."""
    state = audit.reference.course.states[index]
    held = audit.model.held_contacts(state, audit.script.controls[index - 1])
    effects = list[ModelEffect]()
    if held.velocity > AT_REST:
        return ()
    if held.depth > max(VISIBLE_DEPTH, audit.error):
        effects.append(ModelEffect("depth", held.depth, held.deepest_geoms, held.softness))
    if held.drift > VISIBLE_DRIFT:
        effects.append(
            ModelEffect("drift", held.drift, held.drifting_geoms, held.regularisation)
        )
    return tuple(effects)


Trend = Literal["helps", "hardly helps", "does not help"]


@dataclass(frozen=True)
class Halving:
    """The effect of halving the model's own step on the error."""

    # "diverges": no step reaches the end; "needed": the model's own step does not; "unresolved":
    # the error is within what the certified motion leaves open; "single": the error is resolved at
    # the model's own step alone; the other values say how fast the resolved errors fall.
    outcome: Literal["diverges", "needed", "unresolved", "single"] | Trend
    # [m] the resolved errors, at most LISTED_ERRORS, the error at the model's own step first
    errors: tuple[float, ...]
    resolution: float  # [m] smallest error that the certified motion resolves
    largest_step: float | None  # [s] the largest step that reaches the end
    smallest_step: float  # [s] the smallest step that was run
    # [m] bound on the error at half of the model's own step, if that error is not resolved
    bound: float | None


def halving(audit: Audit) -> Halving:
    """Returns what halves of a model's own step do to its error; a motion has to be certified."""
    compared = audit.found
    assert compared is not None
    runs = compared.own_and_finer
    errors = [run.at(compared.index) for run in runs]
    resolution = RESOLVED * audit.uncertainty
    resolved = [error for error in errors if error > resolution][:LISTED_ERRORS]
    reaching = [run.step for run, e in zip(runs, errors, strict=True) if math.isfinite(e)]
    largest_step = reaching[0] if reaching else None
    outcome: Literal["diverges", "needed", "unresolved", "single"] | Trend
    if largest_step is None:
        outcome = "diverges"
    elif largest_step < compared.own.step:
        outcome = "needed"
    elif not audit.resolved:
        outcome = "unresolved"
    elif len(resolved) < 2:
        outcome = "single"
    else:
        outcome = error_trend(resolved)
    return Halving(
        outcome=outcome,
        errors=tuple(resolved),
        resolution=resolution,
        largest_step=largest_step,
        smallest_step=runs[-1].step,
        bound=errors[1] + audit.uncertainty if errors[1:] else None,
    )


def error_trend(errors: Sequence[float]) -> Trend:
    """Returns in words how halving the step helps; `errors` are the errors at a step and at halves
    of it. The geometric mean of their ratios decides."""
    mean_ratio = (errors[-1] / errors[0]) ** (1 / (len(errors) - 1))
    if mean_ratio < HELPS:
        return "helps"
    return "hardly helps" if mean_ratio < HARDLY_HELPS else "does not help"
