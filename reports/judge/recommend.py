"""Which method, and which step: the cheapest that was measured to reach a wanted error.

An error is looked up on the upper envelope of a method's measured curve: the largest error at this
step or any smaller one, so that a zero of a sawtooth is no recommendation. Between two step sizes
that were run, the error is taken to fall from the larger one with the smallest slope that the curve
shows around there, no faster than the method's order, and to rise from the smaller one as it rose
to it, if that is more: an upper bound for a curve that is convex or concave between them. Nothing
is extrapolated.

Only step sizes that were run count where theory has no series in the step for the error, as where
a discontinuity inside a step makes it a sawtooth; and for an adaptive solver, whose error jumps
from one tolerance to the next. A closed form is no simulation: it is left out. So is a method whose
error on the scene does not converge, or is off what theory says: that one of its runs came near the
exact answer says nothing of the next.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.method import Method
from plumbob.engines.study.convergence import DEFAULT, ConvergenceStudy
from plumbob.engines.study.results import Study
from plumbob.models.registry import unknown as unknown_name
from plumbob.reports.judge.verdict import Judgements
from plumbob.reports.judge.work_precision import Point, of_method, points

DEFAULT_METHOD, DEFAULT_STEP = DEFAULT
UNTRUSTED = ("fail", "not-converging", "diverged")  # verdicts that rule a method out
EXACT = "closed-form"  # the scheme of what is no simulation, and is not recommended as one
_DIGITS = 2  # of an interpolated step, rounded down
# Between two step sizes a run ends up to half a step earlier or later than theirs do, and its
# largest error, often the last one, is a per cent or two off their curve. Calibrated.
_MARGIN = 1.05
_STEEP = 50.0  # a slope that allows nothing: from an error that happened to be next to none


@dataclass(frozen=True)
class Choice:
    """A method at a step: the error it stays within and what it costs."""

    method: str
    control: str  # "step" or "tolerance": what the step is
    step: float  # [s], or the relative tolerance
    error: float  # bound on the largest error, in the observable's unit
    ns_per_second: float  # [ns] of wall time per simulated second
    measured: bool  # this very step was run; else it lies between two that were


@dataclass(frozen=True)
class Recommendation:
    """The answer to "which step?" for one scene and one wanted error."""

    scene: str
    observable: str
    unit: str
    error: float  # wanted
    choice: Choice | None  # the cheapest that reaches it
    runner_up: Choice | None  # the cheapest of another method
    by_engine: tuple[Choice, ...]  # the cheapest in each engine that reaches it, cheapest first
    best: Choice | None  # the most accurate of all that was measured
    defaults: tuple[Choice, ...]  # MuJoCo's default settings, and the chosen method at its step


def cheapest(
    study: Study, scene: str, error: float, judged: Judgements | None = None
) -> Recommendation:
    """The cheapest method and step that keep `scene` within `error` (in the unit of its leading
    observable) in the measurements of `study`, of methods that `judged` does not rule out; raises
    ParameterError for an error that is not positive and a scene that was not measured."""
    positive("error", error)
    names = [s.name for s in study.scenes]
    if scene not in names:
        raise ParameterError("scene", scene, unknown_name(scene, names))
    leading = study.leading(scene)
    exact = {method.name for method in study.methods if method.scheme.integrator == EXACT}
    every = [p for p in points(study, scene) if p.method not in exact]
    found = [p for p in every if trusted(judged, scene, p.method)]
    curves = [
        (
            method,
            _envelope(of_method(every, method)),
            _steepest(study.convergence, scene, method, leading.name),
        )
        for method in study.methods
    ]
    reached = [
        c
        for curve in curves
        if trusted(judged, scene, curve[0].name) and (c := _coarsest(*curve, error)) is not None
    ]
    reached.sort(key=lambda choice: choice.ns_per_second)
    choice = reached[0] if reached else None
    by_engine: dict[str, Choice] = {}
    for c in reached:
        by_engine.setdefault(c.method.partition("/")[0], c)
    done = [p for p in found if math.isfinite(p.error)]
    best = min(done, key=lambda p: (p.error, p.ns_per_second), default=None)
    by_name = {method.name: method for method in study.methods}
    wanted = dict.fromkeys((DEFAULT_METHOD, *((choice.method,) if choice else ())))
    defaults = [c for curve in curves if curve[0].name in wanted if (c := _at_default(*curve))]
    return Recommendation(
        scene,
        leading.name,
        leading.unit,
        error,
        choice,
        reached[1] if len(reached) > 1 else None,
        tuple(by_engine.values()),
        chosen(by_name[best.method], best) if best else None,
        tuple(sorted(defaults, key=lambda c: c.method != DEFAULT_METHOD)),
    )


def trusted(judged: Judgements | None, scene: str, method: str) -> bool:
    """Whether nothing is known against a method on a scene."""
    pair = (judged or {}).get((scene, method))
    return pair is None or pair.whole.verdict not in UNTRUSTED


def _envelope(curve: Sequence[Point]) -> tuple[Point, ...]:
    """Points, fine to coarse, each with the largest error up to it."""
    worst, risen = 0.0, []
    for p in curve:
        worst = max(worst, p.error)
        risen.append(Point(p.method, p.step, worst, p.ns_per_second))
    return tuple(risen)


def _steepest(
    convergence: Sequence[ConvergenceStudy], scene: str, method: Method, leading: str
) -> float:
    """The largest slope that may be relied on: the method's order, or what was observed; 0 where
    theory has no series for the error."""
    convergence_study = next(
        (c for c in convergence if (c.scene, c.method) == (scene, method.name)), None
    )
    predicted = (
        [m.errors[leading].predicted for m in convergence_study.measurements if m.errors]
        if convergence_study
        else []
    )
    if convergence_study is None or not any(
        p is not None and not p.for_this_step for p in predicted
    ):
        return 0.0
    return max(method.order or 0.0, convergence_study.order.low if convergence_study.order else 0.0)


def _coarsest(
    method: Method, curve: Sequence[Point], steepest: float, error: float
) -> Choice | None:
    """The cheapest place of one curve that is within `error`."""
    within = [i for i, p in enumerate(curve) if p.error <= error]
    if not within:
        return None
    if method.control == "tolerance":  # a looser tolerance need not be the cheaper one
        return chosen(method, min((curve[i] for i in within), key=lambda p: p.ns_per_second))
    i = within[-1]
    if i + 1 < len(curve) and (lines := _above(curve, i, steepest)):
        reach = min(h * (error / (_MARGIN * e)) ** (1.0 / slope) for h, e, slope in lines)
        if reach > curve[i].step and (step := _rounded(reach)) > curve[i].step:
            return _between(method, curve, i, step, steepest)
    return chosen(method, curve[i])


def _above(curve: Sequence[Point], i: int, steepest: float) -> list[tuple[float, float, float]]:
    """Straight lines on logarithmic axes, by a step, the error there and a slope, the higher of
    which is above the curve between the steps `i` and `i + 1`; none where it may be flat."""
    fine, coarse = curve[i], curve[i + 1]
    if (falling := min(steepest, _slope(curve, i))) <= 0.0:
        return []
    lines = [(coarse.step, coarse.error, falling)]
    if i and fine.error > 0.0:
        rising = min(_secant(curve[i - 1], fine), _STEEP)
        if rising > _secant(fine, coarse):  # it flattens out between the two
            lines.append((fine.step, fine.error, rising))
    return lines


def _slope(curve: Sequence[Point], i: int) -> float:
    """The smallest slope of log error against log step from step `i` to the next and beside it; 0
    where a run beyond it diverged."""
    if not math.isfinite(curve[i + 1].error):
        return 0.0
    here = _secant(curve[i], curve[i + 1])
    if i + 2 < len(curve) and math.isfinite(curve[i + 2].error):
        return min(here, _secant(curve[i + 1], curve[i + 2]))
    # The last interval: its curvature continues.
    return min(here, 2 * here - _secant(curve[i - 1], curve[i])) if i else 0.0


def _secant(fine: Point, coarse: Point) -> float:
    if fine.error <= 0.0:
        return math.inf
    return math.log(coarse.error / fine.error) / math.log(coarse.step / fine.step)


def _between(
    method: Method, curve: Sequence[Point], i: int, step: float, steepest: float
) -> Choice:
    """The choice at a step between the steps `i` and `i + 1`: the error's upper bound, and the cost
    on the straight line between theirs on logarithmic axes."""
    fine, coarse = curve[i], curve[i + 1]
    bounds = [e * (step / h) ** slope for h, e, slope in _above(curve, i, steepest)]
    error = max(fine.error, _MARGIN * min(max(bounds, default=math.inf), coarse.error))
    fraction = math.log(step / fine.step) / math.log(coarse.step / fine.step)
    cost = fine.ns_per_second * (coarse.ns_per_second / fine.ns_per_second) ** fraction
    return Choice(method.name, method.control, step, error, cost, False)


def _at_default(method: Method, curve: Sequence[Point], steepest: float) -> Choice | None:
    """The method at MuJoCo's default step, where that lies within what was measured."""
    if method.control != "step":
        return None
    for i, p in enumerate(curve):
        if math.isclose(p.step, DEFAULT_STEP, rel_tol=1e-9):
            return chosen(method, p)
        if p.step > DEFAULT_STEP:
            if not i or not math.isfinite(p.error):
                return None
            return _between(method, curve, i - 1, DEFAULT_STEP, steepest)
    return None


def chosen(method: Method, p: Point) -> Choice:
    """What was run, as a choice."""
    return Choice(method.name, method.control, p.step, p.error, p.ns_per_second, True)


def _rounded(step: float) -> float:
    """A step rounded down to two significant digits."""
    exponent = math.floor(math.log10(step)) - _DIGITS + 1
    return float(f"{math.floor(step / 10.0**exponent * (1 + 1e-12))}e{exponent}")
