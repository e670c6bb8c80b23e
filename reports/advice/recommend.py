"""Which method, and which step: the cheapest that was measured to reach a wanted error.

The error of a run is relative: the worst of the scene's quantities of interest over their scales.
It is looked up on the upper envelope of a method's measured curve: the largest error at this
step or any smaller one, so that a zero of a sawtooth is no recommendation. Between two step sizes
that were run, the error is taken to fall from the larger one with the smallest slope that the curve
shows around there, no faster than the method's order, and to rise from the smaller one as it rose
to it, if that is more: an upper bound for a curve that is convex or concave between them. Nothing
is extrapolated.

Only step sizes that were run count where theory has no series in the step for the error, as where
a discontinuity inside a step makes it a sawtooth; and for an adaptive solver, whose error jumps
from one tolerance to the next. A closed form is no simulation: it is left out. So is a method whose
error on the scene does not converge, or is off what theory says: that one of its runs came near the
exact answer says nothing of the next. A surrogate, whose model is not the full body, is named
beside a full model alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.method import Method
from plumbob.engines.study.convergence import DEFAULT, ConvergenceStudy
from plumbob.engines.study.results import Study
from plumbob.models.registry import unknown as unknown_name
from plumbob.reports.advice.work_precision import Point, converging, of_method, points
from plumbob.reports.judge.study_verdicts import Judgements

DEFAULT_METHOD, DEFAULT_STEP = DEFAULT
UNTRUSTED = (
    "off-prediction",
    "inaccurate",
    "not-converging",
    "diverged",
    "cut-short",
)  # verdicts that rule a method out
UNJUDGED = "pre-asymptotic"  # the verdict that leaves it to the curve of errors
EXACT = "closed-form"  # the scheme of what is no simulation, and is not recommended as one
_DIGITS = 2  # of an interpolated step, rounded down
# Between two step sizes a run ends up to half a step earlier or later than theirs do, and its
# largest error, often the last one, is a per cent or two off their curve. Calibrated.
_MARGIN = 1.05
_STEEP = 50.0  # a slope that allows nothing: assigned where the finer error is near zero


@dataclass(frozen=True)
class Choice:
    """A method at a step: the error it stays within and what it costs."""

    method: str
    control: str  # "step" or "tolerance": what the step is
    step: float  # [s], or the relative tolerance
    error: float  # bound on the relative error
    absolute: float  # what that allows the observable's error to be, in its unit
    ns_per_second: float  # [ns] of wall time per simulated second
    measured: bool  # this very step was run; else it lies between two that were
    surrogate: str = ""  # why its model is not the full body, where it is not


@dataclass(frozen=True)
class Recommendation:
    """The answer to "which step?" for one scene and one wanted error."""

    scene: str
    observable: str  # the first quantity of interest
    unit: str
    error: float  # wanted, relative
    absolute: float  # the same of the observable, in its unit
    choice: Choice | None  # the cheapest that reaches it
    runner_up: Choice | None  # the cheapest of another method
    by_engine: tuple[Choice, ...]  # the cheapest in each engine that reaches it, cheapest first
    best: Choice | None  # the most accurate of all that was measured
    defaults: tuple[Choice, ...]  # MuJoCo's default settings, and the chosen method at its step
    surrogate: Choice | None = None  # the cheapest, if cheaper than the full model


@dataclass(frozen=True)
class Wanted:
    """An error that is wanted on a scene, or on every scene of a family."""

    scene: str  # its name, or the family's
    observable: str  # the first quantity of interest
    unit: str
    error: float  # relative
    scale: float  # of the observable, in its unit


def recommended(
    wanted: Wanted,
    within: Sequence[Choice],
    best: Choice | None,
    at_default: Callable[[str], Choice | None],
) -> Recommendation:
    """The recommendation from candidates that are `within` the wanted error, at most one a method,
    and the `best` of all; `at_default` gives a method, by its name, at MuJoCo's default step."""
    by_cost = sorted(within, key=lambda c: c.ns_per_second)
    full = [c for c in by_cost if not c.surrogate]
    choice = full[0] if full else None
    cheaper = [c for c in by_cost if choice and c.ns_per_second < choice.ns_per_second]
    by_engine: dict[str, Choice] = {}
    for c in full:
        by_engine.setdefault(c.method.partition("/")[0], c)
    named = dict.fromkeys((DEFAULT_METHOD, *((choice.method,) if choice else ())))
    return Recommendation(
        wanted.scene,
        wanted.observable,
        wanted.unit,
        wanted.error,
        wanted.error * wanted.scale,
        choice,
        full[1] if len(full) > 1 else None,
        tuple(by_engine.values()),
        best,
        tuple(default for name in named if (default := at_default(name)) is not None),
        cheaper[0] if cheaper else None,  # a surrogate: no full model is cheaper than the choice
    )


