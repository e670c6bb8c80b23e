"""Single steps of two models from the same states, and what rounding and the solvers allow them to
differ by. Each step is judged alone, so that a chaotic motion is judged as well as any other."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.difference import use_by_kind
from plumbob.engines.difference.sample_steps import Allowed, SampleSteps
from plumbob.engines.difference.step_check import worst_place
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
    part: str = ""  # contacts that one of both has, or joint with the largest excess
    # Accelerations that differ and are allowed there, or numbers of iterations of the other solver
    # and of the model's own; 0 of a contact set
    there: tuple[float, float] = (0.0, 0.0)
    why: str = ""  # why not all steps are checked; empty if they are


@dataclass(frozen=True)
class SolverRun:
    """The iterations of the solver in the steps of a run, and what it leaves of them."""

    left: Array  # changes of the states after steps, in tangent coordinates, shape (steps, m)
    largest: float  # largest acceleration that it leaves [m/s², rad/s²]
    iterations: int  # most iterations of a step
    at_cap: int  # number of steps in which it ends at its cap
    steps: int


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


@dataclass(frozen=True)
class OwnSteps:
    """The steps of a model from the samples of a recording. Each is computed once."""

    samples: SampleSteps
    known: dict[int, OwnStep] = field(default_factory=dict)

    def __getitem__(self, interval: int) -> OwnStep:
        """Returns the step in an interval."""
        if interval not in self.known:
            samples = self.samples
            before = samples.recorded(interval)
            outcome = samples.steps.after(before)
            converged = samples.steps.converged(before)
            rounding = samples.rounding(before, interval)
            solver = samples.solver(before, outcome, converged)
            self.known[interval] = OwnStep(
                before, outcome, converged, Allowed(rounding, solver)
            )
        return self.known[interval]


def other_steps(samples: SampleSteps) -> Callable[[OwnStep], OtherStep]:
    """Returns a function from a step to the other model's step from the same state; `samples` are
    those of the other model. The step is `allowed` what its solver may leave."""

    def other_step(step: OwnStep) -> OtherStep:
        """Returns the step of the other model."""
        outcome = samples.steps.after(step.before)
        converged = samples.steps.converged(step.before)
        return OtherStep(outcome, converged, samples.solver(step.before, outcome, converged))

    return other_step


def compared_steps(
    own: OwnSteps, other_step: Callable[[OwnStep], OtherStep], allowance: Allowance
) -> StepsBeside:
    """Compares each step of a model with the step that `other_step` returns for it, until the
    allowance of time is spent."""
    result = StepsBeside()
    for interval in range(own.samples.intervals):
        if allowance.left < 0.0:
            return replace(result, why=OUT_OF_TIME)
        result = _with_step(result, own, interval, other_step(own[interval]))
    return result


def _with_step(
    result: StepsBeside, own: OwnSteps, interval: int, other: OtherStep
) -> StepsBeside:
    """Returns the result with the step in an interval."""
    samples, step = own.samples, own[interval]
    change = _change(samples, other.outcome, step.outcome)
    answers = _change(samples, other.converged, step.converged)
    result = replace(
        result,
        checked=result.checked + 1,
        apart=max(result.apart, largest_acceleration(samples, change)),
    )
    allowed = step.allowed.whole
    held = [(change, allowed + other.allowed), (answers, allowed)]
    degrees = samples.space.velocities
    uses = [use_by_kind(*pair, degrees) for pair in held]
    if uses[1] > 1.0:
        # Two solvers that converge have the same answer but for the rounding of their iterations,
        # which takes as long to measure as the step has taken.
        allowed = samples.rounding(step.before, interval, converged=True)
        held[1] = answers, allowed + step.allowed.solver
        uses[1] = use_by_kind(*held[1], degrees)
    worst = int(np.argmax(uses))
    if uses[worst] > 1.0 and math.isnan(result.begin):
        begin = float(samples.recording.times[interval])
        pair = ("outcome", "converged")[worst]
        outcomes = getattr(step, pair), getattr(other, pair)
        term, part, there = _term(samples, interval, outcomes, *held[worst])
        result = replace(result, begin=begin, term=term, part=part, there=there)
    return replace(result, use=max(result.use, uses[worst]))


def solver_run(samples: SampleSteps) -> SolverRun:
    """Returns what the solver of a model leaves of each step of the run of that model."""
    space, states = samples.space, samples.recording.states
    left = np.zeros((samples.intervals, space.size(states[0])))
    iterations = np.zeros(samples.intervals, dtype=int)
    for interval in range(samples.intervals):
        before = samples.recorded(interval)
        iterations[interval] = samples.steps.after(before).iterations
        converged = samples.steps.converged(before).state
        rest = space.differences(states[interval + 1], converged)
        left[interval] = np.where(np.isfinite(rest), rest, 0.0)
    return SolverRun(
        left=left,
        largest=max((largest_acceleration(samples, row) for row in left), default=0.0),
        iterations=int(iterations.max(initial=0)),
        at_cap=int((iterations >= samples.steps.most_iterations).sum()),
        steps=samples.intervals,
    )


def _change(samples: SampleSteps, second: StepOutcome, first: StepOutcome) -> Array:
    """Returns the change from one outcome to a second one; infinite where it is not finite."""
    change = samples.space.differences(second.state, first.state)
    return np.where(np.isfinite(change), change, np.inf)


def largest_acceleration(samples: SampleSteps, change: Array) -> float:
    """Returns the largest acceleration [m/s², rad/s²] of one step whose end moves by `change`."""
    return float(np.abs(samples.acceleration(change, 0)).max(initial=0.0))


def _term(
    samples: SampleSteps,
    interval: int,
    outcomes: tuple[StepOutcome, StepOutcome],
    change: Array,
    allowed: Array,
) -> tuple[str, str, tuple[float, float]]:
    """Returns the term in which a step first differs, the part of it, and two numbers, as in
    `StepsBeside`."""
    first, second = outcomes
    contacts = set(first.touching) ^ set(second.touching)
    if contacts:
        names = samples.steps.names_of(tuple(sorted(contacts)))
        return "contact set", ", ".join(names), (0.0, 0.0)
    if second.iterations > ITERATIONS_APART * max(first.iterations, 1):
        return "solver's iterations", "", (second.iterations, first.iterations)
    place, size, limit, _ = worst_place(samples, interval, change, allowed)
    return "acceleration", place, (size, limit)
