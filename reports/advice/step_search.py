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
from plumbob.engines.study.stability import KnownLimit
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.work_precision import error_of

# The next four are chosen; tests/validation/test_recommended.py holds them from both sides.
RESOLVED = 1.1  # ratio of the smallest step that fails to the chosen step
STRIDE = 1.25  # ratio of a step that fails to the next step that is tried
ALLOWED = 0.8  # upper bound on recommended steps, relative to a limit of stability
CHEAPER = 1.3  # least ratio of costs for which a method is searched
# Ratios of the smaller steps that are checked to the step itself, none a multiple of another.
FEW = (0.931, 0.787)
MORE = (
    *(0.989, 0.977, 0.965, 0.953, 0.942, 0.92, 0.909, 0.897, 0.883, 0.871, 0.859),
    *(0.843, 0.827, 0.809, 0.769, 0.751, 0.727, 0.703, 0.677, 0.647, 0.613, 0.577),
)
# Margin by which errors off a line must stay below the wanted error. If 25 errors are uniformly
# distributed up to a largest error, all lie below 1/1.2 of it with a probability of 1 %.
SCATTER = 1.2
_STRAIGHT = 0.05  # largest relative distance of an error from a line on logarithmic axes
_SMALLEST = 1e-9  # smallest factor by which a step is extrapolated below all that were run
_SHALLOW = 0.3  # least slope of log error against log step that is extrapolated
_TRIES = 40  # most bisection steps
_FEWEST = 8  # least steps of a run
_TOLERANCES = (1e-13, 0.1)  # the tightest and the loosest relative tolerance
_COMPILE = 0.1  # [s] rough time that a run takes apart from its steps


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
    limits: Mapping[Key, KnownLimit] = field(default_factory=dict)  # limits of the step

    @property
    def scale(self) -> float:
        """The largest scale of the first quantity of interest, in its unit."""
        return max(about[0].scale for about in self.quantities.values())

    def errors(self, method: Method) -> dict[float, float]:
        """Returns {step: largest relative error over the scenes} for each step that was run on any
        scene."""
        largest: dict[float, float] = {}
        for scene in self.scenes:
            for step, run in self._runs(scene, method).items():
                error = error_of(run, self.quantities[scene.name])
                largest[step] = max(error, largest.get(step, 0.0))
        return largest

    def _runs(self, scene: Scene, method: Method) -> dict[float, Measurement]:
        """Returns {step: run} of a method on a scene."""
        return self.runs[scene.name, method.name]

    def common(self, method: Method, below: float = math.inf) -> list[float]:
        """Returns the steps smaller than `below` that were run on every scene, from small to
        large."""
        every = (set(self._runs(scene, method)) for scene in self.scenes)
        return sorted(h for h in set.intersection(*every) if h < below)

    def cost(self, method: Method, step: float) -> float:
        """Returns the wall time [ns] per simulated second, over the family; 0 at an infinite
        step."""
        total = sum(self._price(scene, method, step) for scene in self.scenes)
        return total / sum(scene.duration for scene in self.scenes)

    def _price(self, scene: Scene, method: Method, step: float) -> float:
        """Returns the wall time [ns] of a run. At a tolerance, the steps are counted by the run at
        the nearest tolerance."""
        runs = self._runs(scene, method)
        if math.isinf(step) or not runs:
            return 0.0
        steps = scene.duration / step
        if method.control == "tolerance":
            steps = runs[min(runs, key=lambda h: abs(math.log(h / step)))].steps
        return steps * self.costs[scene.name, method.name]

    def limit(self, method: Method) -> KnownLimit | None:
        """Returns the smallest limit of a method's step on any scene; None if no limit is known."""
        if method.control == "tolerance":
            return None
        known = (self.limits.get((scene.name, method.name)) for scene in self.scenes)
        finite = [limit for limit in known if limit and math.isfinite(limit.step)]
        return min(finite, key=lambda limit: limit.step, default=None)

    def allowed(self, method: Method) -> float:
        """Returns the step [s] that every recommended step is below; infinite without a limit."""
        limit = self.limit(method)
        return math.inf if limit is None else ALLOWED * limit.step

    def missing(self, method: Method, wanted: float) -> float:
        """Returns the smallest step whose error exceeds the wanted one on any scene; infinite if
        there is none."""
        errors = self.errors(method).items()
        return min((h for h, error in errors if not error <= wanted), default=math.inf)

    def failing(self, method: Method, wanted: float) -> float:
        """Returns the smallest step that is ruled out, by its error or a limit; infinite if there
        is none."""
        return min(self.allowed(method), self.missing(method, wanted))

    def choice(self, method: Method, step: float, error: float, wanted: float = 0.0) -> Choice:
        """Returns the choice of a step that was run, with the bound `error` on its relative error.
        `wanted` is the error that was asked for; 0 if none was."""
        limit = self.limit(method)
        allowed = self.allowed(method)
        missing = self.missing(method, wanted)
        larger = max([RESOLVED * step, *self.common(method, missing)])
        return Choice(
            method.name,
            method.control,
            step,
            error,
            error * self.scale,
            self.cost(method, step),
            surrogate=method.surrogate,
            limit=limit,
            margin=None if limit is None else limit.step / step,
            limited=wanted > 0.0 and allowed < missing and allowed <= larger,
        )

    def choices(self, method: Method, below: float = math.inf) -> list[Choice]:
        """Returns the choices of a method at steps smaller than `below` that were run to the end on
        every scene."""
        errors = self.errors(method)
        common = self.common(method, below)
        return [self.choice(method, h, errors[h]) for h in common if math.isfinite(errors[h])]

    def reaches(self, method: Method, step: float, wanted: float, margin: float) -> bool | None:
        """Whether `margin` times the error at a step is at most `wanted` on every scene. Makes the
        runs that are missing; returns None if there is no time for a run."""
        for scene in self.scenes:
            steps = 0.0, scene.duration / _FEWEST
            least, most = steps if method.control == "step" else _TOLERANCES
            if not least <= step <= most:
                return False
            run = self._run(scene, method, step)
            if run is None or not margin * error_of(run, self.quantities[scene.name]) <= wanted:
                return None if run is None else False
        return True

    def _run(self, scene: Scene, method: Method, step: float) -> Measurement | None:
        """Returns the run at a step. Makes the run if it is missing; returns None if there is no
        time for it."""
        runs = self._runs(scene, method)
        if step not in runs and self.run is not None:
            seconds = _COMPILE + 1e-9 * self._price(scene, method, step)
            if seconds > self.seconds:
                self.seconds = 0.0
                return None
            self.seconds -= seconds
            runs[step] = self.run(scene, method, step)
        return runs.get(step)

    def holds(self, method: Method, step: float, wanted: float) -> bool | None:
        """Whether a step and smaller steps near it reach the error. If the method has a fixed step
        and the errors at the step and at two smaller ones lie on a straight line, these three
        decide. Otherwise 22 more are run, and SCATTER times each of the 25 errors must be at most
        the wanted error. Returns None if there is no time for a run."""
        few, more = ([float(f"{step * part:.4g}") for part in parts] for parts in (FEW, MORE))
        few = [step, *few]

        def every(steps: Sequence[float], margin: float) -> bool | None:
            answers = (self.reaches(method, h, wanted, margin) for h in steps)
            return next((answer for answer in answers if not answer), True)

        first = every(few, 1.0)
        if not first or (method.control == "step" and _straight(few, self.errors(method))):
            return first
        return every((*few, *more), SCATTER)