def cheapest(
    study: Study, scene: str, error: float, judged: Judgements | None = None
) -> Recommendation:
    """The cheapest method and step that keep the relative error on `scene` within `error` in the
    measurements of `study`, of methods that `judged` does not rule out; raises ParameterError for
    an error that is not positive and a scene that was not measured."""
    positive("error", error)
    names = [s.name for s in study.scenes]
    if scene not in names:
        raise ParameterError("scene", scene, unknown_name(scene, names))
    first = study.quantities(scene)[0]
    unit = next(o.unit for o in study.observables(scene) if o.name == first.observable)
    curves = {c.method.name: c for c in _curves(study, scene)}
    good = [c for c in curves.values() if trusted(judged, scene, c.runs, c.method.name)]
    within = [c for curve in good if (c := _coarsest(curve, error)) is not None]
    runs = [
        chosen(c.method, p, c.scale)
        for c in good
        if not c.method.surrogate
        for p in c.runs
        if math.isfinite(p.error)
    ]
    return recommended(
        Wanted(scene, first.observable, unit, error, first.scale),
        within,
        min(runs, key=lambda c: (c.error, c.ns_per_second), default=None),
        lambda name: _at_default(curves[name]) if name in curves else None,
    )


def trusted(judged: Judgements | None, scene: str, curve: Sequence[Point], method: str) -> bool:
    """Whether nothing is known against a method on a scene, and where there is no theory of it, its
    errors, from fine to coarse, converge."""
    pair = (judged or {}).get((scene, method))
    if pair is None:
        return True
    verdict = pair.whole.verdict
    return verdict not in UNTRUSTED and (verdict != UNJUDGED or converging(curve))


@dataclass(frozen=True)
class _Curve:
    """The measured errors and costs of one method on one scene."""

    method: Method
    runs: tuple[Point, ...]  # fine to coarse
    envelope: tuple[Point, ...]  # of these
    steepest: float  # the largest slope that may be relied on
    scale: float  # of the first quantity of interest


def _curves(study: Study, scene: str) -> Iterator[_Curve]:
    """The curves of the methods of a study on a scene, but for closed forms."""
    every, first = points(study, scene), study.quantities(scene)[0]
    studies = {c.method: c for c in study.convergence if c.scene == scene}
    for method in study.methods:
        if method.scheme.integrator != EXACT:
            runs = of_method(every, method)
            steepest = _steepest(studies.get(method.name), method, first.observable)
            yield _Curve(method, runs, _envelope(runs), steepest, first.scale)


def _envelope(curve: Sequence[Point]) -> tuple[Point, ...]:
    """Points, fine to coarse, each with the largest error up to it."""
    worst, risen = 0.0, []
    for p in curve:
        worst = max(worst, p.error)
        risen.append(Point(p.method, p.step, worst, p.ns_per_second))
    return tuple(risen)


def _steepest(convergence_study: ConvergenceStudy | None, method: Method, leading: str) -> float:
    """The largest slope that may be relied on: the method's order, or what was observed; 0 where
    theory has no series for the error."""
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


def _coarsest(measured: _Curve, error: float) -> Choice | None:
    """The cheapest place of one curve that is within `error`."""
    method, curve = measured.method, measured.envelope
    within = [i for i, p in enumerate(curve) if p.error <= error]
    if not within:
        return None
    if method.control == "tolerance":  # a looser tolerance need not be the cheaper one
        cheap = min((curve[i] for i in within), key=lambda p: p.ns_per_second)
        return chosen(method, cheap, measured.scale)
    i = within[-1]
    if i + 1 < len(curve) and (lines := _above(curve, i, measured.steepest)):
        reach = min(h * (error / (_MARGIN * e)) ** (1.0 / slope) for h, e, slope in lines)
        if reach > curve[i].step and (step := rounded_down(reach, _DIGITS)) > curve[i].step:
            return _between(measured, i, step)
    return chosen(method, curve[i], measured.scale)


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


def _between(curve: _Curve, i: int, step: float) -> Choice:
    """The choice at a step between the steps `i` and `i + 1`: the error's upper bound, and the cost
    on the straight line between theirs on logarithmic axes."""
    fine, coarse = curve.envelope[i], curve.envelope[i + 1]
    lines = _above(curve.envelope, i, curve.steepest)
    bounds = [e * (step / h) ** slope for h, e, slope in lines]
    error = max(fine.error, _MARGIN * min(max(bounds, default=math.inf), coarse.error))
    fraction = math.log(step / fine.step) / math.log(coarse.step / fine.step)
    cost = fine.ns_per_second * (coarse.ns_per_second / fine.ns_per_second) ** fraction
    between = Point(curve.method.name, step, error, cost)
    return replace(chosen(curve.method, between, curve.scale), measured=False)


def _at_default(curve: _Curve) -> Choice | None:
    """The method at MuJoCo's default step, with the error of that run where there is one, where the
    step lies within what was measured."""
    if curve.method.control != "step":
        return None
    for i, p in enumerate(curve.runs):
        if math.isclose(p.step, DEFAULT_STEP, rel_tol=1e-9):
            return chosen(curve.method, p, curve.scale)
        if p.step > DEFAULT_STEP:
            if not i or not math.isfinite(p.error):
                return None
            return _between(curve, i - 1, DEFAULT_STEP)
    return None


def chosen(method: Method, p: Point, scale: float) -> Choice:
    """A measured run as a choice; `scale` is the observable's."""
    return Choice(
        method.name, method.control, p.step, p.error, p.error * scale, p.ns_per_second, True,
        method.surrogate,
    )  # fmt: skip


def rounded_down(step: float, digits: int) -> float:
    """A step rounded down to so many significant digits."""
    exponent = math.floor(math.log10(step)) - digits + 1
    return float(f"{math.floor(step / 10.0**exponent * (1 + 1e-12))}e{exponent}")
