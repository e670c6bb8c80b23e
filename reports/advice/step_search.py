"""Search for the largest step of each method that reaches a wanted error on all scenes of a family.

A step reaches an error if the run at this step, and the run at every smaller step, has an error no
larger. At least two smaller steps are checked. If the errors do not lie on one straight line on
logarithmic axes, 24 smaller steps are checked: a discontinuity inside a step makes the error a
sawtooth, with zeros by chance.

If a step fails, no larger step is recommended. The cost of the smallest step that fails is
therefore a lower bound on the cost of the method. The search begins with the cheapest method, and
ends when no other method can be much cheaper than the best one so far.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from plumbob.engines.method import Method
from plumbob.engines.study.cost import Key
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Quantities
from plumbob.engines.study.stability import SmallestLimit
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.work_precision import error_or_infinity

# The next four are chosen; tests/validation/test_recommended.py holds them from both sides.
RESOLVED_RATIO = 1.1  # ratio of the smallest step that fails to the chosen step
STRIDE_RATIO = 1.25  # ratio of a step that fails to the next step that is tried
LIMIT_FRACTION = 0.8  # upper bound on recommended steps, relative to a limit of stability
CHEAPER_RATIO = 1.3  # least ratio of costs for which a method is searched
# Ratios of the smaller steps that are checked to the step itself, none a multiple of another.
FEW_RATIOS = (0.931, 0.787)
MORE_RATIOS = (
    *(0.989, 0.977, 0.965, 0.953, 0.942, 0.92, 0.909, 0.897, 0.883, 0.871, 0.859),
    *(0.843, 0.827, 0.809, 0.769, 0.751, 0.727, 0.703, 0.677, 0.647, 0.613, 0.577),
)
# Margin by which errors off a line must stay below the wanted error. If 25 errors are uniformly
# distributed up to a largest error, all lie below 1/1.2 of it with a probability of 1 %.
SCATTER_MARGIN = 1.2
_LINE_DISTANCE = 0.05  # largest relative distance of an error from a line on logarithmic axes
# Smallest factor by which a step is extrapolated below all that were run.
_SMALLEST_FACTOR = 1e-9
_LEAST_SLOPE = 0.3  # least slope of log error against log step that is extrapolated
_MOST_BISECTIONS = 40  # most bisection steps
_LEAST_STEPS = 8  # least steps of a run
_TOLERANCES = (1e-13, 0.1)  # the tightest and the loosest relative tolerance
_COMPILE_SECONDS = 0.1  # [s] rough time that a run takes apart from its steps


@dataclass
class Evidence:
    """Measurements of methods on the scenes of a family, and the means to make more runs."""

    scenes: tuple[Scene, ...]
    quantities: Mapping[str, Quantities]  # {scene: its quantities whose errors count}
    costs: Mapping[Key, float]  # [ns] wall time of a step
    runs: dict[Key, dict[float, Measurement]]  # {scene and method: {step: run}}
    # Function that makes one more run; None if no more runs are to be made.
    run: Callable[[Scene, Method, float], Measurement] | None = None
    seconds: float = math.inf  # [s] computing time that is left
    limits: Mapping[Key, SmallestLimit] = field(default_factory=dict)  # limits of the step

    @property
    def scale(self) -> float:
        """The largest scale of the first quantity of interest, in its unit."""
        return max(quantities[0].scale for quantities in self.quantities.values())

    def errors(self, method: Method) -> dict[float, float]:
        """Returns {step: largest relative error over the scenes} for each step that was run on any
        scene."""
        largest: dict[float, float] = {}
        for scene in self.scenes:
            for step, run in self._method_runs(scene, method).items():
                error = error_or_infinity(run, self.quantities[scene.name])
                largest[step] = max(error, largest.get(step, 0.0))
        return largest

    def _method_runs(self, scene: Scene, method: Method) -> dict[float, Measurement]:
        """Returns {step: run} of a method on a scene."""
        return self.runs[scene.name, method.name]

    def common_steps(self, method: Method, below: float = math.inf) -> list[float]:
        """Returns the steps smaller than `below` that were run on every scene, from small to
        large."""
        steps_by_scene = [set(self._method_runs(scene, method)) for scene in self.scenes]
        common = set.intersection(*steps_by_scene)
        return sorted(step for step in common if step < below)

    def cost(self, method: Method, step: float) -> float:
        """Returns the wall time [ns] per simulated second, over the family; 0 at an infinite
        step."""
        total = sum(self._run_cost(scene, method, step) for scene in self.scenes)
        return total / sum(scene.duration for scene in self.scenes)

    def _run_cost(self, scene: Scene, method: Method, step: float) -> float:
        """Returns the wall time [ns] of a run. At a tolerance, the steps are counted by the run at
        the nearest tolerance."""
        runs = self._method_runs(scene, method)
        if math.isinf(step) or not runs:
            return 0.0
        steps = scene.duration / step
        if method.control == "tolerance":
            nearest = min(runs, key=lambda tolerance: abs(math.log(tolerance / step)))
            steps = runs[nearest].steps
        return steps * self.costs[scene.name, method.name]

    def limit(self, method: Method) -> SmallestLimit | None:
        """Returns the smallest limit of a method's step on any scene; None if no limit is known."""
        if method.control == "tolerance":
            return None
        known = (self.limits.get((scene.name, method.name)) for scene in self.scenes)
        finite = [limit for limit in known if limit and math.isfinite(limit.step)]
        return min(finite, key=lambda limit: limit.step, default=None)

    def step_bound(self, method: Method) -> float:
        """Returns the step [s] that every recommended step is below; infinite without a limit."""
        limit = self.limit(method)
        return math.inf if limit is None else LIMIT_FRACTION * limit.step

    def smallest_miss(self, method: Method, wanted: float) -> float:
        """Returns the smallest step whose error exceeds the wanted one on any scene; infinite if
        there is none."""
        errors = self.errors(method)
        misses = [step for step, error in errors.items() if not error <= wanted]
        return min(misses, default=math.inf)

    def smallest_excluded(self, method: Method, wanted: float) -> float:
        """Returns the smallest step that is ruled out, by its error or a limit; infinite if there
        is none."""
        return min(self.step_bound(method), self.smallest_miss(method, wanted))

    def choice(self, method: Method, step: float, error: float, wanted: float = 0.0) -> Choice:
        """Returns the choice of a step that was run, with the bound `error` on its relative error.
        `wanted` is the error that was asked for; 0 if none was."""
        limit = self.limit(method)
        bound = self.step_bound(method)
        miss = self.smallest_miss(method, wanted)
        largest_reached = max([RESOLVED_RATIO * step, *self.common_steps(method, miss)])
        return Choice(
            method=method.name,
            control=method.control,
            step=step,
            error=error,
            absolute=error * self.scale,
            ns_per_second=self.cost(method, step),
            surrogate=method.surrogate,
            limit=limit,
            margin=None if limit is None else limit.step / step,
            limited=wanted > 0.0 and bound < miss and bound <= largest_reached,
        )

    def choices(self, method: Method, below: float = math.inf) -> list[Choice]:
        """Returns the choices of a method at steps smaller than `below` that were run to the end on
        every scene, each with the largest error at its step and at all smaller steps: an error that
        crosses zero is small at one step by chance."""
        errors = self.errors(method)
        choices = []
        largest = 0.0
        for step in self.common_steps(method, below):
            largest = max(largest, *(errors[s] for s in errors if s <= step))
            if math.isfinite(largest):
                choices.append(self.choice(method, step, largest))
        return choices

    def reaches(self, method: Method, step: float, wanted: float, margin: float) -> bool | None:
        """Whether `margin` times the error at a step is at most `wanted` on every scene. Makes the
        runs that are missing; returns None if there is no time for a run."""
        for scene in self.scenes:
            longest = scene.duration / _LEAST_STEPS
            smallest, largest = (0.0, longest) if method.control == "step" else _TOLERANCES
            if not smallest <= step <= largest:
                return False
            run = self._find_or_make_run(scene, method, step)
            if run is None:
                return None
            error = error_or_infinity(run, self.quantities[scene.name])
            if not margin * error <= wanted:
                return False
        return True

    def _find_or_make_run(
        self, scene: Scene, method: Method, step: float
    ) -> Measurement | None:
        """Returns the run at a step. Makes the run if it is missing; returns None if there is no
        time for it."""
        runs = self._method_runs(scene, method)
        if step not in runs and self.run is not None:
            seconds = _COMPILE_SECONDS + 1e-9 * self._run_cost(scene, method, step)
            if seconds > self.seconds:
                self.seconds = 0.0
                return None
            self.seconds -= seconds
            runs[step] = self.run(scene, method, step)
        return runs.get(step)

    def reaches_nearby(self, method: Method, step: float, wanted: float) -> bool | None:
        """Whether a step and smaller steps near it reach the error. If the method has a fixed step
        and the errors at the step and at two smaller ones lie on a straight line, these three
        decide. Otherwise 22 more are run, and SCATTER_MARGIN times each of the 25 errors must be at
        most the wanted error. Returns None if there is no time for a run."""
        few = [step, *(_four_digits(step * ratio) for ratio in FEW_RATIOS)]
        few_reach = self._all_reach(method, few, wanted, 1.0)
        if not few_reach:
            return few_reach
        if method.control == "step" and _on_straight_line(few, self.errors(method)):
            return few_reach
        more = [_four_digits(step * ratio) for ratio in MORE_RATIOS]
        return self._all_reach(method, (*few, *more), wanted, SCATTER_MARGIN)

    def _all_reach(
        self, method: Method, steps: Sequence[float], wanted: float, margin: float
    ) -> bool | None:
        """Whether all steps reach the error with a margin; None if there is no time for a run
        before one fails."""
        for step in steps:
            reached = self.reaches(method, step, wanted, margin)
            if not reached:
                return reached
        return True


