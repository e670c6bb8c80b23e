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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from statistics import median_high

from plumbob.engines.method import Method
from plumbob.engines.study.cost import Key
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Quantities
from plumbob.engines.study.stability import KnownLimit
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.work_precision import error_of

# Chosen, and held from both sides by tests/validation/test_recommended.py:
RESOLVED = 1.1  # ratio of the smallest step that fails to the one chosen
# Below a step that fails, the next that is tried, of the many that checks leave; its square after
# one that fails, and so on, so that a few lead from where errors scatter to where they hold.
STRIDE = 1.04
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
_DOUBLINGS = 10  # of the digits of a stride: the last, 10^17, is below all steps that were run
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
    quantities: dict[str, Quantities]  # by scene
    costs: dict[Key, float] = field(default_factory=dict)  # [ns of a step]
    runs: dict[Key, dict[float, Measurement]] = field(default_factory=dict)  # by step
    run: Callable[[Scene, Method, float], Measurement] | None = None  # None: nothing more is run
    seconds: float = math.inf  # [s] of computing that may still be spent
    taken: dict[Key, list[Measurement]] = field(default_factory=dict)  # what was run
    limits: dict[Key, KnownLimit] = field(default_factory=dict)  # of the step

    @property
    def scale(self) -> float:
        """The largest scale of the first quantity of interest, in its unit."""
        return max(about[0].scale for about in self.quantities.values())

    def errors(self, method: Method) -> dict[float, float]:
        """The largest relative error over the scenes at each step that any of them ran."""
        largest: dict[float, float] = {}
        for scene in self.scenes:
            for step, run in self.runs.get((scene.name, method.name), {}).items():
                error = error_of(run, self.quantities[scene.name])
                largest[step] = max(error, largest.get(step, 0.0))
        return largest

    def common(self, method: Method, below: float = math.inf) -> list[float]:
        """The steps below one that were run on every scene, from small to large."""
        every = (set(self.runs.get((s.name, method.name), ())) for s in self.scenes)
        return sorted(h for h in set.intersection(*every) if h < below)

    def cost(self, method: Method, step: float) -> float:
        """[ns] of wall time per simulated second, over the family; 0 where it is not known."""
        total = sum(
            self._count(scene, method, step)
            * self.costs.get((scene.name, method.name), self.price(method))
            for scene in self.scenes
        )
        return total / sum(scene.duration for scene in self.scenes)

    def _count(self, scene: Scene, method: Method, step: float) -> float:
        """Steps of a run; 0 at a tolerance that did not reach the end."""
        if method.control == "step":
            return scene.duration / step
        run = self.runs.get((scene.name, method.name), {}).get(step)
        return run.steps if run and run.status == "done" else 0.0

    def price(self, method: Method) -> float:
        """[ns] of a step, the median over the scenes where it was timed; infinite where none."""
        keys = ((scene.name, method.name) for scene in self.scenes)
        return median_high([self.costs[key] for key in keys if key in self.costs] or [math.inf])

    def limit(self, method: Method) -> KnownLimit | None:
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
        limit, allowed = self.limit(method), self.allowed(method)
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

    def at(self, method: Method, step: float) -> Choice | None:
        """A method at a step [s], with the error of that run; None where it has not run there on
        every scene to the end."""
        if method.control == "tolerance" or step not in self.common(method):
            return None
        error = self.errors(method)[step]
        return self.choice(method, step, error) if math.isfinite(error) else None

    def choices(self, method: Method) -> list[Choice]:
        """The runs of a method on every scene that ended, at steps that may be named."""
        errors = self.errors(method)
        common = self.common(method, self.allowed(method))
        return [self.choice(method, h, errors[h]) for h in common if math.isfinite(errors[h])]

    def reaches(
        self, method: Method, step: float, wanted: float, margin: float = 1.0
    ) -> bool | None:
        """Whether the error at a step is the wanted one over a `margin`, or smaller, on every
        scene; runs what is missing, and is None where that may not be run."""
        for scene in self.scenes:
            least, most = _TOLERANCES
            if method.control == "step":
                least, most = 0.0, scene.duration / _FEWEST
            if not least <= step <= most:
                return False
            run = self._run(scene, method, step)
            if run is None or not margin * error_of(run, self.quantities[scene.name]) <= wanted:
                return None if run is None else False
        return True

    def _run(self, scene: Scene, method: Method, step: float) -> Measurement | None:
        """A run, made now where it is missing and there is time for it."""
        runs = self.runs.setdefault((scene.name, method.name), {})
        if step not in runs and self.run is not None and self.seconds > 0.0:
            near = min(runs or [step], key=lambda h: abs(math.log(h / step)))
            at = step if method.control == "step" else near
            price = 1e-9 * self.price(method)
            if price * self._count(scene, method, at) > self.seconds:
                return None
            runs[step] = self.run(scene, method, step)
            self.taken.setdefault((scene.name, method.name), []).append(runs[step])
            self.seconds -= _COMPILE + price * self._count(scene, method, step)
        return runs.get(step)

    def holds(self, method: Method, step: float, wanted: float) -> bool | None:
        """Whether a step and smaller ones beside it reach the error: two, or 24 where the errors
        scatter, and those by a margin; None where what that needs may not be run."""
        few, more = ([float(f"{step * part:.4g}") for part in parts] for parts in (FEW, MORE))
        few = [step, *few]
        reached = (self.reaches(method, h, wanted) for h in few)
        first = next((answer for answer in reached if not answer), True)
        if not first or (method.control == "step" and _straight(few, self.errors(method))):
            return first
        beyond = (self.reaches(method, h, wanted, SCATTER) for h in (*few, *more))
        return next((answer for answer in beyond if not answer), True)


