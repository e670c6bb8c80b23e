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
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

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
# two that fail, and so on, so that a few lead from where errors scatter to where they hold.
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
_DIGITS = 3  # of a step that is tried, rounded down
_FEWEST = 8  # steps of a run
_MOST = 4_000_000  # steps of a run
_TIGHTEST = 1e-13  # a relative tolerance
_STEEPEST = 0.25  # of steps against tolerance, on logarithmic axes: a solver of order 4 or more
_COMPILE = 0.1  # [s] that a run takes beside its steps, roughly


@dataclass
class Evidence:
    """Measurements of the methods on the scenes of a family, and the means to run more."""

    scenes: tuple[Scene, ...]
    quantities: Mapping[str, Quantities]  # by scene
    costs: Mapping[Key, float]  # [ns of a step]
    runs: dict[Key, dict[float, Measurement]]
    run: Callable[[Scene, Method, float], Measurement] | None = None  # None: nothing more is run
    seconds: float = math.inf  # [s] of computing that may still be spent
    taken: dict[Key, list[Measurement]] = field(default_factory=dict)  # what was run
    limits: Mapping[Key, KnownLimit] = field(default_factory=dict)  # of the step

    def of(self, scene: Scene, method: Method) -> dict[float, Measurement]:
        """The runs of a pair by step."""
        return self.runs.setdefault((scene.name, method.name), {})

    def error(self, scene: Scene, method: Method, step: float) -> float:
        """The relative error of a run that is there."""
        return error_of(self.of(scene, method)[step], self.quantities[scene.name])

    @property
    def scale(self) -> float:
        """The largest scale of the first quantity of interest, in its unit."""
        return max(about[0].scale for about in self.quantities.values())

    def worst(self, method: Method, step: float) -> float:
        """The largest error over the scenes that this step was run on."""
        ran = [s for s in self.scenes if step in self.of(s, method)]
        return max((self.error(s, method, step) for s in ran), default=math.nan)

    def largest(self, method: Method, step: float) -> float:
        """The largest error at a step or below, over all scenes."""
        runs = ((s, h) for s in self.scenes for h in self.of(s, method) if h <= step)
        return max(self.error(s, method, h) for s, h in runs)

    def cost(self, method: Method, step: float) -> float:
        """[ns] of wall time per simulated second, over the family; 0 where it is not known."""
        price = self.price(method)
        total = 0.0
        for scene in self.scenes:
            count = scene.duration / step
            if method.control == "tolerance":
                run = self.of(scene, method).get(step)
                count = run.steps if run and run.status == "done" else 0.0
            total += count * self.costs.get((scene.name, method.name), price)
        return total / sum(scene.duration for scene in self.scenes)

    def price(self, method: Method) -> float:
        """[ns] of a step, the median over the scenes where it was timed; infinite where none."""
        prices = sorted(
            self.costs[key] for s in self.scenes if (key := (s.name, method.name)) in self.costs
        )
        return prices[len(prices) // 2] if prices else math.inf

    def limit(self, method: Method) -> KnownLimit | None:
        """The smallest limit of a method's step on any scene; None where none is known."""
        if method.control == "tolerance":
            return None
        known = [x for s in self.scenes if (x := self.limits.get((s.name, method.name)))]
        finite = [limit for limit in known if math.isfinite(limit.step)]
        return min(finite, key=lambda limit: limit.step, default=None)

    def allowed(self, method: Method) -> float:
        """The step that all steps that are named are below; infinite without a limit."""
        limit = self.limit(method)
        return math.inf if limit is None else ALLOWED * limit.step

    def limited(self, method: Method, step: float, wanted: float) -> bool:
        """Whether the limit alone keeps a step from being larger, as far as is known."""
        allowed, missing = self.allowed(method), self.missing(method, wanted)
        larger = [RESOLVED * step, *self.common(method, missing)]
        return allowed < missing and allowed <= max(larger)

    def failing(self, method: Method, wanted: float) -> float:
        """The smallest step that is not to be named; infinite if there is none."""
        return min(self.allowed(method), self.missing(method, wanted))

    def missing(self, method: Method, wanted: float) -> float:
        """The smallest step with an error above the wanted one on any scene; infinite if none."""
        return min(
            (
                h
                for s in self.scenes
                for h in self.of(s, method)
                if self.error(s, method, h) > wanted
            ),
            default=math.inf,
        )

    def common(self, method: Method, below: float) -> list[float]:
        """The steps below one that were run on every scene, from small to large."""
        every = [set(self.of(scene, method)) for scene in self.scenes]
        return sorted(h for h in set.intersection(*every) if h < below)

    def choice(
        self, method: Method, step: float, error: float, wanted: float | None = None
    ) -> Choice:
        """A step that was run, with the relative `error` that is said of it, as an answer to the
        one `wanted`."""
        limit = self.limit(method)
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
            limited=wanted is not None and self.limited(method, step, wanted),
        )

    def at(self, method: Method, step: float) -> Choice | None:
        """A method at a step [s], with the error of that run; None where it has not run there on
        every scene to the end."""
        if method.control == "tolerance" or step not in self.common(method, math.inf):
            return None
        error = self.worst(method, step)
        return self.choice(method, step, error) if math.isfinite(error) else None

    def choices(self, method: Method) -> list[Choice]:
        """The runs of a method on every scene that ended, at steps that may be named."""
        errors = {h: self.worst(method, h) for h in self.common(method, self.allowed(method))}
        return [self.choice(method, h, e) for h, e in errors.items() if math.isfinite(e)]

    def reaches(self, method: Method, step: float, wanted: float) -> bool:
        """Whether a step is within the wanted error on every scene, the hardest first; runs what
        is missing."""
        near = {s.name: self._nearest(s, method, step) for s in self.scenes}
        for scene in sorted(self.scenes, key=lambda s: -near[s.name]):
            if step not in self.of(scene, method):
                if self.run is None:
                    return False
                run = self.run(scene, method, step)
                self.of(scene, method)[step] = run
                self.taken.setdefault((scene.name, method.name), []).append(run)
                count = run.steps if run.status == "done" else scene.duration / step
                self.seconds -= _COMPILE + 1e-9 * self.price(method) * count
            if not self.error(scene, method, step) <= wanted:
                return False
        return True

    def _nearest(self, scene: Scene, method: Method, step: float) -> float:
        """The error at the step that was run nearest to this one."""
        ran = self.of(scene, method)
        if not ran:
            return math.inf
        return self.error(scene, method, min(ran, key=lambda h: abs(math.log(h / step))))


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
    family = len(evidence.scenes) > 1
    bounds = {m.name: evidence.cost(m, evidence.failing(m, wanted)) for m in methods}
    for method in sorted(methods, key=lambda m: _hoped(evidence, m, wanted)):
        refine = best > CHEAPER * bounds[method.name] and _may(evidence, method, wanted, best)
        if not refine and family and evidence.run is not None:
            continue  # to judge it on every scene would take long
        if not trusted(method):
            continue
        step = _largest(evidence, method, wanted, best, refine and evidence.run is not None)
        if step is not None:
            choices.append(evidence.choice(method, step, evidence.largest(method, step), wanted))
            best = min(best, choices[-1].ns_per_second)
    return sorted(choices, key=lambda choice: choice.ns_per_second)


