"""Derivatives of the end of a method's run, by differences of whole runs and by an engine's own
ways, each with the exact derivative and the predicted error.

A run with the parameter p has the observable o(p) + e(p), with o exact and e the error, so that

    central:  (o + e)(p + eps) - (o + e)(p - eps) over 2 eps = o' + e' + C eps^2 + rounding/eps (1)

and the forward difference has C eps in place of C eps^2. With e predicted at these two parameters,
eq. 1 predicts all but the rounding. A way without eps has the error e'.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain, product
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.answer_cache import Same, expected_series
from plumbob.analytic.left_open import SOLVER_FACTOR, by_series, roundings
from plumbob.analytic.parameters import ParameterError, nearest
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import ADAPTIVE
from plumbob.analytic.theory import reaches
from plumbob.engines.abilities import OwnDerivative, SecondRun
from plumbob.engines.derivative_ways import (
    CENTRAL,
    DIFFERENCE_WAYS,
    MIN_DIFFERENCES,
    DifferenceWay,
)
from plumbob.engines.method import Engine, Method, Unsupported
from plumbob.engines.registry import engine_of, engines
from plumbob.engines.study.measurement import ObservedError, confirming, measure, scheme_of
from plumbob.engines.study.request import Changes, RunRequest
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene

if TYPE_CHECKING:  # loading a stored derivative must not import the exact motions
    from plumbob.analytic.sensitivities.neighbours import Sensitivity
    from plumbob.engines.abilities import Derivatives
    from plumbob.models.gradient import Number

DIFFERENCE_DISTANCES = tuple(float(f"1e-{digit}") for digit in range(2, 11))
"""Differences that are tried, relative to the parameter, or to its unit if the parameter is 0."""
PREDICTION_STEP = 1e-5  # difference for the derivative of a predicted error, likewise relative
CONTROL_FACTOR = 10.0  # least factor by which differences of an engine's own way are smaller
# Calibrated: the bound on a model's error changes as the power 4 of a parameter at most.
POWER = 4.0
# Relative spacing and number of the runs that measure rounding noise, and the order of the
# differences of their ends. Third differences remove the smooth part (More and Wild 2011, SIAM J.
# Sci. Comput. 33, 1292). If a solver takes one step more or less its error jumps, and the runs show
# no rounding.
NEIGHBOUR_CHANGE, ROUNDING_NEIGHBOURS, SMOOTH_NEIGHBOURS = 1e-9, 8, 3
# Calibrated by capsule-plan/beside-curve-31. If a support stops within a step, and the residual of
# a solver with it, a model's error jumps from one parameter to the next by 2e-3 of its bound.
JUMP = 5e-3
# Number of times at which the growth of derivatives is read, and the ratio of a derivative to its
# observable from which the observable counts as zero.
COURSE, LOST_DERIVATIVE_GROWTH = 65, 1e6
SHORTEST_RUN = 1e-6  # [s] shortest time of a run to which a cost is relative


@dataclass(frozen=True)
class TriedDifference:
    """A derivative by a difference of runs, or by a way without a difference, and the parts of its
    predicted error."""

    eps: float | None
    computed: float
    truncation: float  # error of the difference if exact answers take the place of the runs
    slope: float  # derivative of the predicted error; NaN without theory
    rounding: float  # bound on the part by the rounding of both runs, which is divided by eps
    remainder: float  # bound on all else that theory leaves open
    noise: float = 0.0  # effect of rounding, measured by runs at neighbouring values

    @property
    def predicted(self) -> float | None:
        """The predicted error, signed; None without theory."""
        return None if math.isnan(self.slope) else self.truncation + self.slope

    @property
    def left_open(self) -> float:
        """The amount by which the error may differ from the predicted error."""
        return self.rounding + self.remainder

    @property
    def size(self) -> float:
        """The expected size of the error of the difference itself."""
        return abs(self.truncation) + self.noise


@dataclass(frozen=True)
class Gradient:
    """The derivative of one observable by one number, computed in one way."""

    of: str
    by: str
    way: str
    at: float = math.nan  # [s]
    step: float = math.nan  # [s], or a relative tolerance
    exact: float = math.nan
    uncertainty: float = math.nan  # uncertainty of the exact derivative
    no_exact: str = ""  # why there is no exact derivative
    why: str = ""  # why this way of differentiating is unsupported; empty if it is supported
    # Exact one-sided derivatives, if there is no other
    one_sided: tuple[float, float] | None = None
    # Differences with falling eps; empty if the way is unsupported
    tried: tuple[TriedDifference, ...] = ()
    # The eps at which both parts of the error are alike. None without theory, and if the observable
    # is linear in the number. None is predicted if the number of a solver's steps changes nearby.
    predicted_best: float | None = None
    measured_best: float | None = None
    cost: float = math.nan  # cost in runs

    @property
    def reference(self) -> float:
        """The exact derivative, or the one from above if only one-sided derivatives exist."""
        return self.exact if self.one_sided is None else self.one_sided[1]

    @property
    def best(self) -> TriedDifference:
        """The difference with the smallest expected error."""
        return min(self.tried, key=lambda tried: tried.size)


@dataclass(frozen=True)
class Gradients:
    """The derivatives of all observables by one number, computed in all ways."""

    records: tuple[Gradient, ...]


@dataclass(frozen=True)
class GradientSearch(RunRequest[Gradients]):
    """Request for derivatives of the end of a scene's run with a method by one number of its
    parameters."""

    label, of_pair = "derivatives", True

    scene: str
    method: str
    of: tuple[str, ...]  # observables
    by: str
    ways: tuple[str, ...] = ()  # empty: all ways
    step: float | None = None  # [s], or a relative tolerance; None: the method's usual step
    eps: tuple[float, ...] = ()  # differences of the parameter, in its unit; empty: a sweep
    at: float | None = None  # [s]; None: the end
    changes: Changes = ()

    def check(self, case: Case) -> None:
        """Raises ParameterError if the case lacks an observable or a time, or no engine has a
        way."""
        allowed = (
            ("of", self.of, [observable.name for observable in case.system.observables]),
            ("way", self.ways, ways()),
        )
        for argument, wanted, known in allowed:
            for name in wanted:
                if name not in known:
                    raise ParameterError(argument, name, f"one of {nearest(name, known)}")
        if self.at is not None and not 0.0 < self.at <= case.scene.duration:
            raise ParameterError("at", self.at, f"above 0, {case.scene.duration:g} s at most")

    def made(self, scene: Scene, method: Method) -> Gradients:
        """Returns the derivatives. Raises ParameterError."""
        from plumbob.models.gradient import numbers

        case = case_of(scene)
        self.check(case)
        if self.at is not None:
            case = case.lasting(self.at)
        step = usual_step(case, method) if self.step is None else self.step
        every = (_gradients_by_number(n, method, step, self) for n in numbers(case, self.by))
        return Gradients(tuple(chain.from_iterable(every)))


@dataclass(frozen=True)
class _End:
    """The value of one observable at the end of a run, with the predicted error and bounds."""

    value: float
    exact: float
    error: float  # predicted, signed; NaN without theory
    terms: tuple[Array, ...]  # terms of its series over the run; empty if it is no series
    rounding: float  # bound on the rounding of the value
    control: float  # signed error of a solver that chooses its steps, by a second run
    model_error: float  # bound on the model error
    doubt: float  # uncertainty of the exact motion in double precision
    steps: int


@dataclass
class _Runs:
    """Runs of a case with one number changed, each made once."""

    number: Number
    method: Method
    step: float
    of: tuple[str, ...]
    ends: dict[float, Mapping[str, _End]] = field(default_factory=dict)

    def at(self, value: float) -> Mapping[str, _End]:
        """Returns {observable: value at the end} of the run whose varied parameter has this
        `value`. Each run is made once and kept. Raises ParameterError and Unsupported."""
        if value not in self.ends:
            self.ends[value] = self._run_ends(self.number.moved(value))
        return self.ends[value]

    def _run_ends(self, case: Case) -> Mapping[str, _End]:
        """Returns {observable: the end of its run} of a case. Raises Unsupported if the run is not
        complete."""
        measured, run = measure(case, self.method, self.step)
        if measured.status != "done" or run is None:
            raise Unsupported(measured.reason or measured.status)
        scheme = scheme_of(case, self.method)
        powers, *_ = expected_series(
            Same(case.reference), Same(case.errors), scheme, self.step, run.times.tobytes()
        )
        series = [powers[power] for power in sorted(powers)]
        ends = {}
        second = confirming(case, self.method) if scheme.integrator == ADAPTIVE else None
        for name in measured.errors.keys() & self.of:
            error = measured.errors[name]
            value = float(run.observables[name][-1])
            terms = error.predicted.terms if error.predicted else {}
            by_second = value if second is None else float(second.observables[name][-1])
            ends[name] = _End(
                value=value,
                exact=value - error.end,
                error=_predicted_error(error),
                terms=tuple(part[name] for part in series) if terms else (),
                rounding=_rounding_bound(error, measured.steps),
                control=value - by_second,
                model_error=error.model_error,
                doubt=error.uncertainty,
                steps=measured.steps,
            )
        return ends

    def difference(
        self, name: str, values: tuple[float, float], exact: float
    ) -> TriedDifference:
        """Returns eq. 1 for an observable between two values of the number, with no eps yet;
        `exact` is the exact derivative."""
        low, high = (self.at(value)[name] for value in values)
        distance = values[1] - values[0]
        remainder = POWER * max(low.model_error, high.model_error) / self.number.size
        if len(high.terms) == len(low.terms) > 0:
            pairs = zip(low.terms, high.terms, strict=True)
            remainder += float(
                by_series([(above - below) / distance for below, above in pairs])[-1]
            )
        rounding = (
            low.rounding + high.rounding + SOLVER_FACTOR * abs(high.control - low.control)
        )
        return TriedDifference(
            eps=None,
            computed=(high.value - low.value) / distance,
            truncation=(high.exact - low.exact) / distance - exact,
            slope=(high.error - low.error) / distance,
            rounding=rounding / distance,
            remainder=remainder,
        )

    def read_at_shifts(self, field_name: str, name: str, shifts: Array) -> Array:
        """Returns the field `field_name` of the ends of runs whose number is shifted by `shifts`
        (relative to its size), shape (n,). It is NaN for a shift at which no run is possible."""

        def read(shift: float) -> float:
            try:
                return float(getattr(self.at(self.number.value + shift)[name], field_name))
            except (ParameterError, Unsupported):
                return math.nan

        return np.array([read(shift) for shift in (shifts * self.number.size).tolist()])

    def slope(self, field_name: str, name: str) -> float:
        """Returns the derivative of a field of the ends, such as the predicted error, by a
        difference of size PREDICTION_STEP. All differences share this slope: if a theory takes the
        run's own steps, the predicted error has the rounding of those steps, too. NaN if one of the
        two runs is not possible."""
        low, high = self.read_at_shifts(
            field_name, name, PREDICTION_STEP * np.array(CENTRAL.values(0.0, 1.0))
        )
        return float(high - low) / (2.0 * PREDICTION_STEP * self.number.size)

    def noise(self, name: str) -> float:
        """Returns the standard deviation of the rounding of an end; 0 if there is no run."""
        ends = self.read_at_shifts(
            "value", name, NEIGHBOUR_CHANGE * np.arange(0.5, ROUNDING_NEIGHBOURS)
        )
        scatter = np.nan_to_num(np.diff(ends, SMOOTH_NEIGHBOURS))
        return float(
            np.sqrt(np.mean(scatter**2) / math.comb(2 * SMOOTH_NEIGHBOURS, SMOOTH_NEIGHBOURS))
        )

    def steady(self, name: str) -> bool:
        """Whether a solver took the same number of steps in all runs near the number's value."""
        value = self.number.value
        reach = 2.0 * PREDICTION_STEP * self.number.size
        neighbours = (ends for at, ends in self.ends.items() if abs(at - value) <= reach)
        return len({ends[name].steps for ends in neighbours}) == 1

    def corner(self, name: str, eps: float) -> float:
        """Returns the difference of the slopes of the predicted error on the two sides, `eps` of
        the number's size away, without the part from its curvature. The predicted error jumps at a
        special motion, next to which another theory holds. It has a corner if a switch falls on the
        end of a step."""
        shifts = np.array([eps, PREDICTION_STEP, 2.0 * PREDICTION_STEP])
        below, middle, above = (
            self.read_at_shifts("error", name, s * shifts) for s in (-1, 0, 1)
        )
        at_eps, at_near, at_twice_near = np.nan_to_num(
            (above - 2.0 * middle + below) / shifts / self.number.size
        )
        return float(abs(at_eps - (at_twice_near - at_near) * eps / PREDICTION_STEP))


