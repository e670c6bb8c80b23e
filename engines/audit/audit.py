"""The audit of a user model: a certified reference, its own steps, and the conclusions."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.changes import AuditChange
from plumbob.engines.audit.environment_returns import MotionReturn
from plumbob.engines.audit.episodes import EpisodePlan, Episodes, episode_returns
from plumbob.engines.audit.gradient import CertifiedGradient, certified_gradient
from plumbob.engines.audit.kept_reference import kept_or_certified
from plumbob.engines.audit.mean_returns import EpisodeReturns
from plumbob.engines.audit.reference import RESOLVED, Certificate, start_certificate
from plumbob.engines.audit.stability import LargestSteps, largest_steps
from plumbob.engines.audit.step_errors import (
    Balance,
    StateErrors,
    StepComparison,
    StepError,
    balances,
    compare_steps,
    error_at_step,
    reason_for_mismatch,
    state_errors,
)
from plumbob.engines.audit.trims import TrimmedFile, Trims, trims
from plumbob.engines.own_motion import NotCertifiable, OwnModel, Script

if TYPE_CHECKING:
    from plumbob.engines.audit.engines import EngineError

REFERENCE, TRIMS, STABLE = 0.6, 0.1, 0.05  # fractions of the budget
# Time for the search for the largest steps: LEAST_STABLE seconds at least, but no more than
# MOST_STABLE times the budget. Most searches take less than two seconds.
LEAST_STABLE, MOST_STABLE = 5.0, 3.0
AFTER = TRIMS + STABLE


@dataclass(frozen=True)
class Audit:
    """The errors of a model's own steps on one motion."""

    name: str
    integrator: str
    step: float  # [s]
    script: Script
    control: str  # the source of its controls: "zero", "sines", or a file's name
    reference: Certificate
    found: StepComparison | None  # None if there is no reference
    clamped: Mapping[str, int]
    notes: tuple[str, ...]
    seconds: float  # wall time
    model: OwnModel
    trims: Trims | None = None  # None if no error is known
    balances: tuple[Balance, ...] = ()
    # Errors of attitudes, coordinates and activations; None if the error is not known.
    state_errors: StateErrors | None = None
    stability: LargestSteps | None = None  # largest steps that hold
    written: TrimmedFile | None = None  # None if no trimmed file was written
    # The derivatives, or the reason why there are none; None if they are not asked for.
    gradient: CertifiedGradient | str | None = None
    # Changes since another audit; None if it is compared with none.
    changes: tuple[AuditChange, ...] | None = None
    engines: tuple[EngineError, ...] = ()  # errors of the other engines that the user asked for
    # In a loop: the error at the model's own step if the controls of the reference are replayed;
    # None if there is no loop, or no error is known.
    replayed: StepError | None = None
    returns: EpisodeReturns | None = None  # None if no episodes are asked for
    # The return of an environment in a loop; None for other audits.
    motion_return: MotionReturn | None = None

    @property
    def error(self) -> float:
        """The error [m] at the model's own integrator and step, at the last time up to which steps
        tend to the reference; NaN if there is no reference."""
        return self.found.own.at(self.found.index) if self.found else float("nan")

    @property
    def replayed_error(self) -> float:
        """The error [m] at the model's own step if the controls of the continuous motion are
        replayed, at `until`; NaN if it is not known, or there is no loop."""
        if self.replayed is None or self.found is None:
            return math.nan
        return self.replayed.at(self.found.index)

    @property
    def feedback_factor(self) -> float | None:
        """The ratio of the error in the loop to the error with replayed controls: below 1 feedback
        takes errors back, above 1 it amplifies them. None if either is not resolved by the
        reference, or infinite."""
        errors = self.error, self.replayed_error
        if not all(
            math.isfinite(error) and error > RESOLVED * self.uncertainty for error in errors
        ):
            return None
        return self.error / self.replayed_error

    @property
    def diverged(self) -> bool:
        """Whether the run with the model's own integrator and step ended before `until`."""
        return self.found is not None and bool(self.found.own.why) and math.isinf(self.error)

    @property
    def pose(self) -> Signals:
        """{body: centre of mass [m]} of the reference at `until`; empty if there is no
        reference."""
        if self.found is None:
            return {}
        (last,) = self.model.poses(self.reference.states[self.found.index][None])
        return dict(zip(self.model.bodies, last[:, :3], strict=True))

    @property
    def corners(self) -> Signals:
        """{body: its corner points [m], shape (n, 3)} of the reference at `until`, for bodies that
        can move and have a size; empty if there is no reference."""
        if self.found is None:
            return {}
        last = self.reference.corners[self.found.index]
        bodies = self.model.corner_bodies
        moving = np.flatnonzero(np.bincount(bodies) > 1).tolist()
        return {self.model.bodies[body]: last[bodies == body] for body in moving}

    @property
    def states(self) -> tuple[Array, Array]:
        """The states of the reference, and of the model's own steps from the same start, at the
        ends of the periods up to `until`, shape (n, ...) each."""
        assert self.found is not None
        stepped = self.model.stepped(self.script, self.integrator, self.found.own.parts)
        last = self.found.index + 1
        return self.reference.course.states[:last], stepped.states[:last]

    @property
    def uncertainty(self) -> float:
        """The uncertainty [m] of the reference at `until`; infinite if there is no reference."""
        return (
            float(self.reference.uncertainty[self.found.index]) if self.found else float("inf")
        )

    @property
    def until(self) -> float:
        """The time [s] up to which the error is known."""
        return float(self.script.times[self.found.index]) if self.found else 0.0

    @property
    def still(self) -> bool:
        """Whether the reference reaches the end of the motion, and positions, velocities and
        activations never change."""
        states = self.reference.states
        return self.complete and not self.error and bool((states == states[0]).all())

    @property
    def complete(self) -> bool:
        """Whether the error is known to the end of the motion."""
        return self.until >= self.script.duration * (1 - 1e-9)

    @property
    def resolved(self) -> bool:
        """Whether the error exceeds RESOLVED times the uncertainty of the reference."""
        return self.error > RESOLVED * self.uncertainty

    @property
    def resolved_index(self) -> int:
        """The index of the last period at whose end the error exceeds RESOLVED times the
        uncertainty of the reference; 0 if there is none."""
        if self.found is None:
            return 0
        errors = self.found.own.errors[: self.found.index + 1]
        uncertainty = self.reference.uncertainty[: self.found.index + 1]
        resolved = (errors > RESOLVED * uncertainty) | (uncertainty == 0.0)
        return int(np.flatnonzero(resolved)[-1])

    def assert_referenced(self) -> None:
        """Raises AssertionError unless the error is known over the whole motion."""
        __tracebackhide__ = True
        if not self.complete:
            raise AssertionError(
                f"{self.name}: no reference beyond {self.until:g} s: {self.reference.why}"
            )

    def assert_within(self, metres: float) -> None:
        """Raises AssertionError unless the error is known over the whole motion and within
        `metres`."""
        __tracebackhide__ = True
        self.assert_referenced()
        if not self.error + self.uncertainty <= metres:
            raise AssertionError(
                f"{self.name}: {self.integrator} at {self.step:g} s is {self.error:.3g} m off "
                f"(known to {self.uncertainty:.1g} m), more than {metres:g} m"
            )

    def assert_return_within(self, fraction: float) -> None:
        """Raises AssertionError unless the step changes the mean return by no more than a fraction
        of it, at the far end of the interval."""
        __tracebackhide__ = True
        if self.returns is None or not self.returns.within(fraction):
            raise AssertionError(
                f"{self.name}: the step of {self.step:g} s may change the mean return by more than "
                f"{100 * fraction:g} %"
            )

    def assert_stable(self) -> None:
        """Raises AssertionError if the model's own step is unstable along the motion."""
        __tracebackhide__ = True
        if self.stability is not None and self.stability.unstable:
            limit = self.stability.own
            raise AssertionError(
                f"{self.name}: {self.integrator} at {self.step:g} s is unstable; steps up to "
                f"{limit.largest_step:.3g} s hold"
            )


