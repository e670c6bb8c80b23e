"""A model's own steps held against its continuous motion: error, order, choice."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.costs import costs_in_turns, timed_periods
from plumbob.engines.audit.reference import NOTHING, RESOLVED, Certificate, largest
from plumbob.engines.own_motion import OwnModel, Script, Stepped
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.order import Order, fit_order

TARGETS = (0.1, 0.01, 1e-3, 1e-4)  # [m] wanted errors
HALVINGS = 7  # of the model's own step
TRUSTED = 0.2  # of a wanted error: the reference must be known to that
# Of the error at the model's own step, or a finer one: some step must come nearer to the reference
# than this, or it is not what the steps tend to.
FALLS = 0.4
# Of the error at a step four times as large: where the errors of all integrators fall by less, and
# the reference resolves them, they level off at how far the reference is from their own limit.
LEVEL = 0.7
# Times the error of the coarsest steps: errors at contacts scatter by less, and a contact that is
# passed over changes a motion by more.
RISES = 10.0
MOSTLY = 0.8  # of the periods so far must tend: contacts make single ones irregular


@dataclass(frozen=True)
class StepError:
    """Errors of one integrator's run at one step, over time."""

    integrator: str
    step: float  # [s]
    parts: int  # in a control period
    # [m] largest displacement of any corner so far, at the ends of the periods, shape (n,)
    errors: Array
    worst: str  # the body with the corner that is furthest off
    seconds: float  # of processor time, of one run
    why: str = ""  # it ended early
    remarks: tuple[str, ...] = ()  # what was noticed on the way
    cost: Cost | None = None  # of a step; None where it ended early
    # Whether the engine would soften contacts or limits of this run, which the audit prevented.
    softened: bool = False

    @property
    def pace(self) -> Cost | None:
        """Processor time over simulated time; None where it ended early."""
        return self.cost and self.cost.scaled(1e-9 / self.step)

    @property
    def ns_per_second(self) -> float | None:
        """[ns] of processor time per simulated second; None where it ended early."""
        return 1e9 * self.pace.ns_per_step if self.pace else None

    def at(self, index: int) -> float:
        """Error [m] at the end of a period; infinite where the run had ended."""
        return float(self.errors[index])


@dataclass(frozen=True)
class Compared:
    """All steps that were tried, own integrator first, coarse to fine, and how far they reach."""

    own: StepError
    steps: tuple[StepError, ...]
    index: int  # of the period up to which the steps tend to the reference
    nearest: float  # [m] the smallest error of the finest steps there
    order: Order | None  # of the own integrator
    # Whether contacts or limits that the engine softens at the own step act in the motion.
    clamping_acts: bool = False


@dataclass(frozen=True)
class Balance:
    """One reading at the model's own step beside the continuous motion's, which accounts for the
    work of actuators, springs, dampers and friction: a difference of their energies is due to the
    steps alone. At the ends of the control periods, up to where errors are known."""

    name: str
    own: float  # the largest magnitude at the own step; of an energy the largest change
    continuous: float  # the same of the continuous motion
    apart: float  # largest difference of the two at the same time


@dataclass(frozen=True)
class StateErrors:
    """The largest differences of two motions in bodies' attitudes, joint coordinates and
    activations; 0 if a model has none of them."""

    attitude: float  # [rad]
    coordinates: float  # [rad or m]
    activations: float


def compared(
    model: OwnModel, script: Script, reference: Certificate, allowance: Allowance
) -> Compared:
    """Run each of the model's integrators at the model's step, at twice that step if the control
    period allows, and at halves of it, and hold each run against the reference. In an executor the
    integrators run beside each other; costs are measured afterwards, alone."""
    names = model.integrators
    groups = [names] if allowance.executor is None else [(name,) for name in names]
    runs = [
        allowance.start(halved, model, script, reference, names, allowance.left)
        for names in groups
    ]
    errors = [step for run in runs for step in run()]
    allowance.progress("costs")
    errors = priced(model, script, reference, errors)
    fixed = [s for s in errors if s.integrator == model.integrator]
    as_is = next(s for s in fixed if s.parts == round(script.period / model.step))
    index = tends(errors, as_is, reference)
    errors = [
        replace(
            s, softened=s.parts < as_is.parts and model.softens(script, s.integrator, s.parts)
        )
        for s in errors
    ]
    errors.sort(key=lambda s: (s.integrator != model.integrator, s.integrator, -s.step))
    return Compared(
        as_is,
        tuple(errors),
        index,
        float(finest(errors)[index]),
        observed_order(fixed, reference, index),
        model.clamping_acts(script),
    )