def _may(evidence: Evidence, method: Method, wanted: float, best: float) -> bool:
    """Whether a method may be much cheaper than the best: one run at the step where it would be."""
    if math.isfinite(best) and evidence.seconds <= 0.0:
        return False
    if math.isinf(best) or method.control == "tolerance" or evidence.run is None:
        return True
    step = _rounded(CHEAPER * evidence.cost(method, 1.0) / best)
    if step > min(scene.duration for scene in evidence.scenes) / _FEWEST:
        return False
    return not _affordable(evidence, method, step) or evidence.reaches(method, step, wanted)


def _hoped(evidence: Evidence, method: Method, wanted: float) -> float:
    """The cost of a method, roughly, before it is searched."""
    failing = evidence.failing(method, wanted)
    good = evidence.common(method, failing)
    if not good:
        return 4.0 * evidence.cost(method, failing) if math.isfinite(failing) else math.inf
    return evidence.cost(method, good[-1])


def _largest(
    evidence: Evidence, method: Method, wanted: float, best: float, refine: bool
) -> float | None:
    """The largest step that reaches the error, found by bisection between the smallest that fails
    and the largest that holds; without `refine` the largest that was run; None if there is none."""
    if not refine:
        good = evidence.common(method, evidence.failing(method, wanted))
        # A looser tolerance need not be the cheaper one.
        return min(good, key=partial(evidence.cost, method), default=None)
    known = replace(evidence, run=None)
    good = evidence.common(method, evidence.failing(method, wanted))
    chosen = next((h for h in reversed(good) if _holds(known, method, h, wanted)), None)
    above = [h for h in good if chosen is None or h > chosen]
    ceiling = min((h for h in above if _refused(known, method, h, wanted)), default=math.inf)
    resolved = RESOLVED if method.control == "step" else RESOLVED**8  # cost: the 8th root, or so
    failed = 0
    for number in range(_TRIES):
        failing = min(evidence.failing(method, wanted), ceiling)
        if chosen is not None and chosen >= failing:
            chosen = None
        if best <= CHEAPER * evidence.cost(method, failing) and math.isfinite(failing):
            break  # it cannot be much cheaper than what is there
        if chosen is not None and failing <= resolved * chosen:
            break
        step = _next(evidence, method, wanted, chosen, failing, number, failed)
        if step is None or not _affordable(evidence, method, step):
            break
        if _holds(evidence, method, step, wanted):
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
    number: int,
    failed: int,
) -> float | None:
    """The step to try: the largest that was run well below the failing one, if it is not checked
    yet, the further below the more have `failed`; then one between; or one beyond all that were
    run."""
    every = evidence.common(method, failing)
    stride = STRIDE**2 ** min(max(failed - 1, 0), _DOUBLINGS)
    good = [h for h in every if stride * h <= failing]
    if not good:  # all that were run are near the failing one
        good = every if failed < 2 else every[:1]
    if chosen is None or (not failed and good and good[-1] > chosen * RESOLVED):
        if good:
            return good[-1]
        return _finer(evidence, method, wanted, failing)
    if math.isinf(failing):
        step = 1.8 * chosen
        if method.control == "tolerance":
            return _rounded(4.0 * chosen) if 4.0 * chosen < 0.1 else None
        longest = min(scene.duration for scene in evidence.scenes) / _FEWEST
        return _rounded(step) if step <= longest else None
    middle = math.sqrt(chosen * failing)
    low, high = evidence.worst(method, chosen), evidence.worst(method, failing)
    if number % 2 == 0 and 0.0 < low < high < math.inf:
        slope = math.log(high / low) / math.log(failing / chosen)
        ratio = min(math.log(0.99 * wanted / low) / slope, math.log(failing / chosen))
        middle = min(max(chosen * math.exp(ratio), chosen * 1.03), failing / 1.03)
    step = _rounded(middle)
    return step if chosen < step < failing else None