def cheapest_choices(
    evidence: Evidence, methods: Sequence[Method], wanted: float, best: float = math.inf
) -> list[Choice]:
    """Returns the cheapest choices that reach the error, at most one a method, the cheapest first.
    Methods that may be cheaper than all others by CHEAPER_RATIO are searched with new runs. For
    other methods the runs made before count. `best` is the cost [ns per simulated second] of the
    cheapest method known so far."""

    def rough_cost(method: Method) -> float:
        """Returns a rough cost of a method before the search."""
        excluded = evidence.smallest_excluded(method, wanted)
        steps = evidence.common_steps(method, excluded)
        return evidence.cost(method, steps[-1]) if steps else math.inf

    choices: list[Choice] = []
    for method in sorted(methods, key=rough_cost):
        step = _largest_step(evidence, method, wanted, best)
        if step is None:
            continue
        errors = evidence.errors(method)
        error = max(errors[smaller] for smaller in errors if smaller <= step)
        choices.append(evidence.choice(method, step, error, wanted))
        best = min(best, choices[-1].ns_per_second)
    return sorted(choices, key=lambda choice: choice.ns_per_second)


def _largest_step(
    evidence: Evidence, method: Method, wanted: float, best: float
) -> float | None:
    """Returns the largest step that reaches the error; None if there is none. The step is found by
    bisection between the smallest step that fails and the largest one that reaches the error. If no
    more runs are to be made, it is the cheapest step that was run."""

    def expensive(step: float) -> bool:
        """Whether the smaller steps cannot be much cheaper than the best cost so far."""
        return best <= CHEAPER_RATIO * evidence.cost(method, step)

    ceiling = evidence.smallest_excluded(method, wanted)
    if evidence.run is None or expensive(ceiling):
        # A looser tolerance need not be the cheaper one.
        allowed = evidence.common_steps(method, ceiling)
        return min(allowed, key=partial(evidence.cost, method), default=None)
    # A cost is proportional to 1/step, and roughly to tolerance^(-1/8).
    resolved = RESOLVED_RATIO if method.control == "step" else RESOLVED_RATIO**8
    chosen = 0.0
    for _ in range(_MOST_BISECTIONS):
        ceiling = min(ceiling, evidence.smallest_excluded(method, wanted))
        if chosen >= ceiling:
            chosen = 0.0
        if expensive(ceiling) or ceiling <= resolved * chosen:
            break
        step = _next_step(evidence, method, wanted, chosen, ceiling)
        if step == chosen:
            break
        reached = evidence.reaches_nearby(method, step, wanted)
        if reached is None:
            break
        if reached:
            chosen = step
        else:
            ceiling = step
    return chosen or None


