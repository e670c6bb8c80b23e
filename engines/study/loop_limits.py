"""The limits of a loop through a digital controller: the hold, the delay and the gain up to which a
method's runs are stable, by bisection."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LOOP_QUANTITIES, TRIAL_STEP_RATIO, LoopQuantity
from plumbob.engines.largest_step import bracket
from plumbob.engines.method import Method, Simulation, Unsupported
from plumbob.engines.registry import engine_of
from plumbob.engines.study.measurement import REFERENCE_STEP, scheme_of
from plumbob.engines.study.request import RunRequest
from plumbob.engines.study.stability import MeasuredLimit, SceneLimits
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene

if TYPE_CHECKING:  # pages load this module, and no exact motion
    from plumbob.analytic.systems.held_loop import HeldLoop

# Holds in a run: half a percent beyond a limit a motion grows by a few percent or more in them
PERIODS = 400
WHY_FAILS = "its motion grows"
WHY_HOLDS = "every value that was tried holds"


@dataclass(frozen=True)
class LoopSearch(RunRequest[SceneLimits]):
    """Request for the limits of the loop of a scene with a method, by runs at a step [s] of the
    scene's own hold. None stands for the step at which methods are compared."""

    label, of_pair, as_planned = "limits of the loop", True, True

    scene: str
    method: str
    step: float | None = None

    def made(self, scene: Scene, method: Method) -> SceneLimits:
        """Returns the limits of the loop's hold, delay and gain."""
        return loop_limits(scene, method, self.step or REFERENCE_STEP)


def has_loop(scene: Scene) -> bool:
    """Whether a scene has a loop through a digital controller."""
    case = case_of(scene)
    return case.system.loop(case.problem) is not None


def loop_limits(scene: Scene, method: Method, step: float) -> SceneLimits:
    """Returns the limits of hold [s], delay [s] and gain [1] of the loop of a scene. A hold keeps
    its number of steps [s] and its delay in periods; a delay is a multiple of the step. The limits
    are empty, with the reason, if the method cannot run the scene, or if the step does not divide
    the hold and the delay."""
    from plumbob.analytic.errors.smooth_motion.held_steps import steps_of

    case = case_of(scene)
    loop = case.system.loop(case.problem)
    if loop is None:
        return SceneLimits((), why="no controller of it is digital")
    parts, late = steps_of(loop.hold, step), steps_of(loop.delay, step)
    if method.control != "step" or not parts or late is None:
        return SceneLimits((), why=f"{step:g} s does not divide its hold and its delay")
    trials = LoopTrials(case, method, loop, step, parts)
    try:
        trials.prepare(case, step)
        limits = [trials.limit(quantity) for quantity in LOOP_QUANTITIES]
    except Unsupported as why:
        return SceneLimits((), why=str(why))
    return SceneLimits(tuple(limits), equilibrium=True)


@dataclass(frozen=True)
class LoopTrials:
    """Runs of a case with other holds, delays and gains, at `parts` steps a hold."""

    case: Case
    method: Method
    loop: HeldLoop
    step: float  # [s] at the hold of the case
    parts: int

    def limit(self, quantity: LoopQuantity) -> MeasuredLimit:
        """Returns the limit of a quantity, beside the limit of the scheme's own map and that of the
        continuous joint."""
        from plumbob.analytic.errors.smooth_motion.held_steps import scheme_limit

        predicted = scheme_limit(
            self.loop, scheme_of(self.case, self.method), quantity, self.step
        )
        continuous = self.loop.limit(quantity)
        value_of, low, high = self._grid(quantity)
        nearest = continuous if predicted is None else predicted
        first = max((k for k in range(low, high + 1) if value_of(k) <= nearest), default=low)
        held, failed = bracket(
            lambda number: self._holds(quantity, value_of(number)), first, low, high
        )
        return MeasuredLimit(
            kind=quantity,
            predicted=predicted,
            holds=None if held is None else value_of(held),
            fails=None if failed is None else value_of(failed),
            why=WHY_HOLDS if failed is None else WHY_FAILS,
            continuous=continuous,
        )

    def _grid(self, quantity: LoopQuantity) -> tuple[Callable[[int], float], int, int]:
        """Returns a function from a number to the value of a quantity, and the smallest and the
        largest number."""
        from plumbob.analytic.systems.held_loop import MOST_DELAY, SCAN_END

        if quantity == "delay":
            return lambda number: number * self.step, 0, MOST_DELAY * self.parts
        own = self.loop.hold if quantity == "hold" else 1.0
        end = round(math.log(SCAN_END) / math.log(TRIAL_STEP_RATIO))
        return lambda number: float(own * TRIAL_STEP_RATIO**number), -end, end

    def _holds(self, quantity: LoopQuantity, value: float) -> bool:
        """Whether the motion of a run with another value of a quantity does not grow."""
        changes = self.case.system.loop_changes(self.case.problem, quantity, value)
        scene = self.case.scene
        changed = replace(scene, parameters={**scene.parameters, **changes})
        hold = self.loop.changed(quantity, value).hold
        case = replace(case_of(changed), scene=changed).lasting(PERIODS * hold)
        with np.errstate(all="ignore"):  # runs that are lost overflow
            run = self.prepare(case, hold / self.parts).run()
            return run.diverged_at is None and not any(
                _grows(values) for values in run.observables.values()
            )

    def prepare(self, case: Case, step: float) -> Simulation:
        """Returns the simulation of a case at a step [s]; raises Unsupported."""
        return engine_of(self.method).prepare(case, self.method, step)


def _grows(values: Array) -> bool:
    """Whether the largest value of the last quarter is at least that of the first quarter."""
    quarters = np.array_split(np.abs(values), 4)
    return not float(quarters[-1].max()) < float(quarters[0].max())