def _finer(evidence: Evidence, method: Method, wanted: float, failing: float) -> float | None:
    """A step below all that were run, where the curve of errors leads to the wanted one."""
    every = evidence.common(method, math.inf)
    if len(every) < 2 or not math.isfinite(failing):
        return None
    low, high = evidence.worst(method, every[0]), evidence.worst(method, every[1])
    if not 0.0 < low < high < math.inf:
        return None
    slope = math.log(high / low) / math.log(every[1] / every[0])
    if slope < _SHALLOW:
        return None
    factor = min(0.8, 0.9 * (wanted / low) ** (1.0 / slope))
    # Smaller steps take too long, and may underflow.
    return _rounded(min(failing, every[0]) * factor) if factor > _SMALLEST else None


def _affordable(evidence: Evidence, method: Method, step: float) -> bool:
    """Whether the runs that check a step are short enough."""
    if evidence.seconds <= 0.0:
        return False
    if step in evidence.common(method, math.inf):
        return True
    longest = max(scene.duration for scene in evidence.scenes)
    checks, timed, most = 1 + len(FEW), step, 1.0  # times as many steps
    if method.control == "tolerance":
        near = [h for h in evidence.common(method, math.inf) if evidence.cost(method, h) > 0.0]
        if step < _TIGHTEST or not near:
            return False
        timed = min(near, key=lambda h: abs(math.log(h / step)))
        checks, most = checks + len(MORE), max(1.0, (timed / step) ** _STEEPEST)
    elif longest / step > _MOST:
        return False
    length = sum(scene.duration for scene in evidence.scenes)
    seconds = 1e-9 * evidence.cost(method, timed) * most * length * checks
    return seconds <= evidence.seconds


def _holds(evidence: Evidence, method: Method, step: float, wanted: float) -> bool:
    """Whether a step and smaller ones beside it reach the error: two, or 24 where the errors
    scatter, and those below the wanted one by a margin."""
    few = [step, *_fractions(step, FEW)]
    if not all(evidence.reaches(method, h, wanted) for h in few):
        return False
    if method.control == "step" and _straight(few, [evidence.worst(method, h) for h in few]):
        return True
    more = [*few, *_fractions(step, MORE)]
    return all(evidence.reaches(method, h, wanted) for h in more) and all(
        evidence.worst(method, h) * SCATTER <= wanted for h in more
    )


def _refused(evidence: Evidence, method: Method, step: float, wanted: float) -> bool:
    """Whether what was run tells that `_holds` is false of a step that reaches the error."""
    ran = set(evidence.common(method, math.inf))
    few = [step, *_fractions(step, FEW)]
    if not ran.issuperset(few) or _straight(few, [evidence.worst(method, h) for h in few]):
        return False
    beside = ran.intersection((*few, *_fractions(step, MORE)))
    return any(evidence.worst(method, h) * SCATTER > wanted for h in beside)


def _straight(steps: Sequence[float], errors: Sequence[float]) -> bool:
    """Whether three errors lie on a rising line on logarithmic axes."""
    if min(errors) <= 0.0:
        return False
    (a, b, c), (x, y, z) = ([math.log(v) for v in values] for values in (steps, errors))
    slope = (x - z) / (a - c)
    return slope > _SHALLOW and abs(y - (x + slope * (b - a))) <= _STRAIGHT


def _fractions(step: float, fractions: Iterable[float]) -> list[float]:
    return [float(f"{step * fraction:.4g}") for fraction in fractions]


def _rounded(step: float) -> float:
    """A step rounded down to so many significant digits."""
    exponent = math.floor(math.log10(step)) - _DIGITS + 1
    return float(f"{math.floor(step / 10.0**exponent * (1 + 1e-12))}e{exponent}")