def _next_step(
    evidence: Evidence, method: Method, wanted: float, chosen: float, ceiling: float
) -> float:
    """Returns the step that the bisection tries next, between the largest step that reaches the
    error, `chosen` (0: none so far), and the smallest one that fails, `ceiling`. Returns `chosen`
    if no step is left to try."""
    if not chosen:
        below = evidence.common_steps(method, ceiling)
        well_below = [step for step in below if STRIDE_RATIO * step <= ceiling]
        candidates = well_below or below[:1]
        if candidates:
            return candidates[-1]
        return _extrapolated_step(evidence, method, wanted, ceiling)
    if math.isinf(ceiling):
        return _rounded_down(chosen * (1.8 if method.control == "step" else 4.0))
    return _rounded_down(math.sqrt(chosen * ceiling))


def _extrapolated_step(
    evidence: Evidence, method: Method, wanted: float, ceiling: float
) -> float:
    """Returns a step below all steps that were run, at which the extrapolated error is the wanted
    one; 0 if the errors do not fall with the step."""
    steps = evidence.common_steps(method)
    if len(steps) < 2:
        return 0.0
    small, large = steps[:2]
    errors = evidence.errors(method)
    if not 0.0 < errors[small] < errors[large] < math.inf:
        return 0.0
    slope = math.log(errors[large] / errors[small]) / math.log(large / small)
    if slope < _LEAST_SLOPE:
        return 0.0
    factor = min(0.8, 0.9 * (wanted / errors[small]) ** (1.0 / slope))
    # A smaller factor would take too long, and may underflow.
    return _rounded_down(min(ceiling, small) * factor) if factor > _SMALLEST_FACTOR else 0.0


def _on_straight_line(steps: Sequence[float], errors: Mapping[float, float]) -> bool:
    """Whether the errors at three steps lie on a rising line on logarithmic axes."""
    if min(errors[step] for step in steps) <= 0.0:
        return False
    x0, x1, x2 = (math.log(step) for step in steps)
    y0, y1, y2 = (math.log(errors[step]) for step in steps)
    slope = (y0 - y2) / (x0 - x2)
    return slope > _LEAST_SLOPE and abs(y1 - (y0 + slope * (x1 - x0))) <= _LINE_DISTANCE


def _rounded_down(step: float) -> float:
    """Returns a step rounded down to three significant digits."""
    exponent = math.floor(math.log10(step)) - 2
    return float(f"{math.floor(step / 10.0**exponent * (1 + 1e-12))}e{exponent}")


def _four_digits(step: float) -> float:
    """Returns a step rounded to four significant digits."""
    return float(f"{step:.4g}")