def _predicted_error(error: ObservedError) -> float:
    """Returns the predicted error at the end. It is 0 for a solver that is compared with a second
    run. It is NaN if there is no theory, or theory predicts that the motion is lost."""
    predicted = error.predicted
    if predicted is None:
        return math.nan if error.controlled is None else 0.0
    if predicted.largest > error.scale > 0.0:  # the predicted error is larger than the motion
        return math.nan
    series = predicted.terms, predicted.largest, predicted.nonlinearity
    return predicted.end if predicted.for_this_step or reaches(*series) else math.nan


def _rounding_bound(error: ObservedError, steps: int) -> float:
    """Returns the bound on the rounding of the end of a run with `steps` steps."""
    stepped_uncertainty = error.predicted.uncertainty if error.predicted else None
    return (
        error.uncertainty if stepped_uncertainty is None else stepped_uncertainty
    ) * roundings(steps)


def ways() -> tuple[str, ...]:
    """Returns the names of all ways: differences of runs, and the engines' own ways."""
    own = chain.from_iterable(e.abilities_of(OwnDerivative) for e in engines().values())
    return (*DIFFERENCE_WAYS, *sorted({ability.way for ability in own}))


def usual_step(case: Case, method: Method) -> float:
    """Returns the step [s] at which methods are compared, or the tightest tolerance."""
    if method.control == "tolerance":
        return min(method.step_sizes, default=1e-9)
    return min((method.step_sizes or (1e-3,))[0], case.scene.duration)


