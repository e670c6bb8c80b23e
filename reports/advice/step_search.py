"""The largest step of each method that reaches a wanted error on all scenes of a family, measured.

A step reaches an error if the runs at it and at every smaller step that was run do. That is checked
at two smaller steps at least, and at 24 where the errors do not lie on one straight line on
logarithmic axes: a discontinuity inside a step makes the error a sawtooth, with zeros by chance.

Every step at and above the smallest one that fails is ruled out: the cost there is the least that a
method can have. Methods are searched from the cheapest on, until no other can be much cheaper than
what was found.
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
from plumbob.reports.advice.work_precision import error_of

# Chosen, and held from both sides by tests/validation/test_recommended.py:
RESOLVED = 1.1  # ratio of the smallest step that fails to the one chosen
STRIDE = 1.25  # below a step that fails, the next that is tried, of the many that checks leave
ALLOWED = 0.8  # of a limit of stability: the largest step that is named is smaller
CHEAPER = 1.3  # a method that could be cheaper by no more is not searched
# Fractions of a step that are run beside it, none a multiple of another.
FEW = (0.931, 0.787)
MORE = (
    *(0.989, 0.977, 0.965, 0.953, 0.942, 0.92, 0.909, 0.897, 0.883, 0.871, 0.859),
    *(0.843, 0.827, 0.809, 0.769, 0.751, 0.727, 0.703, 0.677, 0.647, 0.613, 0.577),
)
# How far errors off a line stay below the wanted one: of 25 errors that are equally likely up to a
# largest, one in a hundred times all are below 1/1.2 of that.
SCATTER = 1.2
_STRAIGHT = 0.05  # relative: errors nearer to a line on logarithmic axes lie on it
_SMALLEST = 1e-9  # of the smallest step that was run
_SHALLOW = 0.3  # a curve of errors with a smaller slope promises nothing
_TRIES = 40
_FEWEST = 8  # steps of a run
_TOLERANCES = (1e-13, 0.1)  # the tightest and the loosest relative tolerance
_COMPILE = 0.1  # [s] that a run takes beside its steps, roughly


@dataclass
class Evidence:
    """Measurements of methods on the scenes of a family, and the means to run more."""

    scenes: tuple[Scene, ...]
    quantities: Mapping[str, Quantities]  # by scene
    costs: Mapping[Key, float]  # [ns of a step]
    runs: dict[Key, dict[float, Measurement]]  # by step
    # None: nothing more is run
    run: Callable[[Scene, Method, float], Measurement] | None = None
    seconds: float = math.inf  # [s] of computing that may still be spent
    limits: Mapping[Key, SmallestLimit] = field(default_factory=dict)  # of the step

    @property
    def scale(self) -> float:
        """The largest scale of the first quantity of interest, in its unit."""
        return max(about[0].scale for about in self.quantities.values())

    def errors(self, method: Method) -> dict[float, float]:
        """The largest relative error over the scenes at each step that any of them ran."""
        largest: dict[float, float] = {}
        for scene in self.scenes:
            for step, run in self._runs(scene, method).items():
                error = error_of(run, self.quantities[scene.name])
                largest[step] = max(error, largest.get(step, 0.0))
        return largest

    def _runs(self, scene: Scene, method: Method) -> dict[float, Measurement]:
        return self.runs[scene.name, method.name]

    def common(self, method: Method, below: float = math.inf) -> list[float]:
        """The steps below one that were run on every scene, from small to large."""
        every = (set(self._runs(scene, method)) for scene in self.scenes)
        return sorted(h for h in set.intersection(*every) if h < below)

    def cost(self, method: Method, step: float) -> float:
        """[ns] of wall time per simulated second, over the family; 0 at an infinite step."""
        total = sum(self._price(scene, method, step) for scene in self.scenes)
        return total / sum(scene.duration for scene in self.scenes)

    def _price(self, scene: Scene, method: Method, step: float) -> float:
        """[ns] of a run, at a tolerance that of the nearest run."""
        runs = self._runs(scene, method)
        if math.isinf(step) or not runs:
            return 0.0
        steps = scene.duration / step
        if method.control == "tolerance":
            steps = runs[min(runs, key=lambda h: abs(math.log(h / step)))].steps
        return steps * self.costs[scene.name, method.name]

    def limit(self, method: Method) -> SmallestLimit | None:
        """The smallest limit of a method's step on any scene; None where none is known."""
        if method.control == "tolerance":
            return None
        known = (self.limits.get((scene.name, method.name)) for scene in self.scenes)
        finite = [limit for limit in known if limit and math.isfinite(limit.step)]
        return min(finite, key=lambda limit: limit.step, default=None)

    def allowed(self, method: Method) -> float:
        """The step that all steps that are named are below; infinite without a limit."""
        limit = self.limit(method)
        return math.inf if limit is None else ALLOWED * limit.step

    def missing(self, method: Method, wanted: float) -> float:
        """The smallest step with an error above the wanted one on any scene; infinite if none."""
        errors = self.errors(method).items()
        return min((h for h, error in errors if not error <= wanted), default=math.inf)

    def failing(self, method: Method, wanted: float) -> float:
        """The smallest step that is not to be named; infinite if there is none."""
        return min(self.allowed(method), self.missing(method, wanted))

    def choice(self, method: Method, step: float, error: float, wanted: float = 0.0) -> Choice:
        """A step that was run, with the relative `error` that is said of it, as an answer to the
        one `wanted`."""
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
        """The runs of a method on every scene that ended, at the steps below one."""
        errors = self.errors(method)
        common = self.common(method, below)
        return [self.choice(method, h, errors[h]) for h in common if math.isfinite(errors[h])]

    def reaches(self, method: Method, step: float, wanted: float, margin: float) -> bool | None:
        """Whether the error at a step is the wanted one over a `margin`, or smaller, on every
        scene; runs what is missing, and is None where there is no time for that."""
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
        """A run, made now where it is missing and there is time for it."""
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
        """Whether a step and smaller ones beside it reach the error: two, or 24 where the errors
        scatter, and those by a margin; None where there is no time for it."""
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
    """The cheapest steps that reach the error, the cheapest first, at most one a method: those that
    could be the cheapest by far are searched, of others what was run before counts; `best` [ns per
    simulated second] is what others cost."""
    choices: list[Choice] = []

    def hoped(method: Method) -> float:
        """The cost, roughly, before it is searched."""
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
    """The largest step that reaches the error, by bisection between the smallest that fails and the
    largest that holds, or the cheapest that was run where nothing more is to be; None if there is
    none."""

    def expensive(step: float) -> bool:
        """Whether a smaller step cannot be much cheaper than what is there."""
        return best <= CHEAPER * evidence.cost(method, step)

    ceiling = evidence.failing(method, wanted)
    if evidence.run is None or expensive(ceiling):
        # A looser tolerance need not be the cheaper one.
        good = evidence.common(method, ceiling)
        return min(good, key=partial(evidence.cost, method), default=None)
    # cost: the 8th root, or so
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
    """A step below all that were run, where the curve of errors leads to the wanted one; 0 where it
    leads nowhere."""
    steps = evidence.common(method)
    errors = evidence.errors(method)
    if len(steps) < 2 or not 0.0 < errors[steps[0]] < errors[steps[1]] < math.inf:
        return 0.0
    small, large = steps[:2]
    slope = math.log(errors[large] / errors[small]) / math.log(large / small)
    if slope < _SHALLOW:
        return 0.0
    factor = min(0.8, 0.9 * (wanted / errors[small]) ** (1.0 / slope))
    # Smaller steps take too long, and may underflow.
    return _rounded(min(failing, small) * factor) if factor > _SMALLEST else 0.0


def _straight(steps: Sequence[float], errors: Mapping[float, float]) -> bool:
    """Whether the errors at three steps lie on a rising line on logarithmic axes."""
    if min(errors[h] for h in steps) <= 0.0:
        return False
    (a, x), (b, y), (c, z) = ((math.log(h), math.log(errors[h])) for h in steps)
    slope = (x - z) / (a - c)
    return slope > _SHALLOW and abs(y - (x + slope * (b - a))) <= _STRAIGHT


def _rounded(step: float) -> float:
    """A step rounded down to three significant digits."""
    exponent = math.floor(math.log10(step)) - 2
    return float(f"{math.floor(step / 10.0**exponent * (1 + 1e-12))}e{exponent}")