def audited(
    model: OwnModel,
    script: Script,
    control: str,
    allowance: Allowance,
    begun: Callable[[Audit], None] = lambda audit: None,
    references: Path | None = None,
) -> Audit:
    """Returns the audit of `model` on the motion under `script`. `begun` is called with the audit
    as it is known before anything is computed. The reference is kept in the folder `references`, if
    it is given."""
    progress = allowance.progress
    began = time.perf_counter()
    audit = Audit(
        name=model.name,
        integrator=model.integrator,
        step=model.step,
        script=script,
        control=control,
        reference=start_certificate(model, script),
        found=None,
        clamped=model.clamped,
        notes=model.notes,
        seconds=0.0,
        model=model,
    )
    begun(audit)
    reference, result = compare_with_reference(model, script, allowance, references)
    script = script_of_reference(script, reference)
    audit = replace(audit, script=script, reference=reference, found=result)
    if script.loop is not None and result is not None:
        parts = result.own.parts
        replayed = error_at_step(model, script.replayed, reference, audit.integrator, parts)
        audit = replace(audit, replayed=replayed)
    if result is not None and math.isfinite(audit.error):
        progress("what can be left out")
        parts = result.own.parts
        index = result.index
        error = audit.error
        left_out = trims(model, script, parts, index, error, allowance.part(TRIMS))
        states = audit.states
        audit = replace(
            audit,
            balances=balances(model, *states),
            state_errors=state_errors(model, *states),
            trims=left_out,
        )
    largest = largest_steps_along(model, script, reference, allowance)
    return replace(audit, stability=largest, seconds=time.perf_counter() - began)


