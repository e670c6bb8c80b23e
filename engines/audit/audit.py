"""The audit of a user model: a certified reference, its own steps, and the conclusions."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.changes import Moved
from plumbob.engines.audit.gradient import CertifiedGradient, certified_gradient
from plumbob.engines.audit.reference import RESOLVED, Certificate, certified, uncertain
from plumbob.engines.audit.stability import LargestSteps, largest_steps
from plumbob.engines.audit.step_errors import (
    Balance,
    Compared,
    StateErrors,
    balances,
    compared,
    state_errors,
    unlike,
)
from plumbob.engines.audit.trims import Trim, Trims, trims
from plumbob.engines.own_motion import NotCertifiable, OwnModel, Script

if TYPE_CHECKING:
    from plumbob.engines.audit.engines import EngineError

REFERENCE, TRIMS, STABLE = 0.6, 0.1, 0.05  # of the budget
# For the largest steps, of which most take less than two seconds: so many seconds at least, but no
# more than so many times the budget.
LEAST_STABLE, MOST_STABLE = 5.0, 3.0
AFTER = TRIMS + STABLE


@dataclass(frozen=True)
class Audit:
    """The errors of a model's own steps on one motion of it."""

    name: str
    integrator: str
    step: float  # [s]
    script: Script
    control: str  # what drives it: "zero", "sines", or a file's name
    reference: Certificate
    found: Compared | None  # None where there is no reference
    clamped: Mapping[str, int]
    notes: tuple[str, ...]
    seconds: float  # wall time
    model: OwnModel
    trims: Trims | None = None  # None where no error is known
    balances: tuple[Balance, ...] = ()
    # Beside the error in metres; None where that is not known.
    state_errors: StateErrors | None = None
    stability: LargestSteps | None = None  # the largest steps that hold
    written: tuple[str, Trim] | None = None  # the trimmed file, and what it does, read back
    # why there is none; None where it is not asked for
    gradient: CertifiedGradient | str | None = None
    # since another audit; None where it is held to none
    changes: tuple[Moved, ...] | None = None
    engines: tuple[EngineError, ...] = ()  # others, that are asked for

    @property
    def error(self) -> float:
        """Error [m] at the model's own integrator and step, as far as the reference is known; not a
        number where there is none."""
        return self.found.own.at(self.found.index) if self.found else float("nan")

    @property
    def pose(self) -> Signals:
        """{body: centre of mass [m]} of the reference at `until`; empty where there is none."""
        if self.found is None:
            return {}
        (last,) = self.model.poses(self.reference.states[self.found.index][None])
        return dict(zip(self.model.bodies, last[:, :3], strict=True))

    @property
    def corners(self) -> Signals:
        """{body: its corner points [m], shape (n, 3)} of the reference at `until`, of bodies that
        can move and have a size; empty where there is none."""
        if self.found is None:
            return {}
        last = self.reference.corners[self.found.index]
        bodies = self.model.corner_bodies
        moving = np.flatnonzero(np.bincount(bodies) > 1).tolist()
        return {self.model.bodies[body]: last[bodies == body] for body in moving}

    @property
    def states(self) -> tuple[Array, Array]:
        """States of the reference, and of the model's own steps from where it starts, at the ends
        of the periods up to `until`, shape (n, ...) each."""
        assert self.found is not None
        stepped = self.model.stepped(self.script, self.integrator, self.found.own.parts)
        last = self.found.index + 1
        return self.reference.course.states[:last], stepped.states[:last]

    @property
    def uncertainty(self) -> float:
        """[m] of the reference there."""
        return (
            float(self.reference.uncertainty[self.found.index]) if self.found else float("inf")
        )

    @property
    def until(self) -> float:
        """[s] to which the error is known."""
        return float(self.script.times[self.found.index]) if self.found else 0.0

    @property
    def still(self) -> bool:
        """Whether the reference reaches the end of the motion, and positions, velocities and
        activations stay as they are until then."""
        states = self.reference.states
        return self.complete and not self.error and bool((states == states[0]).all())

    @property
    def complete(self) -> bool:
        """Whether the error is known to the end of the motion."""
        return self.until >= self.script.duration * (1 - 1e-9)

    @property
    def resolved(self) -> bool:
        """Whether the error stands out of the reference's uncertainty."""
        return self.error > RESOLVED * self.uncertainty

    @property
    def resolved_index(self) -> int:
        """Of the last period at whose end the error stands out of the reference's uncertainty, 0
        where none does."""
        if self.found is None:
            return 0
        errors = self.found.own.errors[: self.found.index + 1]
        known = self.reference.uncertainty[: self.found.index + 1]
        return int(np.flatnonzero((errors > RESOLVED * known) | (known == 0.0))[-1])

    def assert_referenced(self) -> None:
        """Raise AssertionError unless the error is known over the whole motion."""
        if not self.complete:
            raise AssertionError(
                f"{self.name}: no reference beyond {self.until:g} s: {self.reference.why}"
            )

    def assert_within(self, metres: float) -> None:
        """Raise AssertionError unless the error is known over the whole motion and within
        `metres`."""
        self.assert_referenced()
        if not self.error + self.uncertainty <= metres:
            raise AssertionError(
                f"{self.name}: {self.integrator} at {self.step:g} s is {self.error:.3g} m off "
                f"(known to {self.uncertainty:.1g} m), more than {metres:g} m"
            )

    def assert_stable(self) -> None:
        """Raise AssertionError if the model's own step is unstable along the motion."""
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
) -> Audit:
    """The audit of `model` on the motion that `script` makes of it; `begun` is called with what is
    known before anything is computed."""
    progress = allowance.progress
    began = time.perf_counter()
    audit = Audit(
        model.name,
        model.integrator,
        model.step,
        script,
        control,
        uncertain(model, script),
        None,
        model.clamped,
        model.notes,
        0.0,
        model,
    )
    begun(audit)
    reference, result = held_to_reference(model, script, allowance)
    audit = replace(audit, reference=reference, found=result)
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


