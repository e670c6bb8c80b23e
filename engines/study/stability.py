"""The largest step at which a method's runs keep the properties of the exact motion, by
bisection."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from plumbob.analytic.bisection import Holds
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.stability import (
    BAND,
    LARGEST_STEP_AWAY,
    LARGEST_TRIAL_STEP,
    LOST_GROWTH,
    SMALLEST_TRIAL_STEP,
    TRIAL_STEP_RATIO,
    TRIAL_STRIDE,
    FailureKind,
    LoopQuantity,
    StabilityTheory,
    StepLimit,
    exponent,
)
from plumbob.engines.largest_step import bracket
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import engine_of
from plumbob.engines.study.measurement import invariant_drifts, scheme_of
from plumbob.engines.study.request import RunRequest
from plumbob.engines.trajectory import Trajectory, lost
from plumbob.models.registry import case_of, stability_of
from plumbob.models.scene import Case, Scene

# Sizes of the nudge of the start, relative to the scales of the state. If the exact motion and
# LOST_GROWTH would magnify START_NUDGE to the size of the motion, the nudge is smaller, but far
# above the resolution of a double. In single precision the nudge is 80 units in the last place:
# LOST_GROWTH makes it a hundredth of the motion, and ten thousand roundings remain below that.
START_NUDGE, SMALLEST_NUDGE, SMALL = 1e-6, 1e-11, 0.1
SINGLE_NUDGE = 1e-5
# Shortest duration of a run: steps, and periods of the fastest mode.
MIN_RUN_STEPS, MIN_RUN_PERIODS = 10_000, 100
PILOT = 500  # steps of pilot runs, which show most failures at little cost
FIRST_TRIAL_STEP = 0.3  # first step of a search without a prediction, in fastest periods
# Periods and samples of the exact motion that determine its kind and its scales.
FOLLOWED, FOLLOWED_SAMPLES = 30, 501


@dataclass(frozen=True)
class SmallestLimit:
    """The smallest of the known limits of a scene with a method."""

    kind: FailureKind
    step: float  # [s] largest step that holds: infinite if none is too large, zero if all are
    measured: bool  # whether it is measured; else it is predicted
    why: str


@dataclass(frozen=True)
class MeasuredLimit:
    """The limit of a kind, measured and predicted: of the step [s], or of a loop the limit of the
    hold [s], the delay [s] or the factor of the gains [1]."""

    kind: Literal[FailureKind, LoopQuantity]
    predicted: float | None  # [s]; infinite if no step is too large, None without theory
    holds: float | None  # [s] largest step that holds; None if none that was tried does
    fails: float | None  # [s] next step of the grid; None if all that were tried hold
    why: str  # what fails in the run at the next step, or why nothing does
    reason: str = ""  # reason for the predicted limit
    # Limit of the loop if its joint moved without the errors of steps, in the unit of the kind;
    # None if the limit is of no loop
    continuous: float | None = None

    @property
    def measured(self) -> bool:
        """Whether runs showed the limit. If not, it is from theory alone."""
        return self.holds is not None or self.fails is not None

    @property
    def largest(self) -> float:
        """The largest step that holds [s]; infinite if all that were tried hold."""
        if not self.measured:
            return self.predicted or 0.0
        return math.inf if self.fails is None else self.holds or 0.0


@dataclass(frozen=True)
class SceneLimits:
    """The limits of a scene with a method, the limit of stability first."""

    limits: tuple[MeasuredLimit, ...]
    equilibrium: bool = False  # whether the motion stays by an equilibrium
    why: str = ""  # why there are no limits


@dataclass(frozen=True)
class StabilitySearch(RunRequest[SceneLimits]):
    """Request for the largest step of a scene with a method, by its runs or by theory."""

    label, of_pair, as_planned = "largest step", True, True

    scene: str
    method: str
    by_runs: bool = True

    def made(self, scene: Scene, method: Method) -> SceneLimits:
        """Returns the largest steps of the scene with the method."""
        return scene_limits(scene, method, self.by_runs)


def scene_limits(scene: Scene, method: Method, by_runs: bool = True) -> SceneLimits:
    """Returns the largest steps of `method` on `scene`, by its runs or by theory. Raises
    ParameterError."""
    if method.control == "tolerance":
        return SceneLimits((), why="it chooses its steps itself, and pays with their number")
    case = case_of(scene)
    if case.system.loop(case.problem):
        return SceneLimits((), why="its loop has limits of hold, delay and gain instead")
    if by_runs and not case.system.start:
        return SceneLimits((), why="no parameter of the scene is its start, to be nudged")
    theory = stability_of(case)
    try:
        if by_runs:
            engine_of(method).prepare(case, method, min(scene.steps[0], scene.duration))
    except Unsupported as why:
        return SceneLimits((), why=str(why))
    predicted = theory.limits(scheme_of(case, method)) if theory else ()
    if by_runs:
        return searched_limits(case, method, theory, predicted)
    return SceneLimits(
        tuple(
            MeasuredLimit(limit.kind, limit.step, None, None, limit.why) for limit in predicted
        )
    )


def searched_limits(
    case: Case, method: Method, theory: StabilityTheory | None, predicted: tuple[StepLimit, ...]
) -> SceneLimits:
    """Returns the limits of a case, by a search that begins at the `predicted` limits."""
    trials = Trials(case, method, theory)
    by_kind = {limit.kind: limit for limit in predicted}
    unstable = _limit(
        trials, "unstable", by_kind.get("unstable"), trials.keeps_nudge_small, FIRST_TRIAL_STEP
    )
    start = (unstable.holds or unstable.fails or 0.0) / trials.fastest_period
    changes = _limit(
        trials, "changes-kind", by_kind.get("changes-kind"), trials.keeps_kind, start
    )
    if changes.fails and not trials.keeps_nudge_small(
        exponent(changes.fails / trials.fastest_period)
    ):
        # The first search may have begun beyond unstable steps.
        predicted_step = unstable.predicted
        reason = unstable.reason
        unstable = replace(changes, kind="unstable", predicted=predicted_step, reason=reason)
    changes_first = (changes.fails or math.inf) < (unstable.holds or 0.0)
    several = changes_first or "changes-kind" in by_kind
    equilibrium = theory is not None and theory.equilibrium
    return SceneLimits((unstable, changes) if several else (unstable,), equilibrium)


def _limit(
    trials: Trials,
    kind: FailureKind,
    predicted: StepLimit | None,
    holds: Holds[int],
    start: float,
) -> MeasuredLimit:
    """Returns the limit of a `kind`. The search begins at the predicted limit, or at `start`
    fastest periods if there is no prediction."""
    if predicted is not None:
        start = predicted.step / trials.fastest_period
    every = 1 if trials.monotone else TRIAL_STRIDE
    end = LARGEST_TRIAL_STEP if trials.monotone else LARGEST_STEP_AWAY
    low = exponent(SMALLEST_TRIAL_STEP, every)
    high = exponent(end, every)
    first = max(exponent(min(start, end), every), low) if start > 0.0 else low
    held, failed = bracket(holds, first, low, high, every)
    why = "every step that was tried holds"
    if failed is not None:
        outcome = trials.outcome(failed)
        why = outcome.unstable or outcome.changes_kind
    return MeasuredLimit(
        kind=kind,
        predicted=None if predicted is None else predicted.step,
        holds=None if held is None else trials.step(held),
        fails=None if failed is None else trials.step(failed),
        why=why,
        reason="" if predicted is None else predicted.why,
    )


@dataclass(frozen=True)
class TrialOutcome:
    """The reasons for which the runs at one step fail; both are empty if the step holds."""

    unstable: str = ""  # why the runs are unstable
    changes_kind: str = ""  # why their motion is of another kind than the exact motion

    @classmethod
    def lost(cls, why: str) -> TrialOutcome:
        """Returns the outcome of a run that fails in both ways, since it ends early or its
        invariants are lost."""
        return cls(why, why)


@dataclass
class Trials:
    """Runs of a case and of the case with a nudged start, each at a step of a grid and made
    once."""

    case: Case
    method: Method
    theory: StabilityTheory | None
    outcomes: dict[int, TrialOutcome] = field(default_factory=dict)

    def keeps_nudge_small(self, number: int) -> bool:
        """Whether a nudge stays small at a step of the grid."""
        return not self.outcome(number).unstable

    def keeps_kind(self, number: int) -> bool:
        """Whether a nudge stays small and the motion stays of its kind."""
        outcome = self.outcome(number)
        return not (outcome.unstable or outcome.changes_kind)

    def step(self, number: int) -> float:
        """Returns a step of the grid [s]."""
        return float(self.fastest_period * TRIAL_STEP_RATIO**number)

    def outcome(self, number: int) -> TrialOutcome:
        """Returns the outcome of runs at a step of the grid."""
        if number not in self.outcomes:
            self.outcomes[number] = self._run_outcome(self.step(number))
        return self.outcomes[number]

    @cached_property
    def fastest_period(self) -> float:
        """The fastest period [s]; without theory, the largest of the scene's own steps."""
        return self.theory.fastest if self.theory else self.case.scene.steps[0]

    @property
    def monotone(self) -> bool:
        """Whether all steps above the first step that fails fail, too. They do if eigenvalues set
        the limit, or friction brings all motions to the same rest."""
        return self.theory is None or self.theory.equilibrium

    @cached_property
    def exact(self) -> Signals:
        """The exact motion over the scene's duration, or over FOLLOWED fastest periods if they are
        longer and the motion is known for so long."""
        longest = max(
            self.case.scene.duration, FOLLOWED * self.fastest_period if self.theory else 0.0
        )
        try:
            return self.case.reference.observe(np.linspace(0.0, longest, FOLLOWED_SAMPLES))
        except ParameterError:
            return self.case.reference.observe(
                np.linspace(0.0, self.case.scene.duration, FOLLOWED_SAMPLES)
            )

    @cached_property
    def scales(self) -> Mapping[str, float]:
        """{observable of the state: its largest magnitude}; the scale of an angle is at most one
        radian."""
        scales = {}
        for observable in self.case.system.observables:
            if not observable.force:
                most = 1.0 if observable.unit == "rad" else math.inf
                largest = float(np.abs(self.exact[observable.name]).max())
                scales[observable.name] = min(largest, most) or 1.0
        return scales

    @cached_property
    def nudge_growth_scales(self) -> Mapping[str, float]:
        """{observable of the state: the scale for the growth of a nudge}. The scale of a rate is at
        least the largest rate of an oscillation in the fastest mode whose amplitude is the scale of
        the angle: 2 pi times this scale, divided by the period."""
        if self.theory is None:
            return self.scales
        rate_scales = {
            f"{name}_dot": math.tau * scale / self.fastest_period
            for name, scale in self.scales.items()
        }
        return {
            name: max(scale, rate_scales.get(name, 0.0)) for name, scale in self.scales.items()
        }

    @cached_property
    def nudged(self) -> Case:
        """The case with a nudged start."""
        system = self.case.system
        parameters = self.case.scene.parameters
        names = [name for name in system.start if name in parameters] or system.start[-1:]
        changes = {
            name: self._nudged_parameter(name, parameters.get(name, 0.0)) for name in names
        }
        changed = system.change(parameters, changes)
        return case_of(replace(self.case.scene, parameters=changed))

    @cached_property
    def nudge(self) -> float:
        """The relative size of the nudge."""
        if scheme_of(self.case, self.method).unit > 1.0:
            return SINGLE_NUDGE
        growth = (
            self.theory.growth(MIN_RUN_STEPS * self.fastest_period * FIRST_TRIAL_STEP)
            if self.theory
            else 1.0
        )
        return min(max(SMALL / (LOST_GROWTH * growth), SMALLEST_NUDGE), START_NUDGE)

    def _nudged_parameter(self, name: str, value: Any) -> Any:
        """Returns the `value` of a parameter of the start, moved by the nudge."""
        values = np.asarray(value, dtype=np.float64)
        size = self.nudge * self.scales.get(name, float(np.abs(values).max()) or 1.0)
        return tuple((values + size).tolist()) if values.ndim else float(values) + size

    @cached_property
    def kind(self) -> str:
        """The kind of the exact motion."""
        return self.theory.kind_of(self.exact) if self.theory else ""

    def _run_outcome(self, step: float) -> TrialOutcome:
        """Returns the outcome of runs at a step [s]."""
        steps = max(MIN_RUN_STEPS, math.ceil(MIN_RUN_PERIODS * self.fastest_period / step))
        with np.errstate(all="ignore"):  # runs that are lost overflow
            early = self._outcome_of_pair(step, PILOT)
            return early if early.unstable else self._outcome_of_pair(step, steps)

    def _outcome_of_pair(self, step: float, steps: int) -> TrialOutcome:
        """Returns the outcome of two runs with `steps` steps of `step` [s]: of the case, and of the
        case with a nudged start."""
        run = self._run(self.case, step, steps)
        if why := _loss(run):
            return TrialOutcome.lost(why)
        beyond = {n: d for n, d in invariant_drifts(self.case, run).items() if d > BAND}
        if beyond:
            name = next(iter(beyond))
            why = f"{name.replace('_', ' ')} differs by {beyond[name]:.2g} times its scale"
            return TrialOutcome.lost(why)
        grown = self._excessive_growth(run, self._run(self.nudged, step, steps))
        return TrialOutcome(unstable=grown, changes_kind=self._change_of_kind(run))

    def _run(self, case: Case, step: float, steps: int) -> Trajectory:
        """Returns a run of `case` with `steps` steps of `step` [s]."""
        return (
            engine_of(self.method).prepare(case.lasting(steps * step), self.method, step).run()
        )

    def _excessive_growth(self, run: Trajectory, nudged: Trajectory) -> str:
        """Explains how a nudge has grown beyond its growth in the exact motion; empty if the growth
        is allowed."""
        if why := _loss(nudged):
            return f"nudged, it is {why}"
        differences = np.max(
            [
                np.abs(nudged.observables[name] - run.observables[name]) / scale
                for name, scale in self.nudge_growth_scales.items()
                if name in run.observables
            ],
            axis=0,
        )
        growth = differences / (differences[0] or self.nudge)
        if growth.max() <= LOST_GROWTH:
            return ""
        beyond = growth / self._exact_growth(run.times)
        if beyond.max() <= LOST_GROWTH:
            return ""
        first_beyond = int(np.argmax(beyond > LOST_GROWTH))
        within = float(f"{run.times[first_beyond]:.3g}")  # 6110 s, and not 6.11e+03 s
        return f"a nudge grows {LOST_GROWTH:.0f}-fold within {within:g} s"

    def _exact_growth(self, times: Array) -> Array:
        """Returns the factors by which the exact motion magnifies a nudge until `times` [s], shape
        (n,). The factors are computed for durations that double; each is used for all times up to
        its duration."""
        if self.theory is None:
            return np.ones_like(times)
        lasting = float(times[-1]) * 0.5 ** np.arange(8.0)[::-1]
        factors = np.array([self.theory.growth(float(t)) for t in lasting])
        return np.asarray(factors[np.searchsorted(lasting, times).clip(max=7)])

    def _change_of_kind(self, run: Trajectory) -> str:
        """Explains how the motion is of another kind; empty if it is of the same kind."""
        kind = self.theory.kind_of(run.observables) if self.theory else ""
        return "" if kind == self.kind else f"{self.kind} becomes {kind}"


def _loss(run: Trajectory) -> str:
    """Says when a run is lost; empty if it is not."""
    if run.diverged_at is not None:
        return f"lost after {run.diverged_at:.3g} s"
    return lost(run)
