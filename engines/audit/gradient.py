"""Derivatives of the end of a motion by its controls and its start: certified derivatives of the
continuous motion, and the errors of the derivatives of a run in MuJoCo or another engine.

Central differences D(eps) of certified motions have an error C eps^2 + O(eps^4), so that

    (4 D(eps/2) - D(eps)) / 3                                                                  (1)

has an error of O(eps^4). Eq. 1 is computed twice, the second time by another method with another
eps; the whole difference of the two is the uncertainty. The best eps of a run's central difference
is predicted with this C and with R = u |x| sqrt(N) growth, for a rounding u in each of N steps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import groupby, product
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import OwnDerivative
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.built_mechanism import ScriptRuns, built_runs, script_scene
from plumbob.engines.audit.reference import TIGHT, Certificate, integration
from plumbob.engines.audit.step_of_method import MUJOCO, builder_of, in_own_process
from plumbob.engines.derivative_ways import (
    CENTRAL,
    DIFFERENCE_WAYS,
    STEP_NUDGE,
    RunDerivatives,
    steadiest_difference,
)
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.own_motion import NotCertifiable, OwnModel, Script
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method

# The two computations of eq. 1, (method, tolerance, eps). With contacts, ten times smaller
# differences show the error that the tolerance leaves (calibrated in
# tests/audit/test_audit_gradient), and the error is no power of eps: hence the two eps differ by a
# factor of three (checked by tests/audit/robots/gradients).
CERTIFYING = (("DOP853", TIGHT, 1e-3), ("RK45", 10.0 * TIGHT, 3e-3))
# eps of the differences of the model's own run
SWEEP = tuple(float(f"1e-{digit}") for digit in range(2, 9))
LARGEST = 10  # most entries that are listed
TRUSTED = 0.2  # largest relative uncertainty of a gradient that counts as known
LOST = 1.0  # relative error from which a gradient means nothing


Entry = Mapping[str, Any]
"""The derivative "of" one coordinate "by" one number at the end of the motion, or the norm of "all"
derivatives. It has the "way", "exact" and its "uncertainty" [m or rad per unit of the number],
"computed", "relative_error" and "eps". A value that does not exist is None."""


@dataclass(frozen=True)
class CertifiedGradient:
    """The certified derivatives of the continuous motion, and the derivatives of a run."""

    of: tuple[str, ...]  # names of the coordinates
    # Names of the numbers: of the start, and constant additions to controls
    by: tuple[str, ...]
    exact: Array  # at the ends of periods, shape (n, coordinates, parameters); NaN if not known
    uncertainty: Array  # uncertainty of the largest entry, shape (n, parameters)
    times: Array  # [s], shape (n,)
    ways: tuple[RunDerivatives, ...]
    predicted_eps: float  # best eps of a central difference
    left_out: tuple[str, ...] = ()  # numbers without a known derivative, each with the reason

    @cached_property
    def known(self) -> Array:
        """Whether the derivative by each number is known at the end, shape (numbers,)."""
        return np.asarray(np.isfinite(self.uncertainty[-1]))

    def norm(self, values: Array) -> Array:
        """Returns the norms of matrices of shape (..., coordinates, numbers), over the numbers with
        known derivatives."""
        return np.asarray(np.linalg.norm(values[..., self.known], axis=(-2, -1)))

    def relative(self, norms: Array) -> Array:
        """Returns a norm over time, shape (n,), relative to the norm of the gradient; 0 as long as
        nothing depends on any number."""
        sizes = self.norm(self.exact)
        return np.divide(norms, sizes, out=np.zeros_like(sizes), where=sizes > 0.0)

    @cached_property
    def certificate(self) -> Array:
        """The uncertainty relative to the gradient, over time, shape (n,)."""
        return self.relative(np.linalg.norm(self.uncertainty[:, self.known], axis=1))

    def errors(self, way: RunDerivatives) -> Array:
        """Returns the error of a way relative to the gradient, over time, shape (n,)."""
        assert way.computed is not None
        return self.relative(self.norm(way.computed - self.exact))

    @property
    def along(self) -> RunDerivatives | None:
        """The first way that gives derivatives, whose horizon is stated: the product along the run
        unless that gives none. None if no way does."""
        return next((way for way in self.ways if way.computed is not None), None)

    @cached_property
    def lost(self) -> tuple[tuple[float, float], ...]:
        """Intervals [s] within which the error is always as large as the gradient. Times at which
        the gradient is not known well enough are skipped."""
        if self.along is None:
            return ()
        known = self.certificate <= TRUSTED
        wrong = self.errors(self.along)[known] >= LOST
        times = self.times[known].tolist()
        runs = (list(run) for _, run in groupby(range(len(times)), lambda k: bool(wrong[k])))
        return tuple((times[run[0]], times[run[-1]]) for run in runs if wrong[run[0]])

    @property
    def horizon(self) -> float | None:
        """The time [s] from which on the error stays as large as the gradient, as long as the
        gradient is known; None if there is no such time."""
        if not self.lost:
            return None
        begins, ends = self.lost[-1]
        return begins if ends == self.times[self.certificate <= TRUSTED][-1] else None

    @property
    def why(self) -> str:
        """Explains why there is no time from which on the derivative means nothing; empty if there
        is such a time."""
        if self.horizon is not None:
            return ""
        if self.along is None:
            return self.ways[-1].why
        known = self.certificate <= TRUSTED
        errors = 100.0 * self.errors(self.along)[known]
        until = self.times[known][-1]
        if not self.lost:
            return f"the error is at most {errors.max():.2g} % up to {until:.3g} s"
        spans = " and ".join(f"from {first:.3g} to {last:.3g} s" for first, last in self.lost)
        return f"the error is as large {spans} only; it is {errors[-1]:.2g} % at {until:.3g} s"

    def growth(self, values: Array) -> float | None:
        """Returns the largest size of the derivatives by the positions of the start, relative to
        their size at the start; None if they are not known."""
        count = len(self.of)
        sizes = np.linalg.norm(values[:, :, :count][..., self.known[:count]], axis=(1, 2))
        return float(sizes.max() / sizes[0]) if self.known[:count].any() else None

    def worst(self, way: RunDerivatives) -> Entry:
        """Returns the entry with the largest error of a way."""
        assert way.computed is not None
        errors = np.nan_to_num(np.abs(way.computed[-1] - self.exact[-1]))
        return self._entry(way, int(np.argmax(errors)))

    @property
    def entries(self) -> tuple[Entry, ...]:
        """The norm of all derivatives and then the largest derivatives, each by every way."""
        sizes = np.nan_to_num(np.abs(self.exact[-1]))
        return self._entries([None, *np.argsort(-sizes, axis=None)[:LARGEST].tolist()])

    def between(self, of: Sequence[str], by: Sequence[str]) -> tuple[Entry, ...]:
        """Returns the derivatives of some coordinates by some numbers, each by every way."""
        both = product(map(self.of.index, of), map(self.by.index, by))
        return self._entries([len(self.by) * row + column for row, column in both])

    def _entries(self, places: Sequence[int | None]) -> tuple[Entry, ...]:
        """Returns the entries at some places of the matrix, counted by rows, each by every way."""
        return tuple(self._entry(way, place) for place, way in product(places, self.ways))

    def _entry(self, way: RunDerivatives, place: int | None) -> Entry:
        """Returns the entry at a place of the matrix, counted by rows; for None, the norm of
        all."""
        row, column = divmod(place or 0, len(self.by))

        def value(matrix: Array) -> float:
            return float(self.norm(matrix) if place is None else matrix[row, column])

        exact = value(self.exact[-1])
        computed = error = None
        if way.computed is not None and math.isfinite(value(way.computed[-1])):
            computed = value(way.computed[-1])
            error = value(way.computed[-1] - self.exact[-1])
        uncertainty = (
            self.certificate[-1] * exact if place is None else self.uncertainty[-1, column]
        )
        return {
            "of": "all" if place is None else self.of[row],
            "by": "all" if place is None else self.by[column],
            "way": way.name,
            "exact": exact,
            "uncertainty": float(uncertainty),
            "computed": computed,
            "relative_error": error / exact if error is not None and exact else None,
            "eps": way.eps,
        }


def certified_gradient(
    model: OwnModel,
    script: Script,
    reference: Certificate,
    index: int,
    allowance: Allowance,
    method: Method | None = None,
) -> CertifiedGradient:
    """Returns the derivatives at the end of the period `index`, up to which the motion is
    certified, and the derivatives of the run of a `method`, or of the model's own integrator. They
    are by as many numbers as time allows, controls first. Raises NotCertifiable with the reason if
    there are none, and Unsupported if the engine of the method cannot express a part of the
    model."""
    if not index:
        raise NotCertifiable(f"there is no reference: {reference.why}")
    if reference.widths:
        why = "contacts that begin over layers leave no derivative that is certain"
        raise NotCertifiable(why)
    script = replace(script, controls=script.controls[:index])
    exact, uncertainty, curvature, left_out = _certified_derivatives(model, script, allowance)
    known = np.isfinite(uncertainty[-1])
    if not known.any():
        raise NotCertifiable(left_out[0])
    allowance.progress("derivatives of its own run")
    method = method or find_method(f"{MUJOCO}/{model.integrator}")
    asked = (method, model, script, known, allowance.seconds)
    if method.engine == MUJOCO:
        ways = derivatives_of_run(*asked)
    else:
        ways = in_own_process(derivatives_of_run, asked, 2.0 * allowance.seconds)
    # A model whose coordinates are 0 has coordinates of the size of the shifts in the differences.
    size = max(SWEEP[0], float(np.abs(reference.course.states[: index + 1]).max()))
    rounding = np.finfo(float).eps * size * math.sqrt(script.duration / model.step)
    rounding *= max(1.0, float(np.abs(exact[..., known]).max()))
    return CertifiedGradient(
        of=model.names["position"],
        by=numbers_of(model),
        exact=exact,
        uncertainty=uncertainty,
        times=script.times,
        ways=ways,
        predicted_eps=CENTRAL.best_eps(max(curvature, rounding), rounding),
        left_out=left_out,
    )


def numbers_of(model: OwnModel) -> tuple[str, ...]:
    """Returns the names of the numbers by which derivatives are taken: a kind, and the name of a
    joint, an activation or an actuator."""
    numbers = list[str]()
    for kind, names in model.names.items():
        numbers += [f"{kind} {name}" for name in names]
    return tuple(numbers)


def _certified_derivatives(
    model: OwnModel, script: Script, allowance: Allowance
) -> tuple[Array, Array, float, tuple[str, ...]]:
    """Returns the derivatives and the uncertainty of a `CertifiedGradient`, the largest C of eq. 1,
    and the numbers that are left out, each with the reason."""
    by = numbers_of(model)
    count = len(model.names["position"])
    exact = np.full((len(script.times), count, len(by)), np.nan)
    uncertainty = np.full((len(exact), len(by)), math.inf)
    curvatures = [0.0]
    left_out = list[str]()
    first_control = len(by) - len(model.names["control"])
    for number in (*range(first_control, len(by)), *range(first_control)):
        allowance.progress(f"derivative by {by[number]}")
        try:
            _check_range(model, script, number - first_control)
            computations = [
                _extrapolated_difference(model, script, number, way, allowance)
                for way in CERTIFYING
            ]
        except NotCertifiable as why:
            left_out.append(f"{by[number]}: {why}")
            continue
        exact[..., number] = computations[0][0]
        uncertainty[:, number] = np.abs(computations[0][0] - computations[1][0]).max(axis=1)
        curvatures.append(computations[0][1])
    return exact, uncertainty, max(curvatures), tuple(left_out)


def _check_range(model: OwnModel, script: Script, actuator: int) -> None:
    """Raises NotCertifiable for a control at an end of its range, which has a one-sided derivative
    only."""
    if actuator >= 0:
        (low, high) = model.ranges[actuator]
        values = script.controls[:, actuator]
        if min(values.min() - low, high - values.max()) < max(eps for *_, eps in CERTIFYING):
            raise NotCertifiable("at an end of its range")


def _shifted_script(model: OwnModel, script: Script, number: int, by: float) -> Script:
    """Returns a script with one number of the start, or of all controls, changed `by` an amount."""
    shift = by * (np.arange(len(numbers_of(model))) == number)
    state = shift.size - model.rest.size
    start = model.shifted(script.start, shift[:state]) if number < state else script.start
    return replace(script, start=start, controls=script.controls + shift[state:])


def _extrapolated_difference(
    model: OwnModel,
    script: Script,
    number: int,
    way: tuple[str, float, float],
    allowance: Allowance,
) -> tuple[Array, float]:
    """Returns eq. 1 over time, shape (n, coordinates), and C. `way` is (method, tolerance, eps).
    Raises NotCertifiable."""
    method, tolerance, eps = way

    def course(by: float) -> Array:
        moved = _shifted_script(model, script, number, by)
        motion = integration(model, moved, method, tolerance, allowance.left)
        if motion.why:
            raise NotCertifiable(motion.why)
        return motion.states

    wide, narrow = (
        CENTRAL.derivative(course, size, model.coordinates) for size in (eps, eps / 2.0)
    )
    curvature = float(np.abs(wide - narrow).max() * 4.0 / 3.0 / eps**2)
    return (4.0 * narrow - wide) / 3.0, curvature


def derivatives_of_run(
    method: Method, model: OwnModel, script: Script, known: Array, seconds: float
) -> tuple[RunDerivatives, ...]:
    """Returns derivatives of the run of a method at the model's own step by the numbers that are
    `known`.

    The ways are: the product along the run; the engine's own ways for mechanisms; central and
    forward differences, each with the eps whose derivatives change least when eps becomes the next
    smaller one. If the method is one of MuJoCo's, the integrator is the model's own. Raises
    Unsupported if another engine cannot express a part of the model, and names that part.
    """
    parts = script.parts(model.step)
    if method.engine == MUJOCO:
        stepper = model.stepper(model.integrator, script.period / parts)
        runs = ScriptRuns(model, stepper, parts)
    else:
        runs = built_runs(builder_of(method), model, script, parts, seconds)

    @cache
    def states(number: int, by: float) -> Array:
        stepped = runs.run(_shifted_script(model, script, number, by))
        if stepped.why:
            raise NotCertifiable(f"its run {stepped.why}")
        return stepped.states

    numbers = np.flatnonzero(known).tolist()
    shape = len(script.times), len(model.names["position"]), known.size
    engines_own = (
        _engines_own_derivatives(own, method, model, script, known)
        for own in engine_of(method).abilities_of(OwnDerivative)
        if own.of_mechanisms is not None
    )
    differences = (
        steadiest_difference(way, states, numbers, model.coordinates, SWEEP, shape)
        for way in DIFFERENCE_WAYS.values()
    )
    return (runs.product(script), *engines_own, *differences)


def _engines_own_derivatives(
    own: OwnDerivative, method: Method, model: OwnModel, script: Script, known: Array
) -> RunDerivatives:
    """Returns derivatives at the end by a way of the engine's own, which is given three mechanisms:
    one as it is, and two with a start or controls shifted to either side."""
    assert own.of_mechanisms is not None
    names = numbers_of(model)
    mechanism = model.mechanism()
    degrees = len(model.names["position"])
    computed = np.full((len(script.times), degrees, known.size), np.nan)
    reasons = dict[str, str]()
    for number in np.flatnonzero(known).tolist():
        scenes = [
            script_scene(mechanism, _shifted_script(model, script, number, shift))
            for shift in (-STEP_NUDGE, 0.0, STEP_NUDGE)
        ]
        try:
            computed[-1, :, number] = own.of_mechanisms(
                scenes, 2.0 * STEP_NUDGE, method, model.step, script.duration
            ).by_qpos
        except Unsupported as reason:
            reasons[names[number]] = str(reason)
    if not np.isfinite(computed[-1]).any():
        return RunDerivatives(own.way, None, why=next(iter(reasons.values())))
    why = "; ".join(f"by {name}: {text}" for name, text in reasons.items())
    return RunDerivatives(own.way, computed, why=why)
