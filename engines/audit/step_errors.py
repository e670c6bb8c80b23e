"""The errors of a model's own steps, and of other steps and integrators, against its continuous
motion, and their order."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.costs import costs_in_turns, timed_periods
from plumbob.engines.audit.reference import NOTHING, RESOLVED, Certificate, running_maximum
from plumbob.engines.own_motion import OwnModel, Script, Stepped
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.order import Order, fit_order

TARGETS = (0.1, 0.01, 1e-3, 1e-4)  # [m] wanted errors
HALVINGS = 7  # most halvings of the model's own step
TRUSTED = 0.2  # largest uncertainty of the reference, as a fraction of a wanted error
# Fraction of the error at the model's own or finer steps: some step must come nearer to the
# reference than this, or the steps tend to another motion.
FALLS = 0.4
# Fraction of the error at a step four times as large. If the errors of all integrators fall by
# less, and the reference resolves them, they level off at the distance of the reference from the
# limit of the steps.
LEVEL = 0.7
# Multiple of the error of the coarsest steps. Errors at contacts scatter by less; a contact that
# the steps pass over changes a motion by more.
RISES = 10.0
# Fraction of the periods so far that must tend to the reference: contacts make single periods
# irregular
MOSTLY = 0.8


@dataclass(frozen=True)
class StepError:
    """The errors of one integrator's run at one step, over time."""

    integrator: str
    step: float  # [s]
    parts: int  # steps in a control period
    # [m] largest displacement of any corner so far, at the ends of the periods, shape (n,)
    errors: Array
    worst: str  # the body whose corner has the largest error
    seconds: float  # [s] processor time of one run
    why: str = ""  # why the run ended early; empty if it did not
    remarks: tuple[str, ...] = ()  # remarks about the run
    cost: Cost | None = None  # cost of a step; None if the run ended early
    # Whether the engine would soften contacts or limits of this run, which the audit prevented.
    softened: bool = False

    @property
    def pace(self) -> Cost | None:
        """Processor time over simulated time; None if the run ended early."""
        return self.cost and self.cost.scaled(1e-9 / self.step)

    @property
    def ns_per_second(self) -> float | None:
        """Processor time [ns] per simulated second; None if the run ended early."""
        return 1e9 * self.pace.ns_per_step if self.pace else None

    def at(self, index: int) -> float:
        """Returns the error [m] at the end of a period; infinite if the run had ended."""
        return float(self.errors[index])


@dataclass(frozen=True)
class StepComparison:
    """The errors of all steps that were tried, the model's own integrator first, coarse to fine,
    and the period up to which they tend to the reference."""

    own: StepError
    steps: tuple[StepError, ...]
    index: int  # index of the last period up to which the steps tend to the reference
    nearest: float  # [m] smallest error of the finest steps there
    order: Order | None  # order of the model's own integrator
    # Whether contacts or limits act in the motion that the engine softens at the model's own step
    clamping_acts: bool = False

    @property
    def own_and_finer(self) -> list[StepError]:
        """The runs of the model's own integrator at the model's own step and at smaller steps,
        coarse to fine."""
        return _own_and_finer(self.steps, self.own)


@dataclass(frozen=True)
class Balance:
    """One reading at the model's own step and of the continuous motion, at the ends of the control
    periods up to which errors are known. The energy of the continuous motion includes the work of
    actuators, springs, dampers and friction: a difference of the two energies comes from the steps
    alone."""

    name: str
    own: float  # largest magnitude at the model's own step; of an energy the largest change
    continuous: float  # largest magnitude of the continuous motion, likewise
    apart: float  # largest difference of the two at the same time


@dataclass(frozen=True)
class StateErrors:
    """The largest differences of two motions in bodies' attitudes, joint coordinates and
    activations; 0 if a model has none of them."""

    attitude: float  # [rad]
    coordinates: float  # [rad or m]
    activations: float


def compare_steps(
    model: OwnModel, script: Script, reference: Certificate, allowance: Allowance
) -> StepComparison:
    """Runs each of the model's integrators and returns the errors against the reference. The steps
    are the model's own step, twice that step if the control period allows, and halves of it. With
    an executor, integrators run in parallel. Costs are measured afterwards, with nothing else
    running."""
    names = model.integrators
    groups = [names] if allowance.executor is None else [(name,) for name in names]
    runs = [
        allowance.start(errors_at_halved_steps, model, script, reference, names, allowance.left)
        for names in groups
    ]
    errors = list(chain.from_iterable(run() for run in runs))
    allowance.progress("costs")
    errors = with_costs(model, script, reference, errors)
    fixed = [error for error in errors if error.integrator == model.integrator]
    own_step = next(error for error in fixed if error.parts == script.parts(model.step))
    index = last_tending_period(errors, own_step, reference)
    errors = [_with_softening(error, own_step, model, script) for error in errors]
    errors.sort(
        key=lambda error: (error.integrator != model.integrator, error.integrator, -error.step)
    )
    return StepComparison(
        own=own_step,
        steps=tuple(errors),
        index=index,
        nearest=float(finest_errors(errors)[index]),
        order=observed_order(fixed, reference, index),
        clamping_acts=model.clamping_acts(script),
    )