def largest_steps_along(
    model: OwnModel, script: Script, reference: Certificate, allowance: Allowance
) -> LargestSteps:
    """Returns the largest steps that hold along a certified motion, found in a part of the time
    that is allowed for the whole."""
    allowance.progress("the largest step that holds")
    least = min(LEAST_STABLE / allowance.seconds, MOST_STABLE)
    steady = allowance.part(max(STABLE, least))
    return largest_steps(model, script, reference.states, steady)


def held_to_reference(
    model: OwnModel, script: Script, allowance: Allowance
) -> tuple[Certificate, Compared | None]:
    """The certified motion that `script` makes of a model, and the steps of its integrators held
    against it; None where there is no reference, or no step tends to it."""
    allowance.progress("the continuous motion, by two methods")
    reference = certified(model, script, allowance.part(REFERENCE))
    if not reference.known:
        return reference, None
    allowance.progress("the model's own steps")
    left = max(1.0 - AFTER - allowance.spent / allowance.seconds, AFTER)
    result = compared(model, script, reference, allowance.part(left))
    if result.index < reference.known:
        reference = replace(reference, why=unlike(result, reference, script))
    return reference, result if result.index else None


def with_gradient(audit: Audit, allowance: Allowance) -> Audit:
    """An audit with the derivatives of the end, or why there are none."""
    began = time.perf_counter()
    index = audit.found.index if audit.found else 0
    derivatives: CertifiedGradient | str
    try:
        derivatives = certified_gradient(
            audit.model, audit.script, audit.reference, index, allowance
        )
    except NotCertifiable as why:
        derivatives = str(why)
    return replace(
        audit, gradient=derivatives, seconds=audit.seconds + time.perf_counter() - began
    )
