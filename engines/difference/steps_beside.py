"""Single steps of two models from the same states, and what rounding and the solvers allow them to
differ by. Each step is judged alone, so that a chaotic motion is judged as well as any other."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.sample_steps import Allowed, SampleSteps
from plumbob.engines.difference.step_check import worst_place
from plumbob.engines.difference.step_terms import excess_of
from plumbob.engines.own_motion import OUT_OF_TIME
from plumbob.engines.recorded_step import StepInput, StepOutcome

# Factor on the iterations of a solver that finds the same answer, above which they are the cause
ITERATIONS_APART = 2


@dataclass(frozen=True)
class StepsBeside:
    """The steps of two models from the states of a motion. Accelerations are in m/s² or rad/s²."""

    checked: int = 0  # number of steps
    use: float = 0.0  # largest ratio of a difference to what rounding and the solvers allow
    apart: float = 0.0  # largest difference of accelerations
    begin: float = math.nan  # [s] start of the first step that is beyond; NaN if none is
    term: str = ""  # "contact set", "solver's iterations" or "acceleration": of that step
    part: str = ""  # contact, numbers of iterations, or joint
    left: float = 0.0  # largest acceleration that the other solver leaves
    own_left: float = 0.0  # largest acceleration that the model's own solver leaves
    iterations: int = 0  # most iterations of the other solver
    at_cap: int = 0  # number of steps in which the other solver ends at its cap
    why: str = ""  # why not all steps are checked; empty if they are


@dataclass(frozen=True)
class OwnStep:
    """A step of a model, and what it may leave."""

    before: StepInput
    outcome: StepOutcome
    converged: StepOutcome  # if its solver converges
    allowed: Allowed


@dataclass(frozen=True)
class OtherStep:
    """A step of another model or of a port from the same state, and what its solver may leave."""

    outcome: StepOutcome
    converged: StepOutcome  # if its solver converges
    allowed: Array
    cap: int  # on the iterations of its solver


@dataclass(frozen=True)
class OwnSteps:
    """The steps of a model from the samples of a recording. Each is computed once."""

    samples: SampleSteps
    known: dict[int, OwnStep] = field(default_factory=dict)

    def __getitem__(self, interval: int) -> OwnStep:
        """Returns the step in an interval."""
        if interval not in self.known:
            samples = self.samples
            warm_starts = samples.recording.warm_starts
            assert warm_starts is not None
            before = samples.before(interval, warm_starts[interval])
            self.known[interval] = OwnStep(
                before=before,
                outcome=samples.steps.after(before),
                converged=samples.steps.converged(before),
                allowed=samples.allowed(before, interval),
            )
        return self.known[interval]


def other_steps(samples: SampleSteps) -> Callable[[OwnStep], OtherStep]:
    """Returns a function that takes the step of another model from the state of a step."""

    def other_step(step: OwnStep) -> OtherStep:
        """Returns the step of the other model."""
        return OtherStep(
            outcome=samples.steps.after(step.before),
            converged=samples.steps.converged(step.before),
            allowed=samples.solver(step.before),
            cap=samples.steps.most_iterations,
        )

    return other_step


def steps_beside(
    own: OwnSteps, take: Callable[[OwnStep], OtherStep], allowance: Allowance
) -> tuple[StepsBeside, Array]:
    """Returns the steps that `take` takes beside those of a model, and what the other solver leaves
    of each step, shape (intervals, m). Steps that the time is too short for are given the largest
    that the solver has left."""
    samples = own.samples
    result = StepsBeside()
    left = np.zeros((samples.intervals, samples.space.size(samples.recording.states[0])))
    for interval in range(samples.intervals):
        if allowance.left < 0.0:
            left[interval:] = np.abs(left[:interval]).max(axis=0, initial=0.0)
            return replace(result, why=OUT_OF_TIME), left
        other = take(own[interval])
        rest = samples.space.differences(other.outcome.state, other.converged.state)
        left[interval] = np.where(np.isfinite(rest), rest, 0.0)
        result = _with_step(result, own, interval, other, left[interval])
    return result, left


def _with_step(
    result: StepsBeside, own: OwnSteps, interval: int, other: OtherStep, left: Array
) -> StepsBeside:
    """Returns the result with the step in an interval, of which the other solver leaves `left`."""
    samples, step = own.samples, own[interval]
    change = _change(samples, other.outcome, step.outcome)
    # Two solvers that converge have the same answer: it may differ by rounding alone.
    answers = _change(samples, other.converged, step.converged)
    own_left = _change(samples, step.outcome, step.converged)
    result = replace(
        result,
        checked=result.checked + 1,
        apart=max(result.apart, _acceleration(samples, change, interval)),
        left=max(result.left, _acceleration(samples, left, interval)),
        own_left=max(result.own_left, _acceleration(samples, own_left, interval)),
        iterations=max(result.iterations, other.outcome.iterations),
        at_cap=result.at_cap + (other.outcome.iterations >= other.cap),
    )
    if not (change.any() or answers.any()):
        return result
    held = (change, step.allowed.whole + other.allowed), (answers, step.allowed.rounding)
    uses = [excess_of(*pair) for pair in held]
    worst = int(np.argmax(uses))
    if uses[worst] > 1.0 and math.isnan(result.begin):
        begin = float(samples.recording.times[interval])
        pair = ("outcome", "converged")[worst]
        term, part = _term(
            samples, interval, (getattr(step, pair), getattr(other, pair)), *held[worst]
        )
        result = replace(result, begin=begin, term=term, part=part)
    return replace(result, use=max(result.use, uses[worst]))


def _change(samples: SampleSteps, second: StepOutcome, first: StepOutcome) -> Array:
    """Returns the change from one outcome to a second one; infinite where it is not finite."""
    change = samples.space.differences(second.state, first.state)
    return np.where(np.isfinite(change), change, np.inf)


def _acceleration(samples: SampleSteps, change: Array, interval: int) -> float:
    """Returns the largest acceleration [m/s², rad/s²] that changes the state by `change`."""
    return float(np.abs(samples.acceleration(change, interval)).max(initial=0.0))


def _term(
    samples: SampleSteps,
    interval: int,
    outcomes: tuple[StepOutcome, StepOutcome],
    change: Array,
    allowed: Array,
) -> tuple[str, str]:
    """Returns the term in which a step first differs, and the part of it."""
    first, second = outcomes
    contacts = set(first.touching) ^ set(second.touching)
    if contacts:
        return "contact set", ", ".join(samples.steps.names_of(tuple(sorted(contacts))))
    if second.iterations > ITERATIONS_APART * max(first.iterations, 1):
        return "solver's iterations", f"{second.iterations}, not {first.iterations}"
    place, size, limit, unit = worst_place(samples, interval, change, allowed)
    return "acceleration", f"{place} by {size:.2g} {unit} ({limit:.2g} allowed)"