def _gradients_by_number(
    number: Number, method: Method, step: float, search: GradientSearch
) -> Iterator[Gradient]:
    """Yields the derivatives by one number, one for each observable and way."""
    from plumbob.models.gradient import exact_gradient

    engine = engine_of(method)
    value = number.value
    wanted = search.ways or (
        *DIFFERENCE_WAYS,
        *(own.way for own in engine.abilities_of(OwnDerivative)),
    )
    blank = [
        Gradient(name, number.name, way, step=step) for name, way in product(search.of, wanted)
    ]
    runs = _Runs(number, method, step, search.of)
    try:
        if isinstance(value, (bool, str)) or not isinstance(value, (int, float)):
            raise Unsupported(f"{number.name} = {value!r} is not a number that can vary")
        results = runs.at(value)
    except Unsupported as why_not:
        yield from (replace(record, why=str(why_not)) for record in blank)
        return
    end = number.case.scene.duration
    if method.control == "step":
        end = step * round(end / step)
    exact = exact_gradient(number.case, [number.name], np.array([end]), search.of)[number.name]
    for record in blank:
        if record.of not in results:
            yield replace(record, why=f"the run leaves out {record.of}")
            continue
        with_exact = _with_exact(replace(record, at=end), exact)
        try:
            if with_exact.way in DIFFERENCE_WAYS:
                yield _difference_gradient(
                    runs, with_exact, DIFFERENCE_WAYS[with_exact.way], search.eps
                )
            else:
                yield _own_gradient(runs, with_exact, engine)
        except (ParameterError, Unsupported) as why_not:
            yield replace(with_exact, why=str(why_not))