def _with_softening(
    error: StepError, own_step: StepError, model: OwnModel, script: Script
) -> StepError:
    """Returns the error of a step with the statement whether the engine would soften contacts or
    limits of the run. The engine softens them only at steps larger than the model's own."""
    if error.parts >= own_step.parts:
        return error
    return replace(error, softened=model.softens(script, error.integrator, error.parts))


def errors_at_halved_steps(
    model: OwnModel,
    script: Script,
    reference: Certificate,
    integrators: Sequence[str],
    seconds: float,
) -> list[StepError]:
    """Returns the errors of runs of some integrators, from coarse to fine steps. The integrators
    take turns, so that about `seconds` of processor time are spread over all of them. The model's
    own step is run regardless of the time."""
    reached = reference.known
    ends = time.process_time() + seconds
    usual = script.parts(model.step)  # steps of the model in a control period
    errors: list[StepError] = []
    # Steps in a control period of the next run of each integrator, which doubles from run to run
    going = {name: usual // 2 if usual % 2 == 0 else usual for name in integrators}
    while going:
        for name, parts in list(going.items()):
            begin = time.process_time()
            due = name == model.integrator and parts <= usual
            if errors and begin >= ends and not due:
                del going[name]
                continue
            errors.append(error_at_step(model, script, reference, name, parts))
            last = errors[-1].at(reached)
            fine = parts >= 4 * usual and last <= 2.0 * float(reference.uncertainty[reached])
            now = time.process_time()
            late = now + 2.5 * (now - begin) > ends
            # At least one halving of the model's own integrator
            needed = usual << (name == model.integrator)
            if fine or (late and parts >= needed) or parts >= usual << HALVINGS:
                del going[name]
            else:
                going[name] = 2 * parts
    return errors


def with_costs(
    model: OwnModel, script: Script, reference: Certificate, steps: Sequence[StepError]
) -> list[StepError]:
    """Returns the step errors with the costs of steps along the reference, except for runs that
    ended early."""
    timed = [
        timed_periods(
            model, script, reference.states, error.integrator, error.parts, error.seconds
        )
        for error in steps
        if not error.why
    ]
    costs = iter(costs_in_turns(timed))
    return [error if error.why else replace(error, cost=next(costs)) for error in steps]


def last_tending_period(
    steps: Sequence[StepError], own_step: StepError, reference: Certificate
) -> int:
    """Returns the index of the last control period up to which the steps confirm the reference.

    Three conditions must hold in most periods. The finest step of some integrator comes much nearer
    to the reference than the worst of the model's own and finer steps, or as near as the reference
    is known. (The model's own step may be near by chance.) The errors of some integrator do not
    level off above that uncertainty. No integrator's errors grow as its steps shrink. If either of
    the last two fails, the reference is another motion than the limit of the steps.
    """
    nearest = finest_errors(steps)
    floor = np.maximum(reference.uncertainty, NOTHING)
    same = [step.errors for step in _own_and_finer(steps, own_step)]
    allowed = np.maximum(floor, FALLS * np.max(same, axis=0))
    good = np.isfinite(reference.uncertainty) & (nearest <= allowed)
    good &= ~_errors_level_off(steps, own_step, floor) & ~_errors_rise(steps, floor)
    mostly = np.cumsum(good) >= MOSTLY * np.arange(1, len(good) + 1)
    return int(np.flatnonzero(good & mostly)[-1])


def _own_and_finer(steps: Iterable[StepError], own_step: StepError) -> list[StepError]:
    """Returns the runs of the integrator of `own_step` with its steps in a period, or more. Steps
    [s] are not compared: the same step may differ by a rounding."""
    return [
        step
        for step in steps
        if step.integrator == own_step.integrator and step.parts >= own_step.parts
    ]


def finest_errors(steps: Sequence[StepError]) -> Array:
    """Returns the errors [m] over time of the finest steps nearest to the reference, shape (n,): at
    each time the smallest over the integrators."""
    ends = [runs[-1].errors for runs in _by_integrator(steps)]
    return np.asarray(np.min(ends, axis=0))


def _by_integrator(steps: Sequence[StepError]) -> list[list[StepError]]:
    """Groups the step errors by integrator, coarse to fine."""
    names = dict.fromkeys(s.integrator for s in steps)
    ordered = sorted(steps, key=lambda s: s.parts)
    return [[s for s in ordered if s.integrator == name] for name in names]


def _errors_rise(steps: Sequence[StepError], floor: Array) -> Any:
    """Whether at each time some integrator's finest steps are much further from the reference than
    its coarsest steps, and the reference resolves the difference, shape (n,). Coarse steps may be
    near if they pass over a contact that the reference passes over, too."""
    rises = [
        runs[-1].errors > np.maximum(RISES * runs[0].errors, RESOLVED * floor)
        for runs in _by_integrator(steps)
    ]
    return np.any(rises, axis=0)


def reason_for_mismatch(result: StepComparison, reference: Certificate, script: Script) -> str:
    """Explains why the steps that were run do not tend to the reference."""
    index = reference.known
    best = min(result.steps, key=lambda s: s.at(index))
    if math.isinf(best.at(index)):
        least = min(s.step for s in result.steps)
        return f"every step that was run diverges, down to {least:.3g} s"
    return (
        f"the model's own steps do not tend to what was integrated: {best.integrator} at "
        f"{best.step:.3g} s comes nearest, {best.at(index):.2g} m at {script.times[index]:.3g} s, "
        f"which is known to {reference.uncertainty[index]:.1g} m"
    )


def _errors_level_off(steps: Sequence[StepError], own_step: StepError, floor: Array) -> Any:
    """Whether at each time the errors of every integrator level off above `floor` [m], shape (n,).
    Three steps up to the model's own step are needed; integrators with fewer are ignored."""
    levels = []
    for runs in _by_integrator(steps):
        errors = [s.errors for s in runs if s.parts >= own_step.parts]
        if len(errors) > 2:
            fine = np.minimum(errors[-1], errors[-2])
            level = fine > np.maximum(LEVEL * errors[-3], floor)
            levels.append(level | np.isinf(fine))
    return np.all(levels, axis=0) if levels else np.zeros(len(own_step.errors), bool)


def observed_order(
    steps: Sequence[StepError], reference: Certificate, index: int
) -> Order | None:
    """Returns the slope of log error against log step, from the errors that the reference
    resolves."""
    done = [s for s in steps if math.isfinite(s.at(index))]
    # `fit_order` uses errors above ten times their floor.
    floor = float(reference.uncertainty[index]) * RESOLVED / 10.0
    return fit_order(
        [s.step for s in done], [s.at(index) for s in done], [floor] * len(done), most=8
    )


def horizon(
    result: StepComparison, reference: Certificate, script: Script, target: float
) -> float:
    """Returns the first time [s] at which even the most accurate step that was run misses `target`
    [m], or at which the reference is not known to a fifth of the target; infinite if neither
    happens."""
    best = np.min([s.errors for s in result.steps], axis=0)
    missed = (best + reference.uncertainty > target) | (
        reference.uncertainty > TRUSTED * target
    )
    at = np.flatnonzero(missed)
    return float(script.times[at[0]]) if at.size else math.inf


def balances(model: OwnModel, reference: Array, steps: Array) -> tuple[Balance, ...]:
    """Returns the readings of two motions, given as states of shape (n, ...). An energy is measured
    from its value at the start, as it has no zero."""
    continuous_readings = model.readings(reference)
    own_readings = model.readings(steps)
    zero = np.zeros(len(steps))
    rows = []
    for name in dict.fromkeys((*own_readings, *continuous_readings)):
        own = own_readings.get(name, zero)
        continuous = continuous_readings.get(name, zero)
        start = own[0] if name == "energy" else 0.0
        sizes = (
            float(np.abs(x).max()) for x in (own - start, continuous - start, own - continuous)
        )
        rows.append(Balance(name, *sizes))
    return tuple(rows)


def state_errors(model: OwnModel, reference: Array, steps: Array) -> StateErrors:
    """Returns the largest differences of two motions' states, shape (n, ...), at equal times."""
    attitudes, stepped_attitudes = (
        np.moveaxis(model.poses(states)[..., 3:], 2, 0) for states in (reference, steps)
    )
    # The rotation from one attitude to the other is a quaternion with this vector; its scalar is
    # the dot product.
    between = attitudes[0] * stepped_attitudes[1:] - stepped_attitudes[0] * attitudes[1:]
    between -= np.cross(attitudes[1:], stepped_attitudes[1:], axis=0)
    angles = 2.0 * np.arctan2(
        np.linalg.norm(between, axis=0), np.abs(np.sum(attitudes * stepped_attitudes, axis=0))
    )
    activations = (steps - reference)[:, model.activations]
    differences = (angles, model.coordinates(steps, reference), activations)
    return StateErrors(*(float(np.abs(values).max(initial=0.0)) for values in differences))


def error_at_step(
    model: OwnModel, script: Script, reference: Certificate, integrator: str, parts: int
) -> StepError:
    """Returns the errors of a run with `parts` steps of an integrator in a control period."""
    run = model.stepped(script, integrator, parts)
    return step_error_of_run(run, model, reference, integrator, parts)


def step_error_of_run(
    run: Stepped, model: OwnModel, reference: Certificate, integrator: str, parts: int
) -> StepError:
    """Returns the errors of a given run of any engine with `parts` steps in a control period."""
    displacements = np.linalg.norm(model.corners(run.states) - reference.corners, axis=2)
    furthest = int(np.argmax(np.nan_to_num(displacements, posinf=0.0).max(axis=0)))
    return StepError(
        integrator=integrator,
        step=run.step,
        parts=parts,
        errors=running_maximum(displacements),
        worst=model.bodies[model.corner_bodies[furthest]],
        seconds=run.seconds,
        why=run.why,
        remarks=run.remarks,
    )