def searched(
    evidence: Evidence, methods: Sequence[Method], wanted: float, best: float = math.inf
) -> list[Choice]:
    """Returns the cheapest choices that reach the error, at most one a method, the cheapest first.
    Methods that may be cheaper than all others by CHEAPER are searched with new runs. For other
    methods the runs made before count. `best` is the cost [ns per simulated second] of the cheapest
    method known so far."""
    choices: list[Choice] = []

    def hoped(method: Method) -> float:
        """Returns a rough cost of a method before the search."""
        good = evidence.common(method, evidence.failing(method, wanted))
        return evidence.cost(method, good[-1]) if good else math.inf

    for method in sorted(methods, key=hoped):
        step = _largest(evidence, method, wanted, best)
        if step is not None:
            error = max(e for h, e in evidence.errors(method).items() if h <= step)
            choices.append(evidence.choice(method, step, error, wanted))
            best = min(best, choices[-1].ns_per_second)
    return sorted(choices, key=lambda choice: choice.ns_per_second)


def _largest(evidence: Evidence, method: Method, wanted: float, best: float) -> float | None:
    """Returns the largest step that reaches the error; None if there is none. The step is found by
    bisection between the smallest step that fails and the largest one that reaches the error. If no
    more runs are to be made, it is the cheapest step that was run."""

    def expensive(step: float) -> bool:
        """Whether the smaller steps cannot be much cheaper than the best cost so far."""
        return best <= CHEAPER * evidence.cost(method, step)

    ceiling = evidence.failing(method, wanted)
    if evidence.run is None or expensive(ceiling):
        # A looser tolerance need not be the cheaper one.
        good = evidence.common(method, ceiling)
        return min(good, key=partial(evidence.cost, method), default=None)
    # The cost goes roughly as the 8th root of the tolerance.
    resolved = RESOLVED if method.control == "step" else RESOLVED**8
    chosen = 0.0
    for _ in range(_TRIES):
        ceiling = min(ceiling, evidence.failing(method, wanted))
        if chosen >= ceiling:
            chosen = 0.0
        if expensive(ceiling) or ceiling <= resolved * chosen:
            break
        if not chosen:
            below = evidence.common(method, ceiling)
            good = [h for h in below if STRIDE * h <= ceiling] or below[:1]
            step = good[-1] if good else _finer(evidence, method, wanted, ceiling)
        elif math.isinf(ceiling):
            step = _rounded(chosen * (1.8 if method.control == "step" else 4.0))
        else:
            step = _rounded(math.sqrt(chosen * ceiling))
        if step == chosen or (holds := evidence.holds(method, step, wanted)) is None:
            break
        chosen, ceiling = (step, ceiling) if holds else (chosen, step)
    return chosen or None