def _with_exact(record: Gradient, exact: Sensitivity) -> Gradient:
    """Returns a record with the exact derivative, or with the one-sided derivatives and the reason
    why there is no other."""
    parts = exact.values, exact.uncertainty, exact.below, exact.above
    value, uncertainty, *sides = (float(part[record.of][0]) for part in parts if part)
    return replace(
        record,
        exact=value,
        uncertainty=uncertainty,
        no_exact=exact.why,
        one_sided=(sides[0], sides[1]) if sides else None,
    )


def _difference_gradient(
    runs: _Runs, record: Gradient, way: DifferenceWay, asked_eps: tuple[float, ...]
) -> Gradient:
    """Returns a record with its differences. Raises Unsupported if no value next to the number's is
    possible."""
    differences = list[TriedDifference]()
    why = ""
    for eps in sorted(
        asked_eps or (part * runs.number.size for part in DIFFERENCE_DISTANCES), reverse=True
    ):
        try:
            differences.append(_difference(runs, record, way, eps))
        except (ParameterError, Unsupported) as error:
            why = str(error)
    if not differences:
        raise Unsupported(why)
    epses = [d.eps or 0.0 for d in differences]
    if len(differences) >= MIN_DIFFERENCES:
        scatter = math.sqrt(2.0) * runs.noise(record.of) / (1.0 - way.low)
        differences = [
            replace(d, noise=scatter / eps) for d, eps in zip(differences, epses, strict=True)
        ]
    slope, control = (runs.slope(what, record.of) for what in ("error", "control"))
    # The error of a run is not linear in the number, either.
    predicted = [abs(d.truncation + d.slope - slope) + d.noise for d in differences]
    measured = [abs(d.computed - record.reference - slope - control) for d in differences]
    return replace(
        record,
        tried=tuple(differences),
        predicted_best=way.best_of_sweep(epses, predicted) if runs.steady(record.of) else None,
        measured_best=way.best_of_sweep(epses, measured),
        cost=2.0,
    )