def searched(
    evidence: Evidence,
    methods: Sequence[Method],
    wanted: float,
    trusted: Callable[[Method], bool],
    best: float = math.inf,
) -> list[Choice]:
    """The cheapest steps that reach the error, the cheapest first, at most one a method: those that
    could be the cheapest by far are searched, of others what was run before counts.
    `trusted` is asked before a method is chosen; `best` [ns per simulated second] is what others
    cost."""
    choices: list[Choice] = []
    methods = [m for m in methods if evidence.allowed(m) > 0.0]
    for method in sorted(methods, key=lambda m: _hoped(evidence, m, wanted)):
        refine = best > CHEAPER * evidence.cost(method, evidence.failing(method, wanted))
        if refine and evidence.run and math.isfinite(best) and method.control == "step":
            # One run, at the step where it would be much cheaper.
            even = _rounded(CHEAPER * evidence.cost(method, 1.0) / best)
            refine = evidence.reaches(method, even, wanted) is not False
        if not refine and evidence.run and len(evidence.scenes) > 1:
            continue  # to judge it on every scene would take long
        if not trusted(method):
            continue
        step = _largest(evidence, method, wanted, best, refine and evidence.run is not None)
        if step is not None:
            error = max(e for h, e in evidence.errors(method).items() if h <= step)
            choices.append(evidence.choice(method, step, error, wanted))
            best = min(best, choices[-1].ns_per_second)
    return sorted(choices, key=lambda choice: choice.ns_per_second)


def _hoped(evidence: Evidence, method: Method, wanted: float) -> float:
    """The cost of a method, roughly, before it is searched."""
    failing = evidence.failing(method, wanted)
    if good := evidence.common(method, failing):
        return evidence.cost(method, good[-1])
    return 4.0 * evidence.cost(method, failing) if math.isfinite(failing) else math.inf


def _largest(
    evidence: Evidence, method: Method, wanted: float, best: float, refine: bool
) -> float | None:
    """The largest step that reaches the error, found by bisection between the smallest that fails
    and the largest that holds; without `refine` the largest that was run; None if there is none."""
    good = evidence.common(method, evidence.failing(method, wanted))
    if not refine:
        # A looser tolerance need not be the cheaper one.
        return min(good, key=partial(evidence.cost, method), default=None)
    known = replace(evidence, run=None)
    held = {h: known.holds(method, h, wanted) for h in good}
    chosen = max((h for h in good if held[h]), default=None)
    above = (h for h in good if held[h] is False and (chosen is None or h > chosen))
    ceiling = min(above, default=math.inf)
    resolved = RESOLVED if method.control == "step" else RESOLVED**8  # cost: the 8th root, or so
    failed = 0
    for _ in range(_TRIES):
        failing = min(evidence.failing(method, wanted), ceiling)
        if chosen is not None and chosen >= failing:
            chosen = None
        if best <= CHEAPER * evidence.cost(method, failing):
            break  # it cannot be much cheaper than what is there
        if chosen is not None and failing <= resolved * chosen:
            break
        step = _next(evidence, method, wanted, chosen, failing, failed)
        if step is None or (holds := evidence.holds(method, step, wanted)) is None:
            break
        if holds:
            chosen = step
        else:
            ceiling, failed = min(ceiling, step), failed + 1
    return chosen


def _next(
    evidence: Evidence,
    method: Method,
    wanted: float,
    chosen: float | None,
    failing: float,
    failed: int,
) -> float | None:
    """The step to try: one that was run, the further below the failing one the more have `failed`,
    or one below all of them; then one beyond all that were run, or one between."""
    if chosen is None:
        every = evidence.common(method, failing)
        stride = STRIDE**2 ** min(failed, _DOUBLINGS)
        good = [h for h in every if stride * h <= failing] or every[:1]
        return good[-1] if good else _finer(evidence, method, wanted, failing)
    if math.isinf(failing):
        return _rounded(chosen * (1.8 if method.control == "step" else 4.0))
    step = _rounded(math.sqrt(chosen * failing))
    return step if chosen < step < failing else None


def _finer(evidence: Evidence, method: Method, wanted: float, failing: float) -> float | None:
    """A step below all that were run, where the curve of errors leads to the wanted one."""
    steps, errors = evidence.common(method), evidence.errors(method)
    if len(steps) < 2 or not 0.0 < errors[steps[0]] < errors[steps[1]] < math.inf:
        return None
    small, large = steps[:2]
    slope = math.log(errors[large] / errors[small]) / math.log(large / small)
    if slope < _SHALLOW or math.isinf(failing):
        return None
    factor = min(0.8, 0.9 * (wanted / errors[small]) ** (1.0 / slope))
    # Smaller steps take too long, and may underflow.
    return _rounded(min(failing, small) * factor) if factor > _SMALLEST else None


def _straight(steps: Sequence[float], errors: dict[float, float]) -> bool:
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