def _finer(evidence: Evidence, method: Method, wanted: float, failing: float) -> float:
    """Returns a step below all steps that were run, at which the extrapolated error is the wanted
    one; 0 if the errors do not fall with the step."""
    steps = evidence.common(method)
    errors = evidence.errors(method)
    if len(steps) < 2 or not 0.0 < errors[steps[0]] < errors[steps[1]] < math.inf:
        return 0.0
    small, large = steps[:2]
    slope = math.log(errors[large] / errors[small]) / math.log(large / small)
    if slope < _SHALLOW:
        return 0.0
    factor = min(0.8, 0.9 * (wanted / errors[small]) ** (1.0 / slope))
    # A smaller factor would take too long, and may underflow.
    return _rounded(min(failing, small) * factor) if factor > _SMALLEST else 0.0


def _straight(steps: Sequence[float], errors: Mapping[float, float]) -> bool:
    """Whether the errors at three steps lie on a rising line on logarithmic axes."""
    if min(errors[h] for h in steps) <= 0.0:
        return False
    (a, x), (b, y), (c, z) = ((math.log(h), math.log(errors[h])) for h in steps)
    slope = (x - z) / (a - c)
    return slope > _SHALLOW and abs(y - (x + slope * (b - a))) <= _STRAIGHT


def _rounded(step: float) -> float:
    """Returns a step rounded down to three significant digits."""
    exponent = math.floor(math.log10(step)) - 2
    return float(f"{math.floor(step / 10.0**exponent * (1 + 1e-12))}e{exponent}")