def _difference(
    runs: _Runs, record: Gradient, way: DifferenceWay, eps: float
) -> TriedDifference:
    """Returns the difference of a way with one eps, including the bound on the jumps and corners
    that contacts cause. Raises ParameterError and Unsupported."""
    number = runs.number
    name = record.of
    low, high = way.values(number.value, eps)
    difference = runs.difference(name, (low, high), record.reference)
    # A corner of the predicted error changes the difference. A one-sided difference starts at the
    # number itself, so that a corner may lie anywhere within its eps.
    corner_distances = [PREDICTION_STEP]
    if low == number.value:
        corner_distances.append(eps / number.size)
    corner_bound = max(runs.corner(name, distance) for distance in corner_distances)
    # The model errors of the two runs may jump independently of each other.
    model_errors = sum(runs.at(value)[name].model_error for value in (low, high))
    jump_bound = JUMP * model_errors / (high - low)
    remainder = difference.remainder + (corner_bound + jump_bound)
    return replace(difference, eps=eps, remainder=remainder)


def _own_gradient(runs: _Runs, record: Gradient, engine: Engine) -> Gradient:
    """Returns a record of a way of the engine's own. Raises Unsupported."""
    number = runs.number
    method = runs.method
    step = runs.step
    way = next(
        (
            candidate
            for candidate in engine.abilities_of(OwnDerivative)
            if candidate.way == record.way
        ),
        None,
    )
    if way is None:
        raise Unsupported(f"{engine.name} has no way called {record.way}")
    computed, cost = _timed(way.of, engine, runs, record)
    near_difference = _error_slope(runs, record)
    unit = scheme_of(number.case, method).unit
    rounding = near_difference.rounding / unit
    second = engine.ability(SecondRun)
    remainder = (
        near_difference.remainder + way.precision * unit * abs(computed) * record.at / step
    )
    if way.beside is not None:
        second_derivative = _one_derivative(way.beside, number, method, step, record)
        rounding = CONTROL_FACTOR * rounding + SOLVER_FACTOR * abs(computed - second_derivative)
    if method.control == "tolerance" and second is not None:
        second_derivative = _one_derivative(way.of, number, *second.of(method), record)
        # Both runs round their start in the same way.
        start_rounding = runs.at(number.value)[record.of].doubt * _growth(number, record.at)
        rounding = SOLVER_FACTOR * abs(computed - second_derivative) + start_rounding
    return replace(
        record,
        tried=(
            TriedDifference(None, computed, 0.0, near_difference.slope, rounding, remainder),
        ),
        cost=cost,
    )


def _growth(number: Number, end: float) -> float:
    """Returns the largest ratio of the derivative of an observable by a number to the observable,
    until an end [s]."""
    from plumbob.models.gradient import exact_gradient

    times = np.linspace(0.0, end, COURSE)
    exact = exact_gradient(number.case, [number.name], times)[number.name].values
    observed = number.case.reference.observe(times)
    sizes = ((np.abs(exact[name]).max(), np.abs(observed[name]).max()) for name in exact)
    return max(
        (
            size / observed_size
            for size, observed_size in sizes
            if size * number.size < LOST_DERIVATIVE_GROWTH * observed_size
        ),
        default=0.0,
    )


def _timed(
    derivatives_of: Derivatives, engine: Engine, runs: _Runs, record: Gradient
) -> tuple[float, float]:
    """Returns the derivative of one observable, and its cost in runs. Raises Unsupported."""
    number = runs.number
    method = runs.method
    step = runs.step
    begin = time.thread_time()
    engine.prepare(number.case, method, step).run()
    between = time.thread_time()
    computed = _one_derivative(derivatives_of, number, method, step, record)
    return computed, (time.thread_time() - between) / max(between - begin, SHORTEST_RUN)


def _error_slope(runs: _Runs, record: Gradient) -> TriedDifference:
    """Returns the derivative of the predicted error. Its remainder includes the amount that two
    differences leave open, and the error of the same difference of the exact answer, which is all
    of it next to a barrier."""
    value = runs.number.value
    size = PREDICTION_STEP * runs.number.size
    near, wider = (
        runs.difference(record.of, (value - eps, value + eps), record.exact)
        for eps in (size, 2 * size)
    )
    open_difference = np.nan_to_num(abs(near.slope - wider.slope)) + runs.corner(
        record.of, PREDICTION_STEP
    )
    return replace(
        near, remainder=near.remainder + open_difference + SOLVER_FACTOR * abs(near.truncation)
    )


def _one_derivative(
    derivatives_of: Derivatives, number: Number, method: Method, step: float, record: Gradient
) -> float:
    """Returns the derivative of one observable. Raises Unsupported."""
    derivatives = derivatives_of(number, method, step)
    if record.of not in derivatives:
        raise Unsupported(f"{record.way} gives {', '.join(derivatives)} alone")
    return derivatives[record.of]