def halved(
    model: OwnModel,
    script: Script,
    reference: Certificate,
    integrators: Sequence[str],
    seconds: float,
) -> list[StepError]:
    """Runs of some integrators, in turns, coarse to fine, so that what the time allows is spread
    over all: about so many `seconds`; the model's own step whatever that takes."""
    reached = reference.known
    ends = time.process_time() + seconds
    usual = round(script.period / model.step)
    errors: list[StepError] = []
    going = {name: usual // 2 if usual % 2 == 0 else usual for name in integrators}
    while going:
        for name, parts in list(going.items()):
            begin = time.process_time()
            due = name == model.integrator and parts <= usual
            if errors and begin >= ends and not due:
                del going[name]
                continue
            errors.append(held(model, script, reference, name, parts))
            last = errors[-1].at(reached)
            fine = parts >= 4 * usual and last <= 2.0 * float(reference.uncertainty[reached])
            now = time.process_time()
            late = now + 2.5 * (now - begin) > ends
            needed = usual << (name == model.integrator)  # one halving at least
            if fine or (late and parts >= needed) or parts >= usual << HALVINGS:
                del going[name]
            else:
                going[name] = 2 * parts
    return errors


def priced(
    model: OwnModel, script: Script, reference: Certificate, steps: Sequence[StepError]
) -> list[StepError]:
    """The same with the costs of those that did not end early, along the reference."""
    timed = [
        timed_periods(model, script, reference.states, s.integrator, s.parts, s.seconds)
        for s in steps
        if not s.why
    ]
    costs = iter(costs_in_turns(timed))
    return [s if s.why else replace(s, cost=next(costs)) for s in steps]


def tends(steps: Sequence[StepError], as_is: StepError, reference: Certificate) -> int:
    """Index of the last control period up to which the steps confirm the reference. Some
    integrator's finest step comes much nearer to it than the worst of the model's own and finer
    steps (its own may be near by luck), or as near as it is known. No integrator's errors level off
    above that, or grow as its steps shrink: both would show a reference of something else."""
    nearest = finest(steps)
    floor = np.maximum(reference.uncertainty, NOTHING)
    same = [
        s.errors for s in steps if s.integrator == as_is.integrator and s.parts >= as_is.parts
    ]
    allowed = np.maximum(floor, FALLS * np.max(same, axis=0))
    good = np.isfinite(reference.uncertainty) & (nearest <= allowed)
    good &= ~_level(steps, as_is, floor) & ~_rising(steps, floor)
    mostly = np.cumsum(good) >= MOSTLY * np.arange(1, len(good) + 1)
    return int(np.flatnonzero(good & mostly)[-1])


def finest(steps: Sequence[StepError]) -> Array:
    """The errors [m] over time of the finest steps of the integrator whose finest steps are nearest
    to the reference, shape (n,)."""
    ends = [runs[-1].errors for runs in _by_integrator(steps)]
    return np.asarray(np.min(ends, axis=0))


def _by_integrator(steps: Sequence[StepError]) -> list[list[StepError]]:
    """The steps of each integrator, coarse to fine."""
    names = dict.fromkeys(s.integrator for s in steps)
    ordered = sorted(steps, key=lambda s: s.parts)
    return [[s for s in ordered if s.integrator == name] for name in names]


def _rising(steps: Sequence[StepError], floor: Array) -> Any:
    """Whether at each time an integrator's finest steps are much further from the reference than
    its coarsest ones, and the reference resolves that, shape (n,). Coarse steps may be near because
    they pass over a contact that the reference passes over, too."""
    rises = [
        runs[-1].errors > np.maximum(RISES * runs[0].errors, RESOLVED * floor)
        for runs in _by_integrator(steps)
    ]
    return np.any(rises, axis=0)


def unlike(result: Compared, reference: Certificate, script: Script) -> str:
    """Why the steps that were run do not tend to the reference."""
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


def _level(steps: Sequence[StepError], as_is: StepError, floor: Array) -> Any:
    """Where the errors of every integrator level off above `floor` [m], shape (n,); three steps up
    to the model's own are needed to tell."""
    levels = []
    for runs in _by_integrator(steps):
        errors = [s.errors for s in runs if s.parts >= as_is.parts]
        if len(errors) > 2:
            fine = np.minimum(errors[-1], errors[-2])
            level = fine > np.maximum(LEVEL * errors[-3], floor)
            levels.append(level | np.isinf(fine))
    return np.all(levels, axis=0) if levels else np.zeros(len(as_is.errors), bool)


def observed_order(
    steps: Sequence[StepError], reference: Certificate, index: int
) -> Order | None:
    """Slope of log error against log step, of the errors that the reference resolves."""
    done = [s for s in steps if math.isfinite(s.at(index))]
    floor = float(reference.uncertainty[index]) * RESOLVED / 10.0  # as `fit_order` takes it
    return fit_order(
        [s.step for s in done], [s.at(index) for s in done], [floor] * len(done), most=8
    )


def horizon(result: Compared, reference: Certificate, script: Script, target: float) -> float:
    """The first time [s] at which even the most accurate step that was run misses `target` [m], or
    the reference is not known to a fifth of it; infinite where neither happens."""
    best = np.min([s.errors for s in result.steps], axis=0)
    missed = (best + reference.uncertainty > target) | (
        reference.uncertainty > TRUSTED * target
    )
    at = np.flatnonzero(missed)
    return float(script.times[at[0]]) if at.size else math.inf


def balances(model: OwnModel, reference: Array, steps: Array) -> tuple[Balance, ...]:
    """Readings of two courses of states, shape (n, ...). An energy, which has no zero, is measured
    from its start."""
    theirs = model.readings(reference)
    ours = model.readings(steps)
    zero = np.zeros(len(steps))
    rows = []
    for name in dict.fromkeys((*ours, *theirs)):
        first = ours.get(name, zero)
        second = theirs.get(name, zero)
        start = first[0] if name == "energy" else 0.0
        sizes = (
            float(np.abs(x).max()) for x in (first - start, second - start, first - second)
        )
        rows.append(Balance(name, *sizes))
    return tuple(rows)


def state_errors(model: OwnModel, reference: Array, steps: Array) -> StateErrors:
    """The largest differences of two motions' states, shape (n, ...), at equal times."""
    here, there = (
        np.moveaxis(model.poses(states)[..., 3:], 2, 0) for states in (reference, steps)
    )
    # The quaternion of the rotation from one attitude to the other: its vector and its scalar.
    between = here[0] * there[1:] - there[0] * here[1:]
    between -= np.cross(here[1:], there[1:], axis=0)
    angles = 2.0 * np.arctan2(
        np.linalg.norm(between, axis=0), np.abs(np.sum(here * there, axis=0))
    )
    activations = (steps - reference)[:, model.activations]
    apart = (angles, model.coordinates(steps, reference), activations)
    return StateErrors(*(float(np.abs(values).max(initial=0.0)) for values in apart))


def held(
    model: OwnModel, script: Script, reference: Certificate, integrator: str, parts: int
) -> StepError:
    """The errors of a run with `parts` steps of an integrator in a control period."""
    run = model.stepped(script, integrator, parts)
    return errors_of(run, model, reference, integrator, parts)


def errors_of(
    run: Stepped, model: OwnModel, reference: Certificate, integrator: str, parts: int
) -> StepError:
    """The errors of a run that has been made, of whatever engine, with `parts` steps in a control
    period."""
    apart = np.linalg.norm(model.corners(run.states) - reference.corners, axis=2)
    furthest = int(np.argmax(np.nan_to_num(apart, posinf=0.0).max(axis=0)))
    return StepError(
        integrator,
        run.step,
        parts,
        largest(apart),
        model.bodies[model.corner_bodies[furthest]],
        run.seconds,
        run.why,
        run.remarks,
    )