def script_of_reference(script: Script, reference: Certificate) -> Script:
    """Returns the script with the controls of the reference, as far as it is known, in place of the
    recorded ones. Raises ParameterError if a policy in the loop gives other controls when it is
    asked again: the reference is then no motion of its own."""
    if script.loop is None:
        return script
    course = reference.course
    answers = course.controls[np.isfinite(course.controls).all(axis=1)]
    count = len(answers)
    script.loop.check_memory(script.times[:count], course.states[:count], answers)
    known = reference.known
    return replace(script, controls=np.concatenate([answers[:known], script.controls[known:]]))


def largest_steps_along(
    model: OwnModel, script: Script, reference: Certificate, allowance: Allowance
) -> LargestSteps:
    """Returns the largest steps that hold along a certified motion, found in a part of the time
    that is allowed for the whole."""
    allowance.progress("the largest step that holds")
    least = min(LEAST_STABLE / allowance.seconds, MOST_STABLE)
    steady = allowance.part(max(STABLE, least))
    return largest_steps(model, script, reference.states, steady)


def compare_with_reference(
    model: OwnModel, script: Script, allowance: Allowance, references: Path | None = None
) -> tuple[Certificate, StepComparison | None]:
    """Returns the certified motion of a model under `script`, and the errors of the steps of its
    integrators; None if there is no reference, or no step tends to it. The reference is kept in the
    folder `references`, if it is given."""
    allowance.progress("the continuous motion, by two methods")
    reference = kept_or_certified(references, model, script, allowance.part(REFERENCE))
    if not reference.known:
        return reference, None
    allowance.progress("the model's own steps")
    left = max(1.0 - AFTER - allowance.spent / allowance.seconds, AFTER)
    result = compare_steps(model, script, reference, allowance.part(left))
    if result.index < reference.known:
        reference = replace(reference, why=reason_for_mismatch(result, reference, script))
    return reference, result if result.index else None


def with_returns(
    audit: Audit, episodes: Episodes, plan: EpisodePlan, allowance: Allowance
) -> Audit:
    """Returns an audit with the returns of the episodes of a plan. Raises ParameterError."""
    began = time.perf_counter()
    returns = episode_returns(episodes, plan, allowance)
    return replace(audit, returns=returns, seconds=audit.seconds + time.perf_counter() - began)


def with_gradient(audit: Audit, allowance: Allowance) -> Audit:
    """Returns an audit with the derivatives of the end, or with the reason why there are none."""
    began = time.perf_counter()
    index = audit.found.index if audit.found else 0
    derivatives: CertifiedGradient | str
    try:
        derivatives = certified_gradient(
            audit.model, audit.script.replayed, audit.reference, index, allowance
        )
    except NotCertifiable as why:
        derivatives = str(why)
    return replace(
        audit, gradient=derivatives, seconds=audit.seconds + time.perf_counter() - began
    )
